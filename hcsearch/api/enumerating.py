"""Search all arrays of a size, or one array, through the stages and into a database."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from hcsearch.api.chosen_searches import chosen_search, chosen_workers
from hcsearch.api.kinds import check_kinds
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import Keep
from hcsearch.designs.grid import Array, Grid
from hcsearch.scenes import Scene
from hcsearch.scenes.scene import with_size
from hcsearch.search.enumeration import Search
from hcsearch.search.pipeline import (
    Funnel,
    Plan,
    RunSummary,
    WorkerPool,
    check_disk_room,
    estimate_run,
    finished_shards,
    run_dry,
    run_into,
)
from hcsearch.search.stages.order import STAGES, check_keep
from hcsearch.subjects.names import Place, database_location, writing_database
from hcsearch.subjects.stored_scenes import read_scene, scene_database
from hcsearch.system.work_steps import Announcement, Progress, no_announcement, no_progress


@dataclass(frozen=True)
class Enumeration:
    """A finished run, as commands report it.

    plan : what was to be done. summary : what was done. location : of the database; None of a dry run.
    """

    plan: Plan
    summary: RunSummary
    location: str | None


def enumerate_into(
    db: Place | None = None,
    *,
    grid: str | Grid | None = None,
    n: int | None = None,
    array: str | Array | None = None,
    until: str | None = None,
    keep: Keep = "all",
    scene: Scene | str | None = None,
    panel: str | None = None,
    budget: int | None = None,
    jobs: int | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
    announce: Announcement | None = None,
) -> Funnel:
    """Search all arrays of n cells, or one array, and store the designs in a database, as `hcsearch enumerate` does.

    Finished work is not repeated: an interrupted search continues.

    Parameters
    ----------
    db
        A path, a URL or an open database; a file that does not exist is made.
    grid
        The name of the grid, such as `hex` (`GRIDS` has all), or a Grid.
    n
        The number of cells, to search all arrays.
    array
        The array to search, in place of n: an Array, or a text such as `3-4-3`.
    until
        The last stage: `circuits`, `foldings`, `twist`, `mobility`, `motion`, `deployment` or `flight`, the default.
    keep
        Which designs are stored, `all`, `two-stack` or `untwisted`.
    scene, panel
        As in `deploy`.
    budget
        Efforts of the search for the motion of each folding; undecided foldings in the database are included.
    jobs
        The number of processes.
    scheduler
        The address of a Dask cluster, in place of jobs.
    progress
        Called with the amount done, the whole amount, and a note.
    announce
        Called with sentences on long runs.

    Returns
    -------
    Funnel
        The number of designs that pass each stage.

    Examples
    --------
    >>> from hcsearch import enumerate_into
    >>> enumerate_into("designs.sqlite", grid="hex", n=8, until="twist")
    Funnel(fixed_circuits=123, arrays=14, circuits=16, two_stack=2, untwisted=1, movable=None, deploys=None)
    """
    check_kinds(enumerate_into, locals())
    search, workers = chosen_search(grid, n, array, keep), chosen_workers(jobs, scheduler)
    plan = plan_enumeration(search, workers, db, until=until, keep=keep, scene=scene, panel=panel, budget=budget)
    return run_enumeration(plan, db, progress or no_progress, announce or no_announcement).summary.funnel


def plan_enumeration(
    search: Search,
    workers: WorkerPool,
    db: Place | None = None,
    *,
    until: str | None = None,
    keep: str = "all",
    scene: Scene | str | None = None,
    panel: str | None = None,
    budget: int | None = None,
) -> Plan:
    """Plan a run and check it; db : where scenes are looked up, the others as in `enumerate_into`."""
    last = list(STAGES)[-1] if until is None else until
    if budget is not None and budget < 1:
        raise HcsearchError(f"a budget of {budget} is too small: give 1 or more efforts, or leave it out")
    check_keep(keep, last)
    with scene_database(scene, db) as (database, _):
        chosen = scene if isinstance(scene, Scene) else read_scene(scene, database, search.grid.name)
    workers.check_cluster()
    return Plan(search, last, keep, with_size(chosen, panel, search.grid.name), workers, budget)


def run_enumeration(
    plan: Plan,
    db: Place | None = None,
    progress: Progress = no_progress,
    announce: Announcement = no_announcement,
    listed: Callable[[Funnel], None] = lambda _: None,
    *,
    dry: bool = False,
) -> Enumeration:
    """Run a plan into a database, which is made where there is none.

    listed : called with the funnel of the stages that do not depend on the scene. dry : store nothing. The size of a
    long run is announced first; a run for whose results the disk has no room is refused.
    """
    location = database_location(db)
    expected = estimate_run(
        plan, stored=not dry, finished=() if dry or plan.is_small else finished_shards(plan, location)
    )
    if expected is not None:
        announce(expected.sentence(plan.crew))
        if not dry:
            check_disk_room(expected, location)
    if dry:
        return Enumeration(plan, run_dry(plan, progress, announce, listed), None)
    with writing_database(db, create=True) as database:
        return Enumeration(plan, run_into(plan, database, progress, announce, listed), database.location)
