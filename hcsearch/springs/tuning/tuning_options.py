"""Options of a tuning; the command shows their defaults in its help, so this module loads nothing of the engine."""

from __future__ import annotations

from dataclasses import dataclass, fields

from hcsearch.basics.errors import HcsearchError


@dataclass(frozen=True)
class Spread:
    """Manufacturing tolerances: standard deviations, relative except for the start.

    stiffness : of each spring, independently. damping, mass : of all dampers together, of all panels together. start :
        of the share of the folded angles at which the motion starts; samples only ever start less folded.
    """

    stiffness: float = 0.05
    damping: float = 0.05
    mass: float = 0.05
    start: float = 0.001


SPREAD_NAMES = tuple(field.name for field in fields(Spread))


@dataclass(frozen=True)
class TuningOptions:
    """Options of a tuning; HcsearchError for a search without evaluations, and for negative numbers.

    catalogue : stiffnesses of the springs that can be bought (N m/rad). evaluations : greatest number of spring sets
    tried in all: for the choice of the formulation, the search and the rounding. samples : drawn of the tolerances in
    `spread` for each reported set; half as many as evaluations may be drawn in addition to compare sets and make them
    more robust. seed : of the random numbers.
    """

    catalogue: tuple[float, ...] = ()
    evaluations: int = 500
    samples: int = 64
    spread: Spread = Spread()
    seed: int = 0

    def __post_init__(self) -> None:
        for name, minimum in (("evaluations", 1), ("samples", 0), ("seed", 0)):
            if (number := getattr(self, name)) < minimum:
                raise HcsearchError(f"{name} cannot be {number}: give {minimum} or more")
