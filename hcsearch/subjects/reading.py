"""What is deployed, tuned or driven: a folding, an assembly or a file, and the scene it is in."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from hcsearch.assemblies import ASSEMBLIES
from hcsearch.deployment.compiling import compile_scene
from hcsearch.deployment.driving import Drives, drives_in
from hcsearch.deployment.looks import Look, first_look, look_parts, scene_of, springs_of
from hcsearch.deployment.naming import numbered
from hcsearch.deployment.scales import settled
from hcsearch.deployment.scene_files import checked_scene, given_by_user, read_file, scene_in, scene_with
from hcsearch.deployment.springs import with_springs
from hcsearch.errors import HcsearchError, SceneError
from hcsearch.flat_pairs import linkage_joined
from hcsearch.folding import Folding
from hcsearch.labels import labels_of
from hcsearch.linkage import Linkage
from hcsearch.scenes import DEFAULT, FlatPairs, Scene, panel_of, panel_text
from hcsearch.subjects.designs import folding_named
from hcsearch.subjects.parameters import parameters_of
from hcsearch.subjects.scenes import read_scene, with_size
from hcsearch.vocabulary import Formulation


@dataclass(frozen=True)
class Request:
    """What a user asks for: a name, and what stands beside it.

    name : DESIGN:CREASE, an assembly, or a file .toml. db : the database in which ids and scenes are looked up.
    folding : what is meant, where it need not be read of the name. scene : its name, or itself. panel, across : sizes
    as texts in millimetres. values : more of the scene, by the names of a scene file; panels and hinges by their names.
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


@dataclass(frozen=True)
class Subject:
    """What is deployed, and its scene, in which panels and flat pairs are those of the linkage.

    facts : what it is, in a file. formulation : what a file names, or None. drives : of hinges, if a file has any.
    """

    linkage: Linkage
    scene: Scene
    formulation: Formulation | None
    facts: dict[str, Any]
    drives: Drives | None = None

    @property
    def title(self) -> str:
        """The name of what it is."""
        return str(next(iter(self.facts.values())))

    @property
    def key(self) -> dict[str, Any]:
        """The key of its stored evaluations: what it is, with its sizes."""
        if self.scene.panel is None:
            return self.facts
        return self.facts | {
            "panel_mm": panel_text(self.scene.panel),
            "flat_pairs": self.scene.flat_pairs,
            "merge": self.scene.merge,
        }


def read_subject(request: Request) -> Subject:
    """What a name or a file stands for, in its scene."""
    content: dict[str, Any] = {}
    name = request.name
    if name.endswith(".toml"):
        content = read_file(name)
        if not {"design", "assembly"} & set(content):
            raise SceneError(f"{name} must name a design or an assembly: write design = 'hex:0234550132:4'")
        name = content["design"] if "design" in content else content["assembly"]
    scene, parts = _scene(content, request)
    parameters = dict(content.get("parameters", {}))
    if name in ASSEMBLIES:
        sized = request.panel or request.across or scene.panel
        if sized or request.merge or request.flat_pairs or "panel_mm" in content or parts:
            raise HcsearchError(
                f"{name} is an assembly with sizes of its own: leave out --panel, --across, --flat-pairs, --merge"
            )
        return _driven(_assembly(name, parameters, scene, content.get("formulation")), content)
    if parameters:
        raise HcsearchError(f"{name} is a design, which has no parameters: leave out [parameters], or name an assembly")
    return _driven(_design(_folding(name, request), scene, parts, request, content.get("formulation")), content)


def read_folding(request: Request) -> tuple[Folding, Scene]:
    """The folding that a name or a file stands for, and its scene, in which panels are settled and flat pairs open."""
    content: dict[str, Any] = {}
    name = request.name
    if name.endswith(".toml"):
        content = read_file(name)
        if "design" not in content:
            raise SceneError(f"{name} must name a design: write design = 'hex:0234550132:4'")
        if "drive" in content:
            raise SceneError(f"{name} has a drive: give it to hcsearch deploy, or leave out its table [drive]")
        if content.get("formulation", "constrained") != "constrained":
            raise SceneError(f"{name} has formulation = {content['formulation']!r}: drives need 'constrained'")
        name = content["design"]
    if name in ASSEMBLIES:
        raise HcsearchError(f"{name} is an assembly, which has no packed state in stacks: name DESIGN:CREASE")
    folding = _folding(name, request)
    return folding, _open_scene(content, request, folding.circuit.grid.name)


