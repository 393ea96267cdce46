"""The motion of a stored folding by which it has its status, for pages that play one motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any, NamedTuple

from hcsearch.basics.errors import HcsearchError
from hcsearch.springs.deployment.simulated_deployment import Deployment, simulate_deployment
from hcsearch.store import Database
from hcsearch.subjects.names import deployment_scene_name
from hcsearch.subjects.replay import Replay
from hcsearch.subjects.replay_sources import replay_of_deployment
from hcsearch.subjects.resolve import resolve
from hcsearch.web.player import payload_of
from hcsearch.web.report.accuracy_section import accuracy_of_deployment
from hcsearch.web.report.data import ReportData, ViewRow
from hcsearch.web.report.reasons import best_deployment, verdict_of_row
from hcsearch.web.report.script_data import design_id_of, drawn_crease, first_design
from hcsearch.web.report.templating import scene_option_text


class DecidingDeployment(NamedTuple):
    """The deployment by which a folding has its status, and its replay."""

    deployment: Deployment
    replay: Replay


def deciding_deployment(
    database: Database, notation: str, folding: ViewRow, deployments: Sequence[ViewRow]
) -> DecidingDeployment | None:
    """Simulate the deployment by which a folding has the status `deploys`; None of a folding of another status.

    folding : its row of `foldings`. deployments : its deployments. HcsearchError where its scene does not suit it.
    """
    best, verdict = best_deployment(deployments), verdict_of_row(folding, deployments)
    if best is None or verdict is None or verdict.status != "deploys":
        return None
    case = resolve(notation, database, scene=deployment_scene_name(best, verdict))
    deployment = simulate_deployment(case.linkage, case.setup, case.formulation or "constrained")
    replay = replay_of_deployment(deployment, notation, reason=str(best["reason"]))
    return DecidingDeployment(deployment, replay)


def with_first_motion(data: ReportData, database: Database) -> ReportData:
    """Return the data of a report whose first design plays the motion that its sentence is about, with its accuracy."""
    if not data.players:
        return data
    design = data.designs[first_design(data)]
    crease = drawn_crease(data, design)
    key = design_id_of(design), -1 if crease is None else crease
    row = next((row for row in data.foldings.get(key[0], ()) if row["crease"] == crease), None)
    if row is None or key not in data.players:
        return data
    with suppress(HcsearchError):  # the path plays on
        notation, deployments = f"{design['circuit']}:{crease}", data.deployments.get(key, ())
        deciding = deciding_deployment(database, notation, row, deployments)
        if deciding is not None:
            players: Mapping[Any, Any] = {**data.players, key: payload_of(deciding.replay)}
            options = scene_option_text(deciding.deployment.compiled.setup.name, data.database_option)
            accuracy = accuracy_of_deployment(deciding.deployment, f"hcsearch accuracy {notation}{options}")
            data = replace(data, players=players, accuracy=accuracy)
    return data
