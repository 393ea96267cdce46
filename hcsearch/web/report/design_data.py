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
from hcsearch.springs.deployment.simulated_deployment import Deployment
from hcsearch.springs.flight.flight_figures import modes_of
from hcsearch.springs.flight.flight_sheet import FlightSheet
from hcsearch.springs.flight.review import review
from hcsearch.springs.flight.rules import read_rules
from hcsearch.springs.flight.stowage import Stowage, stowage_of
from hcsearch.subjects.design_cases import CircuitCase, FoldingCase
from hcsearch.subjects.mechanisms import Freedoms, freedoms_of, lock_sentences
from hcsearch.subjects.names import way_option_text
from hcsearch.subjects.replay import Replay
from hcsearch.subjects.replay_sources import replay_of_deployment, replay_of_design, replay_of_mode
from hcsearch.subjects.stored_designs import StoredDesign
from hcsearch.web.player import Payload, payload_of
from hcsearch.web.report.accuracy_section import ShownAccuracy, accuracy_of_deployment
from hcsearch.web.report.data import ViewRow
from hcsearch.web.report.deciding_motions import best_tried_deployment
from hcsearch.web.report.headline import design_sentence
from hcsearch.web.report.motion_plots import marks_of_motion, plots_of
from hcsearch.web.report.plots import DrawnPlot
from hcsearch.web.report.reasons import best_deployment, play_of_row, status_reason, verdict_of_row
from hcsearch.web.report.templating import scene_option_text


