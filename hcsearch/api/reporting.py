"""Write HTML pages on the designs of a database."""

from __future__ import annotations

from pathlib import Path

from hcsearch.api.kinds import check_kinds
from hcsearch.subjects.names import Place, reading_database
from hcsearch.subjects.stored_scenes import scene_asked_for
from hcsearch.system.outputs import check_output
from hcsearch.web.report.page_files import MAX_PAGE_DESIGNS, write_report


def report(
    path: str | Path,
    query: str = "",
    *,
    db: Place | None = None,
    scene: str | None = None,
    panel: str | None = None,
    limit: int | None = MAX_PAGE_DESIGNS,
) -> Path:
    """Write one HTML page of the designs that a query selects, as `hcsearch report` does; return its path.

    Parameters
    ----------
    path
        The file to write.
    query, db, scene, panel
        As in `read`.
    limit
        The greatest number of designs on the page.

    Returns
    -------
    Path
        The page.
    """
    check_kinds(report, locals())
    check_output(str(path))
    with reading_database(db) as database:
        scene_name = scene_asked_for(database, scene, panel, query=query)
        return write_report(database, query, Path(path), limit=limit, scene=scene_name)
