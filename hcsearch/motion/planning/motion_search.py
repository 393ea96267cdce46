"""The motion of one folding: searches and proofs in the order of their cost, and the result in sentences.

The search starts with the least stated margin and continues with the margin of the scene, which gives panels the most
play. Where flat pairs may be hinged, only hinged pairs are then searched, as their motions include all others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import singledispatchmethod
from typing import NamedTuple

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.basics.vocabulary import Way, counted
from hcsearch.designs.folding import Folding
from hcsearch.designs.panel_sizes import PanelSize
from hcsearch.kernels.collision.intervals import Course
from hcsearch.motion.collision.panel_prisms import margin_of, plates_of, scale_of
from hcsearch.motion.locks.enclosures import Enclosure, enclose_ends
from hcsearch.motion.planning.critical import CriticalMargin, critical_margin
from hcsearch.motion.planning.path_proofs import CERTIFIED_MARGINS, PathProof, Prover
from hcsearch.motion.planning.planner import Planner, TreeGrowth
from hcsearch.motion.planning.problems import check_memory
from hcsearch.motion.planning.schedule import (
    DEFAULT_EFFORT_BUDGET,
    LONG_SEARCH_ROUNDS,
    BisectionStep,
    EffortStep,
    FloodStep,
    MovesStep,
    TreeStep,
    planned_efforts,
)
from hcsearch.motion.planning.simple_moves import simple_path
from hcsearch.motion.searching import Budget, SteppedSearch
from hcsearch.shape.labels import Labels, labels_of
from hcsearch.shape.linkage import Linkage
from hcsearch.system.work_steps import work_step

MAX_FAILED_PROOFS = 3
"""Greatest number of failed proofs in each way of an effort: other seeds hardly help then."""


class ProvedPath(NamedTuple):
    """A proved path: how flat pairs are joined, the course of the hinges, and the play of each face, m."""

    way: Way
    course: Course
    margin: float


@dataclass(frozen=True, eq=False)
class PlannedMotion(ByValue):
    """The known facts about the motion of a folding.

    way : how flat pairs are joined; of the path, if there is one. states : the states of the path, (k, n_hinges), or
    None. proof : the proof of the path, which may have failed. growths : growth of the trees, by way, where the search
    reached no path. labels : names of panels in the linkage of the path, if there is one. efforts : number of efforts
    of `schedule` made in all; a search with a greater budget goes on after these. locks : locks between the ends, by
    way, in the order in which they were proved; one with hinged pairs covers all others. locked : whether the locks
    cover all allowed ways. critical : the critical margin of the widest way, where it was searched for.
    """

    way: Way | None
    states: Reals | None
    proof: PathProof | None
    growths: tuple[tuple[Way, TreeGrowth], ...]
    labels: Labels | None = None
    efforts: int = 0
    locks: tuple[tuple[Way, Enclosure], ...] = ()
    locked: bool = False
    critical: CriticalMargin | None = None

    @property
    def lock(self) -> tuple[Way, Enclosure] | None:
        """The widest lock and its way; where several locks together lock the folding, at their least margin."""
        if not self.locks:
            return None
        way, widest_lock = self.locks[-1]  # a lock with hinged pairs is the last: it ends the search
        margins = [lock.margin for _, lock in self.locks if lock.margin is not None]
        if self.locked and way != "hinged" and margins:
            widest_lock = replace(widest_lock, margin=min(margins))
        return way, widest_lock

    @property
    def margin(self) -> float | None:
        """The least play for each face (m) with which a path is proved; None without a proved path."""
        return None if self.proof is None else self.proof.margin

    @property
    def proved(self) -> ProvedPath | None:
        """The proved path; None without one."""
        if self.way is None or self.proof is None or self.proof.motion is None or self.proof.margin is None:
            return None
        return ProvedPath(self.way, self.proof.motion, self.proof.margin)


def plan_motion(
    folding: Folding,
    panel: PanelSize,
    ways: Sequence[Way],
    margin: float | None = None,
    *,
    budget: int = DEFAULT_EFFORT_BUDGET,
    done: int = 0,
) -> PlannedMotion:
    """Search for a proved path of a folding.

    ways : how flat pairs may be joined, in this order. margin : the greatest margin, m; None for `margin_of`.
    budget : efforts of `schedule`. done : number of efforts made before, without a proof. Congruent foldings share the
    search of their representative. SizeError for more panels than `problems` allows.
    """
    check_memory(folding.circuit.n)
    likeness = folding.likeness(panel)
    representative = folding if likeness is None else likeness.folding
    linkages = {way: representative.linkage(panel, flat_pairs=way) for way in ways if representative.can_join(way)}
    motion = _MotionSearch(linkages, margin, budget, done).run() if linkages else PlannedMotion(None, None, None, ())
    return motion if likeness is None else motion_from_twin(motion, folding, panel)


def plan_linkage_motion(
    linkage: Linkage, margin: float | None = None, *, budget: int = DEFAULT_EFFORT_BUDGET, done: int = 0
) -> PlannedMotion:
    """Search for a proved path of a linkage from its folded to its flat state; its way is `hinged`.

    margin, budget, done : as in `plan_motion`. SizeError for more panels than `problems` allows.
    """
    check_memory(linkage.n_panels)
    return _MotionSearch({"hinged": linkage}, margin, budget, done).run()


def proof_margins(linkage: Linkage, margin: float | None = None) -> list[float]:
    """The margins (m) at which paths are proved, ascending; margin : the greatest; None for `margin_of`."""
    top = margin_of(linkage) if margin is None else margin
    return [*(play * scale_of(linkage) for play in CERTIFIED_MARGINS if play * scale_of(linkage) < top), top]


def motion_from_twin(motion: PlannedMotion, folding: Folding, panel: PanelSize) -> PlannedMotion:
    """Convert the motion of a representative to the motion of a congruent folding: only the numbering differs."""
    locks = tuple((way, _carried_lock(lock, folding.linkage(panel, flat_pairs=way))) for way, lock in motion.locks)
    motion = replace(motion, locks=locks)
    if motion.way is None or motion.states is None:
        return motion
    linkage = folding.linkage(panel, flat_pairs=motion.way)
    assert linkage.twin is not None
    hinges, proof = list(linkage.twin.hinges), motion.proof
    if proof is not None and proof.motion is not None:
        course = proof.motion
        rows = (course.angles[:, hinges], course.rates[:, hinges], course.accelerations[:, hinges])
        proof = replace(proof, motion=Course(course.times, *rows, course.cubic))
    if proof is not None and proof.clearance is not None and proof.clearance.panels is not None:
        first, second = sorted(linkage.twin.panels.index(panel) for panel in proof.clearance.panels)
        proof = replace(proof, clearance=replace(proof.clearance, panels=(first, second)))
    states = motion.states[:, hinges]
    return replace(motion, states=states, proof=proof, labels=labels_of(linkage))


def _carried_lock(lock: Enclosure, linkage: Linkage) -> Enclosure:
    """Renumber the hinges of a twin's lock for a linkage."""
    assert linkage.twin is not None
    place = {hinge: k for k, hinge in enumerate(linkage.twin.linkage.looped.tolist())}
    hinges = [place[linkage.twin.hinges[hinge]] for hinge in linkage.looped.tolist()]
    return replace(lock, lows=lock.lows[:, hinges], highs=lock.highs[:, hinges])


