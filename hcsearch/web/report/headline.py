"""Titles and first sentences in plain words: the findings in a list of designs, and whether a design opens."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from hcsearch.basics.vocabulary import listed, plural
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.grid import grid_named
from hcsearch.designs.panel_sizes import PanelSize, panel_text
from hcsearch.springs.flight.stowage import Stowage
from hcsearch.store import Summary
from hcsearch.store.conditions import AllOf, AnyOf, Condition, ConditionTree, Not, parse_conditions

_SMALL_NUMBERS = (
    *("Zero", "One", "Two", "Three", "Four", "Five", "Six", "Seven", "Eight", "Nine", "Ten", "Eleven", "Twelve"),
)
_SUBJECTS = ("grid", "n", "array")
"""Columns whose conditions name the designs that were searched, not a part of the results."""


@dataclass(frozen=True)
class StageCounts:
    """Numbers of designs, among `total`, that pass each stage; None for a stage that ran on none of them.

    locked : designs that are proved locked.
    """

    total: int
    two_stack: int | None
    untwisted: int | None
    movable: int | None
    deploys: int | None
    locked: int

    @classmethod
    def of(cls, counts: Summary) -> StageCounts:
        """Return the counts of a summary; without designs all are 0."""
        if not counts.circuits:
            return cls(0, 0, 0, 0, 0, 0)
        locked, movable, deploys = counts.locked or 0, counts.movable, counts.deploys
        # Twisted and locked designs are known not to move before any motion is planned.
        if counts.untwisted is None or counts.untwisted > locked:
            movable = movable if movable or counts.planned else None
            deploys = deploys if deploys or counts.tried else None
        return cls(counts.circuits, counts.two_stack, counts.untwisted, movable, deploys, locked)


def title_of(sizes: Sequence[tuple[str, int]], array: str | None = None) -> str:
    """Return a title such as `Twelve thick hexagons`.

    sizes : grid and number of panels of the designs. array : their common array, None for several.
    """
    if not sizes:
        return "No designs"
    grids, numbers = list(dict.fromkeys(grid for grid, _ in sizes)), sorted({n for _, n in sizes})
    panels = listed([plural(grid_named(grid).noun) for grid in grids], "or")
    if len(numbers) > 1:
        return f"{numbers[0]} to {numbers[-1]} thick {panels}"
    number = _SMALL_NUMBERS[numbers[0]] if 0 <= numbers[0] < len(_SMALL_NUMBERS) else str(numbers[0])
    return f"{number} thick {panels}" + (" in one array" if array is not None else "")


def headline_of(counts: StageCounts, query: str = "") -> str:
    """Return the sentence on how many designs open, such as `33 of 1,175 designs open by springs, 28 more by motors.`.

    query : the one that selected the designs; more than a grid, a size or an array makes them `selected designs`.
    """
    if not counts.total:
        return "No design satisfies the query."
    kind = "selected design" if _selects_a_part(parse_conditions(query)) else "design"
    among = _Among(counts.total, kind)
    if counts.movable is None and counts.deploys is None:
        return _before_motion(counts, among)
    if counts.deploys is None or counts.deploys or counts.movable:
        return _opening(counts, among)
    return _nothing_opens(counts, among)


def _opening(counts: StageCounts, among: _Among) -> str:
    """Say how many designs open, or that springs were not tried."""
    by_springs = counts.deploys or 0
    by_motors = max(0, (counts.movable or 0) - by_springs)
    if counts.deploys is None:
        opened = among.text(by_motors) if by_motors else among.none_known
        return f"{opened} by motors; springs have not been tried."
    if not by_springs:
        return f"{among.text(by_motors)} by motors, {'not' if among.total == 1 else 'none'} by springs alone."
    more = f", {by_motors:,} more by motors" if by_motors else ""
    return f"{among.text(by_springs)} by springs{more}."


def _nothing_opens(counts: StageCounts, among: _Among) -> str:
    """Say that no design is known to open, or that none can."""
    if counts.movable is None:
        return f"{among.none_known} by springs; no motion by motors has been searched for."
    if counts.untwisted is None or counts.untwisted > counts.locked:
        return f"{among.none_known}."
    if counts.total == 1:
        return f"The {among.kind} cannot open."
    return f"None of {among.all} can open: they have no folding, are twisted, or are locked."


def _before_motion(counts: StageCounts, among: _Among) -> str:
    """Return the sentence on designs for which no motion has been searched for."""
    their = "its" if counts.total == 1 else "their"
    if counts.two_stack is None:
        return f"{among.all}; {their} foldings have not been computed."
    if counts.untwisted is None:
        return f"{among.text(counts.two_stack, 'fold')} into two stacks; {their} twist has not been computed."
    return f"{among.text(counts.untwisted, 'fold')} without twist; {their} motion has not been searched for."


@dataclass(frozen=True)
class _Among:
    """The designs among which some are counted: their number and their name."""

    total: int
    kind: str

    @property
    def all(self) -> str:
        return f"{self.total:,} {self.kind}{'s' if self.total > 1 else ''}"

    @property
    def none_known(self) -> str:
        """Subject and verb for a sentence which says that no design is known to open."""
        return f"The {self.kind} is not known to open" if self.total == 1 else f"None of {self.all} is known to open"

    def text(self, count: int, verb: str = "open") -> str:
        """Return the subject and verb of a sentence on some of the designs."""
        if self.total == 1:
            return f"The {self.kind} {verb}s" if count else f"The {self.kind} does not {verb}"
        if count == self.total:
            return f"All {count:,} {self.kind}s {verb}"
        of = f"of {self.total:,} {self.kind}s"
        return f"None {of} {verb}s" if not count else f"{count:,} {of} {verb}{'s' if count == 1 else ''}"


def _selects_a_part(tree: ConditionTree) -> bool:
    """Return whether a query names more than a grid, a number of panels or an array."""
    match tree:
        case AllOf(parts) | AnyOf(parts):
            return any(map(_selects_a_part, parts))
        case Not(part):
            return _selects_a_part(part)
        case Condition(name=name):
            return name not in _SUBJECTS


_ENDINGS = {
    "movable": "A path on which its panels do not collide is proved: motors can open it.",
    "undecided": "It is undecided whether it opens: neither a path nor a lock is proved.",
    "locked": "It is proved locked: it cannot open.",
    "twisted": "The loop is twisted: it cannot open.",
}


def design_sentence(
    circuit: Circuit, panel: PanelSize, status: str, room: Stowage | None, seconds: float | None = None
) -> str:
    """Return what a design is, and whether it opens.

    status : of its best folding, `driven` where drives open it, any other word where no stage has judged it. room : of
    this folding, None where the design has none. seconds : time until springs or drives have opened it.
    """
    loop = f"{circuit.n} {plural(circuit.grid.exact_noun)} of {panel_text(panel)} mm form a closed loop"
    if room is None:
        return f"{loop}, which does not fold into two stacks."
    return f"{loop}, which folds into two stacks of {room.packed.text} together. {_ending(status, seconds)}"


def _ending(status: str, seconds: float | None) -> str:
    if status in ("deploys", "driven"):
        return opened_sentence(seconds, driven=status == "driven")
    return _ENDINGS.get(status, "Whether it opens has not been judged.")


def opened_sentence(seconds: float | None, *, driven: bool) -> str:
    """Return that springs or drives open a linkage without a collision; seconds : the time that this takes."""
    time = "" if seconds is None else f" in {seconds:.3g} s"
    return f"{'Its drives' if driven else 'Springs alone'} open it{time}, and its panels are certified not to collide."
