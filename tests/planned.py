"""Paths that tests share: one of each grid, planned and proved once."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.vocabulary import Way
from hcsearch.designs.folding import Folding
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.kernels.enclosure.expansion import HingeRings
from hcsearch.kernels.enclosure.refutation import new_refutation
from hcsearch.kernels.enclosure.wandering import climb_angles, random_walk
from hcsearch.motion.collision.panel_prisms import longest_way
from hcsearch.motion.locks.boxes import whole_box
from hcsearch.motion.locks.enclosures import rings_of
from hcsearch.motion.locks.regions import Region
from hcsearch.motion.planning.path_proofs import CERTIFIED_MARGINS, PathProof, Prover
from hcsearch.motion.planning.planner import Planner
from hcsearch.motion.searching import Budget
from hcsearch.shape.linkage import Linkage
from tests.naive import around_the_loop

Reals = NDArray[np.float64]

SAMPLES: dict[str, tuple[Way, float]] = {
    "hex:0234550132:4": ("hinged", 1e-5),
    "square:012233230011:4": ("rigid", 1e-5),
    "square:012123230301:1": ("hinged", 1e-5),
    "rectangle:0122333011:1": ("hinged", 1e-5),
    "triangle:012343454505012321:3": ("hinged", 1e-5),
}
"""Foldings, how their flat pairs are joined, and the margin (m) of the search. The third passes a switch state."""


@dataclass(frozen=True)
class Planned:
    """A proved path."""

    linkage: Linkage
    states: Reals
    proof: PathProof

    @property
    def wander(self) -> float:
        """What fold angles of closed states differ by from the motion's, summed over hinges (rad)."""
        return float(np.log1p(self.proof.slack / longest_way(self.linkage)))


def joined(name: str, way: Way) -> Linkage:
    """The linkage of a folding."""
    folding = Folding.from_notation(name)
    return folding.linkage(default_panel(folding.circuit.grid.name), flat_pairs=way)


@cache
def planned(name: str) -> Planned:
    """The path of a sample."""
    way, margin = SAMPLES[name]
    linkage = joined(name, way)
    states = Planner(linkage, margin).plan(Budget(100)).states
    assert states is not None
    return Planned(linkage, states, Prover(linkage).prove(states, CERTIFIED_MARGINS))


def cubic(planned_: Planned, k: int) -> Reals:
    """The fold angles in a step of a proved motion, (n_hinges, 4), by the share of the step."""
    motion = planned_.proof.motion
    assert motion is not None
    h = motion.times[k + 1] - motion.times[k]
    (y, z), (b, e) = motion.angles[k : k + 2], h * motion.rates[k : k + 2]
    return np.stack([y, b, 3 * (z - y) - 2 * b - e, b + e - 2 * (z - y)], axis=1)


def along(planned_: Planned, times: Reals) -> Reals:
    """The fold angles of a proved motion at some times."""
    motion = planned_.proof.motion
    assert motion is not None
    steps = np.clip(np.searchsorted(motion.times, times, side="right") - 1, 0, len(motion.times) - 2)
    shares = (times - motion.times[steps]) / np.diff(motion.times)[steps]
    return np.array([cubic(planned_, k) @ s ** np.arange(4) for k, s in zip(steps, shares, strict=True)])


def open_by(linkage: Linkage, angles: Reals) -> Reals:
    """How far loops are open at states (..., n): the greatest entry of T - 1, lengths over the pattern's size."""
    lines = linkage.directions, linkage.points / linkage.pattern.size
    opened = [np.abs(around_the_loop(*lines, loop, angles) - np.eye(4)).max(axis=(-2, -1)) for loop in linkage.loops]
    return np.max(opened, axis=0)


def walks_of(linkage: Linkage, steps: int) -> tuple[HingeRings, list[Reals]]:
    """The loops of a linkage, and closed states that random walks from its packed and its flat state pass."""
    rings, hinges = rings_of(linkage)
    ends = linkage.folded[hinges], linkage.flat[hinges]
    return rings, [random_walk(rings, end, steps, 1, new_refutation(rings)) for end in ends]


def region_of(linkage: Linkage, side: int, steps: int = 20_000, climbs: int = 1000) -> Region:
    """A region around an end by walks and climbs of so many steps, not yet searched."""
    rings, walks = walks_of(linkage, steps)
    work = new_refutation(rings)
    seen = [climb_angles(rings, walk, *whole_box(rings.hinge_count), climbs, 1, work) for walk in walks]
    return Region(rings, side, seen[side], seen[1 - side], 1, new_refutation(rings), new_refutation(rings))
