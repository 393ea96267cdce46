"""Tuning of springs and dampers for a flat and clear deployment (thesis 4.4): search, choice, confirmation, report."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import Formulation, millimetres
from hcsearch.scenes import Scene
from hcsearch.scenes.setup import Setup, setup_of_scene, with_dampings
from hcsearch.shape.labels import Labels, label_data, labels_of
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.deployment_facts import play_facts
from hcsearch.springs.deployment.spring_sets import stiffnesses_of, tied_hinges
from hcsearch.springs.tuning.choice import SpringSet, SpringSetFinder, evaluation_shares, spring_set_of
from hcsearch.springs.tuning.damping_ladder import DampedSprings, damped_springs, damping_factors
from hcsearch.springs.tuning.evaluation import (
    TUNING_STEP_TOLERANCES,
    EvaluationMemory,
    Evaluator,
    SceneScales,
    in_time,
    part_bounds,
    tied_parts,
)
from hcsearch.springs.tuning.spring_search import (
    SpringSearch,
    catalogue_levels,
    first_generation,
    springs_for,
    stiffnesses_of_groups,
)
from hcsearch.springs.tuning.tuning_options import TuningOptions
from hcsearch.system.figures import load_matplotlib
from hcsearch.system.work_steps import Progress, no_progress

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
    damped
        The springs of the scene with more damping, which are tried first; None where they are not.
    rounded
        The same as `best` with springs, and dampers, of the catalogue; None without one.
    evaluations
        How many sets of springs were tried, each by one quick simulation.
    samples
        How many simulations within the tolerances were drawn.
    recalled, samples_recalled
        How many of these a database already held.
    catalogue, damper_catalogue
        The springs that can be bought, N m/rad, and the dampers, N m s/rad.
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
    damped: DampedSprings | None = None
    damper_catalogue: tuple[float, ...] = ()

    def __repr__(self) -> str:
        sure = "certified clear" if self.chosen.confirmed else "not certified clear"
        return f"<{len(self.chosen.stiffnesses)} tuned springs: {sure}, {self.evaluations} evaluations>"

    @property
    def chosen(self) -> SpringSet:
        """The springs to use, with their simulation: catalogue springs if they are confirmed, else `best`."""
        return self.rounded if self.rounded is not None and self.rounded.confirmed else self.best

    @property
    def springs(self) -> dict[str, float]:
        """The stiffness of each hinge's spring, N m/rad, by the names of hinges."""
        return dict(zip(self.labels.hinges, self.chosen.stiffnesses, strict=True))

    @property
    def dampings(self) -> dict[str, float]:
        """The damping of each hinge with the springs to use, N m s/rad, by the names of hinges."""
        return dict(zip(self.labels.hinges, self.chosen.setup_in(self.setup).dampings, strict=True))

    @property
    def _chosen_name(self) -> str:
        """What the springs to use are, in words."""
        dampers = " and dampers" if self.chosen.dampings else ""
        if self.chosen is self.rounded:
            return f"catalogue springs{dampers}"
        if self.damped is not None and self.chosen is self.damped.springs:
            return f"the springs of the scene with {self.damped.factor:g} times its damping"
        return f"tuned springs{dampers}"

    @property
    def advice(self) -> str:
        """A sentence on the springs to use, by the less favourable of the precise simulation and the samples."""
        spring_set, name = self.chosen, self._chosen_name
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
        """A sentence on the springs and dampers to buy, and the hinges that do not get exactly one spring."""
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
        listed += f" ({'; '.join(notes)})" if notes else ""
        return f"{listed}; dampers: {self._dampers_to_buy}" if self.damper_catalogue else listed

    @property
    def _dampers_to_buy(self) -> str:
        """The dampers to buy, with their hinges, in words."""
        hinges_with: dict[float, list[str]] = {}
        for name, damping in zip(self.labels.hinges, self.chosen.dampings, strict=True):
            if not math.isnan(damping):
                hinges_with.setdefault(damping, []).append(name)
        bought = (f"{len(names)} x {c:g} N m s/rad at {_hinges(names)}" for c, names in sorted(hinges_with.items()))
        return ", ".join(bought) or "none"

    def facts(self) -> dict[str, Any]:
        """All results as plain data, as `hcsearch tune --json` prints them; stiffnesses in the order of `hinges`."""
        hinges = [label_data(name) for name in self.labels.hinges]
        damped = None if self.damped is None else self.damped.springs
        sets = {"start": self.start, "damped": damped, "best": self.best, "rounded": self.rounded}
        return {
            "formulation": self.formulation,
            "spring_range_N_m_rad": list(self.setup.spring_range),
            "seconds": self.chosen.setup_in(self.setup).seconds,
            "use": self.advice,
            "hinges": hinges,
            "merged_panels": list(self.labels.merged),
            "tied_hinges": [[hinges[k] for k in group] for group in self.tied],
            **{
                name: None if spring_set is None else _set_facts(spring_set, self.labels, self.setup)
                for name, spring_set in sets.items()
            },
            "damping_factor": None if self.damped is None else self.damped.factor,
            "damping_factors_tried": [] if self.damped is None else list(self.damped.factors),
            "buy": None if (springs_at := self.springs_to_buy) is None else _bought_facts(springs_at, self.chosen),
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
    progress: Progress | None = None,
) -> Tuning:
    """Choose the stiffness of each hinge in the scene's spring range, with dampers in proportion or chosen, too.

    The springs of the scene with more damping are tried first; where they are confirmed at all tolerances and no sample
    fails, no others are searched, unless parts of a catalogue are asked for.
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
    if setup.hold_downs:
        raise HcsearchError("springs are tuned without hold-downs: leave out releases")
    load_matplotlib()  # cma loads it later, too, but not independently of a notebook's choice of windows
    tied, start = _start(setup, linkage)
    levels = catalogue_levels(options.catalogue, *reversed(setup.spring_range)) if options.catalogue else ()
    given, show = setup, progress or no_progress
    parts, searched = start, tied
    if options.damper_range is not None:
        setup = _in_time_of(options.damper_range[1], setup, linkage)
        parts, searched = _with_dampers(start, tied, setup, options.damper_range), tied_parts(tied)
    bounds = part_bounds(setup.spring_range, len(tied), options.damper_range)
    first = first_generation(parts, searched, options.seed, bounds)
    evaluator = _evaluator(linkage, setup, formulation, first, searched, memory, options.evaluations)
    shares = evaluation_shares(options, evaluator.earlier_evaluations)
    search = SpringSearch(evaluator, searched, shares.search, options.seed, show, bounds)
    finder = SpringSetFinder(search, setup, options, shares, tied)
    interrupted, rounded, damped = False, None, None
    start_set = spring_set_of(parts, evaluator.of_springs([parts])[0], setup, evaluator.scales)
    try:
        # checks shrink panels by less and are coarse: the precise simulation may decide where they are undecided
        start_set = finder.with_deployment(start_set)
        multiplied = bool(damping_factors(given, options))
        if multiplied and not (start_set.confirmed and finder.with_samples(start_set).suffices):
            damped = damped_springs(start_set, evaluator, given, options, memory, show)
        if damped is not None and damped.springs.suffices and not levels:
            finder.best = damped.springs
        else:
            search.run(parts, first)
            finder.choose(search.candidates(), start_set, None if damped is None else damped.springs)
        if levels:
            rounded = finder.round_to_catalogue(levels)
    except KeyboardInterrupt:
        interrupted = True
    return Tuning(
        setup,
        evaluator.formulation,
        tied,
        start_set,
        finder.best or _best_so_far(search, damped, start_set, setup, evaluator.scales),
        rounded,
        evaluator.evaluation_count,
        evaluator.recalled,
        interrupted,
        labels_of(linkage),
        evaluator.sample_count + (damped.samples if damped else 0),
        evaluator.samples_recalled + (damped.samples_recalled if damped else 0),
        options.catalogue,
        damped,
        options.damper_catalogue,
    )


def _start(setup: Setup, linkage: Linkage) -> tuple[tuple[tuple[int, ...], ...], Reals]:
    """Return the groups of hinges that get equal springs, and the springs of a setup within its range."""
    given, tied = stiffnesses_of(setup), tied_hinges(linkage, setup.held)
    softest, stiffest = setup.spring_range
    if not (given >= 0.0).all() or not (given <= stiffest * (1.0 + 1e-9)).all():
        raise HcsearchError(
            f"springs of {given.min():g} to {given.max():g} N m/rad are no start of a search from {softest:g} to "
            f"{stiffest:g}: {_remedy(float(given.min()), float(given.max()), softest)}"
        )
    means = [np.clip(given[list(hinges)].mean(), softest, stiffest) for hinges in tied]
    return tied, stiffnesses_of_groups(means, tied)


def _with_dampers(
    start: Reals, tied: Sequence[tuple[int, ...]], setup: Setup, damper_range: tuple[float, float]
) -> Reals:
    """Return the table of some springs and of the dampers of a setup within a range."""
    dampings = [np.mean([setup.dampings[hinge] for hinge in hinges]) for hinges in tied]
    values = [*(start[hinges[0]] for hinges in tied), *np.clip(dampings, *damper_range)]
    return stiffnesses_of_groups(values, tied_parts(tied))


def _in_time_of(damping: float, setup: Setup, linkage: Linkage) -> Setup:
    """Return a setup with the time that it would need with a damping of all hinges."""
    strongest = with_dampings(setup, [damping] * linkage.n_hinges)
    return replace(setup, seconds=max(setup.seconds, in_time(strongest, setup, linkage).seconds))


def _remedy(softest_given: float, stiffest_given: float, softest: float) -> str:
    """Return the remedy for springs outside the range."""
    if softest_given < 0.0:
        return "give springs of 0 N m/rad or more, or none"
    return f"add --spring-range {min(softest, stiffest_given / 2.0):g},{stiffest_given:g}, or give softer springs"


def _best_so_far(
    search: SpringSearch, damped: DampedSprings | None, start: SpringSet, setup: Setup, scales: SceneScales
) -> SpringSet:
    """Return the set to report where a search was interrupted."""
    if damped is not None and damped.springs.confirmed:
        return damped.springs
    return start if search.best is None else spring_set_of(search.best.parts, search.best.check, setup, scales)


def _evaluator(
    linkage: Linkage,
    setup: Setup,
    formulation: Formulation | None,
    first: Reals,
    tied: Sequence[tuple[int, ...]],
    memory: EvaluationMemory | None,
    evaluations: int,
) -> Evaluator:
    """Return the evaluator of the given formulation, or of exact closure unless only compliant arrays become flat.

    Exact closure can keep hinges shut that open in a real array (docs/explanation/dynamics.md, known limits).
    """
    if formulation is not None:
        return Evaluator(linkage, setup, formulation, memory)
    exact = Evaluator(linkage, setup, "constrained", memory)
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


def _set_facts(spring_set: SpringSet, labels: Labels, setup: Setup) -> dict[str, Any]:
    check, precise, chance = spring_set.check, spring_set.deployment, spring_set.robustness
    clearance = None if precise is None else precise.clearance
    return {
        "stiffness_N_m_rad": list(spring_set.stiffnesses),
        "damping_N_m_s_rad": list(spring_set.setup_in(setup).dampings),
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


def _bought_facts(springs_at: list[tuple[float, ...]], chosen: SpringSet) -> dict[str, Any]:
    dampers = [None if math.isnan(damping) else damping for damping in chosen.dampings]
    return {
        "springs": [{"stiffness_N_m_rad": spring, "count": count} for spring, count in _counts(springs_at)],
        "at_hinges_N_m_rad": [list(springs) for springs in springs_at],
        "dampers_N_m_s_rad": dampers or None,
    }
