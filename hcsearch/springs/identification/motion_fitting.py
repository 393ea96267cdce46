"""Least-squares fits of the parameters of a scene to films of a deployment (thesis 4.5; Nocedal and Wright 2006)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import f as f_distribution

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.identification.measured_films import Film, FilmedCourse, course_of
from hcsearch.springs.identification.motion_parameters import MotionParameters, Parameter, nearest_axis, tilts_of

STEP = 1e-4
"""Step of a coordinate for derivatives by differences."""
FACTOR_LEVELS = tuple(math.log(10.0) * k / 4.0 for k in range(-6, 7))
"""Factors of all springs (as logarithms) that are tried as starts: 1/32 to 32."""
DAMPING_LEVELS = (0.0, 0.1, 0.3, 1.0, 3.0)
"""Coordinates of damping that are tried as starts."""
STARTS = 2
"""Number of the best starts from which the least squares begin."""
RELEASE_TRIALS, SCAN_FRAMES, SCAN_TOLERANCE = 60, 30, 1e-5
"""Number of release times tried as starts for a film, number of its frames that they are compared with, and tolerance
of the simulation for this."""
ROUGH_EVALUATIONS, MAX_EVALUATIONS = 8, 60
"""Simulations, besides those for derivatives, from each start, and from the best of the points that these reach."""
ZERO_AMOUNT = 1e-5
"""An amount counts as 0 up to this coordinate: the least squares come near their bounds, and never reach them."""
TILT_STARTS = ((0.0, 0.0), (1.57, 0.0), (-1.57, 0.0), (0.0, 1.57), (0.0, -1.57), (2.8, 0.0))
"""Tilts of gravity (rad) that are tried as starts: towards all axes."""
RIVAL_ANGLE = 0.02
"""Angle (rad) between gravities from which on two minima are distinct."""
FIRST_AMOUNT = 0.1
"""Coordinate at which an amount begins that a simpler fit has left at 0."""
MAX_FACTOR = math.log(1e3)
"""Logarithm of the greatest factor by which a spring may differ from the scene's."""


@dataclass(frozen=True, eq=False)
class FittedFilms(ByValue):
    """Parameters at the least sum of squares.

    x : (n_parameters,), coordinates. releases : (n_films,), time of the release on the clock of each film, s.
    residuals : (n_angles,), model minus film, rad, film by film, frame by frame. slopes : (n_angles, n_parameters +
    n_films), their derivatives by coordinates and releases.
    rivals : coordinates of other minima, with gravity in another direction, that fit as well (95 %).
    """

    parameters: MotionParameters
    x: Reals
    releases: Reals
    residuals: Reals
    slopes: Reals
    rivals: tuple[Reals, ...] = ()

    @property
    def squares(self) -> float:
        """Sum of the squared residuals, rad^2."""
        return float(self.residuals @ self.residuals)

    @property
    def size(self) -> int:
        """Number of fitted numbers, releases included."""
        return len(self.x) + len(self.releases)

    @property
    def freedom(self) -> int:
        """Degrees of freedom of the residuals."""
        return max(1, len(self.residuals) - self.size)


