import asyncio
import json
import sqlite3
from pathlib import Path

import pytest

from hcsearch.designs.grid import GRIDS
from hcsearch.search.enumeration import PolygonSearch
from hcsearch.search.pipeline import Plan, run_into
from hcsearch.store import open_database
from hcsearch.store.columns import DESIGN_QUANTITIES, VIEWS
from hcsearch.store.generated import datasette_json
from tests.judging import judge

FILE = Path(__file__).parents[2] / "db" / "datasette.json"


def test_the_metadata_in_the_repository_are_those_of_the_columns():
    assert FILE.read_text(encoding="utf-8") == datasette_json()


@pytest.mark.extra
def test_datasette_opens_a_database_unaided(tmp_path):
    from datasette.app import Datasette

    # it has SQLite report what callbacks raise, in the whole process, and an interrupt is raised in ours
    sqlite3.enable_callback_tracebacks(False)

    path = tmp_path / "hcsearch.sqlite"
    with open_database(str(path), create=True) as database:
        run_into(Plan(PolygonSearch(GRIDS["hex"], 8), "twist"), database)
        judge(database, [("hex:02234400", 1, "movable", None, None)])

    async def asked(served, *addresses):
        await served.invoke_startup()
        answers = [await served.client.get(address) for address in addresses]
        assert {answer.status_code for answer in answers} == {200}
        return answers

    bare, units = Datasette(files=[str(path)]), Datasette(files=[str(path)], metadata=json.loads(datasette_json()))
    whole, *views = asyncio.run(
        asked(bare, "/hcsearch.json", *(f"/hcsearch/{view}.json?_shape=array" for view in VIEWS))
    )
    assert {view["name"] for view in whole.json()["views"]} == set(VIEWS)
    found = {table["name"]: table["foreign_keys"]["outgoing"] for table in whole.json()["tables"]}
    assert found["folding"] == [{"other_table": "design", "column": "design_id", "other_column": "id"}]
    assert {key["other_table"] for table in ("outcome", "verdict", "motion") for key in found[table]} == {"scene"}
    assert len(views[0].json()) == 16
    assert set(views[0].json()[0]) == {quantity.name for quantity in DESIGN_QUANTITIES}
    page, listed = asyncio.run(asked(units, "/hcsearch/designs", "/hcsearch/designs.json"))
    assert "degrees of freedom at a generic state" in page.text
    assert listed.json()["units"]["needed_margin"] == "mm"
    assert "10.0&nbsp;µm" in page.text
