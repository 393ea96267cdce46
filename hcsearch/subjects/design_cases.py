"""Designs and foldings as cases, with what a database has of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

from hcsearch import store
from hcsearch.basics.errors import DatabaseError, SceneError
from hcsearch.basics.vocabulary import Way
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, no_folding_reason
from hcsearch.designs.panel_sizes import PanelSize, panel_text
from hcsearch.designs.twisting import twist
from hcsearch.scenes import Scene, panel_of
from hcsearch.scenes.looks import SceneVariant, first_variant, setup_of_variant, variant_parts
from hcsearch.scenes.setup import Setup, setup_of_scene
from hcsearch.shape.linkage import Linkage
from hcsearch.subjects.case import Case, CasePath, MovedCase, Page_co, PageMaker
from hcsearch.subjects.stored_designs import StoredDesign, design_facts, folding_lines, stored_design
from hcsearch.system.work_steps import Progress

if TYPE_CHECKING:
    from hcsearch.search.own_patterns.checked import Checked
    from hcsearch.springs.drive.drive_facts import Drive
    from hcsearch.springs.drive.driven_folding import DriveOptions
    from hcsearch.subjects.replay import Replay


@dataclass(frozen=True, eq=False)
class StoredFolding:
    """The stored results on a folding.

    location : of the database, for messages. number : id of the design. scene : name under which verdicts are looked
    up. verdict : on the folding; None before any stage has judged it in this scene. path : the proved path with flat
    pairs joined as in the case; None without one. damage : the error in reading a damaged path. design : the results
    on its design, if they were asked for.
    """

    location: str
    number: int
    scene: str
    verdict: store.StoredVerdict | None = None
    path: store.StoredPath | None = None
    damage: DatabaseError | None = None
    design: StoredDesign | None = None


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class CircuitCase(Case):
    """A design in a scene.

    given : its circuit, in canonical order. foldings : all, or those that are named. stored : the results in a
    database; None without one, and where they are not looked at. cases : the foldings as cases, for a page.
    """

    kind = "design"
    no_path = "is a circuit, no folding: name one as {title}:CREASE"

    given: Circuit
    foldings: Sequence[Folding]
    stored: StoredDesign | None = None
    cases: Sequence[FoldingCase] = ()

    @property
    def entries(self) -> dict[str, Any]:
        """Its circuit."""
        return {"design": self.given.notation}

    @property
    def circuit(self) -> Circuit:
        """Its circuit, in canonical order."""
        return self.given

    @property
    def array(self) -> Circuit:
        """Its circuit."""
        return self.given

    @property
    def dependencies(self) -> list[str]:
        """Its circuit, on which alone the files of its array depend."""
        return [self.given.notation]

    @cached_property
    def linkage(self) -> Linkage:
        """None: each folding has one."""
        raise self.no_motion()

    @property
    def panel(self) -> PanelSize:
        """Length, width and thickness of its panels, m."""
        return panel_of(self.scene, self.given.grid.name)

    def checked(self, progress: Progress | None = None) -> Checked:
        """Take its foldings through every stage."""
        from hcsearch.search.own_patterns.single_circuits import check_circuit

        reporting = () if progress is None else (progress,)
        return check_circuit(self.given, self.scene, [folding.crease for folding in self.foldings], *reporting)

    def page(self, maker: PageMaker[Page_co]) -> Page_co:
        """Return its page."""
        return maker.design_page(self)

    def sentences(self, folding: Folding) -> Iterator[list[str]]:
        """Yield sentences on the mechanism of a folding and its stored motions, each with its details and commands."""
        from hcsearch.subjects.mechanisms import freedoms_of, lock_sentences

        if twist(folding) == 0:
            yield from ([freedoms.sentence] for freedoms in freedoms_of(folding, self.panel))
            yield from lock_sentences(folding, self.panel)
        if self.stored is not None:
            yield from self.stored.motions(folding)

    @property
    def facts(self) -> dict[str, Any]:
        """The properties of the circuit, and its results in a database."""
        return design_facts(self.given, self.stored)

    def lines(self) -> Iterator[str]:
        """Yield its circuit, then each folding."""
        yield from (f"{label:16}{value}" for label, value in self.facts.items())
        yield "cells           " + "  ".join(",".join(map(str, cell)) for cell in self.given.cells)
        if not self.foldings:
            yield f"\nno two-stack folding: {no_folding_reason(self.given.n)}"
        for folding in self.foldings:
            yield from folding_lines(folding)
            yield from ("\n    ".join([f"  {sentence}", *details]) for sentence, *details in self.sentences(folding))


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class FoldingCase(Case):
    """A folding in a scene, which has the size of its panels; `flat_pairs` of the scene are the allowed joinings.

    folding : the folding. look : the variant of the scene: joining of flat pairs, and springs. look_of : source of the
    variant: the `scene`, whose first variant it is, the `name` of the scene, or the `verdict` in the database. stored :
    results in a database. chosen : note on which folding of the design this is, if the name leaves it open.
    """

    kind = "folding"

    folding: Folding
    look: SceneVariant
    look_of: Literal["scene", "name", "verdict"] = "scene"
    stored: StoredFolding | None = None
    chosen: str = ""

    @property
    def entries(self) -> dict[str, Any]:
        """Its notation."""
        return {"design": self.folding.notation}

    @property
    def key(self) -> dict[str, Any]:
        """The key of stored evaluations: the folding with its sizes."""
        return self.entries | {"panel_mm": panel_text(self.panel), "flat_pairs": self.look.pairs}

    @property
    def panel(self) -> PanelSize:
        """Length, width and thickness of its panels, m."""
        return panel_of(self.scene, self.folding.circuit.grid.name)

    @property
    def joined_scene(self) -> Scene:
        """The scene restricted to the joining of flat pairs of this case."""
        return replace(self.scene, panel=self.panel, flat_pairs=(self.look.pairs,))

    @cached_property
    def linkage(self) -> Linkage:
        """Its panels and hinges, with flat pairs joined as in its variant."""
        return self.folding.linkage(self.panel, flat_pairs=self.look.pairs)

    @property
    def array(self) -> Folding:
        """The folding."""
        return self.folding

    @property
    def circuit(self) -> Circuit:
        """Its circuit."""
        return self.folding.circuit

    @property
    def dependencies(self) -> list[str]:
        """All that files of it depend on, as texts: the stored results, too."""
        parts, stored = [*super().dependencies, repr(self.look)], self.stored
        if stored is not None:
            parts.append(repr(stored.verdict))
            parts += [] if stored.path is None else [repr(stored.path.way), stored.path.states.tobytes().hex()]
        return parts

    def stem(self, number: int) -> str:
        """Return the stem of its files: the id of its design and its crease."""
        return f"{number}-{self.folding.crease}"

    @cached_property
    def setup(self) -> Setup:
        """The scene in quantities of the linkage, in the variant of this case."""
        setup = setup_of_variant(setup_of_scene(self.scene, self.linkage), self.scene, self.look)
        if not self.look.springs:
            return setup
        from hcsearch.springs.deployment.compiled_scene import compile_scene
        from hcsearch.springs.deployment.spring_sets import springs_of, with_springs

        compiled = compile_scene(self.linkage, setup, keep=frozenset({"stops"}))
        return with_springs(compiled, springs_of(self.folding, self.panel, compiled, self.look.springs)).setup

    @property
    def sentence(self) -> str:
        """Notes for users: chosen folding, scene, joining of flat pairs, and their source."""
        return self._told(self._way())

    @property
    def driven_sentence(self) -> str:
        """The notes for a motion along a path, which has the springs of the scene."""
        return self._told(self._way(with_springs=False))

    def _told(self, way: str) -> str:
        """Return the notes with a sentence on the joining of flat pairs."""
        return "; ".join(filter(None, (self.noted, self.chosen, way)))

    def _way(self, *, with_springs: bool = True) -> str:
        """Return the sentence on joining of flat pairs, springs and their source; empty unless from a verdict."""
        if self.look_of != "verdict":
            return ""
        if not self._has_status("deploys"):
            return f"flat pairs {self.look.pairs}, as in the proved path"
        springs = f", springs {self.look.springs}" if self.look.springs and with_springs else ""
        return f"flat pairs {self.look.pairs}{springs}, as in the deployment that deploys"

    def _has_status(self, status: str) -> bool:
        """Whether its stored verdict is this one."""
        return self.stored is not None and self.stored.verdict is not None and self.stored.verdict.status == status

    @property
    def allowed(self) -> tuple[Way, ...]:
        """The joinings of flat pairs to search for a path: that of the stored verdict, else those of the scene."""
        return (self.look.pairs,) if self.look_of == "verdict" else self.scene.flat_pairs

    def in_variant(self, name: str) -> FoldingCase:
        """Return the case in the variant that the name of a scene ends with; this case without one."""
        pairs, springs = variant_parts([part.strip() for part in name.split(",")])
        if pairs is None and not springs:
            return self
        return replace(self, look=variant_of(self.scene, pairs, springs), look_of="name")

    def check_moved(self) -> None:
        """Refuse a case with a drive, a formulation or a variant of a scene, as a motion along a path has none."""
        super().check_moved()
        if self.look_of == "name":
            springs = self.look.springs or self.look.pairs
            raise SceneError(f"{springs!r} is a variant of a scene: name the scene alone, and --flat-pairs")

    def path(self) -> CasePath:
        """Plan its motion.

        Springs may open a folding with one joining of flat pairs while its path is proved with another. The joining of
        the springs is tried first, so that all results are of one linkage; the other only if no path is proved.
        """
        from hcsearch.springs.drive.driven_folding import find_drive_motion

        first = self.first_path()
        way = None if self.stored is None or self.stored.verdict is None else self.stored.verdict.path_flat_pairs
        if first.motion.margin is not None or self.look_of != "verdict" or way in (None, self.look.pairs):
            return first
        scene = replace(self.scene, flat_pairs=(way,))
        proved = find_drive_motion(self.folding, scene)
        if proved.margin is None:
            return first
        note = f"flat pairs {way}, as in the proved path: none is proved with flat pairs {self.look.pairs}"
        return CasePath(scene, proved, self._told(note))

    def first_path(self) -> CasePath:
        """Plan its motion only with the joining of flat pairs of its status."""
        from hcsearch.springs.drive.driven_folding import find_drive_motion

        self.check_moved()
        scene = replace(self.scene, flat_pairs=self.allowed)
        return CasePath(scene, find_drive_motion(self.folding, scene), self.driven_sentence)

    def path_linkage(self, path: CasePath) -> Linkage:
        """Return the linkage with flat pairs joined as in a path."""
        assert path.motion.way is not None
        return self.folding.linkage(self.panel, flat_pairs=path.motion.way)

    def unproved(self, path: CasePath) -> str:
        """Return a sentence on why no path is proved."""
        from hcsearch.springs.drive.driven_folding import no_drive_reason

        return no_drive_reason(self.folding, path.scene, path.motion)

    def stored_replay(self) -> Replay | None:
        """Return the replay of its stored proved path; None without one."""
        from hcsearch.subjects.replay_sources import replay_of_stored_path

        if self.stored is not None and self.stored.damage is not None:
            raise self.stored.damage
        if self.stored is None or self.stored.path is None:
            return None
        return replay_of_stored_path(self.stored.path, self.folding, self.panel, self.stored.location)

    def travel(self) -> MovedCase:
        """Return its travel: by the motion that gave its status, else by springs, else along a planned path."""
        if self.look_of != "name":
            self.check_moved()
        unopened = ""
        if not self._has_status("movable"):
            by_springs = self.travel_by_springs()
            if isinstance(by_springs, MovedCase):
                return by_springs
            unopened = by_springs
        if self.stored is not None and self.stored.damage is not None:
            raise self.stored.damage
        return self.travel_by_path(unopened)

    def travel_by_path(self, unopened: str) -> MovedCase:
        """Return its travel along its stored path, else along a proved one; unopened : why springs do not move it."""
        from hcsearch.springs.flight.travel import travel_along

        stored = None if self.stored is None else self.stored.path
        if stored is not None and stored.way is not None:
            way, states, note = stored.way, stored.states, self.driven_sentence
        else:
            _, motion, note = self.path()
            if motion.margin is None or motion.way is None or motion.states is None:
                raise self.no_travel(unopened)
            way, states = motion.way, motion.states
        linkage = self.folding.linkage(self.panel, flat_pairs=way)
        scene = replace(self.joined_scene, flat_pairs=(way,))
        source = f"{unopened}{note or f'a proved path, flat pairs {way}'}"
        return MovedCase(travel_along(linkage, self.scene, states), scene, source)

    def driven(self, path: CasePath, options: DriveOptions | None, progress: Progress | None) -> Drive:
        """Choose motors that open it along a path; NoPathError where none is proved."""
        from hcsearch.springs.drive.driven_folding import drive_along

        return drive_along(self.folding, path.scene, path.motion, options, progress)

    def certificate(self, budget: int, progress: Progress | None) -> tuple[dict[str, Any], list[str]]:
        """Prove a path or a lock."""
        from hcsearch.motion.certificates.certifying import prove_folding

        self.check_moved()
        return prove_folding(self.folding, self.panel, self.allowed, self.scene.margin, budget)

    def checked(self, progress: Progress | None = None) -> Checked:
        """Take it through every stage."""
        self.check_moved()
        return self._alone(None).checked(progress)

    def shown(self) -> CircuitCase:
        """Return its design, with this folding alone, and the results on it in its scene."""
        stored = self.stored
        if stored is None or stored.verdict is None:
            return self._alone(None)
        design = stored.design or stored_design(stored.number, stored.location, stored.scene)
        return self._alone(design)

    def page(self, maker: PageMaker[Page_co]) -> Page_co:
        """Return the page of its design, with this folding alone; with a drive of its own, no stored result is its."""
        is_own = self.drive is not None or self.formulation is not None
        return (self._alone(None) if is_own else self.shown()).page(maker)

    def _alone(self, stored: StoredDesign | None) -> CircuitCase:
        folding = Folding.from_notation(self.folding.notation)
        return CircuitCase(
            name=self.name, scene=self.scene, given=folding.circuit, foldings=[folding], stored=stored, cases=[self]
        )


def variant_of(scene: Scene, pairs: Way | None, springs: str) -> SceneVariant:
    """Return the variant of a scene with a joining of flat pairs, by default the first one, and named springs."""
    first = first_variant(scene)
    is_first = not springs and pairs in (None, first.pairs)
    return first if is_first else SceneVariant(pairs or first.pairs, springs)


def tried_variant(verdict: store.StoredVerdict, folding: Folding, scene: Scene) -> SceneVariant | None:
    """Return the variant behind a verdict: that of the deployment that deploys, or of the proved path."""
    if verdict.status == "deploys" and verdict.deployed_variant is not None:
        variant = verdict.deployed_variant
        known = variant.is_known and variant.pairs in scene.flat_pairs and folding.can_join(variant.pairs)
        return variant if known else None
    way = verdict.path_flat_pairs
    if verdict.status == "movable" and way is not None and folding.can_join(way):
        return SceneVariant(way, as_written=True)
    return None
