"""Options of a tuning; the command shows their defaults in its help, so this module loads nothing of the engine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

from hcsearch.basics.errors import HcsearchError

MAX_MOST_DAMPING, MAX_DAMPING = 10.0, 1e12
"""Greatest multiple of the damping that is tried, and greatest damping of a hinge, N m s/rad."""


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

    catalogue : stiffnesses of the springs that can be bought (N m/rad), and damper_catalogue : the damping (N m s/rad)
    of a hinge with one of the dampers. most_damping : greatest multiple of the damping of the scene that is tried with
    its springs before other springs are; 1 for none. damper_range : the least and the greatest damping of a hinge (N m
    s/rad) where dampers are searched together with springs. evaluations : greatest number of spring sets
    tried in all: for the choice of the formulation, the search and the rounding. samples : drawn of the tolerances in
    `spread` for each reported set; half as many as evaluations may be drawn in addition to compare sets and make them
    more robust. seed : of the random numbers.
    """

    catalogue: tuple[float, ...] = ()
    evaluations: int = 500
    samples: int = 64
    spread: Spread = Spread()
    seed: int = 0
    most_damping: float = 10.0
    damper_range: tuple[float, float] | None = None
    damper_catalogue: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        for name, minimum in (("evaluations", 1), ("samples", 0), ("seed", 0)):
            if (number := getattr(self, name)) < minimum:
                raise HcsearchError(f"{name} cannot be {number}: give {minimum} or more")
        if not 1.0 <= self.most_damping <= MAX_MOST_DAMPING:
            raise HcsearchError(f"most_damping cannot be {self.most_damping:g}: give 1 to {MAX_MOST_DAMPING:g}")
        if not all(0.0 < damping <= MAX_DAMPING for damping in self.damper_catalogue):
            raise HcsearchError("a catalogue has dampers above 0 N m s/rad: write --damper-catalogue 0.005,0.01")
        object.__setattr__(self, "damper_catalogue", tuple(sorted(set(self.damper_catalogue))))
        if self.damper_catalogue and not self.catalogue:
            raise HcsearchError("dampers of a catalogue go with springs of one: add --catalogue 0.07,0.10")
        if self.damper_range and self.catalogue and not self.damper_catalogue:
            raise HcsearchError(
                "springs of a catalogue go with dampers of one: add --damper-catalogue 0.005,0.01, or leave out "
                "--damper-range"
            )


def damper_bounds(values: Sequence[float]) -> tuple[float, float]:
    """Return the least and the greatest damping of a search, N m s/rad; HcsearchError for other numbers."""
    bounds = [float(value) for value in values]
    if len(bounds) != 2 or not 0.0 < bounds[0] < bounds[1] <= MAX_DAMPING:
        raise HcsearchError(
            f"dampers have no range {', '.join(f'{bound:g}' for bound in bounds)}: give the least and the greatest, "
            "above 0 N m s/rad, such as 0.001,0.02"
        )
    return bounds[0], bounds[1]
