"""The page of an atlas: a report on all its designs, which searches them without a server."""

from __future__ import annotations

from dataclasses import replace

from hcsearch.store import Database
from hcsearch.web.atlas.atlas_card import DATABASE_FILE, LICENCE
from hcsearch.web.atlas.atlas_request import AtlasRequest
from hcsearch.web.report.data import fetch_report_data
from hcsearch.web.report.page_files import render_report

MAX_ATLAS_PAGE_DESIGNS = 200_000
"""Greatest number of designs on the page, which a browser still loads in seconds; the page names the total."""


def atlas_page(database: Database, request: AtlasRequest) -> str:
    """Return the page with the designs of an atlas, best first."""
    data = fetch_report_data(database, "", MAX_ATLAS_PAGE_DESIGNS)
    meta = [(name, value) for name, value in data.meta if name in {"grid", "n", "scene", "hcsearch"}]
    return render_report(
        replace(
            data,
            title=request.title,
            meta=[*meta, ("licence", LICENCE), ("files", "README.md")],
            database_option=f" --db {DATABASE_FILE}",
        )
    )
