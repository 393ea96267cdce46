"""A linkage of Python as a case: springs move it, and its motion can be followed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from hcsearch.basics.errors import HcsearchError
from hcsearch.scenes import Scene
from hcsearch.shape.linkage import Linkage
from hcsearch.subjects.asked import Asked
from hcsearch.subjects.case import Case
from hcsearch.subjects.stored_scenes import read_scene, scene_database


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
