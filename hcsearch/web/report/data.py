"""The data of a report, read from the database: counts over all designs of a query, and the first designs."""

from __future__ import annotations

import json
import re
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime
from importlib.metadata import version
from typing import Any

from hcsearch.basics.errors import DatabaseError, NotationError
from hcsearch.basics.simulation_summaries import accuracy_sentences, undecided_sentences
from hcsearch.designs.circuit import Circuit
from hcsearch.scenes import DEFAULT_SCENE_NAME
from hcsearch.store import Database, Summary, best_creases, rows_of_designs, scene_names, select, summarize
from hcsearch.store.columns import DESIGN_QUANTITIES
from hcsearch.store.quantity import Quantity
from hcsearch.subjects.replay_sources import stored_replays
from hcsearch.system.work_steps import work_step
from hcsearch.web.player import Payload, payload_of
from hcsearch.web.report.accuracy_section import ShownAccuracy
from hcsearch.web.report.headline import StageCounts, headline_of, title_of
from hcsearch.web.report.templating import database_option_text

ViewRow = Mapping[str, object]
FoldingKey = tuple[int, int]
"""Id of a design and crease of its folding."""


@dataclass(frozen=True)
class FunnelStage:
    """A stage of the funnel with its count.

    count : None if the stage has not run.
    previous_count : the count by which this one is divided; None without one, as for a count in another unit.
    """

    label: str
    count: int | None
    previous_count: int | None = None


@dataclass(frozen=True)
class ReportData:
    """The content of the page, in reading order.

    sentence : how many designs open, in plain words.
    meta : subject, versions and dates of the search, as (name, value).
    funnel : counts over all selected designs, including those beyond the limit.
    census : (foldings, smallest twist, designs) over all selected designs; None where unknown.
    designs, foldings : rows of the SQL views of these names, foldings by the id of their design.
    best : by design id, crease of the folding behind the status; without one `drawn_crease` chooses.
    motions : the sentence on each planned motion. deployments : rows of `deployments`, best first.
    players : data of the 3D player for each folding with a path, or their address on a server.
    total : number of selected designs; `designs` contains the first of them.
    notes : sentences on designs that the counts omit.
    size : length and width of a panel on the square grids, None for the default ones.
    columns : the quantities of a design, with their meaning.
    database_option : the command option that names the database, empty for the default one.
    page_address : address of the page of a design, with `{id}` as placeholder; empty without pages.
    accuracy : of the deployment of the first design, if it is one that deploys.
    """

    title: str
    sentence: str = ""
    meta: Sequence[tuple[str, str]] = ()
    funnel: Sequence[FunnelStage] = ()
    census: Sequence[tuple[int | None, int | None, int]] = ()
    designs: Sequence[ViewRow] = ()
    foldings: Mapping[int, Sequence[ViewRow]] = field(default_factory=dict)
    best: Mapping[int, int] = field(default_factory=dict)
    motions: Mapping[FoldingKey, str] = field(default_factory=dict)
    deployments: Mapping[FoldingKey, Sequence[ViewRow]] = field(default_factory=dict)
    players: Mapping[FoldingKey, Mapping[str, Any] | str] = field(default_factory=dict)
    total: int = 0
    notes: Sequence[str] = ()
    size: tuple[float, float] | None = None
    columns: Sequence[Quantity] = DESIGN_QUANTITIES
    scene: str = DEFAULT_SCENE_NAME
    database_option: str = ""
    page_address: str = ""
    accuracy: ShownAccuracy | None = None


MAX_PLAYED_DESIGNS = 2000
"""Number of the first designs whose motions a page contains; a motion takes about 5 kB per folding."""
BEST_FIRST_ORDER = "-untwisted,-two_stack,-score,status,deploy_time"
"""Default order of the designs, best first, so that a limit cuts off the worst; ties by id."""


