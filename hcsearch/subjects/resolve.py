"""Resolution of names, files and values to cases, in one transaction of the database.

All commands that build a linkage begin here, so that drawings, motions and drives of a folding are of one linkage: that
of the stored deployment that deploys, else that of the stored proved path in the requested scene.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from hcsearch import store
from hcsearch.basics.errors import DatabaseError, HcsearchError, NoDatabaseError, PatternError, QueryError, SceneError
from hcsearch.basics.vocabulary import Way
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, folding_of, foldings, split_crease
from hcsearch.library.assemblies import ASSEMBLIES
from hcsearch.scenes import DEFAULT_SCENE_NAME, Scene, panel_of
from hcsearch.scenes.looks import SceneVariant, first_variant, variant_parts
from hcsearch.scenes.scene import with_size
from hcsearch.scenes.scene_file import SUBJECT_KEYS, read_scene_file, scene_file_text, scene_in, scene_with
from hcsearch.scenes.values import shown_value
from hcsearch.shape.linkage import Linkage
from hcsearch.store.failures import retry_if_changed
from hcsearch.subjects.case import Case, CaseSubject, NamedAssembly, StoredFolding
from hcsearch.subjects.databases import Place, database_snapshot
from hcsearch.subjects.names import is_id, only_folding, refuse_unknown, stored_circuit
from hcsearch.subjects.pattern_files import (
    PATTERN_SUFFIXES,
    DrawnPattern,
    is_pattern_file,
    only_drawn_folding,
    read_pattern_file,
)
from hcsearch.subjects.stored_scenes import only_scene, read_scene, scene_database
from hcsearch.system.terminal import write_notice


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
    packed: bool = True,
) -> Case:
    """Resolve a named subject and its scene to a case; a case is returned unchanged.

    Parameters
    ----------
    what
        A text, DESIGN:CREASE, the name of an assembly, a file `NAME.toml` or a pattern as `check` takes it, or a
        Folding, a Circuit or a Linkage. A design without a crease stands for its best folding in the database. If the
        database has verdicts of only one scene and none is named, an id stands for the design in this scene.
    db
        The database in which ids, scenes and verdicts are looked up, in one transaction.
    scene
        A Scene, the name of one, or a file `NAME.toml`.
    panel
        Size of panels in millimetres, such as `50x40x6` or `across 1000x20`.
    flat_pairs
        Joining of flat pairs.
    values
        Values of the scene, by the names of a scene file.
    path
        Whether a design stands for its first folding with a proved path if its best folding has none.
    packed
        Whether a drawn pattern must have a packed state; else a line on standard error says that it has none.

    Returns
    -------
    Case
        The subject in its scene.

    Raises
    ------
    HcsearchError
        For unknown files, scenes, ids and names, and for contradictory arguments.
    """
    if isinstance(what, Case):
        return what
    arguments = _Arguments(scene, panel, flat_pairs, dict(values or {}), path, packed)
    if isinstance(what, Linkage):
        return _of_linkage(what, arguments, db)
    if isinstance(what, Circuit):
        return _of_circuit(what, arguments, db)
    folding = what if isinstance(what, Folding) else None
    return _resolved(str(what), arguments, db, folding)


def resolve_scene(
    grid: str,
    db: Place | None = None,
    *,
    scene: Scene | str | None = None,
    panel: str | None = None,
    flat_pairs: Way | None = None,
    values: Mapping[str, Any] | None = None,
) -> Scene:
    """Resolve the scene in which all foldings of a design are tried, with panels on a grid; as `resolve`."""
    arguments = _Arguments(scene, panel, flat_pairs, dict(values or {}), path=False)
    with scene_database(scene, db) as (database, _):
        base, parts = _base_scene({}, arguments, database, grid)
    if parts:
        raise SceneError(f"{parts[-1]!r} is a variant of a scene: name the scene alone, and --flat-pairs")
    return replace(arguments.changed(base), panel=panel_of(base, grid))


def resolve_pattern(
    drawn: DrawnPattern,
    db: Place | None = None,
    *,
    scene: Scene | str | None = None,
    flat_pairs: Way | None = None,
    values: Mapping[str, Any] | None = None,
) -> Case:
    """Resolve a drawn pattern and its scene to a case, as `resolve`; it need not have a packed state."""
    return _of_pattern(drawn.path, drawn, {}, _Arguments(scene, None, flat_pairs, dict(values or {}), path=False), db)


@dataclass(frozen=True)
class _Arguments:
    """The arguments of `resolve` beside the name."""

    scene: Scene | str | None
    panel: str | None
    flat_pairs: Way | None
    values: dict[str, Any]
    path: bool
    packed: bool = True

    def changed(self, scene: Scene) -> Scene:
        """Return the scene with the requested values and joining of flat pairs."""
        changes = {} if self.flat_pairs is None else {"flat_pairs": self.flat_pairs}
        return scene_with(scene, self.values | changes)


def _of_linkage(linkage: Linkage, arguments: _Arguments, db: Place | None) -> Case:
    if arguments.panel is not None or arguments.flat_pairs is not None:
        raise HcsearchError("a Linkage has panels and flat pairs: leave out panel and flat_pairs")
    named = arguments.scene
    with scene_database(named, db) as (database, _):
        scene = named if isinstance(named, Scene) else read_scene(named, database)
    scene = replace(arguments.changed(scene), panel=None)
    return Case(repr(linkage), linkage, scene, first_variant(scene))


def _of_circuit(circuit: Circuit, arguments: _Arguments, db: Place | None) -> Case:
    """Return the case of a circuit's only or best folding, numbered as in this circuit, canonical or not."""
    case = _resolved(circuit.notation, arguments, db, None)
    assert case.folding is not None
    return replace(case, what=next(fold for fold in foldings(circuit) if fold.notation == case.folding.notation))


