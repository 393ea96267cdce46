"""Resolution of names, files and values to cases, in one transaction of the database.

All commands that build a linkage begin here, so that drawings, motions and drives of a folding are of one linkage: that
of the stored deployment that deploys, else that of the stored proved path in the requested scene.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from hcsearch.basics.errors import DatabaseError, HcsearchError, NoDatabaseError, QueryError, SceneError
from hcsearch.basics.vocabulary import Way
from hcsearch.cases.case import Case, CaseSubject, NamedAssembly, StoredFolding
from hcsearch.cases.names import Place, database_snapshot, is_id, only_folding, refuse_unknown, stored_circuit
from hcsearch.cases.stored_scenes import only_scene, read_scene
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, folding_of, foldings, split_crease
from hcsearch.library.assemblies import ASSEMBLIES
from hcsearch.scenes import DEFAULT_SCENE_NAME, Scene, panel_of
from hcsearch.scenes.looks import SceneVariant, first_variant, variant_parts
from hcsearch.scenes.scene import with_size
from hcsearch.scenes.scene_file import read_scene_file, scene_file_text, scene_in, scene_with
from hcsearch.shape.linkage import Linkage
from hcsearch.store import (
    Database,
    StoredVerdict,
    best_creases,
    find_circuit,
    find_paths,
    find_scene,
    find_verdict,
    scene_names,
)
from hcsearch.store.failures import retry_if_changed


@retry_if_changed
def resolve(
    what: CaseSubject | Case,
    db: Place | None = None,
    *,
    scene: Scene | str | None = None,
    panel: str | None = None,
    flat_pairs: Way | None = None,
    values: Mapping[str, Any] | None = None,
    path: bool = False,
) -> Case:
    """Resolve a named subject and its scene to a case; a case is returned unchanged.

    what : a text, DESIGN:CREASE, the name of an assembly or a file `.toml`, or a Folding, a Circuit or a Linkage. A
    design without a crease stands for its best folding in the database. If the database has verdicts of only one scene
    and none is named, an id stands for the design in this scene. db : the database in which ids, scenes and verdicts
    are looked up, in one transaction.
    scene : a Scene, the name of one, or a file `.toml`. panel : size of panels in millimetres, such as `50x40x6` or
    `across 1000x20`. flat_pairs : joining of flat pairs. values : of the scene, by the names of a scene file.
    path : whether a design stands for its first folding with a proved path if its best folding has none.

    Errors: HcsearchError for unknown files, scenes, ids and names, and for contradictory arguments.
    """
    if isinstance(what, Case):
        return what
    asked = _Asked(scene, panel, flat_pairs, dict(values or {}), path)
    if isinstance(what, Linkage):
        return _of_linkage(what, asked, db)
    if isinstance(what, Circuit):
        return _of_circuit(what, asked, db)
    folding = what if isinstance(what, Folding) else None
    return _resolved(str(what), asked, db, folding)


def resolve_scene(
    grid: str,
    db: Place | None = None,
    *,
    scene: Scene | str | None = None,
    panel: str | None = None,
    flat_pairs: Way | None = None,
    values: Mapping[str, Any] | None = None,
) -> Scene:
    """Resolve the scene in which all foldings of a design are tried, with panels on a grid; as `resolve` does."""
    asked = _Asked(scene, panel, flat_pairs, dict(values or {}), path=False)
    with database_snapshot(db) as (database, _):
        base, parts = _base_scene({}, asked, database, grid)
    if parts:
        raise SceneError(f"{parts[-1]!r} is a way to try a scene: name a scene alone, and --flat-pairs")
    return replace(asked.changed(base), panel=panel_of(base, grid))


@dataclass(frozen=True)
class _Asked:
    """The arguments of `resolve` beside the name."""

    scene: Scene | str | None
    panel: str | None
    flat_pairs: Way | None
    values: dict[str, Any]
    path: bool

    def changed(self, scene: Scene) -> Scene:
        """Return the scene with the requested values and joining of flat pairs."""
        own = {} if self.flat_pairs is None else {"flat_pairs": self.flat_pairs}
        return scene_with(scene, self.values | own)


def _of_linkage(linkage: Linkage, asked: _Asked, db: Place | None) -> Case:
    if asked.panel is not None or asked.flat_pairs is not None:
        raise HcsearchError("a Linkage has panels and flat pairs: leave out panel and flat_pairs")
    with database_snapshot(db) as (database, _):
        given = asked.scene
        scene = given if isinstance(given, Scene) else read_scene(given, database)
    scene = replace(asked.changed(scene), panel=None)
    return Case(repr(linkage), linkage, scene, first_variant(scene))


def _of_circuit(circuit: Circuit, asked: _Asked, db: Place | None) -> Case:
    """Return the case of a circuit's only or best folding, numbered as in this circuit, canonical or not."""
    case = _resolved(circuit.notation, asked, db, None)
    assert case.folding is not None
    return replace(case, what=next(fold for fold in foldings(circuit) if fold.notation == case.folding.notation))