@work_step("reading the designs")
def fetch_report_data(
    database: Database, query: str, limit: int | None, sort: str = BEST_FIRST_ORDER, scene: str = DEFAULT_SCENE_NAME
) -> ReportData:
    """Read the data of a report on a query; the database must come from `open_readonly`.

    limit : designs on the page, None for all; counts always cover all selected designs. scene : the one whose verdicts
    are shown.
    """
    selected = select(database, query, sort=sort, limit=limit, scene=scene).records()
    counts = summarize(database, query, scene)
    passed = StageCounts.of(counts)
    runs = [run for run in select(database, view="runs").records() if (run["grid"], run["n"]) in counts.sizes]
    ids = [design["id"] for design in selected]
    return ReportData(
        title=title_of(counts.sizes, counts.array),
        sentence=headline_of(passed, query),
        meta=[
            ("grid", _listed(grid for grid, _ in counts.sizes)),
            ("n", _listed(sorted({n for _, n in counts.sizes}))),
            *([("array", counts.array)] if counts.array is not None else []),
            ("query", query.strip() or "all designs"),
            ("kept", _listed(run["keep"] for run in runs)),
            ("scene", scene),
            ("hcsearch", version("hcsearch")),
            ("made", datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")),
        ],
        funnel=_funnel(counts, passed),
        census=list(counts.census),
        designs=selected,
        foldings=foldings_of(database, ids, scene),
        best=best_creases(database, ids, scene),
        motions=motions_of(database, ids, scene),
        deployments=deployments_of(database, ids, scene),
        players=_players_of(database, selected, scene),
        total=counts.circuits,
        notes=[
            *([] if counts.planned or counts.tried else _elsewhere(database, scene)),
            *(
                f"{sentence[0].upper()}{sentence[1:]}."
                for sentence in (*accuracy_sentences(counts.accuracy), *undecided_sentences(counts.not_decided))
            ),
            *_notes(runs),
        ],
        size=_size(database, runs, scene),
        scene=scene,
        database_option=database_option_text(database),
    )


def _elsewhere(database: Database, scene: str) -> list[str]:
    """Return notes on scenes with results if this scene has none."""
    other_scenes = [name for name in scene_names(database) if name != scene]
    if not other_scenes:
        return []
    return [
        f"No motion was searched for in the scene {scene}: --scene names one with results ({', '.join(other_scenes)})."
    ]


def _funnel(counts: Summary, passed: StageCounts) -> list[FunnelStage]:
    """Return the stages of the funnel; passed : how many designs pass each."""
    total = passed.total
    return [
        FunnelStage("fixed circuits", counts.fixed),
        FunnelStage("array" if counts.arrays == 1 else "arrays", counts.arrays),
        FunnelStage("non-isomorphic circuits", total, total),
        FunnelStage("two-stack", passed.two_stack, total),
        FunnelStage("untwisted", passed.untwisted, total),
        FunnelStage("movable", passed.movable, total),
        FunnelStage("deployed by springs", passed.deploys, total),
    ]


def foldings_of(database: Database, ids: Sequence[int], scene: str) -> dict[int, list[ViewRow]]:
    """Return the rows of `foldings` in a scene, by the id of their design."""
    by_design: dict[int, list[ViewRow]] = defaultdict(list)
    for row in rows_of_designs(database, "foldings", ids, scene):
        by_design[row["design_id"]].append(row)
    return dict(by_design)


def motions_of(database: Database, ids: Sequence[int], scene: str) -> dict[FoldingKey, str]:
    """Return the sentence on each motion planned in a scene, by folding."""
    return {
        (row["design_id"], row["crease"]): row["reason"] for row in rows_of_designs(database, "motions", ids, scene)
    }


def deployments_of(database: Database, ids: Sequence[int], scene: str) -> dict[FoldingKey, list[ViewRow]]:
    """Return the deployments of each folding for a scene: first in the scene itself, then with other springs."""
    by_folding: dict[FoldingKey, list[ViewRow]] = defaultdict(list)
    for row in rows_of_designs(database, "deployments", ids, scene):
        by_folding[row["design_id"], row["crease"]].append(row)
    return {key: sorted(rows, key=lambda row: row["scene"] != scene) for key, rows in by_folding.items()}


def _listed(values: Iterable[object]) -> str:
    """Join the distinct values in order of occurrence."""
    return ", ".join(dict.fromkeys(map(str, values))) or "-"


def _notes(runs: Sequence[ViewRow]) -> list[str]:
    """Return notes on designs that the counts omit: those not kept, and unfinished searches."""
    notes = []
    complete = {(run["grid"], run["n"]) for run in runs if run["keep"] == "all" and run["target"] == ""}
    partial = [run for run in runs if run["keep"] != "all" and (run["grid"], run["n"]) not in complete]
    if partial:
        keeps = _listed(run["keep"] for run in partial)
        notes.append(
            f"Some runs kept only {keeps} designs: the circuits and arrays counted here are those that were kept."
        )
    latest = {(run["grid"], run["n"], run["target"], run["keep"]): run for run in runs}
    open_runs = [str(run["id"]) for run in latest.values() if run["finished"] is None]
    if open_runs:
        notes.append(f"The search is not finished (run {', '.join(open_runs)}): there may be more designs.")
    return notes


def panel_size_in(database: Database, scene: str) -> tuple[float, float] | None:
    """Return length and width of the panels in a scene; None unless all runs agree on them."""
    return _size(database, select(database, view="runs").records(), scene)


def _size(database: Database, runs: Sequence[ViewRow], scene: str) -> tuple[float, float] | None:
    runs_in_scene = [run for run in runs if _scene_of(database, run) == scene]
    # before any result depends on the scene, panels of all runs count
    runs = runs_in_scene or ([] if scene_names(database) else runs)
    sizes = {str(run["panel"]) for run in runs if run["panel"]}
    if len(sizes) != 1:
        return None
    match = re.match(r"(\d{1,9}(?:\.\d+)?)x(\d{1,9}(?:\.\d+)?)", sizes.pop(), re.ASCII)
    return (float(match[1]), float(match[2])) if match else None


def _scene_of(database: Database, run: ViewRow) -> str:
    """Return the scene of a run by its arguments."""
    try:
        arguments = json.loads(str(run["arguments"]))
    except (ValueError, RecursionError):
        arguments = None
    if not isinstance(arguments, dict):
        raise DatabaseError(
            f"database {database.location} is damaged, the arguments of run {run['id']} are no object in JSON: restore "
            "a copy, or mend it with `sqlite3 FILE`"
        )
    return str(arguments.get("scene", DEFAULT_SCENE_NAME))


def _players_of(database: Database, designs: Sequence[ViewRow], scene: str) -> dict[FoldingKey, Payload]:
    """Return the player data of the foldings with a stored path in a scene, proved or not."""
    circuits: dict[int, Circuit] = {}
    for design in designs:
        if len(circuits) == MAX_PLAYED_DESIGNS:
            break
        if design.get("untwisted"):
            with suppress(NotationError):  # an unreadable path has no picture either
                circuits[int(str(design["id"]))] = Circuit.from_notation(str(design["circuit"]))
    if not circuits:
        return {}
    return {
        (path.design_id, path.crease): payload_of(replay) for path, replay in stored_replays(database, circuits, scene)
    }
