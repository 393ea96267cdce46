"""The data of a design's page: stored results, recomputed motions, and the required space."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from importlib.metadata import version
from typing import cast

from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import STATUSES, millimetres, play_sentence
from hcsearch.cases.mechanisms import Freedoms, freedoms_of, lock_sentences
from hcsearch.cases.names import deployment_scene_name, way_option_text
from hcsearch.cases.replay import Replay
from hcsearch.cases.replay_sources import replay_case, replay_of_deployment, replay_of_mode, stored_replays
from hcsearch.cases.resolve import resolve
from hcsearch.cases.stored_scenes import stored_scene
from hcsearch.cases.travels import travel_of_case
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding
from hcsearch.designs.panel_sizes import PanelSize, panel_text
from hcsearch.designs.twisting import twist
from hcsearch.export.bill_items import BillOfMaterials, bill_of_case
from hcsearch.scenes import DEFAULT_SCENE_NAME, SCENES, Scene, panel_of
from hcsearch.springs.deployment.agreement import confirm_deployment
from hcsearch.springs.deployment.simulated_deployment import simulate_deployment
from hcsearch.springs.flight.flight_figures import modes_of
from hcsearch.springs.flight.flight_sheet import FlightSheet
from hcsearch.springs.flight.review import review
from hcsearch.springs.flight.rules import read_rules
from hcsearch.springs.flight.stowage import Stowage, stowage_of
from hcsearch.store import Database, best_creases, select
from hcsearch.web.player import Payload, payload_of
from hcsearch.web.report.data import FoldingKey, ViewRow, deployments_of, foldings_of, motions_of
from hcsearch.web.report.lead_sentences import design_sentence
from hcsearch.web.report.motion_plots import marks_of_motion, plots_of
from hcsearch.web.report.plots import DrawnPlot
from hcsearch.web.report.reasons import best_deployment, play_of_row, status_reason, verdict_of_row
from hcsearch.web.report.templating import database_option_text, scene_option_text


@dataclass(frozen=True)
class ShownMotion:
    """A motion that the page plays and plots; `command` reproduces it.

    shows : the status of the folding that the motion proves: `movable`, `deploys`, or empty for none.
    flat_time : s until it is flat by springs, in the digits on which tolerances agree; None without agreement.
    """

    title: str
    source: str
    command: str
    payload: Payload
    plots: Sequence[DrawnPlot]
    shows: str = ""
    flat_time: float | None = None


@dataclass(frozen=True)
class ShownFolding:
    """A folding with all results on it.

    row : of the view `foldings`, empty if not stored. status : a word, or `twisted`.
    reason : the reason for the status. deployments : rows of `deployments`. locks : sentences on each end state,
    followed by more precise ones. sheet : the flight sheet of the best folding, if it moves. bill : its parts.
    """

    folding: Folding
    row: ViewRow
    twist: int
    status: str
    reason: str
    room: Stowage
    deployments: Sequence[ViewRow] = ()
    freedoms: Sequence[Freedoms] = ()
    locks: Sequence[Sequence[str]] = ()
    motions: Sequence[ShownMotion] = ()
    sheet: FlightSheet | None = None
    bill: BillOfMaterials | None = None


@dataclass(frozen=True)
class DesignData:
    """The content of the page; row : of the view `designs`, empty if not stored. meta : what the results depend on.

    sentence : what the design is, and whether it opens. links : (words, address) of neighbouring pages.
    exports : addresses of files by crease of a folding, on a server.
    """

    title: str
    notation: str
    array: str
    row: ViewRow
    meta: Sequence[tuple[str, str]]
    foldings: Sequence[ShownFolding]
    best: int | None
    sentence: str
    size: tuple[float, float] | None = None
    links: Sequence[tuple[str, str]] = ()
    exports: Mapping[int, Sequence[tuple[str, str]]] = field(default_factory=dict)


NOT_JUDGED_REASON = "no stage has judged it in this scene: run `hcsearch enumerate` in the scene, without --until"


def fetch_design_data(
    circuit: Circuit,
    foldings: Sequence[Folding],
    db: str,
    database: Database | None,
    number: int,
    scene: str = DEFAULT_SCENE_NAME,
) -> DesignData:
    """Return the data of a design, with its circuit in canonical order, and of some of its foldings in a scene.

    database : from `open_readonly`; if None, motions are planned and simulated. number : id of the design in it.
    db : name of the database, for lookups by name.
    """
    values = SCENES[DEFAULT_SCENE_NAME] if database is None else stored_scene(database, scene)
    panel = panel_of(values, circuit.grid.name)
    stored = _Known() if database is None else _known(database, number, circuit, scene)
    ordered = sorted(foldings, key=lambda folding: (folding.crease != stored.best, folding.crease))
    shown = [_folding(folding, stored, values, db) for folding in ordered]
    if stored.best is None:
        shown.sort(key=lambda folding: _order(folding.status))
    best = shown[0] if shown else None
    if best is not None and best.motions:
        shown[0] = _with_sheet(best, stored, values, db)
    return DesignData(
        title=f"Design {number}" if database is not None else f"Design {circuit.notation}",
        notation=circuit.notation,
        array=circuit.array.canonical().notation,
        row=stored.design,
        meta=[
            ("circuit", circuit.notation),
            ("array", circuit.array.canonical().notation),
            ("panels", f"{circuit.n} of {panel_text(panel)} mm"),
            ("scene", scene),
            ("density", f"{values.density_of(panel[2]):.4g} kg/m³"),
            ("hcsearch", version("hcsearch")),
            ("made", datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")),
        ],
        foldings=shown,
        best=stored.best,
        sentence=_sentence(circuit, panel, best),
        size=(1e3 * panel[0], 1e3 * panel[1]),
    )


def _sentence(circuit: Circuit, panel: PanelSize, best: ShownFolding | None) -> str:
    if best is None:
        return design_sentence(circuit, panel, "no_folding", None)
    seconds = best.motions[0].flat_time if best.motions else None
    return design_sentence(circuit, panel, best.status, best.room, seconds)


@dataclass(frozen=True)
class _Known:
    """The stored results on a design in a scene; the defaults stand for a design that is not stored.

    database_option : the command option that names the database.
    """

    number: int = 0
    scene: str = DEFAULT_SCENE_NAME
    database_option: str = ""
    design: ViewRow = field(default_factory=dict)
    rows: Mapping[int, ViewRow] = field(default_factory=dict)
    best: int | None = None
    motions: Mapping[FoldingKey, str] = field(default_factory=dict)
    deployments: Mapping[FoldingKey, Sequence[ViewRow]] = field(default_factory=dict)
    paths: Mapping[int, Replay] | None = None

    def path(self, folding: Folding, db: str) -> Replay | None:
        """Return the path of a folding: the stored one, proved or not; a planned one if the design is not stored."""
        if self.paths is not None:
            return self.paths.get(folding.crease)
        try:
            return replay_case(resolve(folding.notation, db, path=True), "path")[0]
        except HcsearchError:
            return None


def _known(database: Database, number: int, circuit: Circuit, scene: str) -> _Known:
    (design,) = select(database, f"id={number}", scene=scene).records()
    return _Known(
        number,
        scene,
        database_option_text(database),
        design=design,
        rows={int(str(row["crease"])): row for row in foldings_of(database, [number], scene).get(number, [])},
        best=best_creases(database, [number], scene).get(number),
        motions=motions_of(database, [number], scene),
        deployments=deployments_of(database, [number], scene),
        paths={path.crease: replay for path, replay in stored_replays(database, {number: circuit}, scene)},
    )


def _folding(folding: Folding, stored: _Known, scene: Scene, db: str) -> ShownFolding:
    row, turns = stored.rows.get(folding.crease, {}), twist(folding)
    key = (stored.number, folding.crease)
    deployments, panel = stored.deployments.get(key, ()), panel_of(scene, folding.circuit.grid.name)
    motions = [] if turns else _motions(folding, stored, row, deployments, db)
    reason = status_reason({**row, "twist": turns}, stored.motions.get(key), deployments)
    status = "twisted" if turns else str(row.get("status") or "not_judged")
    return ShownFolding(
        folding=folding,
        row=row,
        twist=turns,
        status=_shown(motions) if stored.paths is None and not turns else status,
        reason=reason or "; ".join(motion.source for motion in motions) or NOT_JUDGED_REASON,
        room=stowage_of(folding.linkage(panel), scene.density_of(panel[2])),
        deployments=deployments,
        freedoms=() if turns else freedoms_of(folding, panel),
        locks=() if turns else lock_sentences(folding, panel),
        motions=motions,
        bill=_bill(folding, stored, scene, db),
    )


def _bill(folding: Folding, stored: _Known, scene: Scene, db: str) -> BillOfMaterials | None:
    """Return the parts of a folding in the scene of the page; None where its scene does not suit it."""
    try:
        return bill_of_case(resolve(folding.notation, db, scene=scene if stored.paths is None else stored.scene))
    except HcsearchError:
        return None


def _order(status: str) -> int:
    """Return the place of a status in the order from best to worst."""
    return STATUSES.index(status) if status in STATUSES else len(STATUSES)


def _with_sheet(shown: ShownFolding, stored: _Known, scene: Scene, db: str) -> ShownFolding:
    """Return a folding with its flight sheet and its first mode; unchanged where it has no proved motion."""
    notation = shown.folding.notation
    try:
        moved = travel_of_case(resolve(notation, db, scene=scene if stored.paths is None else stored.scene, path=True))
    except HcsearchError:
        return shown
    sheet, modes = review(moved.travel, read_rules("ecss"), title=notation, source=moved.source), modes_of(moved.travel)
    command = f"hcsearch sheet {notation}{scene_option_text(stored.scene, stored.database_option)}"
    motions = list(shown.motions)
    if modes.deployed_hz is not None:
        payload = payload_of(replay_of_mode(moved.travel.linkage, modes, 0, notation))
        motions.append(ShownMotion("First mode of the flat array", payload["source"], command, payload, ()))
    return replace(shown, sheet=sheet, motions=motions)


def _shown(motions: Sequence[ShownMotion]) -> str:
    """Return the status of a folding that is not stored: the best one that its motions prove."""
    shown = {motion.shows for motion in motions}
    return next((status for status in ("deploys", "movable") if status in shown), "not_judged")


def _motions(
    folding: Folding, stored: _Known, row: ViewRow, deployments: Sequence[ViewRow], db: str
) -> list[ShownMotion]:
    """Return the path of a folding and the motion of its best deployment, or in `default` if it is not stored.

    The motion that gave the folding its status comes first.
    """
    motions, best, verdict = [], best_deployment(deployments), verdict_of_row(row, deployments)
    path = stored.path(folding, db)
    if path is not None:
        payload = payload_of(path)
        deployed_pairs = None if verdict is None or verdict.deployed_variant is None else verdict.deployed_variant.pairs
        option = (
            way_option_text(verdict.path_flat_pairs)
            if verdict is not None and deployed_pairs not in (None, verdict.path_flat_pairs)
            else ""
        )
        command = f"hcsearch drive {folding.notation}{scene_option_text(stored.scene, stored.database_option)}{option}"
        shows = "movable" if path.certified else ""
        play = play_sentence(1e3 * path.margin) if path.certified else None
        source = "; ".join(filter(None, (path.source, play)))
        motions.append(ShownMotion("Planned path", source, command, payload, plots_of(path, payload), shows))
    if best is None and stored.rows:
        return motions
    name = DEFAULT_SCENE_NAME if best is None else deployment_scene_name(best, verdict)
    try:
        case = resolve(folding.notation, db, scene=name)
        deployment = simulate_deployment(case.linkage, case.setup, case.formulation or "constrained")
    except HcsearchError:
        return motions
    agreement = confirm_deployment(deployment) if best is None else None
    reason, flat_time = (None, None) if agreement is None else (agreement.reason, agreement.flat_time)
    if best is not None:
        reason, flat_time = str(best["reason"]), cast("float | None", best["deploy_time"])
    replay = replay_of_deployment(deployment, folding.notation, design=True, reason=reason)
    payload = payload_of(replay)
    command = f"hcsearch deploy {folding.notation}{scene_option_text(name, stored.database_option)}"
    needed = None if agreement is None else millimetres(agreement.needed_margin)
    play = play_sentence(needed) if best is None else play_of_row(best)
    source = "; ".join(
        filter(None, (replay.source, *(mark.text for mark in marks_of_motion(replay) if mark.is_collision), play))
    )
    shows = "deploys" if agreement is not None and agreement.verdict == "deploys" else ""
    plots = plots_of(replay, payload, deployment, flat_time)
    opens = shows == "deploys" or (verdict is not None and verdict.status == "deploys")
    motion = ShownMotion("Motion by springs", source, command, payload, plots, shows, flat_time)
    motions.insert(0 if opens else len(motions), motion)
    return motions
