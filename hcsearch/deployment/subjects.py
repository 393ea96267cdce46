"""What can be deployed: a folding, or a file that names one with a scene of its own."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from hcsearch.deployment.compiling import FORMULATIONS
from hcsearch.errors import HcsearchError
from hcsearch.folding import Folding
from hcsearch.linkage import Linkage
from hcsearch.scenes import SCENES, PanelSize, Scene, default_panel

LEAST = 1e-9
"""Of a density (kg/m^3), and of a time to simulate (s)."""


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
            least = 0.0 if key == "base_inertia" else -1e12
            if len(found) != 3 or not all(least <= number < 1e12 for number in found):
                raise ValueError
            return found
        if key == "springs":
            return tuple((int(hinge), str(law)) for hinge, law in dict(value).items())
        if key == "spring":
            return str(value)
        if key == "held":
            return value if value in {"bottom", "free"} else int(str(value))
        number = float(value)
    except (TypeError, ValueError) as error:
        raise HcsearchError(f"{key} cannot be {value!r}: see the scenes of docs/dynamics.md") from error
    if not 0.0 <= number < 1e12:
        raise HcsearchError(f"{key} cannot be {value!r}: give a number of 0 or more")
    if key in {"density", "seconds"} and number < LEAST:
        raise HcsearchError(f"{key} cannot be {value!r}: give {LEAST:g} or more")
    if key == "restitution" and number > 1.0:
        raise HcsearchError(f"{key} cannot be {value!r}: give a number from 0 to 1")
    return number


def read_file(path: str) -> dict[str, Any]:
    """A TOML file: `design` or `assembly`, `panel_mm`, `flat_pairs`, `merge`, `formulation`, `parameters`, `scene`."""
    try:
        with Path(path).open("rb") as file:
            found = tomllib.load(file)
    except OSError as error:
        raise HcsearchError(f"cannot read {path}: {error.strerror}; name a file that is there") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise HcsearchError(f"{path} is no TOML: {error}; write lines such as design = 'hex:0234550132:4'") from error
    unknown = set(found) - set(_KINDS)
    if unknown:
        raise HcsearchError(f"{path} has {min(unknown)!r}, which nothing reads: see docs/dynamics.md")
    if ("design" in found) == ("assembly" in found):
        raise HcsearchError(f"{path} must name a design or an assembly: write design = 'hex:0234550132:4'")
    for key, value in found.items():
        kind, example = _KINDS[key]
        if not isinstance(value, kind):
            raise HcsearchError(f"{path} has {key} = {value!r}: write {example}")
    if found.get("flat_pairs", "rigid") not in {"rigid", "hinged"}:
        raise HcsearchError(f"{path} has flat_pairs = {found['flat_pairs']!r}: write 'rigid' or 'hinged'")
    if found.get("formulation", FORMULATIONS[0]) not in FORMULATIONS:
        names = ", ".join(FORMULATIONS)
        raise HcsearchError(f"{path} has formulation = {found['formulation']!r}: write one of {names}")
    if not isinstance(found.get("scene", {}).get("name", ""), str):
        raise HcsearchError(f"{path} has the scene {found['scene']['name']!r}: choose one of {', '.join(SCENES)}")
    for key, value in found.get("parameters", {}).items():
        if isinstance(value, bool) or not isinstance(value, str if key == "size" else (int, float)):
            example = "size = '3x2'" if key == "size" else f"a number, such as {key} = 70"
            raise HcsearchError(f"{path} has {key} = {value!r}: write {example}")
    return found


def file_text(facts: Mapping[str, Any], formulation: str, scene: Scene) -> str:
    """A file that `read_file` reads, and `hcsearch deploy` replays: what is deployed, and all of its scene that counts.

    facts : its other keys, `parameters` among them.
    """
    plain = Scene()
    values = {field.name: getattr(scene, field.name) for field in fields(Scene)}
    changed = {name: value for name, value in values.items() if name != "name" and value != getattr(plain, name)}
    lines = [f"{key} = {_toml(value)}" for key, value in facts.items() if not isinstance(value, dict)]
    lines.append(f"formulation = {_toml(formulation)}")
    tables = {"parameters": facts.get("parameters", {}), "scene": changed}
    for title, table in tables.items():
        if table:
            lines += ["", f"[{title}]", *(f"{key} = {_toml(value)}" for key, value in table.items())]
    return "\n".join(lines) + "\n"


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple) and value and isinstance(value[0], tuple):  # springs of single hinges
        return "{ " + ", ".join(f"{hinge} = {_toml(law)}" for hinge, law in value) + " }"
    if isinstance(value, tuple):
        return "[" + ", ".join(map(_toml, value)) + "]"
    return json.dumps(value)


_KINDS: dict[str, tuple[type, str]] = {
    "design": (str, "design = 'hex:0234550132:4'"),
    "assembly": (str, "assembly = 'unit-i'"),
    "panel_mm": (str, "panel_mm = '50x50x6'"),
    "flat_pairs": (str, "'rigid' or 'hinged'"),
    "merge": (bool, "merge = true"),
    "parameters": (dict, "a table [parameters] with lines such as alpha = 70"),
    "formulation": (str, "formulation = 'compliant'"),
    "scene": (dict, "a table [scene] with lines such as spring = 'linear:0.1'"),
}
"""What a file may hold: of which kind, and an example."""
