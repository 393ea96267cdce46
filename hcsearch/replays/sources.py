"""The replay of what a name stands for: a stored or planned path, or the deployment by springs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from typing import Literal

from hcsearch.assemblies import ASSEMBLIES
from hcsearch.circuit import Circuit
from hcsearch.deployment.deploying import deploy
from hcsearch.drive.driving import find_motion, why_not
from hcsearch.errors import DatabaseError, HcsearchError, SizeError
from hcsearch.flat_pairs import can_be, linkage_joined
from hcsearch.folding import Folding, folding_of
from hcsearch.linkage import Linkage
from hcsearch.planning.motions import PlannedMotion
from hcsearch.replays.finding import find_path
from hcsearch.replays.recording import replay_of_deployment, replay_of_path
from hcsearch.replays.replay import Replay
from hcsearch.scenes import DEFAULT, PanelSize, Scene, panel_of
from hcsearch.store import Database, StoredPath, find_paths, open_readonly
from hcsearch.subjects.reading import read_folding, read_subject
from hcsearch.subjects.requests import Request, known_of, settled
from hcsearch.subjects.scenes import stored_scene
from hcsearch.vocabulary import WAYS

By = Literal["path", "springs"]


def replay_named(request: Request, by: By | None = None) -> Replay:
    """The replay of a folding, an assembly or a file, with its flat pairs joined in the way that gave it its status.

    by : `path`, from packed to flat: the one that a database holds of a judged folding, else planned in the scene;
    `springs`, simulated. Unless given: the proved path of a folding that has one, else what springs do, unless they do
    not open it and there is a path that is not proved. HcsearchError where a path is asked for and there is none.
    """
    return find_replay(request, by)[0]


def find_replay(request: Request, by: By | None = None) -> tuple[Replay, str]:
    """The same, and what users should know of how its flat pairs are joined."""
    request = settled(request)
    known = known_of(request)
    if by != "springs":
        replay, said = _stored(request), known.driven_sentence
        if replay is None:
            replay, said = _of_path(request, required=by == "path")
        if replay is not None and (by == "path" or replay.certified):
            return replay, said
    else:
        replay, said = None, ""
    subject = read_subject(request)
    deployment = deploy(subject.linkage, subject.scene, subject.formulation or "constrained", drives=subject.drives)
    if replay is not None and not deployment.deploys:
        return replay, said
    return replay_of_deployment(deployment, subject.title, design="design" in subject.facts), known.sentence


def _stored(request: Request) -> Replay | None:
    """The proved path of a judged folding, where it is of the way that gave its status; None without one."""
    known = known_of(request)
    folding, verdict = known.folding, known.verdict
    if folding is None or verdict is None or verdict.path is None or known.number is None:
        return None
    circuit = Circuit.from_notation(folding.circuit.notation)
    own = request.values or request.flat_pairs or request.merge or known.parts or circuit != folding.circuit
    if own or (known.look is not None and known.look.pairs != verdict.path):
        return None
    with open_readonly(request.db) as database:
        replays = stored_replays(database, {known.number: circuit}, known.stored)
        return next((replay for path, replay in replays if path.crease == folding.crease), None)


def _of_path(request: Request, *, required: bool) -> tuple[Replay | None, str]:
    name = known_of(request).name
    if required and name in ASSEMBLIES:
        raise HcsearchError(f"{name} is an assembly, for which no path is planned: ask for --motion springs")
    try:
        folding, scene, motion, said = find_path(request) if required else _opened(request)
    except SizeError:
        raise
    except HcsearchError:
        if required:
            raise
        return None, ""  # an assembly, or a file with springs or a drive of its own
    if motion.states is None or motion.way is None:
        if required:
            raise HcsearchError(why_not(folding, scene, motion))
        return None, ""
    linkage = linkage_joined(folding, panel_of(scene, folding.circuit.grid.name), motion.way)
    return replay_of_path(linkage, motion.states, folding.notation, margin=motion.margin), said


def _opened(request: Request) -> tuple[Folding, Scene, PlannedMotion, str]:
    """As `find_path`, in the way alone that gave the folding its status: springs open it where no path does."""
    folding, scene = read_folding(request)
    return folding, scene, find_motion(folding, scene), known_of(request).driven_sentence


def stored_replays(
    database: Database, circuits: Mapping[int, Circuit], scene: str = DEFAULT
) -> Iterator[tuple[StoredPath, Replay]]:
    """The replays of the paths that a database holds of the foldings of designs, by design and crease.

    circuits : of the designs, by their ids, as the database has them.
    """
    values = stored_scene(database, scene)
    for path in find_paths(database, list(circuits), scene):
        circuit = circuits[path.design_id]
        folding, linkage = _folded(database, circuit, panel_of(values, circuit.grid.name), path)
        margin = None if path.needed_margin is None else 1e-3 * path.needed_margin
        yield path, replay_of_path(linkage, path.states, folding.notation, margin=margin)


def _folded(database: Database, circuit: Circuit, panel: PanelSize, path: StoredPath) -> tuple[Folding, Linkage]:
    """The folding of a path, and its linkage; without a proof the hinges say how its flat pairs are joined."""
    ways = WAYS if path.way is None else (path.way,)
    with suppress(HcsearchError):  # of a folding that the circuit does not have
        folding = folding_of(circuit, path.crease)
        for way in ways:
            if can_be(folding, way):
                linkage = linkage_joined(folding, panel, way)
                if linkage.n_hinges == path.states.shape[1]:
                    return folding, linkage
    raise DatabaseError(
        f"database {database.location} is damaged: its path of folding {path.crease} of {circuit.notation} has "
        f"{path.states.shape[1]} hinges, as no linkage of it; restore a copy, or enumerate anew"
    )
