"""A database of ten hexagons with verdicts that nobody computed, in two scenes, and an application on it."""

import threading

import pytest

from hcsearch.designs.grid import GRIDS
from hcsearch.search.enumeration import PolygonSearch
from hcsearch.search.pipeline import Plan, run_into
from hcsearch.store import open_database, open_readonly
from tests.judging import judge
from tests.serve.asking import Asking

MOVES = "hex:0234435011"
"""Has foldings at 1, which moves here, at 3 and at 4."""


@pytest.fixture(scope="session")
def database_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("serve") / "designs.sqlite"
    with open_database(str(path), create=True) as database:
        run_into(Plan(PolygonSearch(GRIDS["hex"], 10), "twist"), database)
        judge(database, [(MOVES, 1, "movable", None, None), (MOVES, 4, "locked", None, None)])
        judge(database, [(MOVES, 1, "locked", None, None)], "solar", key="p#0/2")
    return path


@pytest.fixture(scope="session")
def number(database_file):
    """The id of the design that moves."""
    with open_readonly(str(database_file)) as database:
        from hcsearch.store import find_design

        return find_design(database, MOVES)["id"]


@pytest.fixture(scope="module")
def asking(database_file):
    from hcsearch.web.serve.application import Application

    with open_readonly(str(database_file)) as database:
        application = Application(database, str(database_file))
        yield Asking(application)
        application.close()


@pytest.fixture(scope="module")
def address(asking):
    """Where the application answers browsers."""
    from waitress import create_server

    server = create_server(asking.application, host="127.0.0.1", port=0)
    threading.Thread(target=server.run, daemon=True).start()
    yield f"http://127.0.0.1:{server.effective_port}"
    server.close()
