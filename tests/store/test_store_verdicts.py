"""Verdicts of the stage `deployment` in the database: stored, kept beside other stages, and made anew by newer work."""

from dataclasses import replace

import numpy as np
import pytest
from store_samples import begin, sample

from hcsearch.records import NONE, DeploymentBatch, MobilityBatch, Trial, Work
from hcsearch.store import find_design, record_batches, select

NAMES = ("hex:a", "hex:b", "hex:c")
UNTWISTED = 3  # of the four foldings of the three designs


def mobility(locked=False):
    numbers = {
        name: np.full(4, value)
        for name, value in (("dof", 6), ("dof_folded", 7), ("dof_flat", 6), ("merged_panels", 0))
    }
    none = {name: np.full(4, NONE) for name in ("kutzbach_merged", "dof_merged")}
    return MobilityBatch(kutzbach=6, **numbers, **none, locked=np.array([False] * 3 + [locked]))


def trial(scene, status, clearance=None, time=None, contact=None):
    return Trial(UNTWISTED, scene, "{}", "constrained", status, "so it was", clearance, contact, time, 1e-7, 2e-9)


def batch(status=None, trials=(), locked=False):
    """The sample with the stage `mobility`, and with `deployment` where a status of its untwisted folding is given."""
    word = status or ("locked" if locked else "undecided")
    found = None
    if status is not None:
        numbers = np.full(4, np.nan), np.full(4, np.nan)
        for one in trials:
            if one.status == "deploys":
                numbers[0][UNTWISTED] = one.clearance
                numbers[1][UNTWISTED] = one.deploy_time
        found = DeploymentBatch([None, None, None, status], *numbers, tuple(trials))
    return replace(
        sample(NAMES),
        mobility=mobility(locked),
        best_crease=np.array([-1, -1, 3]),
        folding_status=[None, None, None, word],
        status=[None, None, word],
        deployment=found,
    )


def store(database, designs):
    work = Work("hex", 12, "", "all")
    record_batches(database, begin(database, work), work, [("p", designs, [])])


def told(database):
    row = find_design(database, "hex:c")
    return [row[name] for name in ("status", "deployable", "min_clearance", "deploy_time")]


COLLIDES = trial("default", "collides", contact=0.25)
DEPLOYS = trial("hinged", "deploys", clearance=1.5e-3, time=0.5)


def test_a_deployment_is_stored_with_its_scenes(database):
    store(database, batch("deploys", [COLLIDES, DEPLOYS]))
    assert told(database) == ["deploys", 1, 1.5, 0.5]
    rows = select(database, view="deployments", columns="crease,scene,status,clearance,first_contact,deploy_time").rows
    assert rows == ((3, "default", "collides", None, 0.25, None), (3, "hinged", "deploys", 1.5, None, 0.5))
    errors = select(database, view="deployments", columns="energy_error,closure_error", limit=1).rows
    assert errors == ((1e-7, pytest.approx(2e-6)),)
    assert [row["scene"] for row in find_design(database, "hex:c")["deployments"]] == ["default", "hinged"]
    shown = select(database, columns="circuit,status,deployable").rows
    assert shown == (("hex:a", "no_folding", 0), ("hex:b", "twisted", 0), ("hex:c", "deploys", 1))


@pytest.mark.parametrize("status", ["deploys", "collides"])
def test_a_stage_that_tries_no_deployment_leaves_the_verdict(database, status):
    trials = [COLLIDES, DEPLOYS] if status == "deploys" else [COLLIDES]
    store(database, batch(status, trials))
    before = told(database)
    store(database, batch())
    assert told(database) == before
    assert len(select(database, view="deployments").rows) == len(trials)


def test_a_proof_of_a_lock_takes_the_place_of_a_verdict(database):
    store(database, batch("collides", [COLLIDES]))
    store(database, batch(locked=True))
    assert told(database)[:2] == ["locked", 0]


def test_newer_deployments_take_the_place_of_older_ones(database):
    store(database, batch("deploys", [COLLIDES, DEPLOYS]))
    store(database, batch("undecided", [replace(COLLIDES, status="undecided", first_contact=None)]))
    assert told(database) == ["undecided", None, None, None]
    assert select(database, view="deployments", columns="scene,status").rows == (("default", "undecided"),)


def test_the_same_batch_twice_changes_nothing(database):
    store(database, batch("deploys", [COLLIDES, DEPLOYS]))
    before = select(database, view="deployments").rows, find_design(database, "hex:c")
    store(database, batch("deploys", [COLLIDES, DEPLOYS]))
    assert (select(database, view="deployments").rows, find_design(database, "hex:c")) == before


def test_a_verdict_comes_after_mobility(database):
    store(database, batch())
    assert told(database) == ["undecided", None, None, None]
    store(database, batch("deploys", [COLLIDES, DEPLOYS]))
    assert told(database) == ["deploys", 1, 1.5, 0.5]
