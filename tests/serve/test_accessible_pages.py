"""Pages of the server, and the report on the same designs, are accessible and as wide as the window."""

import pytest

from hcsearch.store import open_readonly
from hcsearch.web.report.data import fetch_report_data
from hcsearch.web.report.page_files import render_report
from tests.axe import faults
from tests.player.browser import chromium

pytestmark = pytest.mark.extra

CARDS = "Boolean(document.querySelector('.gallery .card .thumb svg'))"
PLAYER = "Boolean(document.querySelector('.player > div'))"
TABLE = "Boolean(document.querySelector('table.rows tbody tr'))"
LARGE = "Boolean(document.querySelector('dialog[open] .thumb svg'))"


@pytest.fixture(scope="module")
def report(database_file, tmp_path_factory):
    with open_readonly(str(database_file)) as database:
        text = render_report(fetch_report_data(database, "", limit=None))
    path = tmp_path_factory.mktemp("accessible") / "report.html"
    path.write_text(text, encoding="utf-8")
    return path.as_uri()


def test_pages_are_accessible_and_fit_into_the_window(report, address, number, axe_script, tmp_path):
    pages = {
        report: CARDS,
        f"{report}#q=n_foldings>=3&as=table": TABLE,
        f"{report}#id={number}": LARGE,
        f"{address}/designs?q=n_foldings>=3": CARDS,
        f"{address}/designs?q=untwisted#id={number},{number - 1}": LARGE,
        f"{address}/designs/{number}": PLAYER,
        f"{address}/assemblies": "Boolean(document.querySelector('.gallery .thumb svg'))",
        f"{address}/assemblies/element-6r": PLAYER,
    }
    # without WebGL, motions are drawn on a plain canvas, which is quick
    with chromium(tmp_path / "profile", "--disable-3d-apis") as tab:
        assert not faults(tab, pages, axe_script)
