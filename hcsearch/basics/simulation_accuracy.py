"""The accuracy of the deployments of a search: what was left out, and the errors of flat times, in one line."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterable
from typing import NamedTuple

from hcsearch.basics.vocabulary import counted, percent


class SimulationAccuracy(NamedTuple):
    """The accuracy of several deployments; None where no deployment has such a number.

    saved : mean share of the work that omissions save. time_error, median_error : greatest and median estimated error
    of a time to flat, over that time. known, unknown : numbers of deployments that become flat with such an estimate
    and without one.
    """

    saved: float | None
    time_error: float | None
    median_error: float | None
    known: int
    unknown: int


class TrialAccuracy(NamedTuple):
    """The share of work saved, verdict, time to flat (s) and its estimated error (s) of a deployment."""

    saved: float
    verdict: str
    time: float | None
    error: float | None


def accuracy_of_trials(trials: Iterable[TrialAccuracy]) -> SimulationAccuracy:
    """Return the accuracy of deployments, those of congruent foldings counted once."""
    shares, errors, flat = [], [], 0
    for trial in trials:
        shares.append(trial.saved)
        flat += trial.verdict == "deploys"
        if trial.error is not None and trial.time:
            errors.append(trial.error / trial.time)
    saved = sum(shares) / len(shares) if shares else None
    known = len(errors)
    median = statistics.median(errors) if errors else None
    return SimulationAccuracy(saved, max(errors, default=None), median, known, flat - known)


def accuracy_sentences(accuracy: SimulationAccuracy) -> tuple[str, ...]:
    """Return a sentence on the accuracy of deployments; none without any."""
    parts = []
    if accuracy.saved is not None:
        parts.append(f"left out: {percent(accuracy.saved)} of the work of a simulation")
    if accuracy.time_error is not None and accuracy.median_error is not None:
        times, half = counted(accuracy.known, "flat time"), ""
        if accuracy.known > 1:
            half = f", half of them at most {_percent_at_most(accuracy.median_error)} %"
        parts.append(f"error of {times} at most {_percent_at_most(accuracy.time_error)} %{half}")
    if accuracy.unknown:
        parts.append(f"error of {counted(accuracy.unknown, 'flat time')} not known")
    return ("; ".join(parts),) if parts else ()


def _percent_at_most(share: float) -> str:
    """Return a share in per cent with one digit, rounded up."""
    if not 0.0 < share < math.inf:
        return f"{100.0 * share:g}"
    unit = 10.0 ** math.floor(math.log10(100.0 * share))
    return f"{math.ceil(100.0 * share / unit * (1.0 - 1e-12)) * unit:.12g}"
