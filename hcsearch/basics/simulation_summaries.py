"""Summaries of the simulations of a search: undecided endings, omissions, and errors of flat times, in sentences."""

from __future__ import annotations

import math
import statistics
from collections import defaultdict
from collections.abc import Iterable, Mapping
from typing import NamedTuple

from hcsearch.basics.vocabulary import ENDINGS, counted, percent

_COMPLIANT = "hcsearch deploy with --formulation compliant"
_BRANCHING, _TOUCHING = "branch-singular", "contact not decided"
UNDECIDED_REMEDIES = {
    "moving": "a scene with more seconds",
    "at rest": "other springs, as of hcsearch tune",
    "stuck": "stiffer springs, or less friction or harness",
    "jammed": _COMPLIANT,
    "diverged": _COMPLIANT,
    "out of steps": "hcsearch deploy with --formulation compliant or a larger --tolerance",
    _BRANCHING: _COMPLIANT,
    _TOUCHING: "hcsearch deploy with a smaller --tolerance",
}
"""By ending of an undecided simulation: what may decide it. A motion may become flat in several ways, depending on the
tolerance, or touch other panels so nearly that a collision is neither certain nor excluded."""


def undecided_ending(reason: str) -> str:
    """Return how a simulation with an undecided verdict ended, of `UNDECIDED_REMEDIES`, by its stored reason."""
    ending = next((ending for ending in ENDINGS if reason.startswith(f"{ending} at ")), "flat")
    if ending == "flat":
        return _BRANCHING if reason.startswith(_BRANCHING) else _TOUCHING
    return ending


def undecided_counts(reasons: Mapping[object, str]) -> dict[str, int]:
    """Return the number of undecided simulations by their ending, the most frequent first; reasons : by folding."""
    counts: dict[str, int] = defaultdict(int)
    for reason in reasons.values():
        counts[undecided_ending(reason)] += 1
    return dict(sorted(counts.items(), key=lambda item: -item[1]))


def undecided_sentences(counts: Mapping[str, int]) -> tuple[str, ...]:
    """Return a sentence on foldings that no simulation decides, and one on what may decide them; none without any."""
    if not counts:
        return ()
    endings = defaultdict(list)
    for ending in counts:
        endings[UNDECIDED_REMEDIES[ending]].append(ending)
    listed = ", ".join(f"{ending} {count:,}" for ending, count in counts.items())
    remedies = "; ".join(f"{' or '.join(names)}: {remedy}" for remedy, names in endings.items())
    return (
        f"not decided by simulation: {counted(sum(counts.values()), 'folding')} ({listed})",
        f"these may decide: {remedies}",
    )


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
