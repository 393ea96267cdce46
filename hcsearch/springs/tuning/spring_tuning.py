"""Tuning of spring stiffnesses for a flat and clear deployment (thesis 4.4): search, choice, confirmation, report."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import Formulation, millimetres
from hcsearch.scenes import Scene
from hcsearch.scenes.setup import Setup, setup_of_scene
from hcsearch.shape.labels import Labels, label_data, labels_of
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.deployment_facts import play_facts
from hcsearch.springs.deployment.spring_sets import stiffnesses_of, tied_hinges
from hcsearch.springs.tuning.choice import SpringSet, SpringSetFinder, evaluation_shares
from hcsearch.springs.tuning.evaluation import TUNING_STEP_TOLERANCES, EvaluationMemory, Evaluator, SceneScales
from hcsearch.springs.tuning.spring_search import (
    SeenSpringSet,
    SpringSearch,
    TuningProgress,
    catalogue_levels,
    first_generation,
    springs_for,
    stiffnesses_of_groups,
)
from hcsearch.springs.tuning.tuning_options import TuningOptions
from hcsearch.system.figures import load_matplotlib

NO_LABELS = Labels((), ())


@dataclass(frozen=True)
class Tuning:
    """The result of `tune_springs`; `springs` has the stiffnesses to use.

    Parameters
    ----------
    setup
        The scene of the simulations, evaluated for the linkage.
    formulation
        The equations of motion.
    tied
        The groups of hinges that have equal springs, by their indices in the linkage.
    start
        The springs with which the search began.
    best
        The confirmed set that is least likely to fail; if none is confirmed, the set with the least objective.
    rounded
        The same with springs of the catalogue; None without one.
    evaluations
        How many sets of springs were tried, each by one quick simulation.
    samples
        How many simulations within the tolerances were drawn.
    recalled, samples_recalled
        How many of these a database already held.
    catalogue
        The springs that can be bought, N m/rad.
    interrupted
        Whether Ctrl-C ended the search.
    labels
        The names of panels and hinges.
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

    @property
    def advice(self) -> str:
        """A sentence on the springs to use, by the less favourable of the precise simulation and the samples."""
        spring_set = self.chosen
        name = "catalogue springs" if spring_set is self.rounded else "tuned springs"
        if not spring_set.confirmed:
            return f"none: no set that was tried becomes flat, certified clear; the {name} come nearest"
        if spring_set.doubt:
            return f"{name}, with care: {spring_set.doubt}"
        chance = spring_set.robustness
        if chance is None:
            return f"{name}: flat, certified clear"
        if not chance.failures:
            return f"{name}: flat, certified clear, in all {chance.samples} samples too"
        share = f"{chance.failures} of {chance.samples} samples within the tolerances fail"
        if 2 * chance.failures > chance.samples:
            return f"none as built: {share}; certified clear holds for the {name} exactly as they are listed"
        return f"{name}, with care: {share}; certified clear holds for springs exactly as they are listed"

    @property
    def springs_to_buy(self) -> list[tuple[float, ...]] | None:
        """The catalogue springs in parallel at each hinge, N m/rad; None unless catalogue springs are to be used."""
        if not self.catalogue or self.chosen is not self.rounded:
            return None
        return [springs_for(stiffness, self.catalogue) for stiffness in self.chosen.stiffnesses]

    @property
    def purchase(self) -> str:
        """A sentence on the springs to buy, and the hinges that do not get exactly one spring."""
        springs_at = self.springs_to_buy
        if springs_at is None:
            none = "none was tried, give more --evaluations" if self.rounded is None else "none is certified clear"
            return f"nothing of the catalogue: {none}"
        listed = ", ".join(f"{count} x {spring:g}" for spring, count in _counts(springs_at))
        listed = f"{listed} N m/rad" if listed else "no springs"
        hinges_with: dict[tuple[float, ...], list[str]] = {}
        for name, springs in zip(self.labels.hinges, springs_at, strict=True):
            # the table shows the stiffness of pairs of equal springs
            key = (0.0, 0.0) if len(springs) == 2 and springs[0] == springs[1] else springs
            hinges_with.setdefault(key, []).append(name)
        notes = [f"{_where(key)} at {_hinges(names)}" for key, names in sorted(hinges_with.items()) if len(key) != 1]
        return listed + (f" ({'; '.join(notes)})" if notes else "")

    def facts(self) -> dict[str, Any]:
        """All results as plain data, as `hcsearch tune --json` prints them; stiffnesses in the order of `hinges`."""
        hinges = [label_data(name) for name in self.labels.hinges]
        sets = {"start": self.start, "best": self.best, "rounded": self.rounded}
        return {
            "formulation": self.formulation,
            "spring_range_N_m_rad": list(self.setup.spring_range),
            "seconds": self.setup.seconds,
            "use": self.advice,
            "hinges": hinges,
            "merged_panels": list(self.labels.merged),
            "tied_hinges": [[hinges[k] for k in group] for group in self.tied],
            **{
                name: None if spring_set is None else _set_facts(spring_set, self.labels)
                for name, spring_set in sets.items()
            },
            "buy": None if (springs_at := self.springs_to_buy) is None else _bought_facts(springs_at),
            "evaluations": self.evaluations,
            "known_before": self.recalled,
            "samples": self.samples,
            "samples_known_before": self.samples_recalled,
            "interrupted": self.interrupted,
        }