def _resolved(name: str, asked: _Asked, db: Place | None, folding: Folding | None) -> Case:
    content = read_scene_file(name) if name.endswith(".toml") else {}
    if name.endswith(".toml") and not {"design", "assembly"} & set(content):
        raise SceneError(f"{name} must name a design or an assembly: write design = 'hex:0234550132:4'")
    subject = str(content.get("design", content.get("assembly", name)))
    if folding is None and subject in ASSEMBLIES:
        return _of_assembly(name, subject, content, asked, db)
    if folding is None:
        refuse_unknown(subject)
    if content.get("parameters"):
        raise HcsearchError(
            f"{subject} is a design, which has no parameters: leave out [parameters], or name an assembly"
        )
    text, crease = split_crease(subject if folding is None else folding.notation)
    with database_snapshot(db) as (database, trouble):
        door = _Door(name, content, text, crease, folding, asked)
        if database is None:
            assert trouble is not None
            return door.without(trouble)
        try:
            return door.within(database)
        except DatabaseError as error:
            return door.without(error)


def _of_assembly(name: str, subject: str, content: Mapping[str, Any], asked: _Asked, db: Place | None) -> Case:
    with database_snapshot(db) as (database, _):
        scene, parts = _base_scene(content, asked, database)
    if asked.panel or scene.panel or asked.flat_pairs or "panel_mm" in content or parts:
        raise HcsearchError(f"{subject} is an assembly with sizes of its own: leave out --panel, --flat-pairs")
    scene = asked.changed(scene)
    what = NamedAssembly(subject, dict(content.get("parameters", {})))
    return Case(
        name, what, scene, first_variant(scene), formulation=content.get("formulation"), drive=content.get("drive")
    )