class _MotionSearch(SteppedSearch[PlannedMotion]):
    """The search for the motion of one folding, by the efforts of a budget after the first `done` ones.

    The result is the motion of the least play, or a lock.
    """

    efforts = 0

    def __init__(self, linkages: dict[Way, Linkage], margin: float | None, budget: int, done: int) -> None:
        self.planned, self.efforts, self.decided = planned_efforts(budget, done)[::-1], done, False
        self.linkages, self.widest = linkages, _widest(tuple(linkages))
        self.planner: tuple[tuple[Way, float], Planner] | None = None
        self.provers: dict[Way, Prover] = {}
        self.proofs_left: dict[Way, int] = {}
        self.growths: dict[Way, TreeGrowth] = {}
        self.locks: dict[Way, Enclosure] = {}
        self.opens_without_panels: dict[Way, bool] = {}
        self.critical: CriticalMargin | None = None
        self.best = PlannedMotion(None, None, None, ())
        self.margins = proof_margins(next(iter(linkages.values())), margin)

    @property
    def done(self) -> bool:
        """Whether a path or a lock is proved, or no effort is left."""
        return self.decided or not self.planned

    def step(self, budget: Budget) -> None:
        """Make one effort."""
        self.efforts += 1
        self.decided = any(self._run_named(step, self.efforts) for step in self.planned.pop())

    @property
    def result(self) -> PlannedMotion:
        """The known facts about the motion."""
        # only the widest ways, even where all ways were searched: a search that goes on knows no others
        shown_ways = [way for way in self.widest if way in self.growths] or list(self.growths)
        growths = () if self.best.states is not None else tuple((way, self.growths[way]) for way in shown_ways)
        locks = tuple(self.locks.items())
        known = replace(self.best, locks=locks, locked=self.locked, critical=self.critical)
        return replace(known, growths=growths, efforts=self.efforts)

    def _run_named(self, step: EffortStep, effort: int) -> bool:
        with work_step(f"effort {effort}: {step.words}"):
            return self._run_step(step)

    @property
    def locked(self) -> bool:
        """Whether the folding is locked in all ways."""
        return "hinged" in self.locks or all(way in self.locks for way in self.linkages)

    @property
    def _unlocked_ways(self) -> tuple[Way, ...]:
        """The ways that are not proved locked."""
        return tuple(way for way in self.linkages if way not in self.locks)

    @singledispatchmethod
    def _run_step(self, step: EffortStep) -> bool:
        """Run a step of an effort; return whether a path or a lock is proved."""
        raise TypeError(step)

    @_run_step.register
    def _moves(self, step: MovesStep) -> bool:
        """Try paths of simple moves, which are quickly computed, and provable where closure is singular throughout."""
        least, top = self.margins[0], self.margins[-1]
        if step.loose and top == least:
            return False
        return any(self._simple(way, top if step.loose else least) for way in self._unlocked_ways)

    @_run_step.register
    def _floods(self, step: FloodStep) -> bool:
        """Try to prove locks by floods, first in the narrower ways, which take less."""
        for way in sorted(self._unlocked_ways, key=lambda way: way in self.widest):
            linkage = self.linkages[way]
            if not step.panels and self._opens_without_panels(way):
                continue
            enclosure = enclose_ends(linkage, step.boxes, plates_of(linkage, self.margins[-1]) if step.panels else None)
            if enclosure.proved:
                self.locks[way] = enclosure
        return self.locked

    def _opens_without_panels(self, way: Way) -> bool:
        """Whether a search opens the folding in a way if panels may pass through each other."""
        if way not in self.opens_without_panels:
            free = Planner(self.linkages[way], self.margins[-1], collide=False).plan(Budget(LONG_SEARCH_ROUNDS))
            self.opens_without_panels[way] = free.states is not None
        return self.opens_without_panels[way]

    @_run_step.register
    def _trees(self, step: TreeStep) -> bool:
        ways = self.widest if step.widest else self._unlocked_ways
        self.proofs_left = dict.fromkeys(ways, MAX_FAILED_PROOFS)
        return any(self._grow_trees(ways, step, seed) for seed in step.seeds)

    @_run_step.register
    def _bisection(self, _step: BisectionStep) -> bool:
        """Search for the critical margin; if the scene's margins include it, its path is a proved one."""
        for way in self.widest:
            if way in self.locks:
                continue
            critical = critical_margin(self.linkages[way])
            if self.critical is None or critical.less_than(self.critical):
                self.critical = critical
            within = critical.least_proved is not None and critical.least_proved <= self.margins[-1]
            if within and critical.states is not None and self._prove(way, critical.states):
                return True
        return False

    def _simple(self, way: Way, margin: float) -> bool:
        """Try a path of simple moves; return whether it is proved."""
        states = simple_path(self.linkages[way], margin)
        return states is not None and self._prove(way, states)

    def _grow_trees(self, ways: Sequence[Way], trees: TreeStep, seed: int) -> bool:
        """Search some ways by trees until a path is proved; return whether one is."""
        for way in ways:
            planner = self._planner(way, self.margins[-1 if trees.loose else 0])
            for attempt in range(self.proofs_left[way]):
                plan = planner.plan(Budget(trees.rounds, seed=seed + 10 * attempt), roots=trees.roots)
                if plan.states is None:
                    self.growths[way] = plan.growth
                    break
                if self._prove(way, plan.states):
                    return True
                self.growths[way] = plan.growth
                self.proofs_left[way] -= 1
        return False

    def _planner(self, way: Way, margin: float) -> Planner:
        """Return the planner of the last search, if it fits, or a new one; a large array's takes much memory."""
        if self.planner is None or self.planner[0] != (way, margin):
            self.planner = None
            self.planner = ((way, margin), Planner(self.linkages[way], margin))
        return self.planner[1]

    def _prove(self, way: Way, states: Reals) -> bool:
        """Try to prove a path, and store it as the best; return whether it is proved."""
        prover = self.provers.setdefault(way, Prover(self.linkages[way]))
        self.best = PlannedMotion(way, states, prover.prove(states, self.margins), (), labels_of(self.linkages[way]))
        return self.best.margin is not None


