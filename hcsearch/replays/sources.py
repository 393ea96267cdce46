"""The replay of what a name stands for: a stored or planned path, or the deployment by springs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Literal

from hcsearch.assemblies import ASSEMBLIES
from hcsearch.circuit import Circuit
from hcsearch.deployment.deploying import deploy
from hcsearch.drive.driving import find_motion, why_not
from hcsearch.errors import HcsearchError
from hcsearch.flat_pairs import can_be, linkage_joined
from hcsearch.folding import Folding, folding_of, split_crease
from hcsearch.linkage import Linkage
from hcsearch.replays.recording import replay_of_deployment, replay_of_path
from hcsearch.replays.replay import Replay
from hcsearch.scenes import DEFAULT, PanelSize, Scene, panel_of
from hcsearch.store import Database, StoredPath, find_paths, open_readonly, scene_names
from hcsearch.subjects.designs import design_named, is_id
from hcsearch.subjects.reading import Request, read_folding, read_subject
from hcsearch.subjects.scenes import scene_asked_for, stored_scene
from hcsearch.vocabulary import WAYS

By = Literal["path", "springs"]


def replay_named(request: Request, by: By | None = None) -> Replay:
    """The replay of a folding, an assembly or a file.

    by : `path`, from packed to flat: the one that a database holds of a design named by its id, else planned in the
    scene; `springs`, simulated. Unless given: the path of a folding that has one, else what springs do. HcsearchError
    where a path is asked for and there is none.
    """
    if by != "springs":
        replay = _stored(request) or _of_path(request, required=by == "path")
        if replay is not None:
            return replay
    subject = read_subject(request)
    deployment = deploy(subject.linkage, subject.scene, subject.formulation or "constrained", drives=subject.drives)
    return replay_of_deployment(deployment, subject.title, design="design" in subject.facts)


def _stored(request: Request) -> Replay | None:
    """The proved path in the request's scene of a folding named by the id of its design; None where there is none."""
    name, crease = split_crease(request.name)
    own = request.values or request.flat_pairs or request.merge or request.folding
    scene = request.scene
    if crease is None or not is_id(name) or own or isinstance(scene, Scene) or (scene or "").endswith(".toml"):
        return None
    circuit, row = design_named(name, request.db)
    wanted = folding_of(circuit, crease).crease
    with open_readonly(request.db) as database:
        asked = scene_asked_for(database, scene, request.panel, request.across)
        if asked != DEFAULT and asked not in scene_names(database):
            return None
        replays = stored_replays(database, {int(row["id"]): circuit}, asked)
        return next((replay for path, replay in replays if path.crease == wanted and path.way is not None), None)


def _of_path(request: Request, *, required: bool) -> Replay | None:
    if required and request.name in ASSEMBLIES:
        raise HcsearchError(f"{request.name} is an assembly, for which no path is planned: ask for --motion springs")
    try:
        folding, scene = read_folding(request)
    except HcsearchError:
        if required:
            raise
        return None  # an assembly, or a file with springs or a drive of its own
    motion = find_motion(folding, scene)
    if motion.states is None or motion.way is None:
        if required:
            raise HcsearchError(why_not(folding, scene, motion))
        return None
    linkage = linkage_joined(folding, panel_of(scene, folding.circuit.grid.name), motion.way)
    return replay_of_path(linkage, motion.states, folding.notation, margin=motion.margin)


def stored_replays(
    database: Database, circuits: Mapping[int, Circuit], scene: str = DEFAULT
) -> Iterator[tuple[StoredPath, Replay]]:
    """The replays of the paths that a database holds of the foldings of designs, by design and crease.

    circuits : of the designs, by their ids, as the database has them.
    """
    values = stored_scene(database, scene)
    for path in find_paths(database, list(circuits), scene):
        folding = folding_of(circuits[path.design_id], path.crease)
        linkage = _linkage(folding, panel_of(values, folding.circuit.grid.name), path)
        margin = None if path.needed_margin is None else 1e-3 * path.needed_margin
        yield path, replay_of_path(linkage, path.states, folding.notation, margin=margin)


def _linkage(folding: Folding, panel: PanelSize, path: StoredPath) -> Linkage:
    """The linkage of a path; without a proof the number of hinges says how its flat pairs are joined."""
    ways = WAYS if path.way is None else (path.way,)
    for way in ways:
        if can_be(folding, way):
            linkage = linkage_joined(folding, panel, way)
            if linkage.n_hinges == path.states.shape[1]:
                return linkage
    raise HcsearchError(
        f"the path of {folding.notation} has {path.states.shape[1]} hinges, as none of its linkages: the database is "
        "damaged; restore a copy, or enumerate anew"
    )
