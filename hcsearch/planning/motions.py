"""The motion of one folding: the ways of joining its flat pairs are tried until a path is proved.

First with the least margin that is stated, then with the scene's own, by which panels have the most play: with hinged
pairs alone where these may be, as their motions include those of all others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from hcsearch.collision.margins import margin_of, scale_of
from hcsearch.equality import ByValue
from hcsearch.flat_pairs import can_be, linkage_joined
from hcsearch.folding import Folding
from hcsearch.kernels.collision.intervals import Course
from hcsearch.labels import Labels, labels_of
from hcsearch.linkage import Linkage
from hcsearch.planning.planner import Growth, Planner
from hcsearch.planning.proofs import PLAYS, PathProof, Prover
from hcsearch.planning.simple_moves import simple_path
from hcsearch.planning.sizes import check_size
from hcsearch.scenes import PanelSize
from hcsearch.typing import Reals
from hcsearch.vocabulary import Way

TIGHT, LOOSE, AGAIN = 40, 60, 3
"""Rounds of the search with the least margin, of those with the greatest that follow it, and how many those are."""
PROOFS = 3
"""Paths that are tried where a proof fails, in each way and with either margin: other seeds hardly mend that."""


@dataclass(frozen=True, eq=False)
class PlannedMotion(ByValue):
    """What is known of the motion of a folding.

    way : how flat pairs are joined; of the path, if there is one. states : of the path, (k, n_hinges), or None.
    proof : of the path, which may have failed. growths : what trees came to, by way, where the search reached no path.
    labels : names of panels in the linkage of the path, if there is one.
    """

    way: Way | None
    states: Reals | None
    proof: PathProof | None
    growths: tuple[tuple[Way, Growth], ...]
    labels: Labels | None = None

    @property
    def margin(self) -> float | None:
        """The least play for each face (m) at which a path is proved; None without a proved path."""
        return None if self.proof is None else self.proof.margin


def motion_of(folding: Folding, panel: PanelSize, ways: Sequence[Way], margin: float | None = None) -> PlannedMotion:
    """Look for a proved path of a folding.

    ways : how flat pairs may be joined, in this order. margin : m, the greatest; None for that of `margin_of`.
    Congruent foldings have one search, that of the folding that stands for them. SizeError for more panels than
    `sizes` allows.
    """
    check_size(folding.circuit.n)
    like = folding.likeness(panel)
    own = folding if like is None else like.folding
    linkages = {way: linkage_joined(own, panel, way) for way in ways if can_be(own, way)}
    found = _Search(linkages, margin).run() if linkages else PlannedMotion(None, None, None, ())
    return found if like is None else carried(found, folding, panel)


def carried(motion: PlannedMotion, folding: Folding, panel: PanelSize) -> PlannedMotion:
    """The motion of a folding, from that of the congruent one that stands for it: only numbers are others."""
    if motion.way is None or motion.states is None:
        return motion
    linkage = linkage_joined(folding, panel, motion.way)
    assert linkage.twin is not None
    hinges, proof = list(linkage.twin.hinges), motion.proof
    if proof is not None and proof.motion is not None:
        course = proof.motion
        rows = (course.angles[:, hinges], course.rates[:, hinges], course.accelerations[:, hinges])
        proof = replace(proof, motion=Course(course.times, *rows, course.cubic))
    if proof is not None and proof.clear is not None and proof.clear.panels is not None:
        one, two = sorted(linkage.twin.panels.index(panel) for panel in proof.clear.panels)
        proof = replace(proof, clear=replace(proof.clear, panels=(one, two)))
    states = motion.states[:, hinges]
    return replace(motion, states=states, proof=proof, labels=labels_of(linkage))


class _Search:
    """The search for a path of one folding."""

    def __init__(self, linkages: dict[Way, Linkage], margin: float | None) -> None:
        self.linkages = linkages
        self.planner: tuple[tuple[Way, float], Planner] | None = None
        self.provers: dict[Way, Prover] = {}
        self.left: dict[Way, int] = {}
        self.growths: dict[Way, Growth] = {}
        self.best = PlannedMotion(None, None, None, ())
        first = next(iter(linkages.values()))
        own = [play * scale_of(first) for play in PLAYS]
        top = margin_of(first) if margin is None else margin
        self.margins = [*(play for play in own if play < top), top]

    def run(self) -> PlannedMotion:
        """The motion that needs the least play."""
        least, top = self.margins[0], self.margins[-1]
        every, widest = tuple(self.linkages), _widest(self.linkages)
        # a path of few hinges at a time is found at once, and proved where closure is singular throughout
        if any(self._simple(way, least) for way in every):
            return self.best
        self.left = dict.fromkeys(every, PROOFS)
        if self._try(every, least, TIGHT, 0):
            return self.best
        if top > least and any(self._simple(way, top) for way in every):
            return self.best
        self.left = dict.fromkeys(widest, PROOFS)
        if any(self._try(widest, top, LOOSE, seed) for seed in range(1, 1 + AGAIN)):
            return self.best
        return self.best if self.best.states is not None else replace(self.best, growths=tuple(self.growths.items()))

    def _try(self, some: Sequence[Way], margin: float, rounds: int, seed: int) -> bool:
        """Try some ways until one has a path that is proved; whether one has."""
        for way in some:
            planner = self._planner(way, margin)
            for again in range(self.left[way]):
                plan = planner.plan(rounds, seed + 10 * again)
                if plan.states is None:
                    self.growths[way] = plan.growth
                    break
                if self._prove(way, plan.states):
                    return True
                self.growths[way] = plan.growth
                self.left[way] -= 1
        return False

    def _simple(self, way: Way, margin: float) -> bool:
        """Prove a path of simple moves; whether there is one that is proved."""
        states = simple_path(self.linkages[way], margin)
        return states is not None and self._prove(way, states)

    def _planner(self, way: Way, margin: float) -> Planner:
        """The planner of the last search, where it fits: one of a large array takes much memory."""
        if self.planner is None or self.planner[0] != (way, margin):
            self.planner = None
            self.planner = ((way, margin), Planner(self.linkages[way], margin))
        return self.planner[1]

    def _prove(self, way: Way, states: Reals) -> bool:
        """Prove a path, and keep it; whether it is proved."""
        prover = self.provers.setdefault(way, Prover(self.linkages[way]))
        self.best = PlannedMotion(way, states, prover.prove(states, self.margins), (), labels_of(self.linkages[way]))
        return self.best.margin is not None


def _widest(linkages: dict[Way, Linkage]) -> tuple[Way, ...]:
    """The way whose motions are those of all others, too, by which hinges are joined; all ways where there is none."""
    return ("hinged",) if "hinged" in linkages else tuple(linkages)
