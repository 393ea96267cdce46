"""Compilation of a scene to the terms that it needs, with the exact omissions, and its closed start."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from hcsearch.basics.array_values import ByValue, Flags, Reals, WholeNumbers
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import Formulation
from hcsearch.motion.collision.panel_prisms import kept_apart
from hcsearch.motion.kinematics.within_stops import close_within_stops
from hcsearch.scenes import Scene
from hcsearch.scenes.laws import scaled_law
from hcsearch.scenes.setup import Setup, setup_of_scene
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.dynamics.body_trees import GROUND, Body, TreeJoint, Weld, joined_body
from hcsearch.springs.dynamics.panels import Mirror, PanelTree, facet_drag, mirror_of, panel_bodies, panel_tree
from hcsearch.springs.dynamics.system import CutHinge, FacetDrag, JointDrive, System
from hcsearch.springs.dynamics.time_integration import cut_states


def start_state(linkage: Linkage, share: float) -> Reals:
    """Return the fold angles of the closed state nearest to a share of the folded ones, within the stops.

    The thesis's start, every hinge at 0.999 pi, is not closed. Where there is no closed state near it, the start is the
    folded state itself, as for foldings locked there at first order; those locked there at second order may start 1e-6
    to 4e-6 rad beside it.
    """
    if not 0.0 < share <= 1.0:
        raise HcsearchError(f"no deployment starts at {share:g} of the folded angles: give a share above 0, up to 1")
    folded: Reals = linkage.folded
    if share == 1.0:
        return folded
    closed, _ = close_within_stops(linkage, share * folded)
    if closed is not None:
        return closed.angles
    if share < 0.9:
        raise HcsearchError(f"no closed state lies near {share:g} of the folded angles: start nearer to 1")
    return folded


OMISSIONS = ("half", "third dimension", "stops")
"""Names of the omissions that a symmetry or a bound allows."""
ALL_OMISSIONS = (*OMISSIONS, "pairs", "closure", "gravity", "base")
"""Names of all omissions. The last three omit terms that a scene does not have; put back, they do nothing: closure
equations of a panel in two halves, a gravity of `NO_GRAVITY`, the joints of a base that is locked."""
NO_GRAVITY = (0.0, 0.0, -1e-30)
"""A gravity (m/s^2) that changes no number: it is below the rounding error of any other acceleration."""


AT_STOP_ANGLE = 1e-6
"""Distance within which a hinge is at a stop (rad)."""


@dataclass(frozen=True)
class Omission:
    """An omission of the compiler and its justification; all are exact."""

    name: str
    what: str
    why: str


@dataclass(frozen=True, eq=False)
class CompiledScene(ByValue):
    """A scene of a linkage as a system of bodies.

    setup : the scene evaluated for the linkage.
    start : (n_joints,), coordinates. joint_of : (n_hinges,), the joint of each hinge, -1 - k for cut hinge k.
    hinged : (n_joints,), whether the joint is a hinge, and not one of a floating base. shares : (n_joints,), 1/2 for
        half a hinge, else 1.
    factor : factor of energies, 2 where half of the array is omitted.
    separated_pairs : pairs of panels, the lower number first, that cannot meet, or only when others do.
    """

    linkage: Linkage
    setup: Setup
    formulation: Formulation
    system: System
    start: Reals
    joint_of: WholeNumbers
    hinged: Flags
    shares: Reals
    factor: float
    separated_pairs: frozenset[tuple[int, int]]
    omissions: tuple[Omission, ...]

    @property
    def seconds(self) -> float:
        """The simulated time, s."""
        return self.setup.seconds

    @property
    def margin(self) -> float:
        """The margin by which panels are shrunk on every face when collisions are checked, m."""
        return self.setup.margin

    def of_hinges(self, q: Reals, v: Reals) -> tuple[Reals, Reals]:
        """Return fold angles and rates of all hinges, (k, n_hinges), from those of the joints, (k, n_joints)."""
        angles, rates = q[:, self.joint_of], v[:, self.joint_of]
        cut = np.flatnonzero(self.joint_of < 0)
        if len(cut):
            cut_folds, cut_rates = cut_states(self.system, q, v)
            angles[:, cut], rates[:, cut] = cut_folds[:, -1 - self.joint_of[cut]], cut_rates[:, -1 - self.joint_of[cut]]
        return angles, rates

    def hinges_of(self, joint: int) -> list[int]:
        """Return the hinges of a joint; cut hinges are numbered after the joints."""
        cut = joint - len(self.system.joints)
        hinges = np.flatnonzero(self.joint_of == (joint if cut < 0 else -1 - cut))
        return [int(hinge) for hinge in hinges]

    def at_stops(self, q: Reals) -> Stops:
        """Return the hinges that are closed and open at one state."""
        angles = self.of_hinges(q[None], np.zeros((1, len(q))))[0][0]
        closed, opened = np.flatnonzero(angles >= math.pi - AT_STOP_ANGLE), np.flatnonzero(angles <= AT_STOP_ANGLE)
        return Stops(tuple(closed.tolist()), tuple(opened.tolist()))


@dataclass(frozen=True)
class Stops:
    """Hinges at their folded and at their flat stops."""

    closed: tuple[int, ...]
    open: tuple[int, ...]


def compile_scene(
    linkage: Linkage,
    scene: Scene | Setup,
    formulation: Formulation = "constrained",
    *,
    keep: frozenset[str] = frozenset(),
) -> CompiledScene:
    """Compile a scene of a linkage; keep : names of `ALL_OMISSIONS` that are not to be omitted.

    Bodies and joints are those of the congruent linkage, if there is one.
    """
    unknown = keep - set(ALL_OMISSIONS)
    if unknown:
        raise HcsearchError(f"a simulation has no omission {min(unknown)!r}: choose from {', '.join(ALL_OMISSIONS)}")
    setup, twin = setup_of_scene(scene, linkage), linkage.twin
    if twin is None:
        return _Compiler(linkage, setup, formulation, keep).run()
    compiled = compile_scene(twin.linkage, setup.of_congruent(linkage), formulation, keep=keep)
    panel_of = {image: panel for panel, image in enumerate(twin.panels)}
    pairs = ((panel_of[first], panel_of[second]) for first, second in compiled.separated_pairs)
    separated_pairs = frozenset((min(pair), max(pair)) for pair in pairs)
    joint_of = compiled.joint_of[list(twin.hinges)]
    return replace(compiled, linkage=linkage, setup=setup, joint_of=joint_of, separated_pairs=separated_pairs)


class _Compiler:
    """The compilation of one setup."""

    def __init__(self, linkage: Linkage, setup: Setup, formulation: Formulation, keep: frozenset[str]) -> None:
        self.linkage, self.setup, self.formulation, self.keep = linkage, setup, formulation, keep
        self.weightless = not any(setup.gravity)
        self.laws = setup.laws
        self.angles = start_state(linkage, setup.start)
        self.omissions: list[Omission] = []
        self.unreached = self._unreached()

    def run(self) -> CompiledScene:
        mirror = self._mirror()
        penalty, compliant = self.formulation == "penalty", self.formulation == "compliant"
        springy = penalty or compliant
        if penalty and (self.setup.hold_downs or self.setup.law_times):
            raise HcsearchError(
                "the penalty formulation has no hold-downs and no laws in time: leave them out, or take another one"
            )
        if springy and self.linkage.loops and not self.setup.cut_stiffness:
            raise HcsearchError("cut_stiffness cannot be 0 where springs close the loops: give a positive number")
        halved = "closure" in self.keep and not self.linkage.loops and not penalty
        cuts = {"cut_hinges": penalty, "halved_leaf": halved}
        tree = panel_tree(self.linkage, self.setup.density, self.setup.held, mirror=mirror, **cuts)
        joints, bodies, welds, shift = self._with_base(tree, mirror)
        welds = self._welds(welds)
        if shift and not self.setup.free:  # locked in all directions in which it could move
            welds = (*welds, _lock(shift - 1, joints[shift - 1].point, mirror))
        drives = (*(JointDrive() for _ in range(shift)), *self._drives(tree))
        if self.formulation == "quasistatic" and not all(drive.damping > 0.0 for drive in drives):
            raise HcsearchError(
                "quasistatic motion has only dampers to set its speed: give every hinge one (damping above 0, springs "
                "that are not free) and hold a panel, or take the constrained formulation"
            )
        system = System(
            joints,
            bodies,
            drives,
            welds,
            gravity=NO_GRAVITY if self.weightless and "gravity" in self.keep else self.setup.gravity,
            size=self.linkage.pattern.size,
            stop_stiffness=self.setup.stop_stiffness if springy else 0.0,
            stop_damping=self.setup.stop_damping if springy else 0.0,
            cuts=self._cuts(tree, shift),
            cut_stiffness=self.setup.cut_stiffness,
            cut_damping=self.setup.cut_damping,
            closure_stiffness=self.setup.cut_stiffness if compliant else 0.0,
            closure_damping=self.setup.cut_damping if compliant else 0.0,
            overdamped=self.formulation == "quasistatic",
            drags=self._drags(tree, mirror, shift),
        )
        joint_of = np.where(tree.joint_of >= 0, tree.joint_of + shift, -1)
        start = np.concatenate([np.zeros(shift), self.angles[tree.hinge_of]])
        for cut, (hinge, _, _) in enumerate(tree.cuts):
            joint_of[hinge] = -1 - cut
        hinged = np.arange(len(joints)) >= shift
        self._report_absent_terms()
        scene = (self.linkage, self.setup, self.formulation, system, start, joint_of, hinged)
        shares, factor = np.concatenate([np.ones(shift), tree.shares]), 1.0 if mirror is None else 2.0
        return CompiledScene(*scene, shares, factor, self._separated_pairs(mirror), tuple(self.omissions))

    def _leave_out(self, name: str, what: str, why: str) -> None:
        self.omissions.append(Omission(name, what, why))

    def _mirror(self) -> Mirror | None:
        """Return the mirror of the whole scene, if one half of it determines the other."""
        # a half has other springs that close its loops than the whole, in number and places
        springy = self.formulation == "penalty" or (self.formulation == "compliant" and bool(self.linkage.loops))
        if "half" in self.keep or springy:
            return None
        mirror = mirror_of(self.linkage, self.setup.held)
        if mirror is None:
            return None
        images = list(mirror.hinges)
        laws = [(law.straight, law.bent, law.snap_up, law.snap_down, law.begin, law.full) for law in self.laws]
        hinges = list(zip(laws, self.setup.dampings, self.setup.resistance, strict=True))
        springs_symmetric = all(hinges[k] == hinges[image] for k, image in enumerate(images))
        gravity_symmetric = abs(np.dot(self.setup.gravity, mirror.normal)) <= 1e-12 * (
            1.0 + math.hypot(*self.setup.gravity)
        )
        held_symmetric = set(self.setup.hold_downs) == {held.moved(images) for held in self.setup.hold_downs}
        if (
            not (springs_symmetric and gravity_symmetric and held_symmetric)
            or np.abs(self.angles - self.angles[images]).max() > 1e-9
        ):
            return None
        self.angles = 0.5 * (self.angles + self.angles[images])
        self._leave_out(
            "half",
            f"half of the array: {sum(mirror.beyond)} panels",
            "pattern, springs, dampers, gravity and start are symmetric in a plane through the held panel, "
            "so the motion is",
        )
        return mirror

    def _with_base(
        self, tree: PanelTree, mirror: Mirror | None
    ) -> tuple[tuple[TreeJoint, ...], tuple[Body, ...], tuple[Weld, ...], int]:
        """Return joints, bodies and welds with the floating base before them, and the number of its joints."""
        if not self.floats:
            return tree.joints, tree.bodies, tree.welds, 0
        panel = panel_bodies(self.linkage, self.setup.density)[self.setup.held]
        base = joined_body([panel, Body(self.setup.base_mass, panel.centre, np.diag(self.setup.base_inertia))])
        base = base.share(1.0 if mirror is None else 0.5)
        if mirror is None:
            slides, turns = np.eye(3), np.eye(3)
        else:  # in the mirror plane it slides two ways and turns about one
            slides, turns = mirror.frame[1:], mirror.frame[:1]
        axes = [(axis, True) for axis in slides] + [(axis, False) for axis in turns]
        shift = len(axes)
        massless = Body(0.0, panel.centre, np.zeros((3, 3)))
        joints = [TreeJoint(k - 1, axis, panel.centre, sliding) for k, (axis, sliding) in enumerate(axes)]
        parents = [shift - 1 if joint.parent == GROUND else joint.parent + shift for joint in tree.joints]
        joints += [replace(joint, parent=parent) for joint, parent in zip(tree.joints, parents, strict=True)]
        bodies = (*(massless for _ in range(shift - 1)), base, *tree.bodies)

        def moved(body: int, held: bool) -> int:
            return body + shift if body != GROUND else (shift - 1 if held else GROUND)

        # welds that close loops at the held panel move with it; welds to the mirror plane stay
        welds = tuple(
            Weld(moved(w.first, len(w.kinds) == 6), w.second + shift, w.point, w.kinds, w.frame) for w in tree.welds
        )
        return tuple(joints), bodies, welds, shift

    @property
    def floats(self) -> bool:
        """Whether the held panel has joints of a base."""
        return self.setup.free or "base" in self.keep

    def _drives(self, tree: PanelTree) -> list[JointDrive]:
        """Return law, damping and stops of each joint of a hinge."""
        drives = [JointDrive()] * len(tree.joints)
        for hinge, joint in enumerate(tree.joint_of):
            if joint >= 0:
                drives[joint] = self._drive(hinge, float(tree.shares[joint]))
        return drives

    def _drive(self, hinge: int, share: float = 1.0) -> JointDrive:
        law = self.laws[hinge]
        upper = math.inf if hinge in self.unreached else math.pi
        share_of_law = law if share == 1.0 else scaled_law(law, share)
        damping, friction = self.setup.damping_of(hinge, law), self.setup.resistance[hinge]
        return JointDrive(share_of_law, share * damping, 0.0, upper, share * friction)

    def _unreached(self) -> set[int]:
        """Find hinges that cannot return to their folded stop: the start energy does not suffice for one spring."""
        if "stops" in self.keep or not self.weightless or self.setup.law_times:
            return set()
        at_start = [law.energy(angle) for law, angle in zip(self.laws, self.angles, strict=True)]
        least_energies = [min(0.0, law.least_energy) for law in self.laws]
        available = (sum(at_start) - sum(least_energies)) * (1.0 + 1e-9)
        needed = [law.energy(math.pi) - least for law, least in zip(self.laws, least_energies, strict=True)]
        unreached = {k for k, energy in enumerate(needed) if self.angles[k] < math.pi and energy > available}
        if unreached:
            self._leave_out(
                "stops",
                f"the folded stops of {len(unreached)} hinges",
                "the energy at the start is less than one of their springs would take to close again",
            )
        return unreached

    def _cuts(self, tree: PanelTree, shift: int) -> tuple[CutHinge, ...]:
        cuts = []
        for hinge, first_body, second_body in tree.cuts:
            line = self.linkage.pattern.hinges[hinge]
            height = self.linkage.points[hinge][2]
            ends = (np.array([*line.start, height]), np.array([*line.end, height]))
            base = shift - 1 if self.floats else GROUND
            bodies = [body + shift if body != GROUND else base for body in (first_body, second_body)]
            cuts.append(CutHinge(bodies[0], bodies[1], ends, self.linkage.directions[hinge], self._drive(hinge)))
        return tuple(cuts)

    def _drags(self, tree: PanelTree, mirror: Mirror | None, shift: int) -> tuple[FacetDrag, ...]:
        """Return the facets of moving panels, on which air acts; halves of panels that the mirror plane halves."""
        if not self.setup.drag:
            return ()
        pattern, facets = self.linkage.pattern, []
        for panel, parts in enumerate(pattern.panels):
            body = int(tree.body_of[panel]) + shift
            if tree.body_of[panel] == GROUND:
                if not self.setup.free or panel != self.setup.held:
                    continue
                body = shift - 1
            share = 0.5 if mirror is not None and mirror.panels[panel] == panel else 1.0
            facets += [
                facet_drag(body, pattern.facets[facet], pattern.thickness, share * self.setup.drag) for facet in parts
            ]
        return tuple(facets)

    def _welds(self, welds: tuple[Weld, ...]) -> tuple[Weld, ...]:
        """Reduce welds to motions in the plane normal to the hinges, if all hinges are parallel."""
        directions = self.linkage.directions
        if not welds or np.abs(np.cross(directions, axis := directions[0])).max() > 1e-9:
            return welds
        # rows that keep panels in a mirror plane normal to the hinges read 0 = 0: rounding would choose among them
        welds = tuple(w for w in welds if len(w.kinds) == 6 or np.abs(np.cross(w.frame[0], axis)).max() > 1e-9)
        if "third dimension" in self.keep:
            return welds
        whole = [weld for weld in welds if len(weld.kinds) == 6]
        if whole:
            self._leave_out(
                "third dimension",
                f"{3 * len(whole)} of {6 * len(whole)} closure equations",
                "all hinges are parallel, so panels move in planes across them",
            )
        upright = np.array([0.0, 0.0, 1.0])
        frame = np.array([axis, np.cross(upright, axis), upright])
        return tuple(Weld(w.first, w.second, w.point, (0, 4, 5), frame) if len(w.kinds) == 6 else w for w in welds)

    def _separated_pairs(self, mirror: Mirror | None) -> frozenset[tuple[int, int]]:
        """Return the pairs of panels that are not checked for contact."""
        if "pairs" in self.keep:
            return frozenset()
        joined = kept_apart(self.linkage)
        images = set()
        if mirror is not None:
            for pair in combinations(range(self.linkage.n_panels), 2):
                image = sorted(mirror.panels[panel] for panel in pair)
                if image < list(pair):
                    images.add(pair)
        separated = frozenset(joined | images)
        self._leave_out(
            "pairs",
            f"{len(separated)} of {math.comb(self.linkage.n_panels, 2)} pairs of panels in the check for contact",
            "stops keep panels on two sides of a hinge apart" + (", and mirror pairs meet together" if images else ""),
        )
        return separated

    def _report_absent_terms(self) -> None:
        """Report omissions of terms that the scene does not have."""
        if not self.linkage.loops and "closure" not in self.keep:
            self._leave_out("closure", "closure", "the array is an open chain")
        if self.weightless and "gravity" not in self.keep:
            self._leave_out("gravity", "gravity", "the scene has none")
        if not self.floats:
            self._leave_out("base", "six freedoms of a floating base", "a panel is held")


def _lock(body: int, point: Reals, mirror: Mirror | None) -> Weld:
    """Return the weld that holds a base; in a mirror plane, in the ways in which it moves there."""
    if mirror is None:
        return Weld(GROUND, body, point)
    return Weld(GROUND, body, point, (0, 4, 5), mirror.frame)
