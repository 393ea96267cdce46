"""Linkages that no file draws as cases: a linkage of Python, and an assembly of the thesis."""

from __future__ import annotations

import math
import re
import shlex
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from hcsearch.basics.errors import HcsearchError
from hcsearch.library.assemblies import ASSEMBLIES, Assembly, Parameters
from hcsearch.scenes import Scene
from hcsearch.scenes.scene import warn_of_panel_size
from hcsearch.shape.linkage import Linkage
from hcsearch.subjects.asked import Asked
from hcsearch.subjects.case import Case, PageFacts
from hcsearch.subjects.stored_scenes import read_scene, scene_database

if TYPE_CHECKING:
    from hcsearch.designs.panel_sizes import PanelSize
    from hcsearch.library.assemblies.description import AssemblyFacts
    from hcsearch.springs.deployment.deployment_facts import Deployed
    from hcsearch.subjects.replay import Replay

LENGTH_PARAMETERS = ("base", "thickness", "side", "width")


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class LinkageCase(Case):
    """A linkage in a scene; given : the linkage."""

    kind = "linkage"
    no_path = "is a linkage, for which no path is planned: name DESIGN:CREASE, or see how springs move it with deploy"

    given: Linkage

    @classmethod
    def claims(cls, subject: object) -> bool:
        """Whether a value is a linkage."""
        return isinstance(subject, Linkage)

    @classmethod
    def read(cls, subject: Linkage, asked: Asked) -> Case:
        """Return the case of a linkage, which has panels of its own."""
        if asked.panel is not None or asked.flat_pairs is not None:
            raise HcsearchError("a Linkage has panels and flat pairs: leave out panel and flat_pairs")
        with scene_database(asked.scene, asked.db) as (database, _):
            scene = asked.scene if isinstance(asked.scene, Scene) else read_scene(asked.scene, database)
        return cls(name=repr(subject), scene=replace(asked.changed(scene), panel=None), given=subject)

    @property
    def entries(self) -> dict[str, Any]:
        """Its representation, which no file can hold."""
        return {"linkage": repr(self.given)}

    @cached_property
    def linkage(self) -> Linkage:
        """The linkage."""
        return self.given


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class AssemblyCase(Case):
    """An assembly in a scene; given : its parameters in degrees, millimetres or columns x rows."""

    kind = "assembly"
    no_path = (
        "is an assembly, for which no path is planned: ask for --motion springs, see how springs move it with "
        "hcsearch deploy {title}, or name DESIGN:CREASE"
    )

    assembly: Assembly
    given: Mapping[str, Any]

    @classmethod
    def claims(cls, subject: object) -> bool:
        """Whether a text is the name of an assembly."""
        return isinstance(subject, str) and subject in ASSEMBLIES

    @classmethod
    def read(cls, subject: str, asked: Asked) -> Case:
        """Return the case of an assembly, which has sizes of its own."""
        if asked.extent == "results" and (asked.scene or asked.panel) and not asked.content:
            raise HcsearchError("the properties of an assembly depend on no scene: add --html, or leave the scene out")
        scene = asked.own_scene(f"{subject} is an assembly with sizes of its own: leave out --panel, --flat-pairs")
        given = dict(asked.content.get("parameters", {}))
        return cls(
            name=asked.name, scene=scene, assembly=ASSEMBLIES[subject], given=given, **asked.formulation_and_drive
        )

    @property
    def entries(self) -> dict[str, Any]:
        """Its name and its parameters."""
        return {"assembly": self.assembly.name, "parameters": dict(self.given)}

    @cached_property
    def linkage(self) -> Linkage:
        """Its panels and hinges."""
        return Linkage(self.assembly.build(self.parameters))

    @property
    def parameters(self) -> Parameters:
        """All its parameters."""
        return parameters_of(self.assembly, self.given)

    @cached_property
    def facts(self) -> AssemblyFacts:
        """Its properties, as of `describe`."""
        from hcsearch.library.assemblies.description import describe_assembly

        return describe_assembly(self.assembly, self.parameters)

    def lines(self) -> Iterator[str]:
        """Yield its properties, as `hcsearch assembly` prints them."""
        from hcsearch.library.assemblies.description import fact_lines

        return fact_lines(self.facts)

    def page_facts(self, deployed: Deployed, subject: str) -> PageFacts:
        """Return its properties; where springs do not bring it flat, also the motion that is followed from packed."""
        from hcsearch.library.assemblies.description import fact_rows, published_rows

        name = self.assembly.name
        flat = (deployed.agreement or deployed.deployment).outcome == "flat"
        followed = None if flat else self._followed()
        return PageFacts(
            title=self.assembly.title,
            facts=self.facts,
            rows=list(fact_rows(self.facts)),
            commands=[
                (f"hcsearch assembly {name}{self._parameter_words}", "prints these properties, also of other sizes"),
                (f"hcsearch motion {subject}", "follows its motion: branches and singular states"),
                (
                    f"hcsearch export {subject} --output {name}.glb",
                    "writes it for other programs, here in three dimensions",
                ),
            ],
            motions=[] if followed is None else [("Motion that is followed", followed, f"hcsearch motion {subject}")],
            notes=self.facts["notes"],
            published=list(published_rows(self.facts)),
        )

    @property
    def _parameter_words(self) -> str:
        """The parameters as words of its command, with a space before each."""
        options = [f" --{name} {shlex.quote(str(value))}" for name, value in self.given.items() if name != "size"]
        return "".join([f" {shlex.quote(str(self.given['size']))}" if "size" in self.given else "", *options])

    def _followed(self) -> Replay | None:
        """Return the replay of the motion that is followed from packed; None where it does not move."""
        from hcsearch.motion.paths.branches import follow_branch
        from hcsearch.motion.paths.linkage_motion import LinkageMotion, row_step
        from hcsearch.motion.paths.start_states import resolve_start
        from hcsearch.subjects.replay_sources import replay_of_motion

        angles, words = resolve_start(self.linkage, self.labels, "folded", stops=True)
        followed = follow_branch(self.linkage, angles, until="end", max_step=row_step(self.linkage))
        motion = LinkageMotion(self.assembly.name, self.linkage, self.labels, words, "end", followed)
        try:
            return replay_of_motion(motion)
        except HcsearchError:
            return None


