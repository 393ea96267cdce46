"""Designs as users name them, read to cases in one transaction of the database.

All commands that build a linkage of a folding begin here, so that drawings, motions and drives are of one linkage: that
of the stored deployment that deploys, else that of the stored proved path in the requested scene.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace

from hcsearch import store
from hcsearch.basics.errors import DatabaseError, HcsearchError, NoDatabaseError, QueryError, SceneError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, folding_of, foldings, split_crease
from hcsearch.scenes import DEFAULT_SCENE_NAME, Scene, panel_of
from hcsearch.scenes.looks import first_variant, variant_parts
from hcsearch.scenes.scene_file import scene_file_text
from hcsearch.subjects.asked import Asked
from hcsearch.subjects.case import Case
from hcsearch.subjects.design_cases import CircuitCase, FoldingCase, StoredFolding, tried_variant, variant_of
from hcsearch.subjects.names import (
    database_snapshot,
    is_id,
    only_folding,
    reading_database,
    refuse_unknown,
    stored_circuit,
)
from hcsearch.subjects.replay_sources import folding_of_path
from hcsearch.subjects.stored_designs import stored_design_in
from hcsearch.subjects.stored_scenes import is_scene_file, only_scene, scene_asked_for, scene_database


@dataclass(frozen=True)
class DesignReading:
    """A design that is read.

    text : id or notation of the design. crease : of the named folding. folding : a given folding, with its own numbers.
    notes : for users.
    """

    asked: Asked
    text: str
    crease: int | None
    folding: Folding | None = None
    notes: tuple[str, ...] = ()

    @classmethod
    def claims(cls, subject: object) -> bool:
        """Whether a value is a design or a folding, as what is of no other kind is."""
        return True

    @classmethod
    def read(cls, subject: str | Folding | Circuit, asked: Asked) -> Case:
        """Return the case of a design: of one folding, or of all, as is asked for."""
        if isinstance(subject, Circuit):
            return cls._of_circuit(subject, asked)
        folding = subject if isinstance(subject, Folding) else None
        name = str(subject)
        if folding is None:
            refuse_unknown(name)
        if asked.content.get("parameters"):
            raise HcsearchError(
                f"{name} is a design, which has no parameters: leave out [parameters], or name an assembly"
            )
        reading = cls(asked, *split_crease(name), folding)
        if asked.extent == "folding" or (asked.extent == "array" and reading.crease is not None) or asked.content:
            return reading.one_folding()
        return reading.all_foldings()

    @classmethod
    def _of_circuit(cls, circuit: Circuit, asked: Asked) -> Case:
        """Return the case of a circuit; its only or best folding is numbered as in this circuit, canonical or not."""
        reading = cls(asked, circuit.notation, None)
        if asked.extent != "folding":
            return reading.all_foldings()
        case = reading.one_folding()
        folding = next(fold for fold in foldings(circuit) if fold.notation == case.folding.notation)
        return replace(case, folding=folding)

    def one_folding(self) -> FoldingCase:
        """Return the case of the folding that is named, or of the best one of the design."""
        with database_snapshot(self.asked.db) as (database, trouble):
            return self._folding_in(database, trouble)

    def all_foldings(self) -> CircuitCase:
        """Return the case of the design with all its foldings, or the one that is named."""
        if is_id(self.text):
            with reading_database(self.asked.db) as opened, opened.snapshot() as database:
                number, notation = store.find_circuit(database, self.text)
                return self._stored_design(database, number, stored_circuit(database, number, notation))
        circuit = Circuit.from_notation(self.text).canonical()
        if self.asked.extent != "page":
            return self.design_of(circuit, self.asked, self.crease)
        with database_snapshot(self.asked.db) as (database, trouble):
            design = self.design_of(circuit, self.asked, self.crease, database)
            readings = [self._reading_of(folding, self.asked) for folding in design.foldings]
            return replace(design, cases=[reading._folding_in(database, trouble) for reading in readings])

    @staticmethod
    def design_of(
        circuit: Circuit, asked: Asked, creases: int | Sequence[int] | None, database: store.Database | None = None
    ) -> CircuitCase:
        """Return the case of a design in the scene that is asked for.

        circuit : in canonical order. creases : of its foldings; all unless given. database : if it is open.
        """
        chosen = None if asked.extent == "array" else asked.scene  # an array depends on no scene
        held = nullcontext((database, None)) if database is not None else scene_database(chosen, asked.db)
        with held as (scenes, _):
            scene = Scene() if asked.extent == "array" else asked.whole_scene(scenes, circuit.grid.name)
        return CircuitCase(name=asked.name, scene=scene, given=circuit, foldings=_chosen(circuit, creases))

    @staticmethod
    def _reading_of(folding: Folding, asked: Asked) -> DesignReading:
        """Return the reading of one folding of a design, as if it were named."""
        asked = replace(asked, name=folding.notation, extent="folding")
        return DesignReading(asked, folding.circuit.notation, folding.crease)

    def _stored_design(self, database: store.Database, number: int, circuit: Circuit) -> CircuitCase:
        """Return the case of a design that is named by its id, with its results in the database if these are asked."""
        asked = self.asked
        if asked.extent in ("array", "design"):
            return self.design_of(circuit, asked, self.crease, database)
        named, is_page = asked.scene, asked.extent == "page"
        assert not isinstance(named, Scene)
        scene_name = scene_asked_for(database, named, asked.panel, grid=circuit.grid.name)
        is_named = bool(named or asked.panel)
        stored = stored_design_in(database, number, scene_name, alone=is_named, paths=is_page)
        for path in stored.paths:
            folding_of_path(path, circuit, database.location)
        chosen = _chosen(circuit, self.crease)
        in_scene = replace(asked, scene=scene_name, panel=None)
        readings = [self._reading_of(folding, in_scene) for folding in (chosen if is_page else ())]
        cases = [reading._stored(database, number, circuit, by_id=False) for reading in readings]
        return CircuitCase(
            name=asked.name, scene=stored.values, given=circuit, foldings=chosen, stored=stored, cases=cases
        )

    def _folding_in(self, database: store.Database | None, trouble: DatabaseError | None) -> FoldingCase:
        """Return the case of a folding, looked up in a database if that can be read; trouble : why it cannot."""
        if database is None:
            assert trouble is not None
            return self._without(trouble)
        try:
            return self._within(database)
        except DatabaseError as error:
            return self._without(error)

    def _without(self, trouble: DatabaseError) -> FoldingCase:
        """Return the case of a notation without a database; raise the database error for an id."""
        if is_id(self.text):
            raise trouble
        if isinstance(trouble, NoDatabaseError):
            return self._unstored(None)
        return replace(self, notes=(f"whether the folding was judged is not known: {trouble}",))._unstored(None)

    def _unstored(self, database: store.Database | None) -> FoldingCase:
        """Return the case of a design that is not in the database."""
        circuit = Circuit.from_notation(self.text).canonical()
        scene, parts = self.asked.base_scene(database, circuit.grid.name)
        return self._case(self._named_folding(circuit), scene, parts)

    def _within(self, database: store.Database) -> FoldingCase:
        """Return the case of a design, looked up in a database that need not contain it."""
        by_id, asked, reading = is_id(self.text) and not self.asked.content, self.asked, self
        if by_id and (asked.scene, asked.panel) == (None, None) and (only := only_scene(database)) is not None:
            note = f"scene {only}, the only one that {database.location} has verdicts of"
            reading = replace(self, asked=replace(asked, scene=only), notes=(*self.notes, note))
        try:
            number, notation = store.find_circuit(database, self.text)
        except QueryError:
            if is_id(self.text):
                raise
            return reading._unstored(database)
        return reading._stored(database, number, stored_circuit(database, number, notation), by_id=by_id)

    def _stored(self, database: store.Database, number: int, circuit: Circuit, *, by_id: bool) -> FoldingCase:
        """Return the case of a folding of a stored design."""
        scene, parts = self.asked.base_scene(database, circuit.grid.name)
        names = store.scene_names(database)
        judged = scene.name in names and self._is_stored(database, scene)
        reading = self
        if by_id and names and not judged:
            listed = ", ".join(names)
            note = f"scene {scene.name}, without verdicts in {database.location}: its scenes are {listed}"
            reading = replace(self, notes=(*self.notes, note))
        stored = StoredFolding(database.location, number, scene.name if judged else DEFAULT_SCENE_NAME)
        best = store.best_creases(database, [number], stored.scene).get(number) if self.crease is None else None
        choice = ""
        if self.folding is None and best is not None and len(folds := foldings(circuit)) > 1:
            choice = f"folding {best}, the best of {len(folds)}"
        if self.folding is not None or best is None:
            folding = self._named_folding(circuit)
        else:
            folding = folding_of(circuit, best)
        case = replace(reading._case(folding, scene, parts), stored=stored, chosen=choice)
        if not judged:
            return case
        case = self._judged(case, stored, database)
        if case.stored is not None and case.stored.verdict is not None and self.asked.extent in ("results", "page"):
            design = stored_design_in(database, number, stored.scene, alone=True, paths=self.asked.extent == "page")
            case = replace(case, stored=replace(case.stored, design=design))
        return self._with_path(case, database) if self.asked.path and choice else case

    def _named_folding(self, circuit: Circuit) -> Folding:
        if self.folding is not None:
            return self.folding
        return only_folding(circuit, self.text) if self.crease is None else folding_of(circuit, self.crease)

    def _case(self, folding: Folding, scene: Scene, parts: tuple[str, ...]) -> FoldingCase:
        remaining = list(parts)
        pairs, springs = variant_parts(remaining)
        if remaining:
            raise SceneError(
                f"a scene has no variant {remaining[0]!r}: `hcsearch show ID` prints those that were tried"
            )
        scene = self.asked.changed(scene)
        scene = replace(scene, panel=panel_of(scene, folding.circuit.grid.name))
        return FoldingCase(
            name=self.asked.name,
            folding=folding,
            scene=scene,
            look=variant_of(scene, pairs, springs),
            look_of="name" if parts else "scene",
            noted="; ".join(self.notes),
            **self.asked.formulation_and_drive,
        )

    def _is_stored(self, database: store.Database, scene: Scene) -> bool:
        """Whether a scene equals the stored scene of its name; one from a file or Python may differ."""
        asked = self.asked
        is_custom = isinstance(asked.scene, Scene) or is_scene_file(asked.scene or "") or is_scene_file(asked.name)
        return not is_custom or store.find_scene(database, scene.name) == scene_file_text({}, None, scene)

    def _judged(self, case: FoldingCase, stored: StoredFolding, database: store.Database) -> FoldingCase:
        """Return the case with the verdict on its folding and, unless another is requested, the variant behind it."""
        folding, asked = case.folding, self.asked
        canonical = Folding.from_notation(folding.notation)
        verdict = store.find_verdict(database, stored.number, canonical.crease, stored.scene)
        stored = replace(stored, verdict=verdict)
        case = replace(case, stored=stored)
        if asked.flat_pairs or case.look_of == "name" or verdict is None:
            return case
        variant = tried_variant(verdict, folding, case.scene)
        if variant is not None:
            own_springs = bool({"spring", "springs"} & set(asked.values))
            case = replace(
                case, look=replace(variant, springs="", as_written=True) if own_springs else variant, look_of="verdict"
            )
        if verdict.path_flat_pairs is None or asked.values or folding.circuit != canonical.circuit:
            return case
        if variant is not None and case.look.pairs != verdict.path_flat_pairs:
            return case
        try:
            paths = store.find_paths(database, [stored.number], stored.scene)
        except DatabaseError as error:  # many cases need no path
            return replace(case, stored=replace(stored, damage=error))
        path = next((path for path in paths if path.crease == canonical.crease), None)
        return replace(case, stored=replace(stored, path=path))

    def _with_path(self, case: FoldingCase, database: store.Database) -> FoldingCase:
        """Return the case of the first folding of the design with a proved path if the best folding has none."""
        best, stored = case.folding, case.stored
        assert stored is not None
        if stored.verdict is None or stored.verdict.path_flat_pairs is not None:
            return case
        for folding in foldings(best.circuit):
            verdict = store.find_verdict(database, stored.number, folding.crease, stored.scene)
            if verdict is not None and verdict.path_flat_pairs is not None:
                choice = f"folding {folding.crease}, as no path of the best one, {best.crease}, is proved"
                replacement = replace(
                    case, folding=folding, chosen=choice, look=first_variant(case.scene), look_of="scene"
                )
                return self._judged(replacement, stored, database)
        return case


def _chosen(circuit: Circuit, creases: int | Sequence[int] | None) -> list[Folding]:
    """Return foldings of a circuit by their creases; all unless these are given."""
    if creases is None:
        return foldings(circuit)
    return [folding_of(circuit, crease) for crease in ([creases] if isinstance(creases, int) else creases)]
