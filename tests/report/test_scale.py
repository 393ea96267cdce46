"""A report of 13,224 designs, every circuit of fourteen hexagons, with verdicts that nobody ran."""

import random

import pytest

from hcsearch.basics.vocabulary import STATUSES
from hcsearch.designs.grid import GRIDS
from hcsearch.search.enumeration import PolygonSearch
from hcsearch.search.pipeline import Plan, run_into
from hcsearch.store import open_database, open_readonly
from hcsearch.web.report.data import fetch_report_data
from hcsearch.web.report.page_files import render_report
from tests.judging import judge
from tests.report.browser import driven

pytestmark = [pytest.mark.extra, pytest.mark.slow]

DRIVER = """
const byId = (name) => document.getElementById(name);
const drawn = () => document.querySelectorAll("*").length;
const drawnAfter = (id, value) => {
  byId(id).value = value;
  byId(id).dispatchEvent(new Event("input", {bubbles: true}));
  document.body.offsetHeight;
  return drawn();
};
probe.drawn = [drawn(), ...[...byId("column").options].map((option) => drawnAfter("column", option.value))];
const queries = ["dof<=6", "status=deploys", "symmetry>1 or n_foldings>=2", "0233", "not (untwisted or dof>7)", ""];
probe.drawn.push(...queries.map((query) => drawnAfter("find", query)));
probe.state = byId("state").textContent;
"""


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    path = tmp_path_factory.mktemp("scale") / "designs.sqlite"
    with open_database(str(path), create=True) as database:
        run_into(Plan(PolygonSearch(GRIDS["hex"], 14), "twist"), database)
    with open_readonly(str(path)) as database:
        plain = fetch_report_data(database, "untwisted", limit=None)
    choose, judged = random.Random(14), []
    for design in plain.designs:
        for row in plain.foldings[design["id"]]:
            if row["untwisted"]:
                status = choose.choice(STATUSES)
                deploys = status == "deploys"
                numbers = (choose.uniform(0, 90), choose.uniform(0.1, 2)) if deploys else (None, None)
                judged.append((design["circuit"], row["crease"], status, *numbers))
    with open_database(str(path), create=False) as database:
        judge(database, judged)
    with open_readonly(str(path)) as database:
        text = render_report(fetch_report_data(database, "", limit=None))
    page = path.with_name("page.html")
    page.write_text(text, encoding="utf-8")
    return page


def test_thirteen_thousand_designs_are_sorted_and_filtered_at_once(page):
    assert page.stat().st_size < 20e6
    # in real time, as a page that waits for no clock is dumped when its scripts are done
    probe = driven(page, DRIVER, clock="--timeout=60000")
    assert probe["errors"] == []
    assert probe["state"] == "13,224 of 13,224 designs"
    # only what is seen is drawn, so that sorting and filtering take no time that is noticed
    assert max(probe["drawn"]) < 2000
