"""The motion of a deployment as collisions are looked for in it: courses of fold angles, and what is open of loops."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hcsearch.basics.arrays import Reals
from hcsearch.kernels.collision.intervals import Course
from hcsearch.motion.collision.reaches import slack_of
from hcsearch.springs.deployment.compiling import CompiledScene
from hcsearch.springs.dynamics.simulation import Motion, closed_between


class DeploymentCourse(NamedTuple):
    """The course of the fold angles; slack : what panels may be elsewhere, m, at all times or in each step."""

    course: Course
    slack: float | Reals


def course_of_deployment(compiled: CompiledScene, motion: Motion) -> DeploymentCourse:
    """The course of a motion of a compiled scene, with the states that keep its loops closed between two."""
    (times, q, v, a), gaps = closed_between(compiled.system, motion)
    angles, rates = compiled.of_hinges(q, v)
    cubic = motion.cubic or bool((compiled.joint_of < 0).any())  # accelerations of cut hinges are not known
    accelerations = np.zeros_like(angles) if cubic else a[:, compiled.joint_of]
    angles, rates, accelerations = map(np.ascontiguousarray, (angles, rates, accelerations))
    if (compiled.joint_of < 0).any():  # what the springs of cut hinges give way opens the loops
        gaps = np.maximum(gaps, motion.gap)
    # springs that close loops give way at impacts, for moments; exact loops hardly open at all
    slack = slack_of(compiled.linkage, 1.0) * (gaps if motion.cubic else gaps.max(initial=0.0))
    return DeploymentCourse(Course(times, angles, rates, accelerations, cubic), slack)
