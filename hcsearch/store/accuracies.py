"""Accuracy of the deployments that a database holds."""

from __future__ import annotations

from typing import Any

from sqlalchemy import Connection, Select, select

from hcsearch.basics.simulation_accuracy import SimulationAccuracy, TrialAccuracy, accuracy_of_trials
from hcsearch.designs.records import WorkKey
from hcsearch.store.database import Database
from hcsearch.store.failures import retry_if_changed
from hcsearch.store.schema import deployment
from hcsearch.store.verdicts import ids_of_run


@retry_if_changed
def simulation_accuracy(database: Database, work: WorkKey) -> SimulationAccuracy:
    """Return the accuracy of the deployments of the designs of a run in its scene."""
    with database.reading() as connection:
        return accuracy_of_deployments(connection, ids_of_run(work), work.scene)


def accuracy_of_deployments(connection: Connection, ids: Select[Any], name: str) -> SimulationAccuracy:
    """Return the accuracy of the deployments of the designs with some ids, for the scene of a name.

    Deployments that were taken over from congruent foldings, and those of before the columns, are left out.
    """
    rows = connection.execute(
        select(deployment.c.time_saved, deployment.c.status, deployment.c.deploy_time, deployment.c.error_time)
        .where(deployment.c.base == name, deployment.c.as_crease.is_(None), deployment.c.time_saved.is_not(None))
        .where(deployment.c.design_id.in_(ids))
    )
    return accuracy_of_trials(TrialAccuracy(*row) for row in rows)
