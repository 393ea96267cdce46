"""What users ask for, and what it comes to: the folding, its scene, and the way that gave it its status.

Everything that builds a linkage begins here, so that drawings, motions and drives of a folding are of one linkage: that
of the deployment that deploys, or of the proved path, where a database holds one in the scene that is asked for.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from hcsearch.assemblies import ASSEMBLIES
from hcsearch.deployment.looks import Look, first_look, look_parts
from hcsearch.deployment.scene_files import checked_scene, file_text, read_file, scene_in
from hcsearch.errors import DatabaseError, HcsearchError, NoDatabaseError, QueryError
from hcsearch.flat_pairs import can_be, ways
from hcsearch.folding import Folding, folding_of, foldings, split_crease
from hcsearch.scenes import DEFAULT, FlatPairs, Scene
from hcsearch.store import (
    Database,
    StoredVerdict,
    best_creases,
    find_circuit,
    find_scene,
    find_verdict,
    open_readonly,
    scene_names,
)
from hcsearch.subjects.designs import is_id
from hcsearch.subjects.scenes import only_scene, read_scene, with_size
from hcsearch.system.terminal import say


@dataclass(frozen=True)
class Known:
    """What a request comes to.

    name : of the design or assembly, that of a file where one is named. content : of this file.
    scene : with the panels that are asked for, before its values change. parts : of its name that say how to look.
    folding : that is meant, where the name or a database says which. stored : name of the scene in the database.
    number : of the design there. verdict : on the folding there. look : that gave this verdict, unless another way is
    asked for; without its springs where others are. chosen : which folding of the design this is, where the request
    leaves it open and there are several. noted : what else users should know.
    """

    name: str
    content: Mapping[str, Any]
    scene: Scene
    parts: tuple[str, ...] = ()
    folding: Folding | None = None
    stored: str = DEFAULT
    number: int | None = None
    verdict: StoredVerdict | None = None
    look: Look | None = None
    chosen: str = ""
    noted: str = ""

    @property
    def sentence(self) -> str:
        """What users should know: which folding in which scene, how flat pairs are joined, and what says so."""
        return self.said("" if self.look is None else way_sentence(self))

    @property
    def driven_sentence(self) -> str:
        """The same of a motion along a path, for which springs are those of the scene."""
        return self.said("" if self.look is None else way_sentence(self, with_springs=False))

    def said(self, way: str) -> str:
        """The same with another sentence on how flat pairs are joined."""
        return "; ".join(filter(None, (self.noted, self.chosen, way)))


@dataclass(frozen=True)
class Request:
    """What a user asks for: a name, and what stands beside it.

    name : DESIGN:CREASE, an assembly, or a file .toml. db : the database in which ids, scenes and verdicts are looked
    up. folding : what is meant, where it need not be read of the name. scene : its name, or itself. panel, across :
    sizes as texts in millimetres. values : more of the scene, by the names of a scene file; panels and hinges by their
    names. known : what it comes to, once `settled` has looked.
    """

    name: str
    db: str
    scene: str | Scene | None = None
    panel: str | None = None
    across: str | None = None
    flat_pairs: FlatPairs | None = None
    merge: bool = False
    values: Mapping[str, Any] = field(default_factory=dict)
    folding: Folding | None = None
    known: Known | None = None


def settled(request: Request) -> Request:
    """The request with what it comes to; HcsearchError for files, scenes and ids that there are not.

    A design without a crease stands for its best folding in the database; where it has verdicts of one scene alone, and
    none is named, an id stands for the design in this scene.
    """
    if request.known is not None:
        return request
    content = read_file(request.name) if request.name.endswith(".toml") else {}
    name = str(content.get("design", content.get("assembly", request.name)))
    circuit, crease = _named(name, request)
    if circuit is None:
        scene, parts = base_scene(content, request)
        return replace(request, known=Known(name, content, scene, parts, request.folding))
    try:
        with open_readonly(request.db) as database:
            return replace(request, known=_looked_up(name, content, circuit, crease, request, database))
    except DatabaseError as error:
        if is_id(circuit):
            raise
        known = _alone(name, content, circuit, crease, request)
        if not isinstance(error, NoDatabaseError):
            known = replace(known, noted=f"whether the folding was judged is not known: {error}")
        return replace(request, known=known)


def known_of(request: Request) -> Known:
    """What a request comes to, looked up where that was not done yet."""
    known = settled(request).known
    assert known is not None
    return known


def announced(request: Request) -> Request:
    """The same as `settled`; says on stderr what users should know of it."""
    request = settled(request)
    say(known_of(request).sentence)
    return request


def _named(name: str, request: Request) -> tuple[str | None, int | None]:
    """The id or the notation of a design, and the crease; None for an assembly, and for what names nothing."""
    if request.folding is not None:
        circuit, crease = split_crease(request.folding.notation)
        return circuit, crease
    if name in ASSEMBLIES or name.endswith(".toml") or not (":" in name or name[:1].isdigit()):
        return None, None
    return split_crease(name)


def _alone(name: str, content: Mapping[str, Any], circuit: str, crease: int | None, request: Request) -> Known:
    """What a notation comes to without a database."""
    from hcsearch.subjects.designs import design_named

    folding, (own, _) = request.folding, design_named(circuit, request.db)
    scene, parts = base_scene(content, request, own.grid.name)
    if folding is None and crease is not None:
        folding = folding_of(own, crease)
    return Known(name, content, scene, parts, folding)


def _looked_up(
    name: str, content: Mapping[str, Any], circuit: str, crease: int | None, request: Request, database: Database
) -> Known:
    """What a design comes to with a database; a notation need not be in it."""
    from hcsearch.subjects.designs import stored_circuit

    said = []
    by_id = is_id(circuit) and not content
    unnamed = (request.scene, request.panel, request.across) == (None, None, None)
    if by_id and unnamed and (only := only_scene(database)) is not None:
        request = replace(request, scene=only)
        said.append(f"scene {only}, the only one that {database.location} has verdicts of")
    try:
        number, circuit = find_circuit(database, circuit)
    except QueryError:
        if is_id(circuit):
            raise
        return _alone(name, content, circuit, crease, request)
    own = stored_circuit(database, number, circuit)
    scene, parts = base_scene(content, request, own.grid.name)
    known = Known(name, content, scene, parts, request.folding, number=number)
    names = scene_names(database)
    judged = scene.name in names and _is_stored(database, scene, request)
    known = replace(known, stored=scene.name) if judged else known
    if by_id and names and not judged:
        said.append(f"scene {scene.name}, without verdicts in {database.location}: its scenes are {', '.join(names)}")
    if known.folding is None:
        chosen = best_creases(database, [number], known.stored).get(number) if crease is None else crease
        folds = foldings(own)
        known = replace(known, folding=None if chosen is None else folding_of(own, chosen))
        if crease is None and len(folds) > 1 and chosen is not None:
            known = replace(known, chosen=f"folding {chosen}, the best of {len(folds)}")
    known = replace(known, noted="; ".join(said))
    if judged and known.folding is not None:
        at = Folding.from_notation(known.folding.notation).crease
        return _judged(known, find_verdict(database, number, at, known.stored), request)
    return known


def with_path(request: Request) -> Request:
    """The request with the first folding of a proved path, where it names a design whose best folding has none."""
    known = known_of(request)
    best, verdict, number = known.folding, known.verdict, known.number
    if not known.chosen or best is None or number is None or verdict is None or verdict.path is not None:
        return request
    with open_readonly(request.db) as database:
        for folding in foldings(best.circuit):
            own = find_verdict(database, number, folding.crease, known.stored)
            if own is not None and own.path is not None:
                chosen = f"folding {folding.crease}, as no path of the best one, {best.crease}, is proved"
                known = replace(known, folding=folding, chosen=chosen)
                return replace(request, known=_judged(known, own, request))
    return request


def _judged(known: Known, verdict: StoredVerdict | None, request: Request) -> Known:
    """The same with the verdict on its folding, and the look that gave it unless the request names another way."""
    known = replace(known, verdict=verdict, look=None)
    if request.flat_pairs or request.merge or known.parts:
        return known
    return replace(known, look=_look(known, own_springs=bool({"spring", "springs"} & set(request.values))))


def _is_stored(database: Database, scene: Scene, request: Request) -> bool:
    """Whether a scene is that of its name in a database, and not another one, from a file or of Python."""
    given = request.scene
    own = isinstance(given, Scene) or (given or "").endswith(".toml") or request.name.endswith(".toml")
    return not own or find_scene(database, scene.name) == file_text({}, None, scene)


def _look(known: Known, *, own_springs: bool) -> Look | None:
    """The look that gave the verdict: that of the deployment that deploys, or the way of the proved path.

    own_springs : whether springs are asked for, so that the way alone is taken.
    """
    verdict, scene, folding = known.verdict, known.scene, known.folding
    if verdict is None or folding is None:
        return None
    if verdict.status == "deploys" and verdict.deployed is not None:
        look = _look_named(verdict.deployed, scene)
        if look is None or not can_be(folding, look.pairs):
            return None
        return Look(look.pairs, first=True) if own_springs else look
    if verdict.status == "movable" and verdict.path is not None and can_be(folding, verdict.path):
        return Look(verdict.path, first=True)
    return None


def _look_named(name: str, scene: Scene) -> Look | None:
    """The look at a scene that a deployment has the name of; None where this program knows no such look."""
    first = first_look(scene)
    if name == scene.name:
        return first
    parts = name.split(", ")
    pairs, springs = look_parts(parts)
    look = Look(pairs or first.pairs, springs)
    return look if look.name(scene) == name and look.pairs in ways(scene) else None


def way_sentence(known: Known, *, with_springs: bool = True) -> str:
    """How flat pairs are joined, which springs there are, and what says so."""
    look, verdict = known.look, known.verdict
    assert look is not None
    assert verdict is not None
    if verdict.status != "deploys":
        return f"flat pairs {look.pairs}, as in the proved path"
    springs = f", springs {look.springs}" if look.springs and with_springs else ""
    return f"flat pairs {look.pairs}{springs}, as in the deployment that deploys"


def base_scene(content: Mapping[str, Any], request: Request, grid: str | None = None) -> tuple[Scene, tuple[str, ...]]:
    """The scene of a file or by its name, with the panels that are asked for, and the parts of its name that say how.

    grid : of the design; None of an assembly, which has panels of its own.
    """
    base: Scene | None = None
    parts: list[str] = []
    if isinstance(text := request.scene, Scene):
        base = checked_scene(text)
    elif text is not None and text.strip():
        named = [part.strip() for part in text.split(",")]
        before = list(named)
        look_parts(named)
        parts = before[len(named) :]
        base = read_scene(", ".join(named) or DEFAULT, request.db, grid)
    elif text is not None:
        base = read_scene(text, request.db, grid)
    if request.merge and request.flat_pairs == "hinged":
        raise HcsearchError("a merged flat pair has no hinge: leave out --merge, or --flat-pairs hinged")
    scene = scene_in(content, base=base, grid=grid)
    return (scene if grid is None else with_size(scene, request.panel, request.across, grid)), tuple(parts)
