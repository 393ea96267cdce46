"""The travel of a case's folding: by the motion that gave its status, else by springs, else along a planned path."""

from __future__ import annotations

from hcsearch.basics.errors import HcsearchError
from hcsearch.cases.case import Case
from hcsearch.cases.replay_sources import find_path
from hcsearch.springs.deployment.simulated_deployment import simulate_deployment
from hcsearch.springs.flight.travel import Travel, travel_along, travel_of_deployment


def travel_of_case(case: Case) -> tuple[Travel, str]:
    """Return the travel of a folding in the scene of its case, and a sentence on what moves it.

    HcsearchError for an assembly, a drive, and a folding that neither springs nor a proved path open.
    """
    folding = case.to_move() if case.look_of != "name" else case.folding
    if folding is None:
        raise HcsearchError(f"{case.title} is no folding: name DESIGN:CREASE")
    stored = case.stored
    proved = stored is not None and stored.verdict is not None and stored.verdict.status == "movable"
    reason = ""
    if not proved:
        deployment = simulate_deployment(case.linkage, case.setup)
        if deployment.deploys:
            return travel_of_deployment(deployment, case.scene), f"springs, {case.sentence or deployment.reason}"
        reason = f"springs do not open it ({deployment.reason}); "
    if stored is not None and stored.damage is not None:
        raise stored.damage
    if stored is not None and stored.path is not None and stored.path.way is not None:
        linkage = folding.linkage(case.panel, flat_pairs=stored.path.way)
        return travel_along(linkage, case.scene, stored.path.states), f"{reason}{case.driven_sentence}"
    _, motion, note = find_path(case)
    if motion.margin is None or motion.way is None or motion.states is None:
        raise HcsearchError(
            f"{folding.notation} has no motion for a flight sheet: {reason}no path is proved; see hcsearch drive "
            f"{folding.notation}"
        )
    linkage = folding.linkage(case.panel, flat_pairs=motion.way)
    note = note or f"a proved path, flat pairs {motion.way}"
    return travel_along(linkage, case.scene, motion.states), f"{reason}{note}"
