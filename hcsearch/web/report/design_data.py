"""The data of a design's page: stored results, recomputed motions, and the required space."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from importlib.metadata import version
from typing import cast

from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import STATUSES, millimetres, play_sentence
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding
from hcsearch.designs.panel_sizes import PanelSize, panel_text
from hcsearch.designs.twisting import twist
from hcsearch.export.bill_items import BillOfMaterials, bill_of_case
from hcsearch.scenes import DEFAULT_SCENE_NAME, Scene, panel_of
from hcsearch.springs.deployment.agreement import confirm_deployment
from hcsearch.springs.deployment.deployment_facts import deploy_linkage
from hcsearch.springs.deployment.simulated_deployment import Deployment, simulate_deployment
from hcsearch.springs.flight.flight_figures import modes_of
from hcsearch.springs.flight.flight_sheet import FlightSheet
from hcsearch.springs.flight.review import review
from hcsearch.springs.flight.rules import read_rules
from hcsearch.springs.flight.stowage import Stowage, stowage_of
from hcsearch.store import Database, best_creases, select
from hcsearch.subjects.case import Case
from hcsearch.subjects.mechanisms import Freedoms, freedoms_of, lock_sentences
from hcsearch.subjects.names import deployment_scene_name, way_option_text
from hcsearch.subjects.replay import Replay
from hcsearch.subjects.replay_sources import replay_case, replay_of_deployment, replay_of_mode, stored_replays
from hcsearch.subjects.resolve import resolve
from hcsearch.subjects.stored_scenes import stored_scene
from hcsearch.subjects.travels import travel_of_case
from hcsearch.web.player import Payload, payload_of
from hcsearch.web.report.accuracy_section import ShownAccuracy, accuracy_of_deployment
from hcsearch.web.report.data import FoldingKey, ViewRow, deployments_of, foldings_of, motions_of
from hcsearch.web.report.lead_sentences import design_sentence
from hcsearch.web.report.motion_plots import marks_of_motion, plots_of
from hcsearch.web.report.plots import DrawnPlot
from hcsearch.web.report.reasons import best_deployment, play_of_row, status_reason, verdict_of_row
from hcsearch.web.report.templating import database_option_text, scene_option_text


@dataclass(frozen=True)
class ShownMotion:
    """A motion that the page plays and plots; `command` reproduces it.

    shows : the status of the folding that the motion proves: `movable`, `deploys`, `driven` by the drives of its case,
    or empty for none. flat_time : s until it is flat by springs or drives, in the digits on which tolerances agree;
    None without agreement. deployment : that it shows, of a motion by springs.
    """

    title: str
    source: str
    command: str
    payload: Payload
    plots: Sequence[DrawnPlot]
    shows: str = ""
    flat_time: float | None = None
    deployment: Deployment | None = None


@dataclass(frozen=True)
class ShownFolding:
    """A folding with all results on it.

    row : of the view `foldings`, empty if not stored. status : a word, or `twisted`.
    reason : the reason for the status. deployments : rows of `deployments`. locks : sentences on each end state,
    followed by more precise ones. sheet : the flight sheet of the best folding, if it moves. accuracy : of its
    deployment. bill : its parts.
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
    accuracy: ShownAccuracy | None = None
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


@dataclass(frozen=True, eq=False)
class ComputedFolding:
    """A folding whose motions are planned and simulated for the page.

    case : the folding in its scene. subject : how commands name this case, with its options.
    """

    case: Case
    subject: str

    @property
    def folding(self) -> Folding:
        """The folding, of a circuit in canonical order."""
        assert self.case.folding is not None
        return self.case.folding


def fetch_design_data(
    circuit: Circuit,
    foldings: Sequence[Folding],
    db: str,
    database: Database,
    number: int,
    scene: str = DEFAULT_SCENE_NAME,
) -> DesignData:
    """Return the data of a stored design, with its circuit in canonical order, and of some of its foldings in a scene.

    database : from `open_readonly`. number : id of the design in it. db : name of the database, for lookups by name.
    """
    values, stored = stored_scene(database, scene), _known(database, number, circuit, scene)
    ordered = sorted(foldings, key=lambda folding: (folding.crease != stored.best, folding.crease))
    shown = [_folding(folding, stored, values, db) for folding in ordered]
    if stored.best is None:
        shown.sort(key=lambda folding: _order(folding.status))
    if shown and shown[0].motions:
        notation = shown[0].folding.notation
        command = f"hcsearch sheet {notation}{scene_option_text(scene, stored.database_option)}"
        with suppress(HcsearchError):
            shown[0] = _with_sheet(shown[0], resolve(notation, db, scene=scene, path=True), command)
        shown[0] = _with_accuracy(shown[0])
    data = _design_data(f"Design {number}", circuit, shown, values, scene)
    return replace(data, row=stored.design, best=stored.best)