@dataclass(frozen=True)
class _Door:
    """The resolution of a design to a case.

    text : id or notation of the design. crease : of the named folding. folding : a given folding, with its own numbers.
    """

    name: str
    content: Mapping[str, Any]
    text: str
    crease: int | None
    folding: Folding | None
    asked: _Asked
    noted: list[str] = field(default_factory=list)

    def without(self, trouble: DatabaseError) -> Case:
        """Return the case of a notation without a database; raise the database error for an id."""
        if is_id(self.text):
            raise trouble
        noted = (
            [] if isinstance(trouble, NoDatabaseError) else [f"whether the folding was judged is not known: {trouble}"]
        )
        return replace(self, noted=noted).alone(None)

    def alone(self, database: Database | None) -> Case:
        """Return the case of a design that is not in the database."""
        circuit = Circuit.from_notation(self.text).canonical()
        scene, parts = _base_scene(self.content, self.asked, database, circuit.grid.name)
        return self._case(self._named_folding(circuit), scene, parts)

    def within(self, database: Database) -> Case:
        """Return the case of a design, looked up in a database that need not contain it."""
        by_id, asked, door = is_id(self.text) and not self.content, self.asked, self
        if by_id and (asked.scene, asked.panel) == (None, None) and (only := only_scene(database)) is not None:
            self.noted.append(f"scene {only}, the only one that {database.location} has verdicts of")
            door = replace(self, asked=replace(asked, scene=only))
        try:
            number, notation = find_circuit(database, self.text)
        except QueryError:
            if is_id(self.text):
                raise
            return door.alone(database)
        return door.stored(database, number, stored_circuit(database, number, notation), by_id)

    def stored(self, database: Database, number: int, circuit: Circuit, by_id: bool) -> Case:
        """Return the case of a stored design."""
        scene, parts = _base_scene(self.content, self.asked, database, circuit.grid.name)
        names = scene_names(database)
        judged = scene.name in names and _is_stored(database, scene, self.asked, self.name)
        if by_id and names and not judged:
            known = ", ".join(names)
            self.noted.append(f"scene {scene.name}, without verdicts in {database.location}: its scenes are {known}")
        stored = StoredFolding(database.location, number, scene.name if judged else DEFAULT_SCENE_NAME)
        best = best_creases(database, [number], stored.scene).get(number) if self.crease is None else None
        chosen = ""
        if self.folding is None and best is not None and len(folds := foldings(circuit)) > 1:
            chosen = f"folding {best}, the best of {len(folds)}"
        if self.folding is not None or best is None:
            folding = self._named_folding(circuit)
        else:
            folding = folding_of(circuit, best)
        case = replace(self._case(folding, scene, parts), stored=stored, chosen=chosen)
        if not judged:
            return case
        case = self._judged(case, database, number)
        return self._with_path(case, database) if self.asked.path and chosen else case

    def _named_folding(self, circuit: Circuit) -> Folding:
        if self.folding is not None:
            return self.folding
        return only_folding(circuit, self.text) if self.crease is None else folding_of(circuit, self.crease)

    def _case(self, folding: Folding, scene: Scene, parts: tuple[str, ...]) -> Case:
        left = list(parts)
        pairs, springs = variant_parts(left)
        if left:
            raise SceneError(f"a scene has no variant {left[0]!r}: `hcsearch show ID` prints those that were tried")
        scene = self.asked.changed(scene)
        scene = replace(scene, panel=panel_of(scene, folding.circuit.grid.name))
        look = first_variant(scene)
        if springs or (pairs is not None and pairs != look.pairs):
            look = SceneVariant(pairs or look.pairs, springs)
        return Case(
            self.name,
            folding,
            scene,
            look,
            "name" if parts else "scene",
            self.content.get("formulation"),
            self.content.get("drive"),
            noted="; ".join(self.noted),
        )

    def _judged(self, case: Case, database: Database, number: int) -> Case:
        """Return the case with the verdict on its folding and, unless another is requested, the variant behind it."""
        folding, asked = case.folding, self.asked
        assert folding is not None
        assert case.stored is not None
        canonical = Folding.from_notation(folding.notation)
        verdict = find_verdict(database, number, canonical.crease, case.stored.scene)
        stored = replace(case.stored, verdict=verdict)
        case = replace(case, stored=stored)
        if asked.flat_pairs or case.look_of == "name" or verdict is None:
            return case
        look = _look_of(verdict, folding, case.scene)
        if look is not None:
            own_springs = bool({"spring", "springs"} & set(asked.values))
            case = replace(
                case, look=replace(look, springs="", as_written=True) if own_springs else look, look_of="verdict"
            )
        if verdict.path is None or asked.values or folding.circuit != canonical.circuit:
            return case
        if look is not None and case.look.pairs != verdict.path:
            return case
        try:
            paths = find_paths(database, [number], stored.scene)
        except DatabaseError as error:  # many cases need no path
            return replace(case, stored=replace(stored, damage=error))
        path = next((path for path in paths if path.crease == canonical.crease), None)
        return replace(case, stored=replace(stored, path=path))

    def _with_path(self, case: Case, database: Database) -> Case:
        """Return the case of the first folding of the design with a proved path if the best folding has none."""
        best, stored = case.folding, case.stored
        assert best is not None
        assert stored is not None
        if stored.verdict is None or stored.verdict.path is not None:
            return case
        for folding in foldings(best.circuit):
            verdict = find_verdict(database, stored.number, folding.crease, stored.scene)
            if verdict is not None and verdict.path is not None:
                chosen = f"folding {folding.crease}, as no path of the best one, {best.crease}, is proved"
                other = replace(case, what=folding, chosen=chosen, look=first_variant(case.scene), look_of="scene")
                return self._judged(other, database, stored.number)
        return case


def _is_stored(database: Database, scene: Scene, asked: _Asked, name: str) -> bool:
    """Return whether a scene equals the stored scene of its name; one from a file or Python may differ."""
    given = asked.scene
    own = isinstance(given, Scene) or (given or "").endswith(".toml") or name.endswith(".toml")
    return not own or find_scene(database, scene.name) == scene_file_text({}, None, scene)


def _look_of(verdict: StoredVerdict, folding: Folding, scene: Scene) -> SceneVariant | None:
    """Return the variant behind a verdict: that of the deployment that deploys, or of the proved path."""
    if verdict.status == "deploys" and verdict.deployed is not None:
        look = verdict.deployed
        return look if look.is_known and look.pairs in scene.flat_pairs and folding.can_join(look.pairs) else None
    if verdict.status == "movable" and verdict.path is not None and folding.can_join(verdict.path):
        return SceneVariant(verdict.path, as_written=True)
    return None


def _base_scene(
    content: Mapping[str, Any], asked: _Asked, database: Database | None, grid: str | None = None
) -> tuple[Scene, tuple[str, ...]]:
    """Return the scene of a file or name with the requested panels, and the parts of its name that denote a variant.

    grid : of the design; None for an assembly, which has panels of its own.
    """
    base: Scene | None = None
    parts: list[str] = []
    text = asked.scene
    if isinstance(text, Scene):
        base = text
    elif text is not None and text.strip():
        named = [part.strip() for part in text.split(",")]
        before = list(named)
        variant_parts(named)
        parts = before[len(named) :]
        base = read_scene(", ".join(named) or DEFAULT_SCENE_NAME, database, grid)
    elif text is not None:
        base = read_scene(text, database, grid)
    scene = scene_in(content, base=base, grid=grid)
    return (scene if grid is None else with_size(scene, asked.panel, grid)), tuple(parts)
