"""Tables of work and precision: runs that take longer each, until one would take too long, and the fastest of them."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

from hcsearch.basics.errors import HcsearchError
from hcsearch.springs.accuracy.measured_accuracy import draw_work_curve
from hcsearch.system.figures import figure_for
from hcsearch_bench.run.machine import MISSING

OURS = "hcsearch"
PATIENCE, QUICK_PATIENCE = 8.0, 2.0
"""Seconds that a run may be expected to take, from the one before it."""


class UnableError(HcsearchError):
    """An engine is not there, cannot be given a system, or does not get to the end."""


@dataclass(frozen=True)
class MeasuredRow:
    """A run of an engine, by a method and a tolerance, or step (s).

    verdict : of the levels of a bench, `wrong`, or `none` where there is no motion (`note` says why). energy : greatest
    error of the energy balance, J; of other engines only where nothing is damped. evaluations : of accelerations; of
    implicit methods, Newton steps. seconds : on the wall, median of `runs`.
    """

    engine: str
    method: str
    tolerance: float | None
    step: float | None
    verdict: str = "none"
    error: float | None = None
    energy: float | None = None
    evaluations: int | None = None
    seconds: float | None = None
    runs: int = 0
    note: str = ""


AnyRow = TypeVar("AnyRow", bound=MeasuredRow)
AnyFastest = TypeVar("AnyFastest", bound=MeasuredRow)


def rising(
    settings: Sequence[float],
    patience: float,
    blank: Callable[[float], AnyRow],
    measure: Callable[[float], AnyRow],
    *,
    by_tolerance: bool,
) -> Iterator[AnyRow]:
    """Rows of rising work, until one would take too long; one with the reason where the engine is unable.

    blank : a row without numbers; measure : one with them, or UnableError.
    """
    took, before = 0.0, None
    for setting in settings:
        more = 2.0 if by_tolerance or before is None else before / setting
        if took * more > patience:
            yield replace(blank(setting), note=f"not tried: more than {patience:g} s")
            continue
        try:
            row = measure(setting)
        except UnableError as error:
            row = replace(blank(setting), note=str(error))
        yield row
        if row.note == MISSING:
            return
        if row.seconds is not None:
            took, before = row.seconds, setting


def level_of(error: float, levels: Sequence[tuple[str, float]], scale: float = 1.0) -> str:
    """The first level that an error is within; `wrong` beyond them all. scale : what the limits are multiplied by."""
    return next((name for name, limit in levels if error <= limit * scale), "wrong")


def seconds_of(row: MeasuredRow) -> float:
    """The seconds of a row that has been measured."""
    assert row.seconds is not None
    return row.seconds


def fastest_rows(
    rows: Sequence[AnyRow],
    subject: Callable[[AnyRow], str],
    key: Callable[[AnyRow], Hashable],
    is_ours: Callable[[AnyRow], bool],
    kind: Callable[..., AnyFastest],
) -> Iterator[AnyFastest]:
    """The fastest rows of each subject, level and key; `times_ours` : their seconds over those of our fastest."""
    for name in dict.fromkeys(map(subject, rows)):
        for level, verdicts in (("high", ("precise", "high")), ("precise", ("precise",))):
            precise = [row for row in rows if subject(row) == name and row.verdict in verdicts]
            fastest = [
                min((row for row in precise if key(row) == one), key=seconds_of)
                for one in dict.fromkeys(map(key, precise))
            ]
            ours = min((seconds_of(row) for row in fastest if is_ours(row)), default=None)
            for row in fastest:
                yield kind(**vars(row), level=level, times_ours=None if ours is None else seconds_of(row) / ours)


WorkPoint = tuple[str, str, str, float, float]
"""A run of a bench of error against time: problem, engine, label of its curve, seconds, error."""


def plot_work(points: Sequence[WorkPoint], ylabel: str, path: Path) -> None:
    """Error against seconds, a picture a problem, a curve an engine and method; ours with dots."""
    names = list(dict.fromkeys(point[0] for point in points))
    curves = list(dict.fromkeys((engine, label) for _, engine, label, _, _ in points))
    with figure_for(path, (15, 7.5)) as figure:
        pictures = figure.subplots(2, -(-len(names) // 2), squeeze=False).ravel()
        for axes, name in zip(pictures, names, strict=False):
            for k, (engine, label) in enumerate(curves):
                mine = [(s, e) for at, _, own, s, e in points if (at, own) == (name, label)]
                draw_work_curve(axes, mine, label, k, "o" if engine == OURS else "s")
            axes.set(title=name, xlabel="seconds", ylabel=ylabel)
        for axes in pictures[len(names) :]:
            axes.set_axis_off()
        figure.legend(*pictures[0].get_legend_handles_labels(), loc="outside lower center", ncols=5, fontsize="small")
