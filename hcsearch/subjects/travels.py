"""The travel of a case: by the motion that gave its status, else by springs, else along a planned path."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from hcsearch.basics.errors import HcsearchError
from hcsearch.scenes import Scene
from hcsearch.springs.deployment.simulated_deployment import simulate_deployment
from hcsearch.springs.flight.travel import Travel, travel_along, travel_of_deployment
from hcsearch.subjects.case import Case
from hcsearch.subjects.pattern_files import DrawnPattern
from hcsearch.subjects.replay_sources import find_path


class MovedCase(NamedTuple):
    """The travel of a case, its scene with the joining of flat pairs that moves, and a sentence on what moves it."""

    travel: Travel
    scene: Scene
    source: str


def travel_of_case(case: Case) -> MovedCase:
    """Return the travel of a folding, or of a pattern of a file, in the scene of its case.

    HcsearchError for an assembly, a drive, and what neither springs nor a proved path open.
    """
    if isinstance(case.what, DrawnPattern):
        case.check_moved()
        return _of_pattern(case)
    folding = case.to_move() if case.look_of != "name" else case.folding
    if folding is None:
        raise HcsearchError(f"{case.title} is no folding: name DESIGN:CREASE")
    stored, reason = case.stored, ""
    proved = stored is not None and stored.verdict is not None and stored.verdict.status == "movable"
    if not proved:
        by_springs = _by_springs(case)
        if isinstance(by_springs, MovedCase):
            return by_springs
        reason = by_springs
    if stored is not None and stored.damage is not None:
        raise stored.damage
    if stored is not None and stored.path is not None and stored.path.way is not None:
        way, states, note = stored.path.way, stored.path.states, case.driven_sentence
    else:
        _, motion, note = find_path(case)
        if motion.margin is None or motion.way is None or motion.states is None:
            raise _no_motion(folding.notation, reason)
        way, states = motion.way, motion.states
    linkage = folding.linkage(case.panel, flat_pairs=way)
    scene = replace(case.joined_scene, flat_pairs=(way,))
    source = f"{reason}{note or f'a proved path, flat pairs {way}'}"
    return MovedCase(travel_along(linkage, case.scene, states), scene, source)


def _of_pattern(case: Case) -> MovedCase:
    """Return the travel of a pattern."""
    by_springs = _by_springs(case)
    if isinstance(by_springs, MovedCase):
        return by_springs
    _, motion, _ = find_path(case)
    if motion.margin is None or motion.states is None:
        raise _no_motion(case.title, by_springs)
    return MovedCase(travel_along(case.linkage, case.scene, motion.states), case.scene, f"{by_springs}a proved path")


def _by_springs(case: Case) -> MovedCase | str:
    """Return the travel by springs; where they do not open the case, the beginning of a sentence that says so."""
    deployment = simulate_deployment(case.linkage, case.setup)
    reason = deployment.check.reason(case.labels) if deployment.outcome == "flat" else deployment.sentence
    if deployment.deploys:
        travel = travel_of_deployment(deployment, case.scene)
        return MovedCase(travel, case.joined_scene, f"springs, {case.sentence or reason}")
    return f"springs do not open it ({reason}); "


def _no_motion(title: str, reason: str) -> HcsearchError:
    """Return the error for a case that does not move; reason : why springs do not move it."""
    return HcsearchError(
        f"{title} has no motion for a flight sheet: {reason}no path is proved; see hcsearch drive {title}"
    )
