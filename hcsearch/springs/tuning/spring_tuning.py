"""Stiffnesses of springs for a deployment that ends flat without a collision (thesis 4.4): search, choose, confirm."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import Formulation
from hcsearch.scenes import Scene
from hcsearch.scenes.setup import Setup, setup_of_scene
from hcsearch.shape.labels import Labels, labels_of
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.spring_sets import stiffnesses_of, tied_hinges
from hcsearch.springs.tuning.choice import SpringSet, SpringSetFinder, evaluation_shares
from hcsearch.springs.tuning.evaluation import TUNING_STEP_TOLERANCES, EvaluationMemory, Evaluator, SceneScales
from hcsearch.springs.tuning.robustness import Spread
from hcsearch.springs.tuning.spring_search import (
    SeenSpringSet,
    SpringSearch,
    TuningProgress,
    catalogue_levels,
    first_generation,
    stiffnesses_of_groups,
)
from hcsearch.system.figures import load_matplotlib

DEFAULT_EVALUATION_COUNT, DEFAULT_SAMPLE_COUNT = 500, 64
"""Sets of springs that are tried, and samples of the tolerances that are drawn for a set that is confirmed."""


NO_LABELS = Labels((), ())


@dataclass(frozen=True)
class Tuning:
    """The result of `tune_springs`; `springs` has the stiffnesses to use.

    setup : the scene of the simulations, in numbers of the linkage. formulation : the equations of motion.
    tied : the groups of hinges that have equal springs, by their places in the linkage.
    start : the springs with which the search began. best : the confirmed set that is least likely to fail; if none is
    confirmed, the set with the least objective. rounded : the same with springs of the catalogue; None without one.
    evaluations : how many sets of springs were tried, each by one quick simulation. samples : how many simulations
    within the tolerances were drawn. recalled, samples_recalled : how many of these a database already held.
    catalogue : the springs that can be bought, N m/rad.
    interrupted : whether Ctrl-C ended the search. labels : the names of panels and hinges.
    """

    setup: Setup
    formulation: Formulation
    tied: tuple[tuple[int, ...], ...]
    start: SpringSet
    best: SpringSet
    rounded: SpringSet | None
    evaluations: int
    recalled: int
    interrupted: bool
    labels: Labels = NO_LABELS
    samples: int = 0
    samples_recalled: int = 0
    catalogue: tuple[float, ...] = ()

    def __repr__(self) -> str:
        sure = "certified clear" if self.chosen.confirmed else "not certified clear"
        return f"<{len(self.chosen.stiffnesses)} tuned springs: {sure}, {self.evaluations} evaluations>"

    @property
    def chosen(self) -> SpringSet:
        """The springs to use, with their simulation: those of the catalogue if they are confirmed, else `best`."""
        return self.rounded if self.rounded is not None and self.rounded.confirmed else self.best

    @property
    def springs(self) -> dict[str, float]:
        """The stiffness of each hinge's spring, N m/rad, by the names of hinges."""
        return dict(zip(self.labels.hinges, self.chosen.stiffnesses, strict=True))


