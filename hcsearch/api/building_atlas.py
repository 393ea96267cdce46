"""Build the atlas: the data set of all designs with up to n panels."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from hcsearch.api.chosen_searches import chosen_search, chosen_workers
from hcsearch.api.enumerating import plan_enumeration, run_enumeration
from hcsearch.api.kinds import check_kinds
from hcsearch.designs.grid import GRIDS
from hcsearch.search.pipeline import Plan, WorkerPool
from hcsearch.store import check_parquet
from hcsearch.system.work_steps import (
    Announcement,
    Progress,
    no_announcement,
    no_progress,
    part_of_progress,
    parts_of_work,
)
from hcsearch.web.atlas.atlas_files import Atlas, atlas_in, write_atlas
from hcsearch.web.atlas.atlas_folder import open_atlas_folder
from hcsearch.web.atlas.atlas_request import AtlasRequest, atlas_request

_SEARCH_SHARE = 0.3
"""Share of the time of the searches where certificates follow, which take most of it."""


def build_atlas(
    path: str | Path,
    *,
    n: int = 12,
    grids: Sequence[str] | None = None,
    until: str | None = None,
    jobs: int | None = None,
    progress: Progress | None = None,
    announce: Announcement | None = None,
) -> Atlas:
    """Build the data set of all designs with up to n panels in a folder, as `hcsearch atlas` does.

    The same versions of the program and its libraries write the same bytes. An interrupted call goes on when it is
    repeated; a finished atlas is checked against its checksums.

    Parameters
    ----------
    path
        The folder, which is empty, missing, or holds this atlas.
    n
        The greatest number of panels.
    grids
        Names of grids; all where None.
    until, jobs, progress, announce
        As in `enumerate_into`.

    Returns
    -------
    Atlas
        The finished atlas.

    Raises
    ------
    OutputError
        For a folder with other contents.
    QueryError
        Without pyarrow.
    """
    check_kinds(build_atlas, locals())
    check_parquet()
    request, workers = atlas_request(list(GRIDS) if grids is None else grids, n, until), chosen_workers(jobs, None)
    for grid in request.grids:  # first, so that an n that is too large is refused before its sizes are listed
        _plan(request, grid, request.n, workers)
    plans = [_plan(request, grid, size, workers) for grid, size in request.sizes]
    show = progress or no_progress
    with open_atlas_folder(path, request) as folder:
        if not folder.is_complete:
            source = folder.work / "designs.sqlite"
            end = _SEARCH_SHARE if request.has_run("motion") else 1.0
            for plan, bounds in zip(
                plans,
                parts_of_work(((plan.search.expected or 1.0) * plan.search.n for plan in plans), end),
                strict=True,
            ):
                name = f"{plan.search.grid.name} n = {plan.search.n}"
                part = part_of_progress(show, *bounds, name=name, unit="" if plan.scene_stages else "batch")
                run_enumeration(plan, source, part, announce or no_announcement)
            certificates = part_of_progress(show, end, 1.0, name="certificates", unit="folding")
            write_atlas(folder, source, request, workers, certificates)
    return atlas_in(folder)


def _plan(request: AtlasRequest, grid: str, n: int, workers: WorkerPool) -> Plan:
    return plan_enumeration(chosen_search(grid, n, None, "all"), workers, until=request.until)