def assembly_named(name: str) -> Assembly:
    """Return an assembly by its name; HcsearchError for an unknown one."""
    if not AssemblyCase.claims(name):
        raise HcsearchError(f"there is no assembly {name!r}: see hcsearch assembly list")
    return ASSEMBLIES[name]


def parameters_of(assembly: Assembly, given: Mapping[str, Any]) -> Parameters:
    """The default parameters of an assembly, with the given ones replaced: degrees, millimetres, columns x rows.

    HcsearchWarning for lengths that are probably not meant.
    """
    changes: dict[str, Any] = {}
    for name, value in given.items():
        if value is None:
            continue
        if name not in (*LENGTH_PARAMETERS, "alpha", "size"):
            raise HcsearchError(f"assemblies have no {name!r}: they have alpha, size, {', '.join(LENGTH_PARAMETERS)}")
        if name == "size":
            changes[name] = _size(str(value))
        else:
            changes[name] = math.radians(float(value)) if name == "alpha" else 1e-3 * float(value)
    for name in changes:
        if name not in assembly.parameter_names:
            option = "SIZE" if name == "size" else f"--{name}"
            raise HcsearchError(f"{assembly.name} does not depend on {option}: leave it out")
    parameters = replace(assembly.defaults, **changes)
    if changes.keys() & {*LENGTH_PARAMETERS}:
        warn_of_panel_size(_panel(assembly, parameters), None)
    return parameters


def _panel(assembly: Assembly, parameters: Parameters) -> PanelSize:
    """The sizes of an assembly's panels, of triangles the base on both sides."""
    side = parameters.base if "base" in assembly.parameter_names else parameters.side
    return (side, parameters.width if "width" in assembly.parameter_names else side, parameters.thickness)


def _size(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"([0-9]{1,4})x([0-9]{1,4})", text)
    if match is None:
        raise HcsearchError(f"{text!r} is no size: write columns x rows, such as 3x2")
    return int(match[1]), int(match[2])
