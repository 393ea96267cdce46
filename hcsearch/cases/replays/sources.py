"""The replay of what a name stands for: a stored or planned path, or the deployment by springs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from typing import Literal

from hcsearch.basics.errors import DatabaseError, HcsearchError, SizeError
from hcsearch.basics.vocabulary import WAYS
from hcsearch.cases.case import Case, NamedAssembly
from hcsearch.cases.replays.finding import find_path
from hcsearch.cases.replays.recording import replay_of_deployment, replay_of_path
from hcsearch.cases.replays.replay import Replay
from hcsearch.cases.stored_scenes import stored_scene
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, folding_of
from hcsearch.designs.panel_sizes import PanelSize
from hcsearch.motion.planning.motions import PlannedMotion
from hcsearch.scenes import DEFAULT_SCENE_NAME, Scene, panel_of
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.deploying import simulate_deployment
from hcsearch.springs.drive.driving import find_drive_motion, no_drive_reason
from hcsearch.store import Database, StoredPath, find_paths

ReplaySource = Literal["path", "springs"]


def replay_case(case: Case, by: ReplaySource | None = None) -> tuple[Replay, str]:
    """Replay a motion of a case, and say what users should know of how its flat pairs are joined.

    by : `path`, from packed to flat: the one that a database holds of a judged folding, else planned in the scene;
    `springs`, simulated. Unless given: the proved path of a folding that has one, else what springs do, unless they do
    not open it and there is a path that is not proved. HcsearchError where a path is asked for and there is none.
    """
    replay, said = None, ""
    if by != "springs":
        replay, said = _stored(case), case.driven_sentence
        if replay is None:
            replay, said = _planned(case, required=by == "path")
        if replay is not None and (by == "path" or replay.certified):
            return replay, said
    deployment = simulate_deployment(case.linkage, case.setup, case.formulation or "constrained", drives=case.drives)
    if replay is not None and not deployment.deploys:
        return replay, said
    design = case.folding is not None
    return replay_of_deployment(deployment, case.title, design=design or None), case.sentence


def _stored(case: Case) -> Replay | None:
    """The proved path of a judged folding, where it is of the way that gave its status; None without one."""
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
        scene, motion, said = find_path(case) if required else _opened(case)
    except SizeError:
        raise
    except HcsearchError:
        if required:
            raise
        return None, ""  # an assembly, or a file with springs or a drive of its own
    folding = case.to_move()
    if motion.states is None or motion.way is None:
        if required:
            raise HcsearchError(no_drive_reason(folding, scene, motion))
        return None, ""
    linkage = folding.linkage(case.panel, flat_pairs=motion.way)
    return replay_of_path(linkage, motion.states, folding.notation, margin=motion.margin), said


def _opened(case: Case) -> tuple[Scene, PlannedMotion, str]:
    """As `find_path`, in the way alone that gave the folding its status: springs open it where no path does."""
    scene = replace(case.scene, flat_pairs=case.allowed)
    return scene, find_drive_motion(case.to_move(), scene), case.driven_sentence


def stored_replays(
    database: Database, circuits: Mapping[int, Circuit], scene: str = DEFAULT_SCENE_NAME
) -> Iterator[tuple[StoredPath, Replay]]:
    """Give the replays of the paths that a database holds of the foldings of designs, by design and crease.

    circuits : of the designs, by their ids, as the database has them.
    """
    values = stored_scene(database, scene)
    for path in find_paths(database, list(circuits), scene):
        circuit = circuits[path.design_id]
        panel = panel_of(values, circuit.grid.name)
        linkage = None
        with suppress(HcsearchError):  # of a folding that the circuit does not have
            folding = folding_of(circuit, path.crease)
            linkage = _linkage_of(folding, panel, path)
        if linkage is None:
            raise _damaged(database.location, circuit, path)
        yield path, _replay_of(path, folding, linkage)


def _linkage_of(folding: Folding, panel: PanelSize, path: StoredPath) -> Linkage | None:
    """The linkage of a path; without a proof the hinges say how its flat pairs are joined. None where none fits."""
    for way in WAYS if path.way is None else (path.way,):
        if folding.can_join(way):
            linkage = folding.linkage(panel, flat_pairs=way)
            if linkage.n_hinges == path.states.shape[1]:
                return linkage
    return None


def _replay_of(path: StoredPath, folding: Folding, linkage: Linkage) -> Replay:
    margin = None if path.needed_margin is None else 1e-3 * path.needed_margin
    return replay_of_path(linkage, path.states, folding.notation, margin=margin)


def _damaged(location: str, circuit: Circuit, path: StoredPath) -> DatabaseError:
    return DatabaseError(
        f"database {location} is damaged: its path of folding {path.crease} of {circuit.notation} has "
        f"{path.states.shape[1]} hinges, as no linkage of it; restore a copy, or enumerate anew"
    )
