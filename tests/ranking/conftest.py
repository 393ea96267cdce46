"""A database whose designs have been deployed, as far as ranks look at it."""

import shutil
from pathlib import Path

import pytest

from hcsearch.enumeration import PolygonSearch
from hcsearch.grid import GRIDS
from hcsearch.pipeline import Plan, run_into
from hcsearch.store import open_database, open_readonly, schema, select


@pytest.fixture(scope="session")
def deployed_hexagons(tmp_path_factory):
    """All designs of ten hexagons; those not locked deploy, collide or stay undecided in turn."""
    path = tmp_path_factory.mktemp("ranks") / "d.sqlite"
    design, folding = schema.design, schema.folding
    with open_database(str(path), create=True) as database:
        run_into(Plan(PolygonSearch(GRIDS["hex"], 10), "mobility"), database)
        ids = [row[0] for row in select(database, "status=undecided", columns="id", sort="id").rows]
        with database.writing() as connection:
            for k, number in enumerate(ids):
                # without a clearance, with one, and cut through each other
                status, gap = [("undecided", None), ("deploys", 0.2 + 0.1 * (k % 4)), ("collides", -0.4)][k % 3]
                connection.execute(design.update().where(design.c.id == number).values(status=status))
                found = {"status": status, "min_clearance": gap, "deploy_time": gap and 0.3 + 0.01 * (k % 5)}
                connection.execute(folding.update().where(folding.c.design_id == number).values(found))
    return path


@pytest.fixture
def path(deployed_hexagons, tmp_path):
    """A copy of that database."""
    return Path(shutil.copy(deployed_hexagons, tmp_path))


@pytest.fixture
def reader(path):
    with open_readonly(str(path)) as opened:
        yield opened
