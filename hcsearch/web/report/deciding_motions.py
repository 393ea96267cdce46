"""The motion of a stored folding by which it has its status, for pages that play one motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any, NamedTuple

from hcsearch.basics.errors import HcsearchError
from hcsearch.springs.deployment.simulated_deployment import Deployment, simulate_deployment
from hcsearch.store import Database
from hcsearch.subjects.case import Case
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


class TriedDeployment(NamedTuple):
    """The name of a variant of a scene, a deployment in it, and its replay."""

    scene: str
    deployment: Deployment
    replay: Replay


def best_tried_deployment(case: Case, folding: ViewRow, deployments: Sequence[ViewRow]) -> TriedDeployment | None:
    """Simulate the best stored deployment of a folding; None without one.

    folding : its row of `foldings`. deployments : its deployments. HcsearchError where its scene does not suit it.
    """
    best = best_deployment(deployments)
    if best is None:
        return None
    name = deployment_scene_name(best, verdict_of_row(folding, deployments))
    tried = case.in_variant(name)
    deployment = simulate_deployment(tried.linkage, tried.setup, tried.formulation or "constrained")
    return TriedDeployment(name, deployment, replay_of_deployment(deployment, case.title, reason=str(best["reason"])))


def deciding_deployment(case: Case, folding: ViewRow, deployments: Sequence[ViewRow]) -> TriedDeployment | None:
    """Simulate the deployment by which a folding has the status `deploys`; None for a folding with another status."""
    return best_tried_deployment(case, folding, deployments) if folding.get("status") == "deploys" else None


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
        case = resolve(f"{design['circuit']}:{crease}", database, scene=data.scene)
        deciding = deciding_deployment(case, row, data.deployments.get(key, ()))
        if deciding is not None:
            players: Mapping[Any, Any] = {**data.players, key: payload_of(deciding.replay)}
            options = scene_option_text(deciding.deployment.compiled.setup.name, data.database_option)
            accuracy = accuracy_of_deployment(deciding.deployment, f"hcsearch accuracy {case.title}{options}")
            data = replace(data, players=players, accuracy=accuracy)
    return data
