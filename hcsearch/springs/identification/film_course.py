"""The fold angles of a deployment as a function of time, to compare with films, and the noise of a film."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hcsearch.basics.array_values import ByValue, Flags, Reals
from hcsearch.scenes.setup import Setup
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.compiled_scene import CompiledScene, compile_scene
from hcsearch.springs.deployment.outcomes import MAX_DEPLOYMENT_STEPS, methods_of
from hcsearch.springs.deployment.released_hinges import simulate_releases
from hcsearch.springs.dynamics.time_integration import Motion
from hcsearch.springs.identification.measured_films import Film

COURSE_TOLERANCE = 1e-8
"""Error of a step of a fitted motion: its derivatives by differences need more digits than a film has."""
NOISE_NEIGHBOURS = (-2, -1, 1, 2)
"""Frames whose cubic predicts the frame between them."""
MEDIAN_TO_DEVIATION = 1.4826
"""Standard deviation over median magnitude of a normal distribution."""


@dataclass(frozen=True, eq=False)
class FilmedCourse(ByValue):
    """A simulated deployment, from its release at time 0."""

    compiled: CompiledScene
    motion: Motion

    def at(self, times: Reals) -> Reals:
        """Return the fold angles (rad) at times (s) since the release, shape (len(times), n_hinges).

        Before the release they are those of the start. After the end of the simulation they are those of the end; where
        that is the flat state (0.01 rad), each angle that closes decays exponentially, from its last rate on, as it
        does where dampers slow it down.
        """
        motion, end = self.motion, float(self.motion.times[-1])
        inside = motion.at(np.clip(times, 0.0, end))
        angles, _ = self.compiled.of_hinges(inside, np.zeros_like(inside))
        if motion.ending == "flat":
            last, rates = (part[0] for part in self.compiled.of_hinges(motion.q[-1:], motion.v[-1:]))
            late = times > end
            decays = np.minimum(np.divide(rates, last, out=np.zeros_like(last), where=last != 0.0), 0.0)
            angles[late] = last * np.exp(decays * (times[late] - end)[:, None])
        return angles


def course_of(linkage: Linkage, setup: Setup, seconds: float, tolerance: float = COURSE_TOLERANCE) -> FilmedCourse:
    """Simulate the deployment of a linkage in a setup for some time, s."""
    compiled = compile_scene(linkage, replace(setup, seconds=seconds))
    methods, steps = methods_of(compiled.formulation), MAX_DEPLOYMENT_STEPS[compiled.formulation]
    return FilmedCourse(compiled, simulate_releases(compiled, methods=methods, tolerance=tolerance, max_steps=steps))


def film_noise(films: Sequence[Film]) -> tuple[float, int]:
    """Estimate the noise of films from neighbouring frames alone; return its standard deviation (rad) and the frames.

    Each angle is compared with the cubic through the four frames around it. The estimate is robust (by the median), as
    angles have kinks where stops are hit. Slow films, in which a cubic misses the motion, seem noisier than they are.
    """
    deviations = np.concatenate([_deviations(film.times, column) for film in films for column in film.angles.T])
    if not len(deviations):
        return 0.0, 0
    return float(MEDIAN_TO_DEVIATION * np.median(np.abs(deviations))), len(deviations)


def _deviations(times: Reals, angles: Reals) -> Reals:
    """Return deviations from cubics through neighbours, scaled to the variance of a single angle."""
    known: Flags = np.isfinite(angles)
    t, a = times[known], angles[known]
    k = np.arange(2, len(t) - 2)
    if not len(k):
        return np.zeros(0)
    near = np.stack([t[k + step] for step in NOISE_NEIGHBOURS], axis=1)
    weights = np.ones_like(near)
    for i in range(len(NOISE_NEIGHBOURS)):
        for j in range(len(NOISE_NEIGHBOURS)):
            if i != j:
                weights[:, i] *= (t[k] - near[:, j]) / (near[:, i] - near[:, j])
    predicted = sum(weights[:, i] * a[k + step] for i, step in enumerate(NOISE_NEIGHBOURS))
    return np.asarray((a[k] - predicted) / np.sqrt(1.0 + (weights**2).sum(axis=1)))
