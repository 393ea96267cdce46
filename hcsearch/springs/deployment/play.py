"""The play between panels that a deployment needs: the least margin at which its motion is certified clear.

It is reported with the least gap of the panels as built, without a margin, which is negative where they overlap.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.collision.intervals import Course
from hcsearch.motion.collision.clearance import certify_clearance, least_gap_of_motion
from hcsearch.motion.collision.panel_prisms import MIN_PANEL_MARGIN, TOUCHING_DISTANCE, scale_of, slack_of
from hcsearch.springs.deployment.compiled_scene import CompiledScene
from hcsearch.springs.dynamics.time_integration import Motion, closed_between
from hcsearch.system.work_steps import work_step


class DeploymentCourse(NamedTuple):
    """The course of the fold angles; slacks : greatest displacement of panels in each step, m."""

    course: Course
    slacks: Reals


def course_of_deployment(compiled: CompiledScene, motion: Motion) -> DeploymentCourse:
    """Return the course of a motion of a compiled scene, with states inserted to keep its loops closed."""
    (times, q, v, a), gaps = closed_between(compiled.system, motion)
    angles, rates = compiled.of_hinges(q, v)
    cubic = motion.cubic or bool((compiled.joint_of < 0).any())  # accelerations of cut hinges are not known
    accelerations = np.zeros_like(angles) if cubic else a[:, compiled.joint_of]
    angles, rates, accelerations = map(np.ascontiguousarray, (angles, rates, accelerations))
    if (compiled.joint_of < 0).any():  # the extension of the springs of cut hinges opens the loops
        gaps = np.maximum(gaps, motion.gap)
    slacks = slack_of(compiled.linkage, 1.0) * gaps
    return DeploymentCourse(Course(times, angles, rates, accelerations, cubic), slacks)


@dataclass(frozen=True)
class Play:
    """The play of a motion that is certified clear at the margin of its scene.

    needed_margin : m, the least margin at which it is certified clear, among the scene's own and the multiples of
        `MIN_PANEL_MARGIN` in proportion to the panels.
    least_gap : m, of the panels as built at any time, negative where they overlap; gaps and overlaps below
        `TOUCHING_DISTANCE` in proportion to the panels are 0. None where no two panels are compared.
    """

    needed_margin: float
    least_gap: float | None

    def clearance(self, gap: float | None) -> float | None:
        """Return the smallest gap to which panels return (`Clearance.gap`), or the least gap of panels that overlap."""
        return self.least_gap if self.least_gap is not None and self.least_gap < 0.0 else gap


@work_step("computing the play")
def play_of_deployment(compiled: CompiledScene, motion: Motion, least_margin: float = 0.0) -> Play:
    """Compute the play of a motion that is certified clear; least_margin : as in `needed_margin_of`."""
    path = course_of_deployment(compiled, motion)
    return Play(_needed(compiled, path, least_margin), _least_gap(compiled, path))


def least_gap_of(compiled: CompiledScene, motion: Motion) -> float | None:
    """Compute the least gap of the panels as built, m, as in `Play`."""
    return _least_gap(compiled, course_of_deployment(compiled, motion))


def _least_gap(compiled: CompiledScene, path: DeploymentCourse) -> float | None:
    touching = TOUCHING_DISTANCE * scale_of(compiled.linkage)
    gap = least_gap_of_motion(compiled.linkage, path.course, resolution=touching, apart=compiled.separated_pairs)
    return 0.0 if gap is not None and abs(gap) < touching else gap


def needed_margin_of(compiled: CompiledScene, motion: Motion, least_margin: float = 0.0) -> float:
    """Compute the least margin (m) at which a motion is certified clear; least_margin : a lower bound of it.

    The motion must be certified at the scene's margin. A motion certified with a margin is certified with any greater
    one, so the least is found by bisection.
    """
    return _needed(compiled, course_of_deployment(compiled, motion), least_margin)


def _needed(compiled: CompiledScene, path: DeploymentCourse, least_margin: float) -> float:
    linkage = compiled.linkage
    step = MIN_PANEL_MARGIN * scale_of(linkage)
    count = math.ceil(compiled.margin / step * (1.0 - 1e-9)) - 1
    margins = [margin for k in range(1, count + 1) if (margin := k * step) >= least_margin * (1.0 - 1e-9)]
    margins.append(compiled.margin)
    certified = partial(certify_clearance, linkage, slack=path.slacks, apart=compiled.separated_pairs, measured=False)
    low, high = 0, len(margins) - 1
    tried = 0  # the least margin first: most motions in which panels hardly touch need no more
    while low < high:
        if certified(path.course, margin=margins[tried]).kind == "clear":
            high = tried
        else:
            low = tried + 1
        tried = (low + high) // 2
    return margins[high]
