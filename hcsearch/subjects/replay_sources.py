"""The replay of a case: a stored or planned path, or the deployment by springs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from hcsearch import store
from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import DatabaseError, HcsearchError, SizeError
from hcsearch.basics.vocabulary import WAYS, Formulation, ReplaySource
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, folding_of
from hcsearch.designs.panel_sizes import PanelSize
from hcsearch.motion.paths.motions import accumulated_turn
from hcsearch.motion.planning.motion_search import PlannedMotion, plan_linkage_motion
from hcsearch.scenes import DEFAULT_SCENE_NAME, Scene, panel_of
from hcsearch.shape.labels import labels_of
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.simulated_deployment import Deployment, simulate_deployment
from hcsearch.springs.drive.driven_folding import find_drive_motion, no_drive_reason, no_path_reason
from hcsearch.springs.flight.deployed_modes import DeployedModes
from hcsearch.subjects.case import Case, NamedAssembly
from hcsearch.subjects.pattern_files import DrawnPattern
from hcsearch.subjects.replay import Replay, thin_states
from hcsearch.subjects.stored_scenes import stored_scene
from hcsearch.system.terminal import short_number

if TYPE_CHECKING:
    from hcsearch.motion.paths.linkage_motion import LinkageMotion


def find_path(case: Case) -> tuple[Scene, PlannedMotion, str]:
    """Plan the motion of a case's folding or pattern; return its scene, the motion and a note on its flat pairs.

    Springs may open a folding with one joining of flat pairs while its path is proved with another. The joining of the
    springs is tried first, so that all results are of one linkage; the other only if no path is proved.
    """
    if isinstance(case.what, DrawnPattern):
        case.check_moved()
        return case.scene, plan_linkage_motion(case.linkage, case.scene.margin), case.driven_sentence
    folding, scene = case.to_move(), replace(case.scene, flat_pairs=case.allowed)
    motion = find_drive_motion(folding, scene)
    path = None if case.stored is None or case.stored.verdict is None else case.stored.verdict.path_flat_pairs
    if motion.margin is None and case.look_of == "verdict" and path not in (None, case.look.pairs):
        assert path is not None
        path_scene = replace(scene, flat_pairs=(path,))
        proved = find_drive_motion(folding, path_scene)
        if proved.margin is not None:
            note = f"flat pairs {path}, as in the proved path: none is proved with flat pairs {case.look.pairs}"
            return path_scene, proved, case.told(note)
    return scene, motion, case.driven_sentence


REPLAY_SUBSTEP_COUNT = 4
"""States inserted per step of a motion: steps are long where fold angles are smooth, but not linear."""
REPLAY_ANGLE_TOLERANCE = 2e-3
"""Largest error of interpolated fold angles in a replay, rad: 0.1 degrees, which a screen does not resolve."""

_LOOPS: dict[Formulation, str] = {
    "constrained": "loops closed exactly",
    "compliant": "loops closed by stiff springs",
    "penalty": "loops closed by the springs of the thesis",
    "quasistatic": "without inertia",
}


def replay_of_deployment(
    deployment: Deployment, title: str, *, design: bool | None = None, reason: str | None = None
) -> Replay:
    """Return the replay of a simulated deployment.

    design : as of `labels_of`. reason : its outcome, including other tolerances if they were tried.
    """
    compiled, motion, clearance = deployment.compiled, deployment.motion, deployment.clearance
    shares = np.linspace(0.0, 1.0, REPLAY_SUBSTEP_COUNT, endpoint=False)
    between = (motion.times[:-1, None] + shares * np.diff(motion.times)[:, None]).ravel()
    times = np.append(between, motion.times[-1])
    times, angles = _without_repeats(times, deployment.angles_at(times))
    indices, error = thin_states(times, angles, REPLAY_ANGLE_TOLERANCE)
    end = float(times[-1]) if clearance is not None and clearance.kind == "clear" else None
    if clearance is not None and clearance.time is not None:
        end = clearance.time
    return Replay(
        linkage=compiled.linkage,
        labels=labels_of(compiled.linkage, design=design),
        axis="time",
        at=times[indices],
        angles=angles[indices],
        certified=() if end is None else ((0.0, end),),
        collision=deployment.check.collision,
        margin=compiled.margin,
        error=error,
        title=title,
        source=f"simulated in the scene {compiled.setup.name!r}, {_LOOPS[compiled.formulation]}: "
        f"{deployment.reason if reason is None else reason}",
    )


def replay_of_path(
    linkage: Linkage,
    states: Reals,
    title: str,
    *,
    margin: float | None,
    design: bool = True,
    near: float = REPLAY_ANGLE_TOLERANCE,
) -> Replay:
    """Return the replay of a planned path, (k, n_hinges), from packed to flat.

    margin : m, the play at which the path is proved as a whole, None without proof. Places on the axis are shares of
    the path's length, the accumulated turn of all hinges. near : rad, allowed error of interpolation.
    """
    length = accumulated_turn(states)
    places = length / length[-1] if length[-1] > 0.0 else np.linspace(0.0, 1.0, len(states))
    places, states = _without_repeats(places, np.asarray(states, float))
    indices, error = thin_states(places, states, near)
    proved = "not proved" if margin is None else f"proved with {short_number(1e3 * margin, 2)} mm of play on every face"
    return Replay(
        linkage=linkage,
        labels=labels_of(linkage, design=design),
        axis="path",
        at=places[indices],
        angles=states[indices],
        certified=() if margin is None else ((0.0, 1.0),),
        collision=None,
        margin=margin or 0.0,
        error=error,
        title=title,
        source=f"planned path from packed to flat, {proved}",
    )


def replay_of_motion(motion: LinkageMotion) -> Replay:
    """Return the replay of a motion that was followed; one that begins flat is played backwards, towards flat.

    Places on the axis are shares of its arc length. HcsearchError for a linkage that does not move.
    """
    rows = motion.rows
    if rows.lengths[-1] <= 0.0:
        raise HcsearchError(f"{motion.name} does not move from {motion.start}: {motion.sentence}")
    places, states = _without_repeats(rows.lengths / rows.lengths[-1], rows.angles)
    if not np.abs(states[0] - motion.linkage.flat).any():
        places, states = (1.0 - places)[::-1], states[::-1]
    indices, error = thin_states(places, states, REPLAY_ANGLE_TOLERANCE)
    return Replay(
        linkage=motion.linkage,
        labels=motion.labels,
        axis="path",
        at=places[indices],
        angles=states[indices],
        certified=(),
        collision=None,
        margin=0.0,
        error=error,
        title=motion.name,
        source=f"followed from {motion.start}, {motion.sentence}; panels may pass through each other",
    )


MODE_AMPLITUDE = 0.15
"""Greatest fold angle in the replay of a mode, rad: enlarged, so that it is seen."""
MODE_STATE_COUNT = 24
"""States of the replay of one period."""


def replay_of_mode(linkage: Linkage, modes: DeployedModes, number: int, title: str, *, design: bool = True) -> Replay:
    """Return one period of a mode of the flat array, enlarged; number : from 0 on, of those that are not soft.

    Loops are closed to first order only, as in the mode itself.
    """
    period = 1.0 / float(modes.frequencies[number])
    phases = np.linspace(0.0, 2.0 * np.pi, MODE_STATE_COUNT + 1)
    shape = modes.rates[modes.soft_modes + number]
    angles = MODE_AMPLITUDE * np.sin(phases)[:, None] * shape / np.abs(shape).max()
    hertz = short_number(1.0 / period, 3)
    return Replay(
        linkage=linkage,
        labels=labels_of(linkage, design=design),
        axis="time",
        at=period * phases / (2.0 * np.pi),
        angles=angles,
        certified=(),
        collision=None,
        margin=0.0,
        error=0.0,
        title=title,
        source=f"mode {number + 1} of the flat array on its latches, {hertz} Hz, enlarged",
    )


def _without_repeats(places: Reals, angles: Reals) -> tuple[Reals, Reals]:
    """Return places and states without repeated places; at an impact the state after it stays."""
    is_last = np.append(np.diff(places) > 0.0, True)
    return places[is_last], angles[is_last]


def replay_case(case: Case, by: ReplaySource | None = None) -> tuple[Replay, str]:
    """Replay a motion of a case; return it with a note on the joining of flat pairs.

    by : `path`, from packed to flat: the stored path of a judged folding, else one planned in the scene; `springs`, a
    simulation. Default: a proved path if there is one, else the simulation, unless springs do not open the folding and
    a path without proof exists. HcsearchError if a path is required and there is none.
    """
    replay, note = None, ""
    if by != "springs":
        replay, note = _stored(case), case.driven_sentence
        if replay is None:
            replay, note = _planned(case, required=by == "path")
        if replay is not None and (by == "path" or replay.certified):
            return replay, note
    deployment = simulate_deployment(case.linkage, case.setup, case.formulation or "constrained", drives=case.drives)
    if replay is not None and not deployment.deploys:
        return replay, note
    design = case.folding is not None
    return replay_of_deployment(deployment, case.title, design=design or None), case.sentence


def _stored(case: Case) -> Replay | None:
    """Return the stored proved path of a judged folding as a replay; None without one."""
    if case.stored is not None and case.stored.damage is not None:
        raise case.stored.damage
    if case.folding is None or case.stored is None or case.stored.path is None:
        return None
    path = case.stored.path
    linkage = case.folding.linkage(case.panel, flat_pairs=path.way or "rigid")
    if linkage.n_hinges != path.states.shape[1]:
        raise _damaged(case.stored.location, case.folding.circuit, path)
    return _replay_of(path, case.folding, linkage)


def _planned(case: Case, *, required: bool) -> tuple[Replay | None, str]:
    if required and isinstance(case.what, NamedAssembly):
        raise HcsearchError(f"{case.title} is an assembly, for which no path is planned: ask for --motion springs")
    try:
        scene, motion, note = find_path(case) if required else _opened(case)
    except SizeError:
        raise
    except HcsearchError:
        if required:
            raise
        return None, ""  # an assembly, or a file with springs or a drive of its own
    drawn = isinstance(case.what, DrawnPattern)
    if motion.states is None or motion.way is None:
        if required:
            raise HcsearchError(no_path_reason(motion) if drawn else no_drive_reason(case.to_move(), scene, motion))
        return None, ""
    linkage = case.linkage if drawn else case.to_move().linkage(case.panel, flat_pairs=motion.way)
    return replay_of_path(linkage, motion.states, case.title, margin=motion.margin, design=not drawn), note


def _opened(case: Case) -> tuple[Scene, PlannedMotion, str]:
    """Plan the motion as `find_path`, but only with the joining of flat pairs behind the status of the folding."""
    if isinstance(case.what, DrawnPattern):
        return find_path(case)
    scene = replace(case.scene, flat_pairs=case.allowed)
    return scene, find_drive_motion(case.to_move(), scene), case.driven_sentence


def stored_replays(
    database: store.Database, circuits: Mapping[int, Circuit], scene: str = DEFAULT_SCENE_NAME
) -> Iterator[tuple[store.StoredPath, Replay]]:
    """Yield the stored paths of some designs with their replays, ordered by design and crease.

    circuits : stored circuits of the designs by id.
    """
    values = stored_scene(database, scene)
    for path in store.find_paths(database, list(circuits), scene):
        circuit = circuits[path.design_id]
        panel = panel_of(values, circuit.grid.name)
        linkage = None
        with suppress(HcsearchError):  # the circuit may have no such folding
            folding = folding_of(circuit, path.crease)
            linkage = _linkage_of(folding, panel, path)
        if linkage is None:
            raise _damaged(database.location, circuit, path)
        yield path, _replay_of(path, folding, linkage)


def _linkage_of(folding: Folding, panel: PanelSize, path: store.StoredPath) -> Linkage | None:
    """Return the linkage of a path, or None; without a proof the number of hinges gives the joining of flat pairs."""
    for way in WAYS if path.way is None else (path.way,):
        if folding.can_join(way):
            linkage = folding.linkage(panel, flat_pairs=way)
            if linkage.n_hinges == path.states.shape[1]:
                return linkage
    return None


def _replay_of(path: store.StoredPath, folding: Folding, linkage: Linkage) -> Replay:
    margin = None if path.needed_margin is None else 1e-3 * path.needed_margin
    return replay_of_path(linkage, path.states, folding.notation, margin=margin)


def _damaged(location: str, circuit: Circuit, path: store.StoredPath) -> DatabaseError:
    return DatabaseError(
        f"database {location} is damaged: its path of folding {path.crease} of {circuit.notation} has "
        f"{path.states.shape[1]} hinges, as no linkage of it; restore a copy, or enumerate anew"
    )
