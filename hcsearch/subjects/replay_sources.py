"""Replays of stored and planned paths, deployments by springs, motions that are followed, and modes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from hcsearch import store
from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import DatabaseError, HcsearchError
from hcsearch.basics.vocabulary import WAYS, Formulation
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, folding_of
from hcsearch.designs.panel_sizes import PanelSize
from hcsearch.motion.paths.motions import accumulated_turn
from hcsearch.scenes import DEFAULT_SCENE_NAME, panel_of
from hcsearch.shape.labels import labels_of
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.simulated_deployment import Deployment
from hcsearch.springs.flight.deployed_modes import DeployedModes
from hcsearch.subjects.replay import Replay, thin_states
from hcsearch.subjects.stored_designs import StoredDesign
from hcsearch.subjects.stored_scenes import stored_scene
from hcsearch.system.terminal import short_number

if TYPE_CHECKING:
    from hcsearch.motion.paths.linkage_motion import LinkageMotion


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


def replay_of_deployment(deployment: Deployment, title: str, *, reason: str | None = None) -> Replay:
    """Return the replay of a simulated deployment.

    reason : its outcome, including other tolerances if they were tried.
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
        labels=labels_of(compiled.linkage),
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
        labels=labels_of(linkage),
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


def replay_of_mode(linkage: Linkage, modes: DeployedModes, number: int, title: str) -> Replay:
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
        labels=labels_of(linkage),
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


def replay_of_stored_path(path: store.StoredPath, folding: Folding, panel: PanelSize, location: str) -> Replay:
    """Return the replay of a stored path of a folding; DatabaseError, which names the database, where it has none."""
    linkage = _linkage_of(folding, panel, path)
    if linkage is None:
        raise _damaged(location, folding.circuit, path)
    return _replay_of(path, folding, linkage)


def replay_of_design(design: StoredDesign, folding: Folding) -> Replay | None:
    """Return the replay of the path of a folding that its design has in a database; None without one."""
    path = next((path for path in design.paths if path.crease == folding.crease), None)
    if path is None:
        return None
    panel = panel_of(design.values, folding.circuit.grid.name)
    return replay_of_stored_path(path, folding, panel, design.location)


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
        folding = folding_of_path(path, circuit, database.location)
        yield path, replay_of_stored_path(path, folding, panel, database.location)


def folding_of_path(path: store.StoredPath, circuit: Circuit, location: str) -> Folding:
    """Return the folding that a stored path moves; DatabaseError where the circuit has no such folding."""
    try:
        return folding_of(circuit, path.crease)
    except HcsearchError:
        raise _damaged(location, circuit, path) from None


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