class FilmProblem:
    """The residuals of films for parameters and releases; z : coordinates, then releases."""

    def __init__(self, linkage: Linkage, parameters: MotionParameters, films: Sequence[Film]) -> None:
        self.linkage, self.parameters, self.films = linkage, parameters, tuple(films)
        self.known = [np.isfinite(film.angles) for film in films]
        self.span = max(float(film.times[-1] - film.times[0]) for film in films)
        self._latest: tuple[bytes, FilmedCourse] | None = None

    @property
    def count(self) -> int:
        """Number of parameters, without releases."""
        return len(self.parameters.parameters)

    def course(self, x: Reals, releases: Reals) -> FilmedCourse:
        """Return the deployment at coordinates, simulated until the last frame."""
        ends = [float(film.times[-1]) - release for film, release in zip(self.films, releases, strict=True)]
        return self._simulated(x, max(*ends, 1e-3 * self.span))

    def _simulated(self, x: Reals, seconds: float) -> FilmedCourse:
        """Simulate, unless the latest course at the same coordinates is long enough."""
        key = np.asarray(x, float).tobytes()
        if self._latest is not None and self._latest[0] == key and self._latest[1].compiled.seconds >= seconds:
            return self._latest[1]
        course = course_of(self.linkage, self.parameters.setup_at(x), seconds)
        self._latest = (key, course)
        return course

    def of_course(self, course: FilmedCourse, releases: Reals) -> Reals:
        """Return the residuals of a course."""
        parts = [
            (course.at(film.times - release) - film.angles)[known]
            for film, release, known in zip(self.films, releases, self.known, strict=True)
        ]
        return np.concatenate(parts)

    def residuals(self, z: Reals) -> Reals:
        """Return model minus film, rad, shape (n_angles,)."""
        x, releases = z[: self.count], z[self.count :]
        return self.of_course(self.course(x, releases), releases)

    def slopes(self, z: Reals) -> Reals:
        """Return the derivatives of the residuals, by a simulation for each parameter; of releases by interpolation."""
        x, releases = z[: self.count], z[self.count :]
        course = self.course(x, releases)
        at = self.of_course(course, releases)
        columns = []
        for k in range(len(x)):
            moved = x.copy()
            moved[k] += STEP
            columns.append((self.of_course(self._apart(moved, course.compiled.seconds), releases) - at) / STEP)
        delay = 1e-6 * self.span
        for k in range(len(releases)):
            later = releases.copy()
            later[k] += delay
            columns.append((self.of_course(course, later) - at) / delay)
        return np.column_stack(columns)

    def _apart(self, x: Reals, seconds: float) -> FilmedCourse:
        return course_of(self.linkage, self.parameters.setup_at(x), seconds)

    def best_releases(self, x: Reals) -> tuple[Reals, float]:
        """Return releases with a small sum of squares at coordinates, among some, and this sum; films are thinned.

        The array may be released long before the first frame, or long after it.
        """
        course = course_of(self.linkage, self.parameters.setup_at(x), 2.0 * self.span, SCAN_TOLERANCE)
        duration = float(course.motion.times[-1])
        releases, total = [], 0.0
        for film in self.films:
            thin = slice(None, None, 1 + len(film.times) // SCAN_FRAMES)
            times, angles = film.times[thin], film.angles[thin]
            trials = np.linspace(film.times[0] - duration, film.times[-1], RELEASE_TRIALS)
            for width in (trials[1] - trials[0], 0.0):
                moved = course.at((times - trials[:, None]).ravel()).reshape(len(trials), *angles.shape)
                sums = np.nansum((moved - angles) ** 2, axis=(1, 2))
                best = int(sums.argmin())
                release, least = float(trials[best]), float(sums[best])
                trials = release + width * np.linspace(-1.0, 1.0, 15)
            releases.append(release)
            total += least
        return np.array(releases), total

    def solve(
        self, x: Reals, releases: Reals, fixed: int | None = None, evaluations: int = MAX_EVALUATIONS
    ) -> FittedFilms:
        """Minimise the squares from a start; fixed : a coordinate that is not varied."""
        start = np.concatenate([x, releases])
        free = np.array([k for k in range(len(start)) if k != fixed])
        lower = np.concatenate([self.parameters.lower, np.full(len(releases), -math.inf)])
        factors = [k for k, parameter in enumerate(self.parameters.parameters) if parameter.kind == "factor"]
        upper = np.full(len(start), math.inf)
        lower[factors], upper[factors] = -MAX_FACTOR, MAX_FACTOR

        def whole(part: Reals) -> Reals:
            z = start.copy()
            z[free] = part
            return z

        least = least_squares(
            lambda part: self.residuals(whole(part)),
            np.clip(start[free], lower[free] + 1e-9, upper[free] - 1e-9),
            jac=lambda part: self.slopes(whole(part))[:, free],
            bounds=(lower[free], upper[free]),
            x_scale="jac",
            ftol=1e-8,
            xtol=1e-7,
            max_nfev=evaluations,
        )
        z, residuals = whole(least.x), np.asarray(least.fun)
        slopes = np.zeros((len(residuals), len(start)))
        slopes[:, free] = least.jac
        nearly = np.isfinite(np.concatenate([self.parameters.lower, releases * math.nan])) & (z < ZERO_AMOUNT)
        nearly[factors] = False
        if nearly.any():
            z[nearly] = 0.0
            residuals = self.residuals(z)
        return FittedFilms(self.parameters, z[: self.count], z[self.count :], residuals, slopes)


def fit_films(
    linkage: Linkage,
    parameters: MotionParameters,
    films: Sequence[Film],
    simpler: Sequence[FittedFilms] = (),
) -> FittedFilms:
    """Fit parameters to films, from several starts; simpler : fits with a part of the parameters, to start from."""
    problem = FilmProblem(linkage, parameters, films)
    starts = [start for fit in simpler for start in _extended(problem, fit)]
    scanned = {parameter.name for parameter in parameters.parameters if _is_scanned(parameter)}
    if not starts or scanned - {parameter.name for fit in simpler for parameter in fit.parameters.parameters}:
        starts += _scanned(problem)
    if any(parameter.kind == "tilt" for parameter in parameters.parameters):
        minima = [problem.solve(x, releases) for x, releases in starts]
        best = min(minima, key=lambda fit: fit.squares)
        best = replace(best, rivals=tuple(fit.x for fit in minima if _rivals(fit, best)))
    else:
        if len(starts) > 1:
            rough = [problem.solve(x, releases, evaluations=ROUGH_EVALUATIONS) for x, releases in starts]
            least = min(rough, key=lambda fit: fit.squares)
            starts = [(least.x, least.releases)]
        best = problem.solve(*starts[0])
    return _about_nearest_axis(problem, best)


def _rivals(fit: FittedFilms, best: FittedFilms) -> bool:
    """Return whether a minimum has gravity in another direction than the best, and squares within its 95 % region."""
    gravity, other = (np.array(one.parameters.setup_at(one.x).gravity) for one in (best, fit))
    apart = math.acos(min(1.0, max(-1.0, float(gravity @ other / np.sqrt(gravity @ gravity * (other @ other))))))
    allowed = best.squares * (1.0 + best.size * float(f_distribution.ppf(0.95, best.size, best.freedom)) / best.freedom)
    return apart > RIVAL_ANGLE and fit.squares <= allowed


def _is_scanned(parameter: Parameter) -> bool:
    """Return whether starts are tried for a parameter: springs as a whole and damping set the time scale."""
    return parameter.name in ("stiffness", "damping")


def _scanned(problem: FilmProblem) -> list[tuple[Reals, Reals]]:
    """Return the best starts among levels of all springs and of damping, each with its best releases."""
    parameters = problem.parameters.parameters
    levels = product(
        FACTOR_LEVELS if any(p.kind == "factor" for p in parameters) else (0.0,),
        DAMPING_LEVELS if any(p.term == "damping" for p in parameters) else (0.0,),
    )
    tried = []
    for factor, damping in levels:
        x = np.array([factor if p.kind == "factor" else damping if p.term == "damping" else 0.0 for p in parameters])
        releases, squares = problem.best_releases(x)
        tried.append((squares, x, releases))
    tried.sort(key=lambda trial: trial[0])
    return [(x, releases) for _, x, releases in tried[:STARTS]]


def _extended(problem: FilmProblem, fit: FittedFilms) -> list[tuple[Reals, Reals]]:
    """Return starts from a fit with fewer parameters; with gravity, one for each axis along which it may act."""
    known = {parameter.name: x for parameter, x in zip(fit.parameters.parameters, fit.x, strict=True)}
    by_term = {p.term: x for p, x in zip(fit.parameters.parameters, fit.x, strict=True) if p.kind == "factor"}
    new = problem.parameters.parameters
    x = np.array(
        [
            known.get(p.name, next(iter(by_term.values()), 0.0) if p.kind == "factor" else FIRST_AMOUNT)
            if p.kind != "tilt"
            else 0.0
            for p in new
        ]
    )
    if not any(parameter.kind == "tilt" for parameter in new):
        return [(x, fit.releases)]
    tilts = [k for k, parameter in enumerate(new) if parameter.kind == "tilt"]
    if any(parameter.kind == "tilt" for parameter in fit.parameters.parameters):
        x[tilts] = tilts_of(fit.parameters.setup_at(fit.x).gravity, problem.parameters.axis)
        return [(x, fit.releases)]
    starts = []
    for direction in TILT_STARTS:
        at = x.copy()
        at[tilts] = direction
        starts.append((at, fit.releases))
    return starts


def _about_nearest_axis(problem: FilmProblem, fit: FittedFilms) -> FittedFilms:
    """Return a fit with the tilts of gravity from the nearest axis, so that their errors are errors of angles."""
    tilts = [k for k, parameter in enumerate(fit.parameters.parameters) if parameter.kind == "tilt"]
    if not tilts:
        return fit
    setup_at = fit.parameters.setup_at
    axis = nearest_axis(setup_at(fit.x).gravity)

    def moved(x: Reals) -> Reals:
        about = x.copy()
        about[tilts] = tilts_of(setup_at(x).gravity, axis)
        return about

    x, rivals = moved(fit.x), tuple(moved(rival) for rival in fit.rivals)
    problem.parameters = fit.parameters.about_axis(axis)
    slopes = problem.slopes(np.concatenate([x, fit.releases]))
    return replace(fit, parameters=problem.parameters, x=x, slopes=slopes, rivals=rivals)
