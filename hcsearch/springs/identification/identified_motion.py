"""Identification of a scene from films: models tried from the simplest on, the chosen one, verdict and scene."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import tomli_w
from scipy.stats import f as f_distribution

from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import MOTION_TERMS, MotionTerm
from hcsearch.scenes.laws import Law, linear_law, scaled_law
from hcsearch.scenes.setup import Setup
from hcsearch.shape.labels import label_data, labels_of
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.outcomes import collision_sentence
from hcsearch.springs.deployment.simulated_deployment import deployment_of_motion
from hcsearch.springs.identification.law_fitting import LAW_REFUSAL_CONFIDENCE
from hcsearch.springs.identification.measured_films import Film
from hcsearch.springs.identification.motion_adequacy import LeftOver, MotionEstimate, estimates_of, left_over
from hcsearch.springs.identification.motion_fitting import FilmProblem, FittedFilms, fit_films
from hcsearch.springs.identification.motion_parameters import STIFFNESS_TERMS, MotionParameters, motion_parameters
from hcsearch.system.work_steps import step_of_thread, work_step

DEFAULT_MOTION_TERMS: tuple[MotionTerm, ...] = ("stiffness", "damping", "friction")
"""Terms that are fitted unless others are named."""


@dataclass(frozen=True)
class MotionFit:
    """A model fitted to all films.

    terms : fitted, none for the scene as it is. size : number of fitted numbers, with a release for each film.
    sureness : probability that the model with all terms fits better, and not by chance (F test).
    releases : time of the release on the clock of each film, s. left : what the model leaves of the films.
    setup : the scene with the fitted values. values : these by the names of a scene file.
    """

    terms: tuple[MotionTerm, ...]
    size: int
    sureness: float
    releases: tuple[float, ...]
    left: LeftOver
    setup: Setup
    values: dict[str, Any]

    @property
    def sufficient(self) -> bool:
        """Whether the films do not require further terms."""
        return self.sureness < LAW_REFUSAL_CONFIDENCE

    @property
    def explained(self) -> bool:
        """Whether the model leaves only noise, or less than films show."""
        return self.left.explained


@dataclass(frozen=True)
class HeldOutFilm:
    """A film that was not fitted, compared with the chosen model; only its release (s) is fitted."""

    film: str
    release: float
    left: LeftOver

    @property
    def predicted(self) -> bool:
        """Whether the model leaves only noise, or less than films show."""
        return self.left.explained


@dataclass(frozen=True, eq=False)
class IdentifiedMotion:
    """Springs, damping and other values of a scene, fitted to films of a deployment.

    name : of what is deployed. films : their names. fits : all models, in the order in which they were tried. chosen :
    the one with the fewest numbers for which the films do not require further terms.
    estimates : of the parameters of the chosen model. validation : on films that were held out. doubts : sentences.
    """

    name: str
    linkage: Linkage
    films: tuple[str, ...]
    fits: tuple[MotionFit, ...]
    chosen: MotionFit
    estimates: tuple[MotionEstimate, ...]
    validation: tuple[HeldOutFilm, ...]
    doubts: tuple[str, ...]

    @property
    def explained(self) -> bool:
        """Whether a model explains all films, those that were held out included."""
        return self.chosen.explained and all(film.predicted for film in self.validation)

    @property
    def verdict(self) -> str:
        """`explained`, or `not explained`."""
        return "explained" if self.explained else "not explained"

    @property
    def values(self) -> dict[str, Any]:
        """The fitted values by the names of a scene file, for `deploy(..., **values)`."""
        return self.chosen.values

    @cached_property
    def reason(self) -> str:
        """The verdict in a sentence, with the remaining misfit where nothing fits."""
        if not self.chosen.explained:
            return f"not explained: {self.remains(self.chosen.left, self.films)}"
        for held_out in self.validation:
            if not held_out.predicted:
                return f"not explained: of the film held out, {self.remains(held_out.left, (held_out.film,))}"
        rms = math.degrees(self.chosen.left.residual)
        return f"explained to {rms:.2g} degrees rms, of which {math.degrees(self.chosen.left.misfit):.2g} are no noise"

    def remains(self, left: LeftOver, films: Sequence[str]) -> str:
        """Return the misfit of a model to films in words, and where it is greatest."""
        hinge = labels_of(self.linkage).hinges[left.hinge]
        return (
            f"{math.degrees(left.misfit):.2g} degrees rms remain that are no noise, most in hinge {hinge} at "
            f"{left.time:.4g} s of {films[left.film]}, where the model is {math.degrees(left.error):+.2g} degrees off"
        )

    def facts(self) -> dict[str, Any]:
        """Return the results as plain data, as `hcsearch identify motion --json` prints them; angles in rad."""
        return {
            "name": self.name,
            "verdict": self.verdict,
            "reason": self.reason,
            "terms": list(self.chosen.terms),
            "parameters": [
                {key: getattr(one, key) for key in ("name", "unit", "value", "error", "low", "high", "identified")}
                for one in self.estimates
            ],
            "scene": self.values,
            "films": [
                {"file": name, "release_s": release}
                for name, release in zip(self.films, self.chosen.releases, strict=True)
            ],
            "left": self._left_facts(self.chosen.left, self.films),
            "tried": [
                {
                    "terms": list(fit.terms),
                    "size": fit.size,
                    "sureness": fit.sureness,
                    "residual_rad": fit.left.residual,
                    "misfit_rad": fit.left.misfit,
                    "explained": fit.explained,
                    "chosen": fit is self.chosen,
                }
                for fit in self.fits
            ],
            "held_out": [
                {"file": one.film, "release_s": one.release, "predicted": one.predicted}
                | self._left_facts(one.left, (one.film,))
                for one in self.validation
            ],
            "doubts": list(self.doubts),
        }

    def _left_facts(self, left: LeftOver, films: Sequence[str]) -> dict[str, Any]:
        return {
            "residual_rad": left.residual,
            "noise_rad": left.noise,
            "misfit_rad": left.misfit,
            "excess_sureness": left.excess_sureness,
            "order_sureness": left.order_sureness,
            "greatest": {
                "file": films[left.film],
                "hinge": label_data(labels_of(self.linkage).hinges[left.hinge]),
                "time_s": left.time,
                "error_rad": left.error,
            },
        }

    def __repr__(self) -> str:
        return f"<{self.name}: {self.reason}>"


@work_step("fitting the films")
def identify_films(
    name: str,
    linkage: Linkage,
    setup: Setup,
    films: Sequence[Film],
    terms: Sequence[MotionTerm] = DEFAULT_MOTION_TERMS,
    held_out: Sequence[Film] = (),
) -> IdentifiedMotion:
    """Fit terms of a scene to films, and choose the model with the fewest that suffice.

    Models are tried from the scene as it is on: springs come first, as one; then the term that lowers the squares most,
    one after the other. A model suffices unless that with all terms fits better, significantly (F test, 99 %), as laws
    of springs do. Terms that are not fitted keep the values of the scene.
    """
    terms = _checked(linkage, setup, films, terms)
    fits = _all_fits(linkage, setup, films, terms)
    whole = fits[terms]
    tried = tuple(_described(linkage, wanted, films, solved, whole) for wanted, solved in fits.items())
    chosen = min((one for one in tried if one.sufficient), key=lambda one: (one.size, one.left.residual))
    solved = fits[chosen.terms]
    estimates = estimates_of(FilmProblem(linkage, solved.parameters, films), solved)
    validation = tuple(_held_out(linkage, chosen.setup, film) for film in held_out)
    doubts = tuple(_doubts(linkage, films, solved, estimates))
    names = tuple(film.name for film in films)
    return IdentifiedMotion(name, linkage, names, tried, chosen, estimates, validation, doubts)


def _all_fits(
    linkage: Linkage, setup: Setup, films: Sequence[Film], terms: tuple[MotionTerm, ...]
) -> dict[tuple[MotionTerm, ...], FittedFilms]:
    """Fit models, from the scene as it is to the one with all terms, and the models with one term less than all."""
    fits: dict[tuple[MotionTerm, ...], FittedFilms] = {}

    def fit(wanted: tuple[MotionTerm, ...], start: tuple[MotionTerm, ...] | None) -> float:
        if wanted not in fits:
            # with gravity there are many minima: all models with one term less are starts
            less = [
                one for one in fits if "gravity" in wanted and set(one) < set(wanted) and len(one) + 1 == len(wanted)
            ]
            starts = [] if start is None else [fits[one] for one in dict.fromkeys([start, *less])]
            fits[wanted] = fit_films(linkage, motion_parameters(linkage, setup, wanted), films, starts)
            step_of_thread().advance(1)
        return fits[wanted].squares

    fit((), None)
    current: tuple[MotionTerm, ...] = ()
    while wider := _wider(current, terms):
        squares = [fit(one, current) for one in wider]
        current = wider[squares.index(min(squares))]
    for term in terms:
        if term not in STIFFNESS_TERMS:
            fit(tuple(other for other in terms if other != term), terms)
    return fits


def _checked(
    linkage: Linkage, setup: Setup, films: Sequence[Film], terms: Sequence[MotionTerm]
) -> tuple[MotionTerm, ...]:
    """Return the terms in order; HcsearchError for those that cannot be fitted."""
    if not films:
        raise HcsearchError("there is no film to fit: give one or more files of angles")
    if not terms:
        raise HcsearchError(f"there is nothing to fit: name some of {', '.join(MOTION_TERMS)}")
    own = {"friction": setup.resistance, "damping": tuple(zip(setup.damping, setup.damping_time, strict=True))}
    for term, values in own.items():
        if term in terms and len(set(values)) > 1:
            raise HcsearchError(
                f"{term} is fitted as one of all hinges, and the scene gives some their own: leave out either"
            )
    motion_parameters(linkage, setup, terms)  # raises for springs that cannot be fitted before the work begins
    return _in_order(terms)


def _in_order(terms: Sequence[MotionTerm]) -> tuple[MotionTerm, ...]:
    return tuple(term for term in MOTION_TERMS if term in terms)


def _wider(current: tuple[MotionTerm, ...], terms: Sequence[MotionTerm]) -> list[tuple[MotionTerm, ...]]:
    """Return the next models: springs as one first; then one more term, or springs that are fitted more finely."""
    finer = [term for term in terms if term in STIFFNESS_TERMS]
    if not current and finer:
        return [("stiffness",)]
    wider = []
    for term in terms:
        if term in finer:
            if "stiffness" in current and term != "stiffness":
                wider.append(_in_order([term, *(other for other in current if other != "stiffness")]))
        elif term not in current:
            wider.append(_in_order([*current, term]))
    return wider


def _described(
    linkage: Linkage, terms: tuple[MotionTerm, ...], films: Sequence[Film], solved: FittedFilms, whole: FittedFilms
) -> MotionFit:
    setup = solved.parameters.setup_at(solved.x)
    excess, unknowns = max(0.0, solved.squares - whole.squares), whole.size - solved.size
    sureness = 0.0
    if unknowns > 0 and excess > 0.0:
        ratio = excess / unknowns / (whole.squares / whole.freedom) if whole.squares > 0.0 else math.inf
        sureness = float(f_distribution.cdf(ratio, unknowns, whole.freedom))
    return MotionFit(
        terms=terms,
        size=solved.size,
        sureness=sureness,
        releases=tuple(solved.releases.tolist()),
        left=left_over(films, solved.residuals, solved.freedom),
        setup=setup,
        values=scene_values(linkage, solved.parameters, setup, solved.x),
    )


def _held_out(linkage: Linkage, setup: Setup, film: Film) -> HeldOutFilm:
    solved = fit_films(linkage, MotionParameters(setup, ()), [film])
    return HeldOutFilm(film.name, float(solved.releases[0]), left_over([film], solved.residuals, solved.freedom))


def _doubts(
    linkage: Linkage, films: Sequence[Film], solved: FittedFilms, estimates: Sequence[MotionEstimate]
) -> Iterator[str]:
    """Yield sentences on parameters that the films do not identify, and on a collision in the fitted motion."""
    unidentified = [estimate.name for estimate in estimates if not estimate.identified]
    if unidentified:
        names = ", ".join(unidentified)
        yield f"the films do not identify {names}: leave them out of --fit, or film what moves them apart"
    if any(estimate.name.startswith("gravity") and not estimate.identified for estimate in estimates):
        yield "the intervals of the other parameters hold for this direction of gravity: give it in the scene"
    course = FilmProblem(linkage, solved.parameters, films).course(solved.x, solved.releases)
    clearance = deployment_of_motion(course.compiled, course.motion).clearance
    if clearance is not None and clearance.kind == "collides" and clearance.panels is not None:
        sentence = collision_sentence(clearance.panels, clearance.time, labels_of(linkage))
        yield f"in the fitted motion, {sentence} after the release: leave out what the films show from then on"


ON_TOP = ("springs",)
"""Values that stand above the table `scene` of a file."""


def scene_values(linkage: Linkage, fitted: MotionParameters, setup: Setup, x: Any) -> dict[str, Any]:
    """Return the fitted values by the names of a scene file, with six digits.

    fitted : the parameters, at coordinates x. setup : with the values there. Friction replaces that of the scene and
    its harness.
    """
    values: dict[str, Any] = {}
    terms = {parameter.term for parameter in fitted.parameters}
    laws = list(fitted.setup.laws)
    for at, parameter in zip(x, fitted.parameters, strict=True):
        if parameter.kind == "factor":
            value = _six_digits(parameter.value(float(at)))
            for hinge in parameter.hinges:
                laws[hinge] = linear_law(value) if parameter.unit else scaled_law(laws[hinge], value)
        elif parameter.kind == "amount":
            values[parameter.term] = _six_digits(parameter.value(float(at)))
    if any(term.startswith("stiffness") for term in terms):
        values = _laws(linkage, laws) | values
    if "friction" in terms and any(fitted.setup.resistance):
        values["harness"] = 0.0
    if "gravity" in terms:
        values["gravity"] = [_six_digits(part) for part in setup.gravity]
    return values


def scene_lines(values: Mapping[str, Any]) -> str:
    """Return fitted values as lines of a scene file."""
    on_top = {key: value for key, value in values.items() if key in ON_TOP}
    return tomli_w.dumps({"scene": {key: value for key, value in values.items() if key not in on_top}} | on_top)


def _laws(linkage: Linkage, laws: list[Law]) -> dict[str, Any]:
    """Return the one law of all hinges, or the laws of single hinges by their names."""
    texts = [law.text for law in laws]
    if len(set(texts)) == 1:
        return {"spring": texts[0]}
    return {"springs": dict(zip(labels_of(linkage).hinges, texts, strict=True))}


def _six_digits(value: float) -> float:
    return float(f"{value:.6g}")
