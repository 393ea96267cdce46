"""What would put the first collision of the thesis's array at the time of its film (4.5.1), searched within bounds.

The film shows the large middle panel meet the back of the top panel at 0.30 s. The scan is a Sobol sequence over all
parameters and directions of gravity, with its best points refined by the simplex of Nelder and Mead.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.optimize import minimize
from scipy.stats import qmc

from hcsearch.basics.array_values import Reals
from hcsearch.scenes import Scene
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.compiled_scene import compile_scene
from hcsearch.springs.deployment.outcomes import DeploymentCheck
from hcsearch.springs.deployment.quick_check import check_deployments
from hcsearch_bench.run.bench import Say
from hcsearch_bench.subjects.deployments import assembly

FILM_TIME, FILM_PANELS = 0.30, (0, 7)
"""Time (s) and panels of the collision in the film: the top pair and the large middle panel."""
FRAME_TOLERANCE = 0.005
"""Difference (s) from the time of the film up to which a collision is that of the film, which has two digits."""
SIMULATED = 0.45
"""Time that is simulated, s."""
GRAVITY = 9.81
SCANNED, REFINED, QUICK_SCANNED = 256, 4, 16
"""Points of the scan, the best of these that are refined, and points of the quick bench."""
NOT_MET = 1.0
"""Distance (s) from the film of a motion in which other panels meet first, or none do."""

Bounds = Mapping[str, tuple[float, float]]
MEASURED: Bounds = {
    "stiffness": (0.095, 0.115),
    "damping": (0.0037, 0.0049),
    "friction": (0.0, 0.005),
    "drag": (0.0, 2.4),
}
"""Stiffness: the thesis's 0.10 N m/rad, and what stiffens it at large angles (4.5.2). Damping: 0.0043 +- 3 x 0.0002 N m
s/rad (table 4.2). Friction: a share of 0.015 of the packed springs' moment, N m. Drag: air with a coefficient of 2."""
PLAUSIBLE: Bounds = {
    "stiffness": (0.08, 0.13),
    "damping": (0.002, 0.0086),
    "friction": (0.0, 0.02),
    "drag": (0.0, 5.0),
}
"""Half to twice the measured damping, friction that holds a spring at 0.2 rad, drag twice that of plates in air."""


@dataclass(frozen=True)
class FilmedRow:
    """The search within bounds; gravity has any direction, unless it is that of the scene `thesis`.

    varied : parameters; the others have the values of the thesis. tried : simulations. met : of those in which the
    panels of the film meet first. latest_s : the latest of these collisions. nearest_s : the nearest to 0.30 s, and the
    parameters there: N m/rad, N m s/rad, N m, kg/m^3, and the direction of gravity. explains : whether it is within
    0.005 s of the film.
    """

    bounds: str
    varied: str
    tried: int
    met: int
    latest_s: float
    nearest_s: float
    explains: str
    stiffness: float
    damping: float
    friction: float
    drag: float
    gravity: str


@dataclass(frozen=True)
class _Search:
    """A search over the unit cube: the varied parameters, then height and azimuth of gravity if it is varied."""

    bounds: Bounds
    varied: tuple[str, ...]
    turned: bool

    @property
    def dimension(self) -> int:
        """Number of coordinates."""
        return len(self.varied) + 2 * self.turned

    def values(self, point: Reals) -> dict[str, float]:
        """Return the parameters at a point."""
        known = {"stiffness": 0.10, "damping": 0.0043, "friction": 0.0, "drag": 0.0}
        for at, name in zip(point, self.varied, strict=False):
            low, high = self.bounds[name]
            known[name] = low + float(at) * (high - low)
        return known

    def gravity(self, point: Reals) -> tuple[float, float, float]:
        """Return the direction of gravity at a point: uniform over the sphere, or that of the scene `thesis`."""
        if not self.turned:
            return (0.0, 1.0, 0.0)
        height, azimuth = 2.0 * float(point[-2]) - 1.0, 2.0 * math.pi * float(point[-1])
        across = math.sqrt(max(0.0, 1.0 - height * height))
        return (across * math.cos(azimuth), across * math.sin(azimuth), height)

    def scene(self, point: Reals) -> Scene:
        """Return the scene at a point."""
        values = self.values(point)
        x, y, z = (GRAVITY * part for part in self.gravity(point))
        return Scene(
            spring=f"linear:{values['stiffness']:.6g}",
            damping=values["damping"],
            friction=values["friction"],
            drag=values["drag"],
            gravity=(x, y, z),
            seconds=SIMULATED,
        )


@cache
def _array() -> Linkage:
    return assembly("thesis-4x4")


def collision_times(scenes: Sequence[Scene]) -> list[float | None]:
    """Return the time of the first collision in each scene, s; None where it is of other panels, or there is none."""
    checks = check_deployments([compile_scene(_array(), scene) for scene in scenes], past_collisions=False)
    return [_time_of(check) for check in checks]


def _time_of(check: DeploymentCheck) -> float | None:
    if check.collision is None or check.collision[1] != FILM_PANELS:
        return None
    return check.collision[0]


def filmed_row(name: str, bounds: Bounds, varied: tuple[str, ...], *, turned: bool, points: int, say: Say) -> FilmedRow:
    """Return the row of a search; turned : whether the direction of gravity is varied."""
    say(f"the film, {name}: {', '.join(varied)}{', gravity' if turned else ''}")
    search = _Search(bounds, varied, turned)
    tried = [np.asarray(point, float) for point in qmc.Sobol(search.dimension, seed=1).random(points)]
    times = collision_times([search.scene(point) for point in tried])

    def distance(point: Reals) -> float:
        inside = np.clip(point, 0.0, 1.0)
        (time,) = collision_times([search.scene(inside)])
        tried.append(inside)
        times.append(time)
        return NOT_MET if time is None else abs(time - FILM_TIME)

    ranked = sorted((abs(t - FILM_TIME), k) for k, t in enumerate(times) if t is not None)
    for off, k in ranked[:REFINED]:
        if off > 0.0:
            minimize(distance, tried[k], method="Nelder-Mead", options={"maxfev": 12 * search.dimension, "xatol": 1e-4})
    met = [(t, k) for k, t in enumerate(times) if t is not None]
    nearest, best = min(met, key=lambda one: abs(one[0] - FILM_TIME))
    values = search.values(tried[best])
    return FilmedRow(
        bounds=name,
        varied=", ".join([*varied, *(["gravity"] if turned else [])]),
        tried=len(tried),
        met=len(met),
        latest_s=max(t for t, _ in met),
        nearest_s=nearest,
        explains="yes" if abs(nearest - FILM_TIME) <= FRAME_TOLERANCE else "no",
        gravity=" ".join(f"{part:+.2f}" for part in search.gravity(tried[best])),
        **values,
    )


def filmed_rows(*, quick: bool, say: Say) -> list[FilmedRow]:
    """Return the searches: each parameter alone, then all together, with gravity in any direction."""
    every, points = tuple(MEASURED), QUICK_SCANNED if quick else SCANNED
    rows = [
        filmed_row("plausible", PLAUSIBLE, (one,), turned=False, points=points // (1 if quick else 8), say=say)
        for one in every
    ]
    for name, bounds in (("measured", MEASURED), ("plausible", PLAUSIBLE)):
        rows.append(filmed_row(name, bounds, every, turned=False, points=points, say=say))
        rows.append(filmed_row(name, bounds, every, turned=True, points=points, say=say))
    return rows
