"""Rows of the bench `identification`: parameters fitted to made-up films of deployments with known parameters."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from statistics import median
from typing import Any

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.vocabulary import MotionTerm, Way
from hcsearch.springs.identification.identified_motion import IdentifiedMotion, identify_films
from hcsearch.springs.identification.measured_films import Film, FilmedCourse, course_of
from hcsearch.springs.identification.motion_parameters import AXES, tilts_of
from hcsearch.subjects.case import Case
from hcsearch.subjects.resolve import resolve
from hcsearch_bench.run.bench import Say

FILM_NOISE = 0.01 * math.pi
"""Standard deviation of measured fold angles, rad: 1 % of their range."""
FRAMES = 120
LONGEST = 10.0
"""Longest time that is simulated to find the end of a motion, s."""


@dataclass(frozen=True)
class FilmCase:
    """A deployment of which films are made.

    scene : values from which the fit starts. planted : those that the films have. terms : fitted. panel, flat_pairs :
    as of `deploy`. share : of the motion that a film shows.
    """

    design: str
    scene: Mapping[str, Any]
    planted: Mapping[str, Any]
    terms: tuple[MotionTerm, ...]
    panel: str | None = None
    flat_pairs: Way = "rigid"
    share: float = 1.2

    def case(self, values: Mapping[str, Any]) -> Case:
        """Return the design in its scene with values."""
        return resolve(self.design, None, panel=self.panel, flat_pairs=self.flat_pairs, values={**self.scene, **values})

    @cached_property
    def course(self) -> FilmedCourse:
        """The motion that the films show."""
        true = self.case(self.planted)
        end = float(course_of(true.linkage, true.setup, LONGEST).motion.times[-1])
        return course_of(true.linkage, true.setup, self.share * end)

    def film(self, seed: int) -> Film:
        """Return a film with white noise that begins before or after the release, by a tenth of the motion at most."""
        random = np.random.default_rng(seed)
        seconds = self.course.compiled.seconds
        times: Reals = np.arange(FRAMES) * seconds / FRAMES
        angles = self.course.at(times - random.uniform(-0.1, 0.1) * seconds)
        return Film(f"film {seed}", times, angles + FILM_NOISE * random.standard_normal(angles.shape))

    def identified(self, seed: int, terms: Sequence[MotionTerm]) -> IdentifiedMotion:
        """Return what is identified in one film, checked by another one."""
        start = self.case({})
        films = [self.film(2 * seed)], [self.film(2 * seed + 1)]
        return identify_films(start.name, start.linkage, start.setup, films[0], terms, films[1])

    @property
    def truths(self) -> dict[str, float]:
        """The planted values by the names of the parameters."""
        values = dict(self.planted)
        truths = {"stiffness": float(str(values.pop("spring")).removeprefix("linear:"))}
        if gravity := values.pop("gravity", None):
            tilts = tilts_of(gravity, AXES.index("-z"))
            truths |= {"gravity, from -z to x": tilts[0], "gravity, from -z to y": tilts[1]}
        return truths | {name: float(value) for name, value in values.items()}


_HEXAGONS = "hex:0234550132:4"
CASES = {
    "friction": FilmCase(
        _HEXAGONS,
        {},
        {"spring": "linear:0.13", "damping": 0.006, "friction": 0.012},
        ("stiffness", "damping", "friction"),
    ),
    "drag": FilmCase(
        _HEXAGONS,
        {"areal_mass": 0.6, "spring": "linear:2"},
        {"spring": "linear:2.5", "damping": 0.06, "drag": 1.8},
        ("stiffness", "damping", "friction", "drag"),
        "500x5",
    ),
    "gravity": FilmCase(
        _HEXAGONS,
        {"spring": "linear:5"},
        {"spring": "linear:4", "damping": 0.4, "gravity": (3.2303621715, -5.3839369525, -7.5375117335)},
        ("stiffness", "damping", "gravity"),
        "300x12",
        "hinged",
    ),
}
"""`friction`: the panels of the thesis. `drag`: large light panels in air. `gravity`: heavy ones, whose flat pairs are
hinged: the motion of fewer hinges does not tell gravity from stiffness and damping."""


@dataclass(frozen=True)
class ParameterRow:
    """A parameter in films of one case.

    films : number of films. identified : of those in which the parameter was fitted and identified. within : of those
    whose 95 % interval holds the planted value. error : relative error (of tilts, rad), rms over these.
    reported_error : standard error that identification reports, rms.
    """

    case: str
    parameter: str
    planted: float
    films: int
    identified: int
    within: int
    error: float
    reported_error: float


@dataclass(frozen=True)
class FilmVerdictRow:
    """The verdicts on films of one case.

    fitted : terms that may be fitted. explained : films that are explained. chosen : of those for which the planted
    terms were chosen. predicted : of those whose model predicts another film. misfit_deg : systematic part of what is
    left, median. s : computing time of a film, median.
    """

    case: str
    fitted: str
    films: int
    explained: int
    chosen: int
    predicted: int
    misfit_deg: float
    s: float


def measure_films(
    name: str, seeds: Sequence[int], *, without: MotionTerm | None = None, say: Say
) -> tuple[FilmVerdictRow, list[ParameterRow]]:
    """Rows from a film of one case for each seed; without : a term that is not fitted, though it is planted."""
    case = CASES[name]
    terms = tuple(term for term in case.terms if term != without)
    results, seconds = [], []
    for seed in seeds:
        say(f"films, {name}, {seed}")
        begun = time.process_time()
        results.append(case.identified(seed, terms))
        seconds.append(time.process_time() - begun)
    planted = {"stiffness", *(key for key in case.planted if key != "spring")}
    verdict = FilmVerdictRow(
        case=name,
        fitted=", ".join(terms),
        films=len(results),
        explained=sum(result.chosen.explained for result in results),
        chosen=sum(set(result.chosen.terms) == planted for result in results),
        predicted=sum(film.predicted for result in results for film in result.validation),
        misfit_deg=math.degrees(median(result.chosen.left.misfit for result in results)),
        s=median(seconds),
    )
    return verdict, [_parameter_row(name, key, truth, results) for key, truth in case.truths.items()]


def _parameter_row(case: str, name: str, truth: float, results: Sequence[IdentifiedMotion]) -> ParameterRow:
    found = [one for result in results for one in result.estimates if one.name == name and one.identified]
    scale = 1.0 if name.startswith("gravity") else abs(truth)
    return ParameterRow(
        case=case,
        parameter=name,
        planted=truth,
        films=len(results),
        identified=len(found),
        within=sum((one.low or 0.0) <= truth <= (one.high or 0.0) for one in found),
        error=_rms([(one.value - truth) / scale for one in found]),
        reported_error=_rms([(one.error or 0.0) / scale for one in found]),
    )


def _rms(values: Sequence[float]) -> float:
    return math.sqrt(sum(value * value for value in values) / len(values)) if values else math.nan