def fetch_computed_data(circuit: Circuit, computed: Sequence[ComputedFolding], scene: Scene) -> DesignData:
    """Return the data of a design, with its circuit in canonical order, whose foldings are planned and simulated.

    scene : of all cases.
    """
    shown = sorted(map(_computed_folding, computed), key=lambda folding: _order(folding.status))
    if shown and shown[0].motions:
        best = next(one for one in computed if one.folding.crease == shown[0].folding.crease)
        with suppress(HcsearchError):
            shown[0] = _with_sheet(shown[0], best.case, f"hcsearch sheet {best.subject}")
        shown[0] = _with_accuracy(shown[0])
    return _design_data(f"Design {circuit.notation}", circuit, shown, scene, scene.name)


def _design_data(
    title: str, circuit: Circuit, shown: Sequence[ShownFolding], scene: Scene, scene_name: str
) -> DesignData:
    """Return the data of a design without its stored results; shown : its foldings, the best one first."""
    panel, array = panel_of(scene, circuit.grid.name), circuit.array.canonical().notation
    return DesignData(
        title=title,
        notation=circuit.notation,
        array=array,
        row={},
        meta=[
            ("circuit", circuit.notation),
            ("array", array),
            ("panels", f"{circuit.n} of {panel_text(panel)} mm"),
            ("scene", scene_name),
            ("density", f"{scene.density_of(panel[2]):.4g} kg/m³"),
            ("hcsearch", version("hcsearch")),
            ("made", datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")),
        ],
        foldings=shown,
        best=None,
        sentence=_sentence(circuit, panel, shown[0] if shown else None),
        size=(1e3 * panel[0], 1e3 * panel[1]),
    )


def _sentence(circuit: Circuit, panel: PanelSize, best: ShownFolding | None) -> str:
    if best is None:
        return design_sentence(circuit, panel, "no_folding", None)
    seconds = best.motions[0].flat_time if best.motions else None
    return design_sentence(circuit, panel, best.status, best.room, seconds)


@dataclass(frozen=True)
class _Known:
    """The stored results on a design in a scene; database_option : the command option that names the database."""

    number: int
    scene: str
    database_option: str
    design: ViewRow
    rows: Mapping[int, ViewRow]
    best: int | None
    motions: Mapping[FoldingKey, str]
    deployments: Mapping[FoldingKey, Sequence[ViewRow]]
    paths: Mapping[int, Replay]


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
    """Return a folding with the results that a database holds."""
    row, turns = stored.rows.get(folding.crease, {}), twist(folding)
    key = (stored.number, folding.crease)
    deployments = stored.deployments.get(key, ())
    motions = [] if turns else _stored_motions(folding, stored, row, deployments, db)
    reason = status_reason({**row, "twist": turns}, stored.motions.get(key), deployments)
    shown = _shown_folding(
        folding, panel_of(scene, folding.circuit.grid.name), scene, motions, str(row.get("status") or "not_judged")
    )
    bill = None
    with suppress(HcsearchError):  # its scene does not suit a bill
        bill = bill_of_case(resolve(folding.notation, db, scene=stored.scene))
    return replace(shown, row=row, reason=reason or shown.reason, deployments=deployments, bill=bill)


def _computed_folding(computed: ComputedFolding) -> ShownFolding:
    """Return a folding with the results that are computed for the page."""
    folding, case = computed.folding, computed.case
    turns = twist(folding)
    motions = [] if turns else _computed_motions(computed)
    proved = {motion.shows for motion in motions}
    status = next((status for status in ("deploys", "driven", "movable") if status in proved), "not_judged")
    shown = _shown_folding(folding, case.panel, case.scene, motions, status)
    bill = None
    with suppress(HcsearchError):  # its scene does not suit a bill
        bill = bill_of_case(case)
    reason = status_reason({"twist": turns}, None, ())
    return replace(shown, reason=reason or shown.reason, bill=bill)


def _shown_folding(
    folding: Folding, panel: PanelSize, scene: Scene, motions: Sequence[ShownMotion], status: str
) -> ShownFolding:
    """Return a folding with its mechanism, room and motions; status : of a folding without twist."""
    turns = twist(folding)
    return ShownFolding(
        folding=folding,
        row={},
        twist=turns,
        status="twisted" if turns else status,
        reason="; ".join(motion.source for motion in motions) or NOT_JUDGED_REASON,
        room=stowage_of(folding.linkage(panel), scene.density_of(panel[2])),
        freedoms=() if turns else freedoms_of(folding, panel),
        locks=() if turns else lock_sentences(folding, panel),
        motions=motions,
    )


def _order(status: str) -> int:
    """Return the place of a status in the order from best to worst."""
    return STATUSES.index(status) if status in STATUSES else len(STATUSES)


def _with_sheet(shown: ShownFolding, case: Case, command: str) -> ShownFolding:
    """Return a folding with its flight sheet and its first mode; HcsearchError where it has no proved motion."""
    notation, moved = shown.folding.notation, travel_of_case(case)
    sheet, modes = review(moved.travel, read_rules("ecss"), title=notation, source=moved.source), modes_of(moved.travel)
    motions = list(shown.motions)
    if modes.deployed_hz is not None:
        payload = payload_of(replay_of_mode(moved.travel.linkage, modes, 0, notation))
        motions.append(ShownMotion("First mode of the flat array", payload["source"], command, payload, ()))
    return replace(shown, sheet=sheet, motions=motions)


def _with_accuracy(shown: ShownFolding) -> ShownFolding:
    """Return a folding with the accuracy of its motion by springs, if it has one."""
    for motion in shown.motions:
        if motion.deployment is not None:
            command = motion.command.replace("hcsearch deploy", "hcsearch accuracy", 1)
            return replace(shown, accuracy=accuracy_of_deployment(motion.deployment, command))
    return shown


def _computed_motions(computed: ComputedFolding) -> list[ShownMotion]:
    """Return the planned path of a folding and its motion by springs; if springs open it, theirs comes first."""
    motions, case, subject = [], computed.case, computed.subject
    with suppress(HcsearchError):  # there is no path, or the case has drives
        motions.append(_path_motion(replay_case(case, "path")[0], f"hcsearch drive {subject}"))
    try:
        deployed = deploy_linkage(
            case.title, case.linkage, case.setup, case.formulation or "constrained", drives=case.drives
        )
    except HcsearchError:
        return motions
    replay = replay_of_deployment(deployed.deployment, case.title, design=True, reason=deployed.reason)
    opens = deployed.verdict == "deploys"
    command, play = f"hcsearch deploy {subject}", play_sentence(millimetres(deployed.needed_margin))
    motion = _springs_motion(replay, deployed.deployment, command, play, deployed.flat_time)
    motion = replace(motion, shows="" if not opens else "deploys" if case.drive is None else "driven")
    motions.insert(0 if opens else len(motions), motion)
    return motions


def _stored_motions(
    folding: Folding, stored: _Known, row: ViewRow, deployments: Sequence[ViewRow], db: str
) -> list[ShownMotion]:
    """Return the stored path of a folding and the motion of its best deployment.

    The motion that gave the folding its status comes first.
    """
    motions, best, verdict = [], best_deployment(deployments), verdict_of_row(row, deployments)
    path = stored.paths.get(folding.crease)
    if path is not None:
        deployed_pairs = None if verdict is None or verdict.deployed_variant is None else verdict.deployed_variant.pairs
        option = (
            way_option_text(verdict.path_flat_pairs)
            if verdict is not None and deployed_pairs not in (None, verdict.path_flat_pairs)
            else ""
        )
        command = f"hcsearch drive {folding.notation}{scene_option_text(stored.scene, stored.database_option)}{option}"
        motions.append(_path_motion(path, command))
    if best is None and stored.rows:
        return motions
    name = DEFAULT_SCENE_NAME if best is None else deployment_scene_name(best, verdict)
    try:
        case = resolve(folding.notation, db, scene=name)
        deployment = simulate_deployment(case.linkage, case.setup, case.formulation or "constrained")
    except HcsearchError:
        return motions
    reason = flat_time = play = None
    opens = verdict is not None and verdict.status == "deploys"
    if best is not None:
        reason, flat_time, play = str(best["reason"]), cast("float | None", best["deploy_time"]), play_of_row(best)
    elif (agreement := confirm_deployment(deployment)) is not None:
        reason, flat_time, opens = agreement.reason, agreement.flat_time, agreement.verdict == "deploys"
        play = play_sentence(millimetres(agreement.needed_margin))
    replay = replay_of_deployment(deployment, folding.notation, design=True, reason=reason)
    command = f"hcsearch deploy {folding.notation}{scene_option_text(name, stored.database_option)}"
    motion = _springs_motion(replay, deployment, command, play, flat_time)
    motions.insert(0 if opens else len(motions), motion)
    return motions


def _path_motion(path: Replay, command: str) -> ShownMotion:
    """Return a path for the page, with the play that it leaves if it is proved."""
    payload, play = payload_of(path), play_sentence(1e3 * path.margin) if path.certified else None
    source = "; ".join(filter(None, (path.source, play)))
    shows = "movable" if path.certified else ""
    return ShownMotion("Planned path", source, command, payload, plots_of(path, payload), shows)


def _springs_motion(
    replay: Replay, deployment: Deployment, command: str, play: str | None, flat_time: float | None
) -> ShownMotion:
    """Return a deployment for the page; play : the sentence on the play that it needs. flat_time : as shown, s."""
    collisions = (mark.text for mark in marks_of_motion(replay) if mark.is_collision)
    payload, source = payload_of(replay), "; ".join(filter(None, (replay.source, *collisions, play)))
    title = spring_motion_title(deployment)
    plots = plots_of(replay, payload, deployment, flat_time)
    springs = deployment if deployment.driven is None else None
    return ShownMotion(title, source, command, payload, plots, flat_time=flat_time, deployment=springs)


def spring_motion_title(deployment: Deployment) -> str:
    """Return the title of a deployment on a page."""
    return "Motion by springs" if deployment.driven is None else "Motion by drives"