def _widest(allowed: tuple[Way, ...]) -> tuple[Way, ...]:
    """The way of joining flat pairs that allows all motions of the others; all ways where there is none."""
    return ("hinged",) if "hinged" in allowed else allowed


END_NAMES = ("packed", "flat")


def reason_of(motion: PlannedMotion, *, joined: bool = True) -> str:
    """The known facts about a motion, as a sentence. joined : whether the joining of flat pairs is stated."""
    if motion.locked:
        assert motion.lock is not None
        way, lock = motion.lock
        return (
            f"{_apart(lock)}: proved{_with(way, joined)} from the {lock.end} state, by {counted(lock.cubes, 'cube')} "
            "of fold angles"
        )
    if motion.margin is not None:
        play = f"{1e3 * motion.margin:.4g} mm of play on every face"
        pairs = _with(motion.way, joined)
        return f"a path from packed to flat is proved{pairs} {'and' if pairs else 'with'} {play}"
    if motion.proof is not None:
        reason = _failed(motion.proof, motion.labels)
        known = f"a path{_with(motion.way, joined)} was found but not proved: {reason}"
    elif not motion.growths:
        return "no path was searched for: the folding has no mirror pairs of panels to merge"
    else:
        known = "no path was found: " + "; ".join(
            f"{f'{way} flat pairs, ' if joined else ''}{_grown(growth)}" for way, growth in motion.growths
        )
    return "; ".join([known, *_beside(motion)])