@dataclass(frozen=True)
class ShownMotion:
    """A motion that the page plays and plots; `command` reproduces it.

    shows : the status of the folding that the motion proves: `movable`, `deploys`, `driven` by the drives of its case,
    or empty for none. flat_time : time (s) until it is flat by springs or drives, in the digits on which tolerances
    agree; None without agreement. deployment : the one that it shows, for a motion by springs.
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


def fetch_design_data(design: CircuitCase, option: str = "", named: str = "") -> DesignData:
    """Return the data of a design: its stored results, or the motions of its foldings, planned and simulated anew.

    option : the scene option of commands that name a folding; with stored results it follows from these. named : how
    commands name the only folding, with its options, if not by its notation.
    """
    stored, circuit = design.stored, design.circuit
    if stored is not None:
        option, named = scene_option_text(stored.scene, stored.location_option), ""
    best = None if stored is None else stored.best
    cases = {case.folding.crease: case for case in design.cases}
    subjects = {crease: named or f"{case.folding.notation}{option}" for crease, case in cases.items()}
    shown = [_shown_folding(case, subjects[crease], stored) for crease, case in cases.items()]
    shown.sort(key=lambda one: (best is not None and one.folding.crease != best, best is None and _order(one.status)))
    if shown and shown[0].motions:
        crease = shown[0].folding.crease
        with suppress(HcsearchError):
            shown[0] = _with_sheet(shown[0], cases[crease], f"hcsearch sheet {subjects[crease]}")
        shown[0] = _with_accuracy(shown[0])
    array, panel = circuit.array.canonical().notation, design.panel
    return DesignData(
        title=f"Design {circuit.notation if stored is None else stored.number}",
        notation=circuit.notation,
        array=array,
        row={} if stored is None else stored.row,
        meta=[
            ("circuit", circuit.notation),
            ("array", array),
            ("panels", f"{circuit.n} of {panel_text(panel)} mm"),
            ("scene", design.scene.name if stored is None else stored.scene),
            ("density", f"{design.scene.density_of(panel[2]):.4g} kg/m³"),
            ("hcsearch", version("hcsearch")),
            ("made", datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")),
        ],
        foldings=shown,
        best=best,
        sentence=_sentence(circuit, panel, shown[0] if shown else None),
        size=(1e3 * panel[0], 1e3 * panel[1]),
    )


def _sentence(circuit: Circuit, panel: PanelSize, best: ShownFolding | None) -> str:
    if best is None:
        return design_sentence(circuit, panel, "no_folding", None)
    seconds = best.motions[0].flat_time if best.motions else None
    return design_sentence(circuit, panel, best.status, best.room, seconds)


def _shown_folding(case: FoldingCase, subject: str, stored: StoredDesign | None) -> ShownFolding:
    """Return a folding with its results; subject : how commands name it, with its options."""
    folding, turns = case.folding, twist(case.folding)
    row: ViewRow = {} if stored is None else stored.folding_row(folding.crease)
    deployments = [] if stored is None else stored.deployments_of(folding.crease)
    motions = [] if turns else _motions(case, subject, stored)
    if stored is None:
        proved = {motion.shows for motion in motions}
        status = next((status for status in ("deploys", "driven", "movable") if status in proved), "not_judged")
    else:
        status = str(row.get("status") or "not_judged")
    planned = None if stored is None else stored.motion_sentence(folding.crease)
    bill = None
    with suppress(HcsearchError):  # its scene does not suit a bill
        bill = bill_of_case(case)
    return ShownFolding(
        folding=folding,
        row=row,
        twist=turns,
        status="twisted" if turns else status,
        reason=status_reason({**row, "twist": turns}, planned, deployments)
        or "; ".join(motion.source for motion in motions)
        or NOT_JUDGED_REASON,
        room=stowage_of(folding.linkage(case.panel), case.scene.density_of(case.panel[2])),
        deployments=deployments,
        freedoms=() if turns else freedoms_of(folding, case.panel),
        locks=() if turns else lock_sentences(folding, case.panel),
        motions=motions,
        bill=bill,
    )


def _order(status: str) -> int:
    """Return the place of a status in the order from best to worst."""
    return STATUSES.index(status) if status in STATUSES else len(STATUSES)


def _with_sheet(shown: ShownFolding, case: FoldingCase, command: str) -> ShownFolding:
    """Return a folding with its flight sheet and its first mode; HcsearchError where it has no proved motion."""
    notation, moved = shown.folding.notation, case.travel()
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


def _motions(case: FoldingCase, subject: str, stored: StoredDesign | None) -> list[ShownMotion]:
    """Return the path of a folding and its motion by springs; the one that gives the folding its status comes first.

    With stored results, the path is the stored one, and the motion is the best deployment.
    """
    motions: list[ShownMotion] = []
    path, option = (_planned_path(case), "") if stored is None else _stored_path(case, stored)
    if path is not None:
        motions.append(_path_motion(path, f"hcsearch drive {subject}{option}"))
    springs = _computed_springs(case, subject) if stored is None else _stored_springs(case, stored)
    if springs is not None:
        motions.insert(0 if springs.shows else len(motions), springs)
    return motions


def _planned_path(case: FoldingCase) -> Replay | None:
    with suppress(HcsearchError):  # there is no path, or the case has drives
        return case.replay("path")[0]
    return None


def _stored_path(case: FoldingCase, stored: StoredDesign) -> tuple[Replay | None, str]:
    """Return the stored path of a folding, and the option with which `drive` finds it."""
    crease = case.folding.crease
    verdict = verdict_of_row(stored.folding_row(crease), stored.deployments_of(crease))
    deployed = None if verdict is None else verdict.deployed_variant
    is_other = verdict is not None and deployed is not None and deployed.pairs != verdict.path_flat_pairs
    option = way_option_text(verdict.path_flat_pairs) if verdict is not None and is_other else ""
    return replay_of_design(stored, case.folding), option


def _computed_springs(case: FoldingCase, subject: str) -> ShownMotion | None:
    """Return the motion of a folding by springs or drives; None where its scene does not suit it."""
    try:
        deployed = case.deployed()
    except HcsearchError:
        return None
    replay = replay_of_deployment(deployed.deployment, case.title, reason=deployed.reason)
    command, play = f"hcsearch deploy {subject}", play_sentence(millimetres(deployed.needed_margin))
    motion = _springs_motion(replay, deployed.deployment, command, play, deployed.flat_time)
    opens = deployed.verdict == "deploys"
    return replace(motion, shows="" if not opens else "deploys" if case.drive is None else "driven")


def _stored_springs(case: FoldingCase, stored: StoredDesign) -> ShownMotion | None:
    """Return the motion of the best deployment of a folding; a folding that no stage has seen is simulated."""
    row, deployments = stored.folding_row(case.folding.crease), stored.deployments_of(case.folding.crease)
    best, tried = best_deployment(deployments), None
    if best is None:
        option = scene_option_text(stored.scene, stored.location_option)
        return None if stored.row["foldings"] else _computed_springs(case, f"{case.folding.notation}{option}")
    with suppress(HcsearchError):
        tried = best_tried_deployment(case, row, deployments)
    if tried is None:
        return None
    command = f"hcsearch deploy {case.folding.notation}{scene_option_text(tried.scene, stored.location_option)}"
    flat_time = cast("float | None", best["deploy_time"])
    motion = _springs_motion(tried.replay, tried.deployment, command, play_of_row(best), flat_time)
    return replace(motion, shows="deploys" if row.get("status") == "deploys" else "")


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
