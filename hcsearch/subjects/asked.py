"""What a user asks for beside a name: a scene, panels, the joining of flat pairs, and values of the scene."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

from hcsearch import store
from hcsearch.basics.errors import HcsearchError, SceneError
from hcsearch.basics.vocabulary import Way
from hcsearch.scenes import DEFAULT_SCENE_NAME, Scene, panel_of
from hcsearch.scenes.looks import variant_parts
from hcsearch.scenes.scene import with_size
from hcsearch.scenes.scene_file import scene_in, scene_with
from hcsearch.subjects.stored_scenes import read_scene, scene_database

if TYPE_CHECKING:
    from hcsearch.subjects.names import Place

Extent = Literal["folding", "array", "design", "results", "page"]
"""What a design is resolved to: one folding; its array, if no folding is named; all its foldings in a scene; these with
the results that a database has of them; or these with all that a page shows."""


@dataclass(frozen=True)
class Asked:
    """The arguments of `resolve`.

    name : as the user gave it. content : of the file that has this name. scene, panel, flat_pairs, values, path,
    packed, extent, db : as of `resolve`.
    """

    name: str
    content: Mapping[str, Any]
    scene: Scene | str | None
    panel: str | None
    flat_pairs: Way | None
    values: Mapping[str, Any]
    path: bool
    packed: bool
    extent: Extent
    db: Place | None

    def changed(self, scene: Scene) -> Scene:
        """Return the scene with the requested values and joining of flat pairs."""
        changes = {} if self.flat_pairs is None else {"flat_pairs": self.flat_pairs}
        return scene_with(scene, {**self.values, **changes})

    def base_scene(self, database: store.Database | None, grid: str | None = None) -> tuple[Scene, tuple[str, ...]]:
        """Return the scene of a file or name with the requested panels, and the parts of its name for a variant.

        grid : of the design; None for what has panels of its own.
        """
        base: Scene | None = None
        parts: list[str] = []
        text = self.scene
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
        scene = scene_in(self.content, base=base, grid=grid)
        return (scene if grid is None else with_size(scene, self.panel, grid)), tuple(parts)

    def whole_scene(self, database: store.Database | None, grid: str) -> Scene:
        """Return the scene in which all foldings of a design are tried, which is no variant."""
        base, parts = self.base_scene(database, grid)
        if parts:
            raise SceneError(f"{parts[-1]!r} is a variant of a scene: name the scene alone, and --flat-pairs")
        return replace(self.changed(base), panel=panel_of(base, grid))

    def own_scene(self, refusal: str) -> Scene:
        """Return the scene of what has panels and joints of its own; refusal : the error where others are asked for."""
        with scene_database(self.scene, self.db) as (database, _):
            scene, parts = self.base_scene(database)
        if self.panel or scene.panel or self.flat_pairs or "panel_mm" in self.content or parts:
            raise HcsearchError(refusal)
        return self.changed(scene)

    @property
    def formulation_and_drive(self) -> dict[str, Any]:
        """The formulation and the drives that a file names, as arguments of a case."""
        return {"formulation": self.content.get("formulation"), "drive": self.content.get("drive")}

    def without_panel(self) -> Asked:
        """Return the same for panels that are known already."""
        return replace(self, panel=None, content={k: v for k, v in self.content.items() if k != "panel_mm"})