def read_scene_of(request: Request, grid: str) -> Scene:
    """The scene that a request asks for of designs of a grid, in which panels are settled and flat pairs open."""
    return _open_scene({}, request, grid)


def _open_scene(content: dict[str, Any], request: Request, grid: str) -> Scene:
    scene, parts = _scene(content, request)
    if parts:
        raise SceneError(f"{parts[-1]!r} is a way to try a scene: name a scene alone, and --flat-pairs or --merge")
    scene = with_size(scene, request.panel, request.across, grid)
    return replace(scene, panel=panel_of(scene, grid))


def _folding(name: str, request: Request) -> Folding:
    return folding_named(name, request.db) if request.folding is None else request.folding


def _driven(subject: Subject, content: dict[str, Any]) -> Subject:
    """The subject with its scene in numbers of the linkage, and the drives of a file, if it has any."""
    drives = drives_in(content["drive"], labels_of(subject.linkage)) if "drive" in content else None
    return replace(subject, scene=numbered(subject.scene, subject.linkage), drives=drives)


def _assembly(name: str, parameters: dict[str, Any], scene: Scene, formulation: Formulation | None) -> Subject:
    assembly = ASSEMBLIES[name]
    linkage = Linkage(assembly.build(parameters_of(assembly, parameters)))
    return Subject(linkage, scene, formulation, {"assembly": name, "parameters": parameters})


def _design(
    folding: Folding, scene: Scene, parts: list[str], request: Request, formulation: Formulation | None
) -> Subject:
    """A folding in a scene, as a look of the stage `deployment` takes it where parts of the scene's name say so."""
    pairs, springs = look_parts(parts)
    if parts:
        raise SceneError(f"a scene has no variant {parts[0]!r}: `hcsearch show ID` prints those that were tried")
    scene = with_size(scene, request.panel, request.across, folding.circuit.grid.name)
    panel = panel_of(scene, folding.circuit.grid.name)
    look = first_look(scene)
    if springs or (pairs is not None and pairs != look.pairs):
        look = Look(pairs or look.pairs, springs)
    linkage = linkage_joined(folding, panel, look.pairs)
    way: FlatPairs = "hinged" if look.pairs == "hinged" else "rigid"
    if not look.first:
        scene = scene_of(settled(scene, linkage), look)
    if springs:
        compiled = compile_scene(linkage, scene, keep=frozenset({"stops"}))
        scene = with_springs(compiled, springs_of(folding, compiled, springs)).scene
    scene = replace(scene, panel=panel, flat_pairs=way, merge=look.pairs == "merged")
    return Subject(linkage, scene, formulation, {"design": folding.notation})


def _scene(content: dict[str, Any], request: Request) -> tuple[Scene, list[str]]:
    """The scene of a file or by its name, with what the options change, and parts of the name that say how to look."""
    base: Scene | None = None
    parts: list[str] = []
    if isinstance(text := request.scene, Scene):
        base = checked_scene(text)
    elif text is not None and text.strip():
        named = [part.strip() for part in text.split(",")]
        before = list(named)
        look_parts(named)
        parts = before[len(named) :]
        base = read_scene(", ".join(named) or DEFAULT, request.db)
    elif text is not None:
        base = read_scene(text, request.db)
    scene = scene_in(content, base=base)
    values = given_by_user(request.values)
    if request.merge and request.flat_pairs == "hinged":
        raise HcsearchError("a merged flat pair has no hinge: leave out --merge, or --flat-pairs hinged")
    if request.flat_pairs is not None:
        values["flat_pairs"] = request.flat_pairs
    if request.merge:
        values["merge"] = True
    return scene_with(scene, values), parts
