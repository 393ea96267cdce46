"""A tuning as plain data, and in sentences."""

from __future__ import annotations

from typing import Any

from hcsearch.deployment.facts import play_facts
from hcsearch.labels import Labels, plain
from hcsearch.play import millimetres
from hcsearch.tuning.choice import SpringSet
from hcsearch.tuning.tuning import Tuning


def facts(tuning: Tuning) -> dict[str, Any]:
    """A tuning as plain data; keys name their units. Stiffnesses are in the order of `hinges`."""
    hinges = [plain(name) for name in tuning.labels.hinges]
    sets = {"start": tuning.start, "best": tuning.best, "rounded": tuning.rounded}
    return {
        "formulation": tuning.formulation,
        "spring_range_N_m_rad": list(tuning.scene.spring_range or ()),
        "seconds": tuning.scene.seconds,
        "use": advice(tuning),
        "hinges": hinges,
        "merged_panels": list(tuning.labels.merged),
        "tied_hinges": [[hinges[k] for k in group] for group in tuning.tied],
        **{name: None if one is None else _set_facts(one, tuning.labels) for name, one in sets.items()},
        "evaluations": tuning.evaluations,
        "known_before": tuning.recalled,
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
        "collision_panels": None if check.collision is None else [plain(labels.panels[k]) for k in check.collision[1]],
        **({"min_clearance_mm": millimetres(check.gap)} if precise is None else play_facts(precise)),
        "objective": one.value,
        "confirmed": one.confirmed,
        "flat_time_s": None if precise is None else precise.flat_time,
        "certified": None if clearance is None else clearance.kind,
        "samples": None if chance is None else chance.samples,
        "collision_probability": None if chance is None else chance.probability,
        "collision_interval_95": None if chance is None else list(chance.interval),
        "failure_interval_95": None if chance is None else list(chance.failure_interval),
    }


def advice(tuning: Tuning) -> str:
    """What to rely on: the least favourable of the precise simulation and of the samples."""
    one = tuning.chosen
    name = "catalogue springs" if one is tuning.rounded else "tuned springs"
    if not one.confirmed:
        return f"none: no set that was tried becomes flat, certified clear; the {name} come nearest"
    chance = one.robustness
    if chance is None or not chance.failures:
        return f"{name}: flat, certified clear" + ("" if chance is None else f", in all {chance.samples} samples too")
    share = f"{chance.failures} of {chance.samples} samples within the tolerances fail"
    if 2 * chance.failures > chance.samples:
        return f"none as built: {share}; certified clear holds for the {name} exactly as they are listed"
    return f"{name}, with care: {share}; certified clear holds for springs exactly as they are listed"


def sentence(one: SpringSet, labels: Labels) -> str:
    """What became of a set, in one line."""
    check, precise, chance = one.check, one.deployment, one.robustness
    text = check.reason(labels)
    if precise is not None:
        clear = precise.clearance is not None and precise.clearance.kind == "clear"
        text += f"; in a precise simulation {precise.reason}, {'' if clear else 'not '}certified clear"
        play = play_facts(precise)["play"]
        text += f"; {play}" if play else ""
    if chance is not None:
        low, high = chance.interval
        text += f"; collides in {chance.collisions} of {chance.samples} samples, {low:.0%} to {high:.0%} at 95 %"
    return text