def _resolved(name: str, arguments: _Arguments, db: Place | None, folding: Folding | None) -> Case:
    content = read_scene_file(name) if name.endswith(".toml") else {}
    if name.endswith(".toml") and not {*SUBJECT_KEYS} & set(content):
        raise SceneError(f"{name} must name a design, an assembly or a pattern: write design = 'hex:0234550132:4'")
    key = next((key for key in SUBJECT_KEYS if key in content), None)
    subject = name if key is None else str(content[key])
    if key is not None:
        _check_key(name, key, subject)
    if folding is None and subject in ASSEMBLIES:
        return _of_assembly(name, subject, content, arguments, db)
    if folding is None and is_pattern_file(subject):
        if name.endswith(".toml"):  # as other files that a scene file names
            subject = str(Path(name).parent / Path(subject).expanduser())
        return _of_pattern_file(name, subject, content, arguments, db)
    if folding is None:
        refuse_unknown(subject)
    if content.get("parameters"):
        raise HcsearchError(
            f"{subject} is a design, which has no parameters: leave out [parameters], or name an assembly"
        )
    return _of_design(name, subject if folding is None else folding.notation, content, arguments, db, folding)


def _check_key(path: str, key: str, subject: str) -> None:
    """Refuse a scene file that names what is deployed by the key of another kind."""
    is_design = is_id(subject) or ":" in subject
    fits = "assembly" if subject in ASSEMBLIES else "pattern" if is_pattern_file(subject) else "design"
    if fits != key and (fits != "design" or is_design):
        raise SceneError(f"{path} has {key} = {shown_value(subject)}: write {fits} = {shown_value(subject)}")
    if key == "pattern" and fits != "pattern":
        raise SceneError(f"{path} has pattern = {shown_value(subject)}: name a file {', '.join(PATTERN_SUFFIXES)}")