def _with(way: Way | None, joined: bool) -> str:
    """The joining of flat pairs as a phrase; empty where it is not stated."""
    return f" with {way} flat pairs" if joined else ""


def _apart(lock: Enclosure) -> str:
    """The cause that keeps the ends apart, as a clause."""
    ends = "keep the packed and the flat state apart"
    if lock.margin is None:
        return f"closed loops and stops {ends}, even if panels could pass through each other"
    return f"locked by collision at margins up to {1e3 * lock.margin:.4g} mm, as panels, loops and stops {ends}"


def _beside(motion: PlannedMotion) -> list[str]:
    """Further known facts about an undecided folding."""
    parts = [f"proved that there is none with {way} flat pairs{_up_to(lock)}" for way, lock in motion.locks]
    critical = motion.critical
    if critical is not None and critical.least_proved is not None:
        parts.append(f"a path is proved with {1e3 * critical.least_proved:.4g} mm of play on every face")
    elif critical is not None and critical.greatest_unmet is not None:
        parts.append(f"none was found with up to {1e3 * critical.greatest_unmet:.4g} mm of play either")
    return parts


def _up_to(lock: Enclosure) -> str:
    """The margins up to which a lock holds, as a phrase; empty for all of them."""
    return "" if lock.margin is None else f" at margins up to {1e3 * lock.margin:.4g} mm"


def _failed(proof: PathProof, labels: Labels | None) -> str:
    """The reason for which a path is not proved."""
    if proof.motion is None:
        return "no closed states are proved beside all of it, as it passes states that are singular, or nearly so"
    if any(proof.end_distances):
        away = " and ".join(
            f"{far:.2g} rad from the {end}" for end, far in zip(END_NAMES, proof.end_distances, strict=True) if far
        )
        return f"its proof ends {away} state"
    if proof.clearance is None:
        return "hinges go beyond their stops by more than the play allows"
    one, two = (k if labels is None else labels.panels[k] for k in proof.clearance.panels or (0, 0))
    return f"panels {one} and {two} come too near with {1e3 * proof.clearance.margin:.4g} mm of play on every face"


def _grown(growth: TreeGrowth) -> str:
    """The growth of the trees of one search, as a clause."""
    if not all(growth.starts):
        return f"no way out of the {END_NAMES[growth.starts[0] > 0]} state"
    one, two = growth.sizes
    closed = [end for end, off in zip(END_NAMES, growth.closed_off, strict=True) if off]
    state = f"closed off at the {' and the '.join(closed)} state" if closed else "still growing"
    return f"trees of {one:,} and {two:,} states {state} after {growth.rounds} rounds, cells {growth.resolution:g} rad"
