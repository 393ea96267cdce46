"""A folding as a machine: its certified path driven by few hinges, or opened by springs alone behind latches.

On a path some hinges leave the packed state later than others. Each of these is latched, and released by one other
hinge: the one that has turned furthest on the path by then, at its angle at that place. Latches are modelled as stops.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import Way
from hcsearch.designs.folding import Folding
from hcsearch.designs.twisting import twist
from hcsearch.motion.planning.motion_search import PlannedMotion, plan_motion, reason_of
from hcsearch.scenes import Scene, panel_of
from hcsearch.scenes.setup import Setup, setup_of_scene
from hcsearch.shape.labels import labels_of
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.compiled_scene import CompiledScene
from hcsearch.springs.deployment.drives import MAX_CONTROL_PERIOD, MIN_CONTROL_PERIOD, Drives
from hcsearch.springs.deployment.outcomes import FLAT_FOLD_ANGLE
from hcsearch.springs.deployment.simulated_deployment import (
    Deployment,
    compile_driven,
    deployment_of_motion,
    simulate_driven_scene,
)
from hcsearch.springs.drive.choosing import FIRM_SINGULAR_VALUE, DrivenHinges, choose_driven_hinges, judge_driven_hinges
from hcsearch.springs.drive.torques import DEFAULT_CONTROL_PERIOD, Torques, position_control, torques_along
from hcsearch.springs.drive.trajectory import (
    DRIVE_END_ANGLES,
    MAX_HINGE_ACCELERATION,
    MAX_HINGE_RATE,
    TimedPath,
    smooth_path,
    time_path,
)
from hcsearch.springs.dynamics.system import System
from hcsearch.springs.dynamics.time_integration import Motion, joined_motion, simulate_system

DEPARTURE_ANGLE = 0.05
"""Turn (rad) from which on a hinge has left the packed state."""
LATCH_DELAY_SHARE = 0.05
"""Delay after the first hinge, as a share of the path, beyond which a hinge is latched."""
LATCH_CHECK_INTERVAL = 0.002
"""Interval at which the release of latches is checked (s)."""


@dataclass(frozen=True)
class Latch:
    """A hinge that is held until another one has unfolded to an angle (rad)."""

    hinge: int
    waits_for: int
    angle: float


def latches_on(linkage: Linkage, angles: Reals) -> tuple[Latch, ...]:
    """Return the latches that follow from a path, (k, n_hinges), from packed to flat; in the order of their release.

    Hinges that are flat in both states are not latched.
    """
    closing = np.flatnonzero(linkage.folded > 0.0)
    turns = linkage.folded - angles
    departures = np.array([int((np.abs(turns[:, hinge]) > DEPARTURE_ANGLE).argmax()) for hinge in closing])
    first = int(departures.min(initial=len(angles)))
    latches = []
    for departure, hinge in sorted(zip(departures.tolist(), closing.tolist(), strict=True)):
        if departure - first <= LATCH_DELAY_SHARE * len(angles):
            continue
        ahead = closing[departures < departure]
        releasing = int(ahead[turns[departure, ahead].argmax()])
        latches.append(Latch(hinge, releasing, float(angles[departure, releasing])))
    return tuple(latches)


def simulate_latched(compiled: CompiledScene, latches: tuple[Latch, ...], *, tolerance: float = 1e-6) -> Deployment:
    """Simulate a deployment by springs with latches, from the start of a scene compiled by `compile_driven`."""
    q, v, waiting = compiled.start.copy(), np.zeros(len(compiled.start)), set(latches)
    motions: list[Motion] = []
    starts: list[float] = []
    now = 0.0
    while now < compiled.seconds:
        motion = simulate_system(
            _latched(compiled, waiting),
            q,
            v,
            end=LATCH_CHECK_INTERVAL if waiting else compiled.seconds - now,
            tolerance=tolerance,
            restitution=compiled.setup.restitution,
            flat=FLAT_FOLD_ANGLE,
            watched=compiled.hinged,
        )
        motions.append(motion)
        starts.append(now)
        q, v, now = motion.q[-1].copy(), motion.v[-1].copy(), now + float(motion.times[-1])
        if motion.ending != "time":
            break
        angles = q[compiled.joint_of]
        waiting = {latch for latch in waiting if angles[latch.waits_for] > latch.angle}
    return deployment_of_motion(compiled, joined_motion(motions, starts))


def _latched(compiled: CompiledScene, waiting: set[Latch]) -> System:
    """Return the system with stops at the latched hinges."""
    drives = list(compiled.system.drives)
    for latch in waiting:
        joint = int(compiled.joint_of[latch.hinge])
        drives[joint] = replace(drives[joint], lower=float(compiled.start[joint]), upper=math.inf)
    return compiled.system.driven(tuple(drives))


SETTLING_TIME = 0.5
"""Simulated time after the end of the course (s)."""
DRIVE_STAGES = ("motion", "driven hinges", "torques", "simulation")
"""Stages of the computation, in order."""
DriveProgress = Callable[[int, int, str], None]
TORQUE_TIME_COUNT, JUDGED_PLACE_COUNT = 1000, 600
"""Numbers of times at which torques are computed, and of places on the path at which driven hinges are evaluated."""


@dataclass(frozen=True)
class DriveOptions:
    """Options of a drive.

    rate, acceleration : greatest of a hinge, rad/s, rad/s^2. near : distances (rad) from the packed and the flat
    state at which the driven motion begins and ends. hinges : the driven hinges, by their names; chosen where empty.
    firm : hinges are added until the least singular value of the reduced Jacobian reaches this; 0 for as many
    hinges as there are freedoms. period : of the controller, s.
    """

    rate: float = MAX_HINGE_RATE
    acceleration: float = MAX_HINGE_ACCELERATION
    near: tuple[float, float] = DRIVE_END_ANGLES
    hinges: tuple[str, ...] = ()
    firm: float = FIRM_SINGULAR_VALUE
    period: float = DEFAULT_CONTROL_PERIOD


@dataclass(frozen=True)
class Drive:
    """A driven folding.

    play : least play of each face (m) at which its path is proved clear. scene : with the panels and the flat-pair
    joint (`way`) of the path. setup : the scene evaluated for the linkage, with the time of the course. deployment :
    the motion simulated under control, certified at the scene's margin.
    """

    folding: Folding
    way: Way
    linkage: Linkage
    scene: Scene
    setup: Setup
    play: float
    choice: DrivenHinges
    timed: TimedPath
    torques: Torques
    drives: Drives
    deployment: Deployment

    @property
    def greatest(self) -> Reals:
        """Greatest torque of each driven hinge under control, until the end of the course, (n_driven,), N m."""
        assert self.deployment.driven is not None
        return self.deployment.driven.greatest_torques

    @property
    def missed(self) -> float:
        """Greatest deviation of a hinge, driven or not, from its planned course during the motion (rad)."""
        return float(np.abs(self.deployment.angles - self.timed.at(self.deployment.motion.times)[0]).max())


class NoPathError(HcsearchError):
    """No proved path along which the folding could be driven."""


def find_drive_motion(folding: Folding, scene: Scene) -> PlannedMotion:
    """Plan a motion of a folding with the panels, flat-pair joints and margin of a scene; HcsearchError without one."""
    ways = [way for way in scene.flat_pairs if folding.can_join(way)]
    if not ways:
        raise HcsearchError("the folding has no mirror image to merge its panels with: leave out --flat-pairs merged")
    return plan_motion(folding, panel_of(scene, folding.circuit.grid.name), ways, scene.margin)


def no_drive_reason(folding: Folding, scene: Scene, motion: PlannedMotion) -> str:
    """Return a sentence on why a folding has no proved path: a twist, a lock, or an undecided search."""
    from hcsearch.motion.locks.end_locks import lock_at  # noqa: PLC0415 - only of foldings without a path

    turns = twist(folding)
    if turns:
        return f"the folding is twisted, with linking number {turns}: no motion leads from packed to flat"
    panel = panel_of(scene, folding.circuit.grid.name)
    for end in ("folded", "flat"):
        linkages = [folding.linkage(panel, flat_pairs=way) for way, _ in motion.growths]
        locks = [lock_at(linkage, getattr(linkage, end)) for linkage in linkages]
        if locks and all(lock.locked for lock in locks):
            return f"the folding is locked, {end}, in every way that the scene allows: {locks[0].reason}"
    hinged = [] if "hinged" in scene.flat_pairs else ["--flat-pairs hinged"]
    remedies = " or ".join(["other panels", *hinged, "a scene file with a greater margin_mm"])
    return f"undecided: {reason_of(motion)}; try {remedies}"


def drive_along(
    folding: Folding,
    scene: Scene,
    motion: PlannedMotion,
    options: DriveOptions | None = None,
    progress: DriveProgress | None = None,
) -> Drive:
    """Design and simulate the drive of a folding along a proved motion; HcsearchError for options that cannot be met.

    progress : called with the steps done, their number, and the next stage; the first step is the search for the
    motion.
    """
    options = options or DriveOptions()

    def report_progress(done: int) -> None:
        if progress is not None:
            progress(done, len(DRIVE_STAGES), DRIVE_STAGES[done])

    if motion.way is None or motion.proof is None or motion.proof.motion is None or motion.margin is None:
        raise NoPathError(no_drive_reason(folding, scene, motion))
    if not MIN_CONTROL_PERIOD <= options.period <= MAX_CONTROL_PERIOD:
        raise HcsearchError(f"a controller's period of {options.period:g} s is out of range: give one from 1e-5 to 0.1")
    panel = panel_of(scene, folding.circuit.grid.name)
    linkage = folding.linkage(panel, flat_pairs=motion.way)
    scene = replace(scene, panel=panel, flat_pairs=(motion.way,))
    report_progress(1)
    path = smooth_path(linkage, motion.proof.motion, options.near)
    angles = path.at(np.linspace(0.0, path.length, JUDGED_PLACE_COUNT))[0]
    labels = labels_of(linkage)
    choice = (
        judge_driven_hinges(linkage, angles, tuple(sorted({labels.hinge(name) for name in options.hinges})))
        if options.hinges
        else choose_driven_hinges(linkage, angles, options.firm)
    )
    report_progress(2)
    course = time_path(path, options.rate, options.acceleration)
    setup = replace(setup_of_scene(scene, linkage), seconds=float(f"{course.seconds + SETTLING_TIME:.4g}"))
    compiled = compile_driven(linkage, setup, None)
    torques = torques_along(compiled, course, choice, TORQUE_TIME_COUNT)
    drives = position_control(compiled, torques, options.period)
    report_progress(3)
    deployment = simulate_driven_scene(start_at_drives(compiled, drives), drives)
    return Drive(folding, motion.way, linkage, scene, setup, motion.margin, choice, course, torques, drives, deployment)


def release_with_latches(driven: Drive) -> tuple[tuple[Latch, ...], Deployment]:
    """Return latches that impose the order of hinges on the path, and a deployment by springs alone with them."""
    path = driven.timed.path
    latches = latches_on(driven.linkage, path.at(np.linspace(0.0, path.length, JUDGED_PLACE_COUNT))[0])
    scene = replace(driven.scene, seconds=None)
    return latches, simulate_latched(compile_driven(driven.linkage, scene, None), latches)


def start_at_drives(compiled: CompiledScene, drives: Drives) -> CompiledScene:
    """Return a compiled scene that starts at the start of drives."""
    return replace(compiled, start=drives.start_in(compiled))


DRIVE_TORQUE_TOLERANCE = 0.05
"""A drive follows its plan if the greatest torque of each driven hinge is within this share of the planned one."""
MIN_COMPARED_TORQUE_SHARE = 0.01
"""Lower bound of the planned torque in that comparison, as a share of the greatest of all hinges."""
DRIVE_ANGLE_TOLERANCE = 0.02
"""Greatest deviation of a hinge from its planned angle (rad) with which a drive follows."""
DEAD_POINT_SINGULAR_VALUE = 0.05
"""Least singular value of the reduced Jacobian below which a dead point is near."""

SINGULAR_CLOSURE_VALUE = 0.01
"""Least singular value of the closure Jacobian below which loops are nearly singular."""


@dataclass(frozen=True)
class Following:
    """The comparison of a drive with its plan.

    follows : whether it follows. share : greatest difference between the greatest torques of a driven hinge under
    control and planned, over the planned one. sentence : both, with a remedy where it does not follow.
    """

    follows: bool
    share: float
    sentence: str


def judge_following(drive: Drive) -> Following:
    """Compare a drive with its plan."""
    planned, greatest = np.abs(drive.torques.torques).max(axis=0), drive.greatest
    shares = np.abs(greatest - planned) / np.maximum(
        np.maximum(planned, MIN_COMPARED_TORQUE_SHARE * planned.max(initial=0.0)), 1e-12
    )
    worst = int(shares.argmax())
    share = float(shares[worst])
    if share <= DRIVE_TORQUE_TOLERANCE and drive.missed <= DRIVE_ANGLE_TOLERANCE:
        return Following(True, share, f"follows: greatest torques are within {_percent(share)} of those planned")
    cause = f"hinges miss their planned angles by up to {drive.missed:.2g} rad"
    if share > DRIVE_TORQUE_TOLERANCE:
        hinge = labels_of(drive.linkage).hinges[drive.drives.hinges[worst]]
        cause = f"hinge {hinge} takes {greatest[worst]:.3g} N m where {planned[worst]:.3g} are planned"
    return Following(False, share, f"does not follow: {cause}; {_remedy(drive)}")


def _remedy(drive: Drive) -> str:
    """Return a remedy for a drive that does not follow, or the advice where there is none.

    Where loops are nearly singular, the manifold of closed states bends sharply, and the torques that a controller adds
    there depend on rounding.
    """
    assert drive.deployment.driven is not None
    drives, driven = drive.drives, drive.deployment.driven
    times = np.linspace(0.0, drive.timed.seconds, 5000)
    interpolated, plan = drives.interpolated(times), drives.at(times)
    interpolation_torque = _most(
        interpolated[2]
        - plan[2]
        + drives.stiffness * (interpolated[0] - plan[0])
        + drives.damping * (interpolated[1] - plan[1])
    )
    if interpolation_torque > 0.5 * _most(driven.torques - driven.planned):
        return "give a shorter --period, or a smaller --rate"
    if drive.choice.least_value < DEAD_POINT_SINGULAR_VALUE:
        return "a dead point is near: drive more hinges (a greater --firm)"
    if drive.choice.closure_value < SINGULAR_CLOSURE_VALUE:
        location = f"{drive.choice.closure_place:.2g} of the path"
        return f"its loops are nearly singular at {location}: size motors by simulated torques, or try other panels"
    return "give a smaller --rate and --acceleration, or drive more hinges (a greater --firm)"


def _most(values: Reals) -> float:
    return float(np.abs(values).max(initial=0.0))


def _percent(share: float) -> str:
    return f"{max(100.0 * share, 0.1):.2g} %"