def _of_design(
    name: str,
    subject: str,
    content: Mapping[str, Any],
    arguments: _Arguments,
    db: Place | None,
    folding: Folding | None,
) -> Case:
    text, crease = split_crease(subject)
    with database_snapshot(db) as (database, trouble):
        resolution = _DesignResolution(name, content, text, crease, folding, arguments)
        if database is None:
            assert trouble is not None
            return resolution.without(trouble)
        try:
            return resolution.within(database)
        except DatabaseError as error:
            return resolution.without(error)


def _of_assembly(name: str, subject: str, content: Mapping[str, Any], arguments: _Arguments, db: Place | None) -> Case:
    with scene_database(arguments.scene, db) as (database, _):
        scene, parts = _base_scene(content, arguments, database)
    if arguments.panel or scene.panel or arguments.flat_pairs or "panel_mm" in content or parts:
        raise HcsearchError(f"{subject} is an assembly with sizes of its own: leave out --panel, --flat-pairs")
    scene = arguments.changed(scene)
    what = NamedAssembly(subject, dict(content.get("parameters", {})))
    return Case(
        name, what, scene, first_variant(scene), formulation=content.get("formulation"), drive=content.get("drive")
    )


def _of_pattern_file(name: str, path: str, content: Mapping[str, Any], arguments: _Arguments, db: Place | None) -> Case:
    """Return the case of the folding that a file draws, or of its pattern; PatternError without a packed state."""
    panel = arguments.panel or content.get("panel_mm")
    if not isinstance(panel, str | None):
        raise SceneError(f"{name} has panel_mm = {panel!r}: write a text, such as panel_mm = '80x8'")
    drawn = read_pattern_file(path, panel)
    if isinstance(drawn, DrawnPattern):
        if not drawn.packed.packed and arguments.packed:
            raise PatternError(
                f"{path}: {drawn.packed.sentence}; see hcsearch check {path}, or follow motions from the flat state by "
                "hcsearch motion --from flat"
            )
        if not drawn.packed.packed:
            write_notice(f"{path}: {drawn.packed.sentence}")
        case = _of_pattern(name, drawn, content, arguments, db)
        if drawn.packed.assumed:
            write_notice(f"{path}: {drawn.packed.assumed}")
        return case
    notation = only_drawn_folding(drawn)
    content = {key: value for key, value in content.items() if key != "panel_mm"}
    case = _of_design(notation, notation, content, replace(arguments, panel=drawn.panel), db, None)
    return replace(case, noted="; ".join(filter(None, (f"{path} is the folding {notation}", case.noted))))


def _of_pattern(
    name: str, drawn: DrawnPattern, content: Mapping[str, Any], arguments: _Arguments, db: Place | None
) -> Case:
    """Return the case of a drawn pattern in the scene that is asked for; a line says why it is no design."""
    content = {key: value for key, value in content.items() if key != "panel_mm"}
    arguments = replace(arguments, panel=None)
    with scene_database(arguments.scene, db) as (database, _):
        scene, parts = _base_scene(content, arguments, database)
    if scene.panel or arguments.flat_pairs or parts:
        raise HcsearchError(
            f"{drawn.path} has panels and joints of its own: leave out --flat-pairs, and name a scene without panels"
        )
    scene = arguments.changed(scene)
    formulation, drive = content.get("formulation"), content.get("drive")
    write_notice(f"{drawn.path} {drawn.no_design}")
    return Case(name, drawn, scene, first_variant(scene), formulation=formulation, drive=drive)


