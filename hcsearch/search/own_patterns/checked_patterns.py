"""All results for a drawn pattern of any panels: freedoms, locks, motion and deployment."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from hcsearch.basics.array_values import Reals
from hcsearch.basics.vocabulary import Status, millimetres, play_sentence, sizes_text
from hcsearch.motion.kinematics.numerical_rank import Rank, generic_rank, rank_at
from hcsearch.motion.locks.end_locks import contact_rows, lock_at
from hcsearch.motion.paths.branches import find_branches
from hcsearch.motion.planning.motion_search import PlannedMotion, plan_linkage_motion, reason_of
from hcsearch.scenes import Scene
from hcsearch.scenes.setup import setup_of_scene
from hcsearch.search.own_patterns.checked import Checked, through_stages
from hcsearch.search.own_patterns.drawn_linkages import longest_edge
from hcsearch.search.own_patterns.fold_reading import STRAIGHT_SIDE_SHARE
from hcsearch.search.own_patterns.packed_states import PackedPattern
from hcsearch.search.stages.order import FOLDING_STAGES
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.mesh import without_straight_corners
from hcsearch.springs.deployment.simulated_deployment import Deployment, simulate_deployment
from hcsearch.system.work_steps import Progress, work_step

MAX_BRANCHING_DOF = 4
"""Greatest number of first-order motions of a flat state among which finite ones are searched for."""


@dataclass(frozen=True)
class PatternVerdict:
    """The verdict on a pattern in a scene.

    Parameters
    ----------
    name
        The name of the file.
    linkage
        Its panels and hinges.
    packed
        Its packed state, or why there is none.
    scene
        The scene.
    dof
        The degrees of freedom at a generic closed state near the packed state, else near the flat one; None where
        rounding leaves them undecided.
    dof_flat, dof_packed
        The degrees of freedom in these states, at first order; None also without the state.
    locks
        The proof that no motion leaves an end, as a sentence, by the end's name.
    branches
        The finite motions that leave the flat state, as a sentence; empty where there is a packed state.
    motion, deployment
        The results of these stages; None where they were left out.
    """

    name: str
    linkage: Linkage
    packed: PackedPattern
    scene: Scene
    dof: int | None
    dof_flat: int | None
    dof_packed: int | None
    locks: dict[str, str]
    branches: str = ""
    motion: PlannedMotion | None = None
    deployment: Deployment | None = None

    @property
    def status(self) -> Status | None:
        """The status, as for a folding; None where no packed state is known and the flat state is not locked."""
        if self.locks or (self.motion is not None and self.motion.locked):
            return "locked"
        if not self.packed.packed:
            return None
        if self.deploys:
            return "deploys"
        return "movable" if self.motion is not None and self.motion.margin is not None else "undecided"

    @property
    def deploys(self) -> bool:
        """Whether springs bring it from packed to flat, certified free of collisions."""
        return self.deployment is not None and self.deployment.deploys

    @property
    def needed_margin(self) -> float | None:
        """The play of each face (m) that the motion behind the status needs; None without one."""
        if self.deployment is not None and self.deployment.deploys and self.deployment.play is not None:
            return self.deployment.play.needed_margin
        return None if self.motion is None else self.motion.margin

    @property
    def play(self) -> str | None:
        """The play that the motion needs, as a sentence."""
        return play_sentence(millimetres(self.needed_margin))

    @property
    def heading(self) -> str:
        """The status."""
        return f"status: {self.status or 'no packed state'}"

    @property
    def deployed_in(self) -> list[tuple[str, str]]:
        """Nothing: `hcsearch deploy` takes the file and the options as they are."""
        return []

    def facts(self) -> dict[str, Any]:
        """All results as plain data; keys name their units."""
        pattern = self.linkage.pattern
        points = pattern.vertices
        outlines = (without_straight_corners(face, points, STRAIGHT_SIDE_SHARE) for face in pattern.faces)
        facets = [tuple(points[v] for v in outline) for outline in outlines]
        rigid = [pair for pair, crease in pattern.creases.items() if crease.face is None]
        return {
            "pattern": self.name,
            "panels": self.linkage.n_panels,
            "hinges": self.linkage.n_hinges,
            "loops": len(self.linkage.loops),
            "longest_edge_mm": millimetres(longest_edge(facets, rigid)),
            "thickness_mm": millimetres(pattern.thickness),
            "scene": self.scene.name,
            "moved_mm": millimetres(self.packed.moved),
            "dof": self.dof,
            "dof_packed": self.dof_packed,
            "dof_flat": self.dof_flat,
            "kutzbach": pattern.kutzbach,
            "status": self.status,
            "reasons": self.reasons,
            "needed_margin_mm": millimetres(self.needed_margin),
            "play": self.play,
        }

    def rows(self) -> Iterator[tuple[str, str]]:
        """Yield the name and the value of each property, and then of each result that is known, as texts."""
        facts = self.facts()
        for name in ("panels", "hinges", "loops"):
            yield name, str(facts[name])
        for name in ("longest_edge_mm", "thickness_mm"):
            yield name.removesuffix("_mm").replace("_", " "), f"{facts[name]:.6g} mm"
        if facts["moved_mm"]:
            yield "points moved", f"by up to {facts['moved_mm']:.3g} mm, so that the packed state closes"
        for name, state in (("dof", "in motion"), ("dof_packed", "packed"), ("dof_flat", "flat")):
            dof = facts[name]
            if name != "dof_packed" or self.packed.packed:
                yield f"dof {state}", "undecided" if dof is None else str(dof)
        yield "kutzbach", str(facts["kutzbach"])
        yield "packed state", self.packed.sentence
        if self.packed.assumed:
            yield "unassigned creases", self.packed.assumed
        for end, sentence in self.locks.items():
            yield f"lock at {end}", sentence
        if self.branches:
            yield "motions from flat", self.branches
        if self.motion is not None:
            yield "planned path", reason_of(self.motion, joined=False)
        if self.deployment is not None:
            yield "springs", self.deployment.sentence

    @property
    def reasons(self) -> list[str]:
        """The packed state, the faces of unassigned creases, the locks and the results of the stages, as sentences."""
        told = [*filter(None, (self.packed.sentence, self.packed.assumed))]
        told += [f"{end}: {sentence}" for end, sentence in self.locks.items()]
        if self.branches:
            told.append(f"motions from flat: {self.branches}")
        if self.motion is not None:
            told.append(reason_of(self.motion, joined=False))
        if self.deployment is not None:
            told.append(f"springs: {self.deployment.sentence}")
        return told


def check_pattern(
    name: str,
    packed: PackedPattern,
    scene: Scene,
    progress: Progress = lambda _done, _total, _stage: None,
) -> Checked:
    """Take a drawn pattern through the stages of a folding in a scene, until one shows that it is locked.

    progress : called with the stages done, their number, and the next one. SizeError as in `plan_linkage_motion`.
    """
    linkage = Linkage(packed.pattern)
    setup = setup_of_scene(scene, linkage)  # a scene that names an unknown hinge is refused before the work

    def begin(stage: str) -> None:
        progress(FOLDING_STAGES.index(stage), len(FOLDING_STAGES), stage)

    def run(stage: str, verdict: PatternVerdict) -> PatternVerdict:
        if stage == "mobility":
            return pattern_mobility(name, packed, linkage, scene)
        if stage == "motion":
            return replace(verdict, motion=plan_linkage_motion(linkage, scene.margin))
        return replace(verdict, deployment=simulate_deployment(linkage, setup))

    unjudged = PatternVerdict(name, linkage, packed, scene, None, None, None, {})
    verdict = through_stages(unjudged, run, begin, lambda verdict: verdict.status == "locked" or not packed.packed)
    return _checked(verdict)


def _checked(verdict: PatternVerdict) -> Checked:
    """Return the verdict on a pattern with its sizes and freedoms."""
    facts = verdict.facts()
    freedoms = {"during the motion": "dof", "packed": "dof_packed", "flat": "dof_flat"}
    told = [f"{'-' if facts[key] is None else facts[key]} {state}" for state, key in freedoms.items()]
    sizes = f"longest edge {facts['longest_edge_mm']:.6g} mm, {facts['thickness_mm']:.6g} mm thick"
    heads = [f"{verdict.name}: {sizes_text(facts)}", f"  {sizes}, scene {facts['scene']}"]
    if facts["moved_mm"]:
        heads.append(f"  points are moved by up to {facts['moved_mm']:.3g} mm, so that the packed state closes")
    heads.append(f"  degrees of freedom: {', '.join(told)} (Kutzbach {facts['kutzbach']})")
    return Checked(verdict.scene, facts, heads, (verdict,), {})


@work_step("computing the degrees of freedom")
def pattern_mobility(name: str, packed: PackedPattern, linkage: Linkage, scene: Scene) -> PatternVerdict:
    """Return the degrees of freedom and the locks of a drawn pattern and its linkage, without later stages."""
    locks = _locks(linkage, packed=packed.packed)
    state = linkage.folded if packed.packed else None
    checked = PatternVerdict(
        name,
        linkage,
        packed,
        scene,
        dof=0 if locks else _moving(linkage, state).nullity,
        dof_flat=rank_at(linkage, linkage.flat).nullity,
        dof_packed=None if state is None else rank_at(linkage, state).nullity,
        locks=locks,
    )
    return checked if locks or packed.packed else replace(checked, branches=_branches(checked))


def _branches(checked: PatternVerdict) -> str:
    """Return a sentence on the finite motions that leave the flat state; empty where there are too many to search."""
    if not 0 < (checked.dof_flat or 0) <= MAX_BRANCHING_DOF:
        return ""
    return find_branches(checked.linkage, checked.linkage.flat, stops=True).sentence


def _locks(linkage: Linkage, *, packed: bool) -> dict[str, str]:
    """Return the proofs that no motion leaves an end, by the end, as sentences."""
    verdicts = {"flat": lock_at(linkage, linkage.flat)}
    if packed:
        verdicts["packed"] = lock_at(linkage, linkage.folded, contact_rows(linkage) if linkage.folds_flat else None)
    return {
        end: f"locked ({'exact proof' if lock.exact else 'numerical proof for points as drawn'}), {lock.reason}"
        for end, lock in verdicts.items()
        if lock.locked
    }


def _moving(linkage: Linkage, packed: Reals | None) -> Rank:
    """Return the rank at a generic closed state near the packed state, if there is one, else near the flat one."""
    near_packed = None if packed is None else generic_rank(linkage, packed)
    if near_packed is not None and near_packed.rank is not None:
        return near_packed
    return generic_rank(linkage, linkage.flat)
