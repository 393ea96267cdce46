"""The search that arguments name, and the workers that run it."""

from __future__ import annotations

from hcsearch.basics.errors import HcsearchError
from hcsearch.designs.grid import GRIDS, Array, Grid, grid_of, parse_array
from hcsearch.search.enumeration import ArraySearch, Search, search_all
from hcsearch.search.pipeline import WorkerPool
from hcsearch.system.machine import usable_cores

MAX_JOBS_PER_CORE = 4
"""Greatest number of processes per core: more gain nothing, and each takes some hundred megabytes."""


def chosen_search(grid: str | Grid | None, n: int | None, array: str | Array | None, keep: str) -> Search:
    """The search of all arrays of n cells, or of one array, for the designs that are kept."""
    if (n is None) == (array is None):
        raise HcsearchError("give either --n N (every array of N cells) or --array SPEC (one array)")
    if grid is None and not isinstance(array, Array):
        raise HcsearchError(f"name a grid: {', '.join(GRIDS)}")
    own = array.grid if isinstance(array, Array) and grid is None else grid_of(grid or "")
    if isinstance(array, Array) and array.grid != own:
        raise HcsearchError(f"the array is on the grid {array.grid.name}, not {own.name}: leave the grid out")
    if array is not None:
        return ArraySearch(parse_array(own, array) if isinstance(array, str) else array)
    assert n is not None
    return search_all(own, int(n), keep)  # NumPy's numbers cannot be stored as JSON


def chosen_workers(jobs: int | None, scheduler: str | None) -> WorkerPool:
    """The workers: processes of this machine, one per core unless `jobs` is given, or a Dask cluster."""
    if jobs is not None and scheduler is not None:
        raise HcsearchError("give either --jobs K (this machine) or --scheduler ADDRESS (a cluster)")
    if jobs is not None and jobs < 1:
        raise HcsearchError(f"--jobs {jobs} is too few: give 1 or more, or leave it out")
    cores = usable_cores()
    most = MAX_JOBS_PER_CORE * cores
    if jobs is not None and jobs > most:
        raise HcsearchError(
            f"--jobs {jobs} is more than four processes a core, of {cores} cores: give {most} at most, or leave it out"
        )
    return WorkerPool(jobs or cores, scheduler)
