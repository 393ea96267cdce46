"""The data of a design's page: what a database holds of it, what is computed anew, and the room it takes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from importlib.metadata import version

import numpy as np
import shapely

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import millimetres, play_sentence
from hcsearch.cases.mechanisms import Freedoms, freedoms_of, lock_sentences
from hcsearch.cases.replay import Replay
from hcsearch.cases.replay_sources import replay_case, replay_of_deployment, stored_replays
from hcsearch.cases.resolve import resolve
from hcsearch.cases.stored_scenes import stored_scene
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding
from hcsearch.designs.panel_sizes import panel_text
from hcsearch.designs.twisting import twist
from hcsearch.scenes import DEFAULT_SCENE_NAME, SCENES, Scene, panel_of
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.agreement import confirm_deployment
from hcsearch.springs.deployment.simulated_deployment import simulate_deployment
from hcsearch.store import Database, best_creases, select
from hcsearch.web.player import Payload, payload_of
from hcsearch.web.report.data import FoldingKey, ViewRow, deployments_of, foldings_of, motions_of
from hcsearch.web.report.plots import DrawnPlot, marks_of_motion, plots_of
from hcsearch.web.report.reasons import (
    best_deployment,
    deployment_scene_name,
    play_of_row,
    status_reason,
    verdict_of_row,
    way_option_text,
)
from hcsearch.web.report.templating import database_option_text, scene_option_text


@dataclass(frozen=True)
class Envelope:
    """The smallest box that stands upright around all panels, m: longer and shorter side of its base, height."""

    length: float
    width: float
    height: float

    @property
    def volume(self) -> float:
        """Of the box, m^3."""
        return self.length * self.width * self.height

    @property
    def text(self) -> str:
        """Sides in millimetres."""
        return " x ".join(f"{1e3 * side:.4g}" for side in (self.length, self.width, self.height)) + " mm"


@dataclass(frozen=True)
class FoldingRoom:
    """A folding packed and flat; mass in kg, of the panels alone; area of the flat panels in m^2."""

    packed: Envelope
    flat: Envelope
    mass: float
    area: float


def folding_room_of(folding: Folding, scene: Scene) -> FoldingRoom:
    """The room that a folding takes with the panels of a scene, flat pairs rigid."""
    panel = panel_of(scene, folding.circuit.grid.name)
    linkage = folding.linkage(panel)
    area = linkage.pattern.area
    mass = scene.density_of(panel[2]) * area * panel[2]
    return FoldingRoom(envelope_at(linkage, linkage.folded), envelope_at(linkage, linkage.flat), mass, area)


def envelope_at(linkage: Linkage, angles: Reals) -> Envelope:
    """The box around a linkage at a state, upright on the base panel's face, its base turned to be smallest."""
    points = np.concatenate([solid.reshape(-1, 3) for solid in linkage.solids(angles)])
    corners = shapely.get_coordinates(shapely.minimum_rotated_rectangle(shapely.MultiPoint(points[:, :2])))
    sides = sorted(np.linalg.norm(np.diff(corners[:3], axis=0), axis=1).tolist(), reverse=True)
    return Envelope(sides[0], sides[1], float(np.ptp(points[:, 2])))


@dataclass(frozen=True)
class ShownMotion:
    """A motion that the page plays and plots; `command` reproduces it.

    shows : the status that it gives its folding: `movable`, `deploys`, or empty for none.
    """

    title: str
    source: str
    command: str
    payload: Payload
    plots: Sequence[DrawnPlot]
    shows: str = ""


@dataclass(frozen=True)
class ShownFolding:
    """A folding with everything known of it.

    row : of the view `foldings`, empty where no database holds it. status : a word, or `twisted`.
    why : the sentence behind it. tried : rows of `deployments`. locks : sentences on each end, more exact ones after.
    """

    folding: Folding
    row: ViewRow
    twist: int
    status: str
    why: str
    room: FoldingRoom
    tried: Sequence[ViewRow] = ()
    freedoms: Sequence[Freedoms] = ()
    locks: Sequence[Sequence[str]] = ()
    motions: Sequence[ShownMotion] = ()