@dataclass(frozen=True)
class _DesignResolution:
    """The resolution of a design to a case.

    text : id or notation of the design. crease : of the named folding. folding : a given folding, with its own numbers.
    """

    name: str
    content: Mapping[str, Any]
    text: str
    crease: int | None
    folding: Folding | None
    arguments: _Arguments
    noted: list[str] = field(default_factory=list)

    def without(self, trouble: DatabaseError) -> Case:
        """Return the case of a notation without a database; raise the database error for an id."""
        if is_id(self.text):
            raise trouble
        notes = (
            [] if isinstance(trouble, NoDatabaseError) else [f"whether the folding was judged is not known: {trouble}"]
        )
        return replace(self, noted=notes).alone(None)

    def alone(self, database: store.Database | None) -> Case:
        """Return the case of a design that is not in the database."""
        circuit = Circuit.from_notation(self.text).canonical()
        scene, parts = _base_scene(self.content, self.arguments, database, circuit.grid.name)
        return self._case(self._named_folding(circuit), scene, parts)

    def within(self, database: store.Database) -> Case:
        """Return the case of a design, looked up in a database that need not contain it."""
        by_id, arguments, resolution = is_id(self.text) and not self.content, self.arguments, self
        if by_id and (arguments.scene, arguments.panel) == (None, None) and (only := only_scene(database)) is not None:
            self.noted.append(f"scene {only}, the only one that {database.location} has verdicts of")
            resolution = replace(self, arguments=replace(arguments, scene=only))
        try:
            number, notation = store.find_circuit(database, self.text)
        except QueryError:
            if is_id(self.text):
                raise
            return resolution.alone(database)
        return resolution.stored(database, number, stored_circuit(database, number, notation), by_id)

    def stored(self, database: store.Database, number: int, circuit: Circuit, by_id: bool) -> Case:
        """Return the case of a stored design."""
        scene, parts = _base_scene(self.content, self.arguments, database, circuit.grid.name)
        names = store.scene_names(database)
        judged = scene.name in names and _is_stored(database, scene, self.arguments, self.name)
        if by_id and names and not judged:
            listed = ", ".join(names)
            self.noted.append(f"scene {scene.name}, without verdicts in {database.location}: its scenes are {listed}")
        stored = StoredFolding(database.location, number, scene.name if judged else DEFAULT_SCENE_NAME)
        best = store.best_creases(database, [number], stored.scene).get(number) if self.crease is None else None
        choice = ""
        if self.folding is None and best is not None and len(folds := foldings(circuit)) > 1:
            choice = f"folding {best}, the best of {len(folds)}"
        if self.folding is not None or best is None:
            folding = self._named_folding(circuit)
        else:
            folding = folding_of(circuit, best)
        case = replace(self._case(folding, scene, parts), stored=stored, chosen=choice)
        if not judged:
            return case
        case = self._judged(case, database, number)
        return self._with_path(case, database) if self.arguments.path and choice else case

    def _named_folding(self, circuit: Circuit) -> Folding:
        if self.folding is not None:
            return self.folding
        return only_folding(circuit, self.text) if self.crease is None else folding_of(circuit, self.crease)

    def _case(self, folding: Folding, scene: Scene, parts: tuple[str, ...]) -> Case:
        remaining = list(parts)
        pairs, springs = variant_parts(remaining)
        if remaining:
            raise SceneError(
                f"a scene has no variant {remaining[0]!r}: `hcsearch show ID` prints those that were tried"
            )
        scene = self.arguments.changed(scene)
        scene = replace(scene, panel=panel_of(scene, folding.circuit.grid.name))
        variant = first_variant(scene)
        if springs or (pairs is not None and pairs != variant.pairs):
            variant = SceneVariant(pairs or variant.pairs, springs)
        return Case(
            self.name,
            folding,
            scene,
            variant,
            "name" if parts else "scene",
            self.content.get("formulation"),
            self.content.get("drive"),
            noted="; ".join(self.noted),
        )

    def _judged(self, case: Case, database: store.Database, number: int) -> Case:
        """Return the case with the verdict on its folding and, unless another is requested, the variant behind it."""
        folding, arguments = case.folding, self.arguments
        assert folding is not None
        assert case.stored is not None
        canonical = Folding.from_notation(folding.notation)
        verdict = store.find_verdict(database, number, canonical.crease, case.stored.scene)
        stored = replace(case.stored, verdict=verdict)
        case = replace(case, stored=stored)
        if arguments.flat_pairs or case.look_of == "name" or verdict is None:
            return case
        variant = _variant_of(verdict, folding, case.scene)
        if variant is not None:
            own_springs = bool({"spring", "springs"} & set(arguments.values))
            case = replace(
                case, look=replace(variant, springs="", as_written=True) if own_springs else variant, look_of="verdict"
            )
        if verdict.path_flat_pairs is None or arguments.values or folding.circuit != canonical.circuit:
            return case
        if variant is not None and case.look.pairs != verdict.path_flat_pairs:
            return case
        try:
            paths = store.find_paths(database, [number], stored.scene)
        except DatabaseError as error:  # many cases need no path
            return replace(case, stored=replace(stored, damage=error))
        path = next((path for path in paths if path.crease == canonical.crease), None)
        return replace(case, stored=replace(stored, path=path))

    def _with_path(self, case: Case, database: store.Database) -> Case:
        """Return the case of the first folding of the design with a proved path if the best folding has none."""
        best, stored = case.folding, case.stored
        assert best is not None
        assert stored is not None
        if stored.verdict is None or stored.verdict.path_flat_pairs is not None:
            return case
        for folding in foldings(best.circuit):
            verdict = store.find_verdict(database, stored.number, folding.crease, stored.scene)
            if verdict is not None and verdict.path_flat_pairs is not None:
                choice = f"folding {folding.crease}, as no path of the best one, {best.crease}, is proved"
                replacement = replace(
                    case, what=folding, chosen=choice, look=first_variant(case.scene), look_of="scene"
                )
                return self._judged(replacement, database, stored.number)
        return case