def tune_springs(
    linkage: Linkage,
    scene: Scene | Setup,
    formulation: Formulation | None = None,
    *,
    catalogue: Sequence[float] = (),
    evaluations: int = DEFAULT_EVALUATION_COUNT,
    samples: int = DEFAULT_SAMPLE_COUNT,
    spread: Spread | None = None,
    seed: int = 0,
    memory: EvaluationMemory | None = None,
    progress: TuningProgress | None = None,
) -> Tuning:
    """Choose the stiffness of each hinge in the scene's spring range, with dampers in proportion.

    formulation : unless given `constrained`, or `compliant` where only so any set becomes flat at first. catalogue :
    stiffnesses of what can be bought (N m/rad). evaluations : sets of springs that are tried at most, in all: for the
    choice of the formulation, the search and the rounding. samples : drawn of the tolerances in `spread` for each set
    that is reported; half as many as evaluations may be drawn besides to compare and harden sets. memory : takes and
    gives evaluations, so that the same tuning again goes on where it stopped.
    The same arguments give the same springs. The springs of the scene are the start; softer ones count as the softest.
    Errors: HcsearchError for stiffer or negative ones, for a floating scene, and for other formulations.
    """
    if formulation is not None and formulation not in TUNING_STEP_TOLERANCES:
        raise HcsearchError(f"springs are not tuned in {formulation}: take {' or '.join(TUNING_STEP_TOLERANCES)}")
    setup = setup_of_scene(scene, linkage)
    if setup.free:
        raise HcsearchError("springs are tuned with a panel held, not floating: hold one, such as panel 0")
    load_matplotlib()  # as cma does later, but whatever windows a notebook asks for
    given = stiffnesses_of(setup)
    tied = tied_hinges(linkage, setup.held)
    softest, stiffest = setup.spring_range
    if not (given >= 0.0).all() or not (given <= stiffest * (1.0 + 1e-9)).all():
        raise HcsearchError(
            f"springs of {given.min():g} to {given.max():g} N m/rad are no start of a search from {softest:g} to "
            f"{stiffest:g}: {_remedy(float(given.min()), float(given.max()), softest)}"
        )
    levels = catalogue_levels(catalogue, stiffest, softest) if catalogue else ()
    start = stiffnesses_of_groups([np.clip(given[list(hinges)].mean(), softest, stiffest) for hinges in tied], tied)
    first = first_generation(start, tied, seed, (softest, stiffest))
    evaluator = _evaluator(linkage, setup, formulation, first, memory, evaluations)
    shares = evaluation_shares(evaluations - evaluator.before, samples, bool(catalogue))
    budget = max(1, shares.total - shares.hardened - shares.rounded)
    search = SpringSearch(evaluator, tied, budget, seed, progress or _silent)
    finder = SpringSetFinder(search, setup, samples, spread or Spread(), shares._replace(total=evaluations))
    interrupted = False
    rounded = None
    begin = SpringSet(tuple(start.tolist()), evaluator.of_springs([start])[0], scales=evaluator.scales)
    try:
        # checks shrink panels by less and are coarse: the precise simulation may decide what they leave open
        begin = finder.precise(begin)
        search.run(start, first)
        finder.choose(search.candidates(), begin)
        if levels:
            rounded = finder.round(levels)
    except KeyboardInterrupt:
        interrupted = True
    best = finder.best or (begin if search.best is None else _seen(search.best, evaluator.scales))
    return Tuning(
        setup,
        evaluator.formulation,
        tied,
        begin,
        best,
        rounded,
        evaluator.done,
        evaluator.recalled,
        interrupted,
        labels_of(linkage),
        evaluator.samples,
        evaluator.samples_recalled,
        tuple(map(float, catalogue)),
    )


def _remedy(least: float, most: float, softest: float) -> str:
    """What to do about springs outside the range."""
    if least < 0.0:
        return "give springs of 0 N m/rad or more, or none"
    return f"add --spring-range {min(softest, most / 2.0):g},{most:g}, or give softer springs"


def _silent(done: int, total: int, note: str) -> None:
    """Show nothing."""


def _seen(place: SeenSpringSet, scales: SceneScales) -> SpringSet:
    return SpringSet(tuple(place.stiffnesses.tolist()), place.check, scales=scales)


def _evaluator(
    linkage: Linkage,
    setup: Setup,
    formulation: Formulation | None,
    first: Reals,
    memory: EvaluationMemory | None,
    evaluations: int = DEFAULT_EVALUATION_COUNT,
) -> Evaluator:
    """The evaluator of the formulation that is asked for, or of exact closure unless only compliant arrays become flat.

    Exact closure can keep hinges shut that a real array lets go (docs/explanation/dynamics.md, known limits).
    """
    if formulation is not None:
        return Evaluator(linkage, setup, formulation, memory)
    exact = Evaluator(linkage, setup, "constrained", memory)
    tied = tied_hinges(linkage, setup.held)
    sets = [stiffnesses_of_groups(np.exp(point), tied) for point in first][:evaluations]
    if any(check.outcome == "flat" for check in exact.of_springs(sets, whole=True)):
        return exact
    other = Evaluator(linkage, setup, "compliant", memory)
    sets = sets[: evaluations - exact.done]
    chosen, left = (
        (other, exact) if any(c.outcome == "flat" for c in other.of_springs(sets, whole=True)) else (exact, other)
    )
    chosen.before, chosen.recalled = left.done, chosen.recalled + left.recalled
    return chosen
