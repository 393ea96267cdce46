"""A case: a folding, an assembly, a drawn pattern or a linkage in a scene, with the stored results on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from hcsearch import store
from hcsearch.basics.errors import DatabaseError, HcsearchError, SceneError
from hcsearch.basics.vocabulary import Formulation, Way
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding
from hcsearch.designs.panel_sizes import PanelSize, panel_text
from hcsearch.library.assemblies import ASSEMBLIES
from hcsearch.scenes import Scene, panel_of
from hcsearch.scenes.looks import SceneVariant, setup_of_variant
from hcsearch.scenes.setup import Setup, setup_of_scene
from hcsearch.shape.labels import Labels, labels_of
from hcsearch.shape.linkage import Linkage
from hcsearch.subjects.names import parameters_of
from hcsearch.subjects.pattern_files import DrawnPattern

if TYPE_CHECKING:
    from hcsearch.springs.deployment.drives import Drives

CaseSubject = str | Folding | Circuit | Linkage
"""The subject of a deployment or tuning: DESIGN:CREASE, an assembly, a file .toml or .fold, or a value."""


@dataclass(frozen=True)
class NamedAssembly:
    """An assembly of the thesis with given parameters in degrees, millimetres or columns x rows."""

    name: str
    parameters: Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class StoredFolding:
    """The stored results on a folding.

    location : of the database, for messages. number : id of the design. scene : name under which verdicts are looked
    up. verdict : on the folding; None before any stage has judged it in this scene. path : the proved path with flat
    pairs joined as in the case; None without one. damage : the error in reading a damaged path.
    """

    location: str
    number: int
    scene: str
    verdict: store.StoredVerdict | None = None
    path: store.StoredPath | None = None
    damage: DatabaseError | None = None


@dataclass(frozen=True, eq=False)
class Case:
    """The subject of a command, in a scene.

    Parameters
    ----------
    name
        The name that the user gave.
    what
        The named subject.
    scene
        The requested scene, with the panels of a folding; its `flat_pairs` are the allowed joinings.
    look
        The variant of the scene: joining of flat pairs, and springs.
    look_of
        Source of the variant: the `scene`, whose first variant it is, the `name` of the scene, or the `verdict` in the
        database.
    formulation, drive
        The formulation and the drives that a file names.
    stored
        Results in a database.
    chosen
        Note on which folding of the design this is, if the name leaves it open.
    noted
        Further notes for users.
    """

    name: str
    what: Folding | NamedAssembly | DrawnPattern | Linkage
    scene: Scene
    look: SceneVariant
    look_of: Literal["scene", "name", "verdict"] = "scene"
    formulation: Formulation | None = None
    drive: Mapping[str, Any] | None = None
    stored: StoredFolding | None = None
    chosen: str = ""
    noted: str = ""

    def __repr__(self) -> str:
        return f"<Case {self.title}, scene {self.scene.name}>"

    @property
    def folding(self) -> Folding | None:
        """The folding; None for assemblies and linkages."""
        return self.what if isinstance(self.what, Folding) else None

    @property
    def facts(self) -> dict[str, Any]:
        """The subject as the entries of a case file; a file has its whole path, from wherever this one is read."""
        if isinstance(self.what, Folding):
            return {"design": self.what.notation}
        if isinstance(self.what, NamedAssembly):
            return {"assembly": self.what.name, "parameters": dict(self.what.parameters)}
        if isinstance(self.what, DrawnPattern):
            path = str(Path(self.what.path).absolute())
            return {"pattern": path} | ({} if self.what.panel is None else {"panel_mm": self.what.panel})
        return {"linkage": repr(self.what)}

    @property
    def title(self) -> str:
        """The name of the subject; of a pattern, that of its file."""
        if isinstance(self.what, DrawnPattern):
            return Path(self.what.path).name
        return str(next(iter(self.facts.values())))

    @property
    def key(self) -> dict[str, Any]:
        """The key of stored evaluations: the subject with its sizes."""
        if self.folding is None:
            return self.facts
        return self.facts | {"panel_mm": panel_text(self.panel), "flat_pairs": self.look.pairs}

    @property
    def panel(self) -> PanelSize:
        """Length, width and thickness of the panels of a folding, m."""
        assert self.folding is not None
        return panel_of(self.scene, self.folding.circuit.grid.name)

    @property
    def joined_scene(self) -> Scene:
        """The scene restricted to the joining of flat pairs of this case."""
        if self.folding is None:
            return self.scene
        return replace(self.scene, panel=self.panel, flat_pairs=(self.look.pairs,))

    @cached_property
    def linkage(self) -> Linkage:
        """The panels and hinges that springs move."""
        if isinstance(self.what, Folding):
            return self.what.linkage(self.panel, flat_pairs=self.look.pairs)
        if isinstance(self.what, NamedAssembly):
            assembly = ASSEMBLIES[self.what.name]
            return Linkage(assembly.build(parameters_of(assembly, self.what.parameters)))
        return Linkage(self.what.packed.pattern) if isinstance(self.what, DrawnPattern) else self.what

    @cached_property
    def labels(self) -> Labels:
        """The names of its panels and hinges."""
        return labels_of(self.linkage, design=True if self.folding is not None else None)

    @cached_property
    def setup(self) -> Setup:
        """The scene in quantities of the linkage, in the variant of this case."""
        setup = setup_of_scene(self.scene, self.linkage)
        if self.folding is None:
            return setup
        setup = setup_of_variant(setup, self.scene, self.look)
        if not self.look.springs:
            return setup
        from hcsearch.springs.deployment.compiled_scene import compile_scene  # noqa: PLC0415 - few cases need the engine
        from hcsearch.springs.deployment.spring_sets import springs_of, with_springs  # noqa: PLC0415

        compiled = compile_scene(self.linkage, setup, keep=frozenset({"stops"}))
        return with_springs(compiled, springs_of(self.folding, self.panel, compiled, self.look.springs)).setup

    @cached_property
    def drives(self) -> Drives | None:
        """The drives of its hinges from a file; None without."""
        if self.drive is None:
            return None
        from hcsearch.springs.deployment.drives import drives_in  # noqa: PLC0415 - few cases need the engine

        return drives_in(self.drive, self.labels)

    @property
    def sentence(self) -> str:
        """Notes for users: chosen folding, scene, joining of flat pairs, and their source."""
        return self.told(self._way())

    @property
    def driven_sentence(self) -> str:
        """The notes for a motion along a path, which has the springs of the scene."""
        return self.told(self._way(with_springs=False))

    def told(self, way: str) -> str:
        """Return the notes with another sentence on the joining of flat pairs."""
        return "; ".join(filter(None, (self.noted, self.chosen, way)))

    def _way(self, *, with_springs: bool = True) -> str:
        """Return the sentence on joining of flat pairs, springs and their source; empty unless from a verdict."""
        if self.look_of != "verdict":
            return ""
        assert self.stored is not None
        assert self.stored.verdict is not None
        if self.stored.verdict.status != "deploys":
            return f"flat pairs {self.look.pairs}, as in the proved path"
        springs = f", springs {self.look.springs}" if self.look.springs and with_springs else ""
        return f"flat pairs {self.look.pairs}{springs}, as in the deployment that deploys"

    @property
    def allowed(self) -> tuple[Way, ...]:
        """The joinings of flat pairs to search for a path: that of the stored verdict, else those of the scene."""
        return (self.look.pairs,) if self.look_of == "verdict" else self.scene.flat_pairs

    def to_move(self) -> Folding:
        """Return the folding for a motion along a path; HcsearchError if the case allows none."""
        if self.folding is None:
            raise HcsearchError(
                f"{self.title} is an assembly, which has no packed state in stacks, and no path is planned: name "
                f"DESIGN:CREASE, or see how springs move it with hcsearch deploy {self.title}"
            )
        self.check_moved()
        return self.folding

    def check_moved(self) -> None:
        """Refuse a case with a drive, a formulation or a variant of a scene, as a motion along a path has none."""
        if self.drive is not None:
            raise SceneError(f"{self.name} has a drive: give it to hcsearch deploy, or leave out its table [drive]")
        if self.formulation not in (None, "constrained"):
            raise SceneError(
                f"{self.name} has formulation = {self.formulation!r}: motions along a path need 'constrained'"
            )
        if self.look_of == "name":
            springs = self.look.springs or self.look.pairs
            raise SceneError(f"{springs!r} is a variant of a scene: name the scene alone, and --flat-pairs")
