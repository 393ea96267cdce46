"""A folding as a machine: its certified path driven by few hinges, or opened by springs alone behind latches.

On a path some hinges leave the packed state later than others. Each of these is latched, and released by one other
hinge: the one that has turned furthest on the path by then, at its angle at that place. Latches are modelled as stops.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.designs.folding import Folding
from hcsearch.designs.twisting import twist
from hcsearch.motion.planning.motion_search import PlannedMotion, ProvedPath, plan_motion, reason_of
from hcsearch.scenes import Scene, panel_of
from hcsearch.scenes.setup import setup_of_scene
from hcsearch.shape.labels import is_label, label_data, labels_of
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
from hcsearch.springs.drive.choosing import FIRM_SINGULAR_VALUE, choose_driven_hinges, judge_driven_hinges
from hcsearch.springs.drive.drive_facts import Drive
from hcsearch.springs.drive.torques import DEFAULT_CONTROL_PERIOD, position_control, torques_along
from hcsearch.springs.drive.trajectory import (
    DRIVE_END_ANGLES,
    MAX_HINGE_ACCELERATION,
    MAX_HINGE_RATE,
    smooth_path,
    time_path,
)
from hcsearch.springs.dynamics.system import System
from hcsearch.springs.dynamics.time_integration import Motion, joined_motion, simulate_system
from hcsearch.system.work_steps import Progress

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
TORQUE_TIME_COUNT, JUDGED_PLACE_COUNT = 1000, 600
"""Numbers of times at which torques are computed, and of places on the path at which driven hinges are evaluated."""


@dataclass(frozen=True)
class DriveOptions:
    """Options of a drive.

    rate, acceleration : greatest rate (rad/s) and acceleration (rad/s^2) of a hinge. near : distances (rad) from the
    packed and the flat state at which the driven motion begins and ends. hinges : the driven hinges, by name; chosen
    where empty. firm : hinges are added until the least singular value of the reduced Jacobian reaches this; 0 for as
    many
    hinges as there are freedoms. period : the sampling period of the controller, s.
    """

    rate: float = MAX_HINGE_RATE
    acceleration: float = MAX_HINGE_ACCELERATION
    near: tuple[float, float] = DRIVE_END_ANGLES
    hinges: tuple[str, ...] = ()
    firm: float = FIRM_SINGULAR_VALUE
    period: float = DEFAULT_CONTROL_PERIOD

    def __post_init__(self) -> None:
        if not all(map(is_label, self.hinges)):
            raise HcsearchError(f"cannot read --hinges {','.join(self.hinges)!r}: write numbers, such as 0,4,5")


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


def no_path_reason(motion: PlannedMotion) -> str:
    """Return a sentence on why a linkage that is no folding has no proved path: a lock, or an undecided search."""
    if motion.locked:
        return reason_of(motion, joined=False)
    return f"undecided: {reason_of(motion, joined=False)}; try other panels, or a scene file with a greater margin_mm"


def drive_along(
    folding: Folding,
    scene: Scene,
    motion: PlannedMotion,
    options: DriveOptions | None = None,
    progress: Progress | None = None,
) -> Drive:
    """Design and simulate the drive of a folding along a proved motion; HcsearchError for options that cannot be met.

    progress : called with the steps done, their number, and the next stage; the first step is the search for the
    motion.
    """
    path = motion.proved
    if path is None:
        raise NoPathError(no_drive_reason(folding, scene, motion))
    panel = panel_of(scene, folding.circuit.grid.name)
    linkage = folding.linkage(panel, flat_pairs=path.way)
    scene = replace(scene, panel=panel, flat_pairs=(path.way,))
    return drive_linkage({"design": folding.notation}, linkage, scene, path, options, progress)


def drive_linkage(
    subject: Mapping[str, str],
    linkage: Linkage,
    scene: Scene,
    proved: ProvedPath,
    options: DriveOptions | None = None,
    progress: Progress | None = None,
) -> Drive:
    """Design and simulate the drive of a linkage along a proved path, as `drive_along`.

    subject : what is driven, as the entries of a scene file.
    """
    options = options or DriveOptions()

    def report_progress(done: int) -> None:
        if progress is not None:
            progress(done, len(DRIVE_STAGES), DRIVE_STAGES[done])

    if not MIN_CONTROL_PERIOD <= options.period <= MAX_CONTROL_PERIOD:
        raise HcsearchError(f"a controller's period of {options.period:g} s is out of range: give one from 1e-5 to 0.1")
    report_progress(1)
    path = smooth_path(linkage, proved.course, options.near)
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
    return Drive(subject, proved.way, linkage, scene, setup, proved.margin, choice, course, torques, drives, deployment)


def latch_facts(driven: Drive) -> dict[str, Any]:
    """Return latches that impose the order of hinges on the path, and the verdict on springs alone with them."""
    path = driven.timed.path
    latches = latches_on(driven.linkage, path.at(np.linspace(0.0, path.length, JUDGED_PLACE_COUNT))[0])
    scene = replace(driven.scene, seconds=None)
    deployment = simulate_latched(compile_driven(driven.linkage, scene, None), latches)
    names = [label_data(name) for name in labels_of(driven.linkage).hinges]
    return {
        "latches": [
            {"hinge": names[latch.hinge], "waits_for": names[latch.waits_for], "angle_rad": latch.angle}
            for latch in latches
        ],
        "latched_verdict": deployment.verdict,
        "latched_reason": deployment.reason,
        "latched_clearance": None if deployment.clearance is None else deployment.clearance.kind,
    }


def start_at_drives(compiled: CompiledScene, drives: Drives) -> CompiledScene:
    """Return a compiled scene that starts at the start of drives."""
    return replace(compiled, start=drives.start_in(compiled))
