"""Build the atlas: the data set of all designs with up to n panels."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from hcsearch.api.chosen_searches import chosen_search, chosen_workers
from hcsearch.api.enumerating import plan_enumeration, run_enumeration
from hcsearch.api.kinds import check_kinds
from hcsearch.designs.grid import GRIDS
from hcsearch.search.pipeline import Plan, WorkerPool
from hcsearch.search.pipeline.run_progress import AnnounceSentence, RunProgress, part_of_progress, parts_of_work
from hcsearch.store import check_parquet
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
    progress: RunProgress | None = None,
    announce: AnnounceSentence | None = None,
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
    show = progress or _hidden
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
                shares_alone = bool(plan.scene_stages)
                part = part_of_progress(show, name, *bounds, shares_alone=shares_alone)
                run_enumeration(plan, source, part, announce)
            certificates = part_of_progress(show, "certificates", end, 1.0, shares_alone=False)
            write_atlas(folder, source, request, workers, certificates)
    return atlas_in(folder)


def _plan(request: AtlasRequest, grid: str, n: int, workers: WorkerPool) -> Plan:
    return plan_enumeration(chosen_search(grid, n, None, "all"), workers, until=request.until)


def _hidden(done: int, total: int, note: str, unit: str = "batch") -> None:
    """Show no progress."""
