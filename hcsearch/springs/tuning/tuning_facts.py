"""A tuning as plain data, and in sentences."""

from __future__ import annotations

from collections import Counter
from typing import Any

from hcsearch.basics.vocabulary import millimetres
from hcsearch.shape.labels import Labels, label_data
from hcsearch.springs.deployment.deployment_facts import play_facts
from hcsearch.springs.deployment.outcomes import reason_with_clearance
from hcsearch.springs.tuning.choice import SpringSet
from hcsearch.springs.tuning.spring_search import springs_for
from hcsearch.springs.tuning.spring_tuning import Tuning


def tuning_facts(tuning: Tuning) -> dict[str, Any]:
    """A tuning as plain data; keys name their units. Stiffnesses are in the order of `hinges`."""
    hinges = [label_data(name) for name in tuning.labels.hinges]
    sets = {"start": tuning.start, "best": tuning.best, "rounded": tuning.rounded}
    return {
        "formulation": tuning.formulation,
        "spring_range_N_m_rad": list(tuning.setup.spring_range),
        "seconds": tuning.setup.seconds,
        "use": tuning_advice(tuning),
        "hinges": hinges,
        "merged_panels": list(tuning.labels.merged),
        "tied_hinges": [[hinges[k] for k in group] for group in tuning.tied],
        **{name: None if one is None else _set_facts(one, tuning.labels) for name, one in sets.items()},
        "buy": None if (each := springs_to_buy(tuning)) is None else _bought_facts(each),
        "evaluations": tuning.evaluations,
        "known_before": tuning.recalled,
        "samples": tuning.samples,
        "samples_known_before": tuning.samples_recalled,
        "interrupted": tuning.interrupted,
    }


def _set_facts(one: SpringSet, labels: Labels) -> dict[str, Any]:
    check, precise, chance = one.check, one.deployment, one.robustness
    clearance = None if precise is None else precise.clearance
    return {
        "stiffness_N_m_rad": list(one.stiffnesses),
        "outcome": check.outcome,
        "clear": check.clear,
        "collision_s": None if check.collision is None else check.collision[0],
        "collision_panels": None
        if check.collision is None
        else [label_data(labels.panels[k]) for k in check.collision[1]],
        **({"min_clearance_mm": millimetres(check.gap)} if precise is None else play_facts(precise)),
        "objective": one.value,
        "confirmed": one.confirmed,
        "flat_time_s": one.flat_time,
        "certified": None if clearance is None else clearance.kind,
        "samples": None if chance is None else chance.samples,
        "collision_probability": None if chance is None else chance.probability,
        "collision_interval_95": None if chance is None else list(chance.interval),
        "failure_interval_95": None if chance is None else list(chance.failure_interval),
    }


def tuning_advice(tuning: Tuning) -> str:
    """What to rely on: the least favourable of the precise simulation and of the samples."""
    one = tuning.chosen
    name = "catalogue springs" if one is tuning.rounded else "tuned springs"
    if not one.confirmed:
        return f"none: no set that was tried becomes flat, certified clear; the {name} come nearest"
    if one.doubt:
        return f"{name}, with care: {one.doubt}"
    chance = one.robustness
    if chance is None or not chance.failures:
        return f"{name}: flat, certified clear" + ("" if chance is None else f", in all {chance.samples} samples too")
    share = f"{chance.failures} of {chance.samples} samples within the tolerances fail"
    if 2 * chance.failures > chance.samples:
        return f"none as built: {share}; certified clear holds for the {name} exactly as they are listed"
    return f"{name}, with care: {share}; certified clear holds for springs exactly as they are listed"


def springs_to_buy(tuning: Tuning) -> list[tuple[float, ...]] | None:
    """The catalogue springs at each hinge, N m/rad, in parallel; None unless catalogue springs are those to use."""
    if not tuning.catalogue or tuning.chosen is not tuning.rounded:
        return None
    return [springs_for(stiffness, tuning.catalogue) for stiffness in tuning.chosen.stiffnesses]


def shopping_sentence(tuning: Tuning) -> str:
    """What to buy, and the hinges that do not get one spring, in one line."""
    each = springs_to_buy(tuning)
    if each is None:
        none = "none was tried, give more --evaluations" if tuning.rounded is None else "none is certified clear"
        return f"nothing of the catalogue: {none}"
    listed = ", ".join(f"{count} x {spring:g}" for spring, count in _counts(each))
    listed = f"{listed} N m/rad" if listed else "no springs"
    where: dict[tuple[float, ...], list[str]] = {}
    for name, springs in zip(tuning.labels.hinges, each, strict=True):
        # pairs of equal springs are told by their stiffness in the table
        key = (0.0, 0.0) if len(springs) == 2 and springs[0] == springs[1] else springs
        where.setdefault(key, []).append(name)
    notes = [f"{_where(key)} at {_hinges(names)}" for key, names in sorted(where.items()) if len(key) != 1]
    return listed + (f" ({'; '.join(notes)})" if notes else "")


def _where(springs: tuple[float, ...]) -> str:
    if not springs:
        return "none"
    return "two each" if springs == (0.0, 0.0) else " and ".join(f"{spring:g}" for spring in springs)


def _hinges(names: list[str]) -> str:
    return ("hinges " if len(names) > 1 else "hinge ") + ", ".join(names)


def _counts(each: list[tuple[float, ...]]) -> list[tuple[float, int]]:
    return sorted(Counter(spring for springs in each for spring in springs).items())


def _bought_facts(each: list[tuple[float, ...]]) -> dict[str, Any]:
    return {
        "springs": [{"stiffness_N_m_rad": spring, "count": count} for spring, count in _counts(each)],
        "at_hinges_N_m_rad": [list(springs) for springs in each],
    }


def spring_set_sentence(one: SpringSet, labels: Labels) -> str:
    """What became of a set, in one line."""
    check, precise, chance = one.check, one.deployment, one.robustness
    if precise is None:
        text = f"{check.reason(labels)} (by a quick simulation)"
    else:
        reason = precise.reason if one.agreement is None else one.agreement.reason
        text = reason_with_clearance(reason, precise.outcome, precise.clearance, labels)
        clear = precise.clearance is not None and precise.clearance.kind == "clear"
        text += f", {'' if clear else 'not '}certified clear"
        play = play_facts(precise)["play"]
        text += f"; {play}" if play else ""
    if chance is not None:
        low, high = chance.interval
        text += f"; collides in {chance.collisions} of {chance.samples} samples, {low:.0%} to {high:.0%} at 95 %"
    return text
