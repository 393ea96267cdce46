"""What is deployed, tuned or driven: a folding, an assembly or a file, and the scene it is in."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from hcsearch.assemblies import ASSEMBLIES
from hcsearch.deployment.compiling import compile_scene
from hcsearch.deployment.driving import Drives, drives_in
from hcsearch.deployment.looks import Look, first_look, look_parts, scene_of, springs_of
from hcsearch.deployment.naming import numbered
from hcsearch.deployment.scales import settled
from hcsearch.deployment.scene_files import given_by_user, scene_with
from hcsearch.deployment.springs import with_springs
from hcsearch.errors import HcsearchError, SceneError
from hcsearch.flat_pairs import linkage_joined, scene_joined
from hcsearch.folding import Folding
from hcsearch.labels import labels_of
from hcsearch.linkage import Linkage
from hcsearch.scenes import Scene, panel_of, panel_text
from hcsearch.subjects.designs import folding_named
from hcsearch.subjects.parameters import parameters_of
from hcsearch.subjects.requests import Known, Request, base_scene, known_of
from hcsearch.vocabulary import Formulation


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
    """What a name or a file stands for, in its scene, joined in the way that gave it its status, if a database says."""
    known = known_of(request)
    content, name = known.content, known.name
    if request.name.endswith(".toml") and not {"design", "assembly"} & set(content):
        raise SceneError(f"{request.name} must name a design or an assembly: write design = 'hex:0234550132:4'")
    parameters = dict(content.get("parameters", {}))
    formulation = content.get("formulation")
    if name in ASSEMBLIES:
        sized = request.panel or request.across or known.scene.panel
        if sized or request.merge or request.flat_pairs or "panel_mm" in content or known.parts:
            raise HcsearchError(
                f"{name} is an assembly with sizes of its own: leave out --panel, --across, --flat-pairs, --merge"
            )
        return _driven(_assembly(name, parameters, _changed(known.scene, request), formulation), content)
    if parameters:
        raise HcsearchError(f"{name} is a design, which has no parameters: leave out [parameters], or name an assembly")
    return _driven(_design(_folding(known, request), known, request, formulation), content)


def read_folding(request: Request) -> tuple[Folding, Scene]:
    """The folding that a name or a file stands for, and its scene, in which panels are settled.

    Flat pairs are joined in the way that gave the folding its status, if a database says; else they are open.
    """
    known = known_of(request)
    content = known.content
    if request.name.endswith(".toml"):
        if "design" not in content:
            raise SceneError(f"{request.name} must name a design: write design = 'hex:0234550132:4'")
        if "drive" in content:
            raise SceneError(f"{request.name} has a drive: give it to hcsearch deploy, or leave out its table [drive]")
        if content.get("formulation", "constrained") != "constrained":
            raise SceneError(f"{request.name} has formulation = {content['formulation']!r}: drives need 'constrained'")
    if known.name in ASSEMBLIES:
        raise HcsearchError(
            f"{known.name} is an assembly, which has no packed state in stacks, and no path is planned: name "
            f"DESIGN:CREASE, or see how springs move it with hcsearch deploy {known.name}"
        )
    folding = _folding(known, request)
    scene = _open(known.scene, known.parts, request, folding.circuit.grid.name)
    return folding, scene if known.look is None else scene_joined(scene, known.look.pairs)


def read_scene_of(request: Request, grid: str) -> Scene:
    """The scene that a request asks for of designs of a grid, in which panels are settled and flat pairs open."""
    return _open(*base_scene({}, request, grid), request, grid)


def _open(scene: Scene, parts: tuple[str, ...], request: Request, grid: str) -> Scene:
    if parts:
        raise SceneError(f"{parts[-1]!r} is a way to try a scene: name a scene alone, and --flat-pairs or --merge")
    return replace(_changed(scene, request), panel=panel_of(scene, grid))


def _folding(known: Known, request: Request) -> Folding:
    return folding_named(known.name, request.db) if known.folding is None else known.folding


def _driven(subject: Subject, content: Mapping[str, Any]) -> Subject:
    """The subject with its scene in numbers of the linkage, and the drives of a file, if it has any."""
    drives = drives_in(content["drive"], labels_of(subject.linkage)) if "drive" in content else None
    return replace(subject, scene=numbered(subject.scene, subject.linkage), drives=drives)


def _assembly(name: str, parameters: dict[str, Any], scene: Scene, formulation: Formulation | None) -> Subject:
    assembly = ASSEMBLIES[name]
    linkage = Linkage(assembly.build(parameters_of(assembly, parameters)))
    return Subject(linkage, scene, formulation, {"assembly": name, "parameters": parameters})


def _design(folding: Folding, known: Known, request: Request, formulation: Formulation | None) -> Subject:
    """A folding in a scene, as a look of the stage `deployment` takes it where one gave its status, or is named."""
    parts = list(known.parts)
    pairs, springs = look_parts(parts)
    if parts:
        raise SceneError(f"a scene has no variant {parts[0]!r}: `hcsearch show ID` prints those that were tried")
    scene = _changed(known.scene, request)
    panel = panel_of(scene, folding.circuit.grid.name)
    look = first_look(scene) if known.look is None else known.look
    if springs or (pairs is not None and pairs != look.pairs):
        look = Look(pairs or look.pairs, springs)
    linkage = linkage_joined(folding, panel, look.pairs)
    if not look.first:
        scene = scene_of(settled(scene, linkage), look)
    if look.springs:
        compiled = compile_scene(linkage, scene, keep=frozenset({"stops"}))
        scene = with_springs(compiled, springs_of(folding, compiled, look.springs)).scene
    scene = replace(scene_joined(scene, look.pairs), panel=panel)
    return Subject(linkage, scene, formulation, {"design": folding.notation})


def _changed(scene: Scene, request: Request) -> Scene:
    """A scene with what the options change."""
    values = given_by_user(request.values)
    if request.flat_pairs is not None:
        values["flat_pairs"] = request.flat_pairs
    if request.merge:
        values["merge"] = True
    return scene_with(scene, values)