@dataclass(frozen=True)
class DesignData:
    """Everything on the page; row : of the view `designs`, empty where no database holds it. meta : what it depends on.

    links : (words, address) of what is around the page. exports : of files of a folding, by its crease, where a server
    has them.
    """

    title: str
    notation: str
    array: str
    row: ViewRow
    meta: Sequence[tuple[str, str]]
    foldings: Sequence[ShownFolding]
    best: int | None
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
    """Everything known of a design, whose circuit is in canonical order, and of some of its foldings in a scene.

    database : from `open_readonly`, or None, and then motions are planned and simulated anew. number : its id there.
    db : names the database, for what is looked up by name.
    """
    values = SCENES[DEFAULT_SCENE_NAME] if database is None else stored_scene(database, scene)
    panel = panel_of(values, circuit.grid.name)
    stored = _Known() if database is None else _known(database, number, circuit, scene)
    ordered = sorted(foldings, key=lambda folding: (folding.crease != stored.best, folding.crease))
    shown = [_folding(folding, stored, values, db) for folding in ordered]
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
        size=(1e3 * panel[0], 1e3 * panel[1]),
    )


@dataclass(frozen=True)
class _Known:
    """What a database holds of a design in a scene; the defaults stand for a design that no database holds.

    where : the option of commands that names the database.
    """

    number: int = 0
    scene: str = DEFAULT_SCENE_NAME
    where: str = ""
    design: ViewRow = field(default_factory=dict)
    rows: Mapping[int, ViewRow] = field(default_factory=dict)
    best: int | None = None
    motions: Mapping[FoldingKey, str] = field(default_factory=dict)
    tried: Mapping[FoldingKey, Sequence[ViewRow]] = field(default_factory=dict)
    paths: Mapping[int, Replay] | None = None

    def path(self, folding: Folding, db: str) -> Replay | None:
        """The path of a folding: as stored, proved or not; planned where no database holds the design."""
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
        tried=deployments_of(database, [number], scene),
        paths={path.crease: replay for path, replay in stored_replays(database, {number: circuit}, scene)},
    )


def _folding(folding: Folding, stored: _Known, scene: Scene, db: str) -> ShownFolding:
    row, turns = stored.rows.get(folding.crease, {}), twist(folding)
    key = (stored.number, folding.crease)
    tried, panel = stored.tried.get(key, ()), panel_of(scene, folding.circuit.grid.name)
    motions = [] if turns else _motions(folding, stored, row, tried, db)
    reason = status_reason({**row, "twist": turns}, stored.motions.get(key), tried)
    status = "twisted" if turns else str(row.get("status") or "not_judged")
    return ShownFolding(
        folding=folding,
        row=row,
        twist=turns,
        status=_shown(motions) if stored.paths is None and not turns else status,
        why=reason or "; ".join(motion.source for motion in motions) or NOT_JUDGED_REASON,
        room=folding_room_of(folding, scene),
        tried=tried,
        freedoms=() if turns else freedoms_of(folding, panel),
        locks=() if turns else lock_sentences(folding, panel),
        motions=motions,
    )


def _shown(motions: Sequence[ShownMotion]) -> str:
    """The status of a folding that no database holds: the best that its motions show."""
    shown = {motion.shows for motion in motions}
    return next((status for status in ("deploys", "movable") if status in shown), "not_judged")


def _motions(folding: Folding, stored: _Known, row: ViewRow, tried: Sequence[ViewRow], db: str) -> list[ShownMotion]:
    """The path of a folding, and what the springs of its best deployment do; without a database, those of `default`."""
    motions, best, verdict = [], best_deployment(tried), verdict_of_row(row, tried)
    path = stored.path(folding, db)
    if path is not None:
        payload = payload_of(path)
        own = None if verdict is None or verdict.deployed is None else verdict.deployed.pairs
        way = way_option_text(verdict.path) if verdict is not None and own not in (None, verdict.path) else ""
        command = f"hcsearch drive {folding.notation}{scene_option_text(stored.scene, stored.where)}{way}"
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
    agreement = confirm_deployment(deployment) if stored.paths is None else None
    said = str(best["reason"]) if best is not None else None if agreement is None else agreement.reason
    replay = replay_of_deployment(deployment, folding.notation, design=True, reason=said)
    payload = payload_of(replay)
    command = f"hcsearch deploy {folding.notation}{scene_option_text(name, stored.where)}"
    needed = None if agreement is None else millimetres(agreement.needed_margin)
    play = play_sentence(needed) if best is None else play_of_row(best)
    source = "; ".join(
        filter(None, (replay.source, *(mark.text for mark in marks_of_motion(replay) if mark.bad), play))
    )
    shows = "deploys" if agreement is not None and agreement.verdict == "deploys" else ""
    plots = plots_of(replay, payload, deployment)
    motions.append(ShownMotion("Motion by springs", source, command, payload, plots, shows))
    return motions
