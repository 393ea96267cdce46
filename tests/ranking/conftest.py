"""A database whose designs have been deployed, as far as ranks look at it."""

import shutil
from pathlib import Path

import pytest

from hcsearch.designs.grid import GRIDS
from hcsearch.search.enumeration import PolygonSearch
from hcsearch.search.pipeline import Plan, run_into
from hcsearch.store import open_database, open_readonly, select
from tests.judging import judge


@pytest.fixture(scope="session")
def deployed_hexagons(tmp_path_factory):
    """All designs of ten hexagons; those not locked deploy, are movable or stay undecided in turn.

    In the scene `solar`, all of these deploy.
    """
    path = tmp_path_factory.mktemp("ranks") / "d.sqlite"
    with open_database(str(path), create=True) as database:
        run_into(Plan(PolygonSearch(GRIDS["hex"], 10), "mobility"), database)
        known = select(database, "untwisted", columns="design_id,crease,status", view="foldings").rows
        places = {number: crease for number, crease, status in known if status is None}
        judged, brighter = [], []
        open_ones = [row for row in select(database, "untwisted", columns="id,circuit,status").rows if row[2] is None]
        for k, (number, name, _) in enumerate(open_ones):
            if k % 7 == 6:
                judged.append((name, places[number], "locked", None, None))
                brighter.append(judged[-1])
                continue
            status, gap = [("undecided", None), ("deploys", 0.2 + 0.1 * (k % 4)), ("movable", None)][k % 3]
            judged.append((name, places[number], status, gap, gap and 0.3 + 0.01 * (k % 5)))
            brighter.append((name, places[number], "deploys", 1.0 + k / 8, 0.5))
        judge(database, judged)
        judge(database, brighter, "solar")
    return path


@pytest.fixture
def path(deployed_hexagons, tmp_path):
    """A copy of that database."""
    return Path(shutil.copy(deployed_hexagons, tmp_path))


@pytest.fixture
def reader(path):
    with open_readonly(str(path)) as opened:
        yield opened