def _is_stored(database: store.Database, scene: Scene, arguments: _Arguments, name: str) -> bool:
    """Return whether a scene equals the stored scene of its name; one from a file or Python may differ."""
    scene_argument = arguments.scene
    is_custom = isinstance(scene_argument, Scene) or (scene_argument or "").endswith(".toml") or name.endswith(".toml")
    return not is_custom or store.find_scene(database, scene.name) == scene_file_text({}, None, scene)


def _variant_of(verdict: store.StoredVerdict, folding: Folding, scene: Scene) -> SceneVariant | None:
    """Return the variant behind a verdict: that of the deployment that deploys, or of the proved path."""
    if verdict.status == "deploys" and verdict.deployed_variant is not None:
        variant = verdict.deployed_variant
        return (
            variant
            if variant.is_known and variant.pairs in scene.flat_pairs and folding.can_join(variant.pairs)
            else None
        )
    if (
        verdict.status == "movable"
        and verdict.path_flat_pairs is not None
        and folding.can_join(verdict.path_flat_pairs)
    ):
        return SceneVariant(verdict.path_flat_pairs, as_written=True)
    return None


def _base_scene(
    content: Mapping[str, Any], arguments: _Arguments, database: store.Database | None, grid: str | None = None
) -> tuple[Scene, tuple[str, ...]]:
    """Return the scene of a file or name with the requested panels, and the parts of its name that denote a variant.

    grid : of the design; None for an assembly, which has panels of its own.
    """
    base: Scene | None = None
    parts: list[str] = []
    text = arguments.scene
    if isinstance(text, Scene):
        base = text
    elif text is not None and text.strip():
        remaining = [part.strip() for part in text.split(",")]
        all_parts = list(remaining)
        variant_parts(remaining)
        parts = all_parts[len(remaining) :]
        base = read_scene(", ".join(remaining) or DEFAULT_SCENE_NAME, database, grid)
    elif text is not None:
        base = read_scene(text, database, grid)
    scene = scene_in(content, base=base, grid=grid)
    return (scene if grid is None else with_size(scene, arguments.panel, grid)), tuple(parts)
