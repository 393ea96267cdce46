"""What can be deployed: a folding, or a file that names one with a scene of its own."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from hcsearch.errors import HcsearchError
from hcsearch.folding import Folding
from hcsearch.linkage import Linkage
from hcsearch.scenes import SCENES, PanelSize, Scene, default_panel


def folding_linkage(
    folding: Folding, panel: PanelSize | None = None, *, hinged: bool = False, merged: bool = False
) -> Linkage:
    """A folding as a linkage whose base is its bottom pair.

    panel : length, width, thickness (m), those of the scene `default` unless given. hinged : flat pairs hinged, not
    rigid. merged : mirror pairs of panels made one.
    """
    pattern = folding.pattern(panel or default_panel(folding.circuit.grid.name), hinged=hinged, merged=merged)
    return Linkage(pattern, base=pattern.panel_of[folding.crease])


def scene_named(name: str) -> Scene:
    """A scene by its name."""
    if name not in SCENES:
        raise HcsearchError(f"there is no scene {name!r}: choose one of {', '.join(SCENES)}")
    return SCENES[name]


def scene_with(scene: Scene, values: Mapping[str, Any]) -> Scene:
    """A scene with some values changed, as a file or a command line gives them."""
    known = {field.name for field in fields(Scene)} - {"name"}
    changes: dict[str, Any] = {}
    for key, value in values.items():
        if key not in known:
            raise HcsearchError(f"a scene has no {key!r}: it has {', '.join(sorted(known))}")
        changes[key] = _read(key, value)
    return replace(scene, **changes)


def _read(key: str, value: Any) -> Any:
    """One value of a scene; HcsearchError where it is of another kind."""
    try:
        if key in {"gravity", "base_inertia"}:
            found = tuple(float(number) for number in value)
            if len(found) != 3:
                raise ValueError
            return found
        if key == "springs":
            return tuple((int(hinge), str(law)) for hinge, law in dict(value).items())
        if key == "spring":
            return str(value)
        if key == "held":
            return value if value in {"bottom", "free"} else int(value)
        number = float(value)
    except (TypeError, ValueError) as error:
        raise HcsearchError(f"{key} cannot be {value!r}: see the scenes of docs/dynamics.md") from error
    if not -1e12 < number < 1e12 or (number < 0.0):
        raise HcsearchError(f"{key} cannot be {value!r}: give a number of 0 or more")
    return number


def read_file(path: str) -> dict[str, Any]:
    """A TOML file with `design` or `assembly`, and tables `[panel]`, `[parameters]` and `[scene]` where wanted."""
    try:
        with Path(path).open("rb") as file:
            found = tomllib.load(file)
    except OSError as error:
        raise HcsearchError(f"cannot read {path}: {error.strerror}; name a file that is there") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise HcsearchError(f"{path} is no TOML: {error}; write lines such as design = 'hex:0234550132:4'") from error
    unknown = set(found) - {"design", "assembly", "parameters", "scene", "flat_pairs", "merge", "panel_mm"}
    if unknown:
        raise HcsearchError(f"{path} has {min(unknown)!r}, which nothing reads: see docs/dynamics.md")
    if ("design" in found) == ("assembly" in found):
        raise HcsearchError(f"{path} must name a design or an assembly: write design = 'hex:0234550132:4'")
    return found