def tune_springs(
    linkage: Linkage,
    scene: Scene | Setup,
    options: TuningOptions,
    formulation: Formulation | None = None,
    *,
    memory: EvaluationMemory | None = None,
    progress: TuningProgress | None = None,
) -> Tuning:
    """Choose the stiffness of each hinge in the scene's spring range, with dampers in proportion.

    formulation : unless given `constrained`, or `compliant` where only with it a set of the first generation becomes
    flat. memory : a cache of evaluations, with which the same tuning resumes where it stopped.
    The same arguments give the same springs. The springs of the scene are the start; softer ones count as the softest.
    Errors: HcsearchError for stiffer or negative ones, for a floating scene, and for other formulations.
    """
    if formulation is not None and formulation not in TUNING_STEP_TOLERANCES:
        raise HcsearchError(f"springs are not tuned in {formulation}: take {' or '.join(TUNING_STEP_TOLERANCES)}")
    setup = setup_of_scene(scene, linkage)
    if setup.free:
        raise HcsearchError("springs are tuned with a panel held, not floating: hold one, such as panel 0")
    load_matplotlib()  # cma loads it later, too, but not independently of a notebook's choice of windows
    given = stiffnesses_of(setup)
    tied = tied_hinges(linkage, setup.held)
    softest, stiffest = setup.spring_range
    if not (given >= 0.0).all() or not (given <= stiffest * (1.0 + 1e-9)).all():
        raise HcsearchError(
            f"springs of {given.min():g} to {given.max():g} N m/rad are no start of a search from {softest:g} to "
            f"{stiffest:g}: {_remedy(float(given.min()), float(given.max()), softest)}"
        )
    levels = catalogue_levels(options.catalogue, stiffest, softest) if options.catalogue else ()
    start = stiffnesses_of_groups([np.clip(given[list(hinges)].mean(), softest, stiffest) for hinges in tied], tied)
    first = first_generation(start, tied, options.seed, (softest, stiffest))
    evaluator = _evaluator(linkage, setup, formulation, first, memory, options.evaluations)
    shares = evaluation_shares(options, evaluator.earlier_evaluations)
    search = SpringSearch(evaluator, tied, shares.search, options.seed, progress or _silent)
    finder = SpringSetFinder(search, setup, options, shares)
    interrupted = False
    rounded = None
    start_set = SpringSet(tuple(start.tolist()), evaluator.of_springs([start])[0], scales=evaluator.scales)
    try:
        # checks shrink panels by less and are coarse: the precise simulation may decide where they are undecided
        start_set = finder.with_deployment(start_set)
        search.run(start, first)
        finder.choose(search.candidates(), start_set)
        if levels:
            rounded = finder.round_to_catalogue(levels)
    except KeyboardInterrupt:
        interrupted = True
    best = finder.best or (start_set if search.best is None else _seen(search.best, evaluator.scales))
    return Tuning(
        setup,
        evaluator.formulation,
        tied,
        start_set,
        best,
        rounded,
        evaluator.evaluation_count,
        evaluator.recalled,
        interrupted,
        labels_of(linkage),
        evaluator.sample_count,
        evaluator.samples_recalled,
        options.catalogue,
    )


def _remedy(softest_given: float, stiffest_given: float, softest: float) -> str:
    """Return the remedy for springs outside the range."""
    if softest_given < 0.0:
        return "give springs of 0 N m/rad or more, or none"
    return f"add --spring-range {min(softest, stiffest_given / 2.0):g},{stiffest_given:g}, or give softer springs"


def _silent(done: int, total: int, note: str) -> None:
    """Show nothing."""


def _seen(seen: SeenSpringSet, scales: SceneScales) -> SpringSet:
    return SpringSet(tuple(seen.stiffnesses.tolist()), seen.check, scales=scales)


def _evaluator(
    linkage: Linkage,
    setup: Setup,
    formulation: Formulation | None,
    first: Reals,
    memory: EvaluationMemory | None,
    evaluations: int,
) -> Evaluator:
    """Return the evaluator of the given formulation, or of exact closure unless only compliant arrays become flat.

    Exact closure can keep hinges shut that open in a real array (docs/explanation/dynamics.md, known limits).
    """
    if formulation is not None:
        return Evaluator(linkage, setup, formulation, memory)
    exact = Evaluator(linkage, setup, "constrained", memory)
    tied = tied_hinges(linkage, setup.held)
    sets = [stiffnesses_of_groups(np.exp(point), tied) for point in first][:evaluations]
    if any(check.outcome == "flat" for check in exact.of_springs(sets, past_collisions=True)):
        return exact
    compliant = Evaluator(linkage, setup, "compliant", memory)
    sets = sets[: evaluations - exact.evaluation_count]
    chosen, rejected = (
        (compliant, exact)
        if any(c.outcome == "flat" for c in compliant.of_springs(sets, past_collisions=True))
        else (exact, compliant)
    )
    chosen.earlier_evaluations, chosen.recalled = rejected.evaluation_count, chosen.recalled + rejected.recalled
    return chosen


def _set_facts(spring_set: SpringSet, labels: Labels) -> dict[str, Any]:
    check, precise, chance = spring_set.check, spring_set.deployment, spring_set.robustness
    clearance = None if precise is None else precise.clearance
    return {
        "stiffness_N_m_rad": list(spring_set.stiffnesses),
        "outcome": check.outcome,
        "clear": check.clear,
        "collision_s": None if check.collision is None else check.collision[0],
        "collision_panels": None
        if check.collision is None
        else [label_data(labels.panels[k]) for k in check.collision[1]],
        **({"min_clearance_mm": millimetres(check.gap)} if precise is None else play_facts(precise)),
        "objective": spring_set.value,
        "confirmed": spring_set.confirmed,
        "flat_time_s": spring_set.flat_time,
        "certified": None if clearance is None else clearance.kind,
        "samples": None if chance is None else chance.samples,
        "collision_probability": None if chance is None else chance.probability,
        "collision_interval_95": None if chance is None else list(chance.interval),
        "failure_interval_95": None if chance is None else list(chance.failure_interval),
    }


def _where(springs: tuple[float, ...]) -> str:
    if not springs:
        return "none"
    return "two each" if springs == (0.0, 0.0) else " and ".join(f"{spring:g}" for spring in springs)


def _hinges(names: list[str]) -> str:
    return ("hinges " if len(names) > 1 else "hinge ") + ", ".join(names)


def _counts(springs_at: list[tuple[float, ...]]) -> list[tuple[float, int]]:
    return sorted(Counter(spring for springs in springs_at for spring in springs).items())


def _bought_facts(springs_at: list[tuple[float, ...]]) -> dict[str, Any]:
    return {
        "springs": [{"stiffness_N_m_rad": spring, "count": count} for spring, count in _counts(springs_at)],
        "at_hinges_N_m_rad": [list(springs) for springs in springs_at],
    }
