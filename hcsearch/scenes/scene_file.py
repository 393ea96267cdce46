"""Scenes in TOML files, with the design or assembly that is deployed in them, and values from a command line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from hcsearch.basics.errors import SceneError
from hcsearch.basics.vocabulary import FORMULATIONS
from hcsearch.designs.panel_sizes import panel_text, read_panel
from hcsearch.scenes.scene import DEFAULT_SCENE_NAME, SCENES, Scene
from hcsearch.scenes.values import MAX_SCENE_VALUE, read_scene_value, shown_value, with_table_points
from hcsearch.system.reading import parse_toml, read_toml

_IN_MILLIMETRES = {"panel_mm": "panel", "margin_mm": "margin"}
_ON_TOP = ("flat_pairs", "held", "springs", "hinges", "releases")
_KINDS: dict[str, tuple[type, str]] = {
    "design": (str, "design = 'hex:0234550132:4'"),
    "assembly": (str, "assembly = 'unit-i'"),
    "pattern": (str, "pattern = 'ring.fold'"),
    "name": (str, "name = 'solar'"),
    "formulation": (str, "formulation = 'compliant'"),
    "parameters": (dict, "a table [parameters] with lines such as alpha = 70"),
    "scene": (dict, "a table [scene] with lines such as spring = 'linear:0.1'"),
    "drive": (dict, "a table [drive], as hcsearch drive --output drive.toml writes it"),
}
"""Keys of a file that are not values of a scene, with their type and an example."""
SUBJECT_KEYS = ("design", "assembly", "pattern")
"""Keys of a file that name what is deployed."""


def scene_named(name: str) -> Scene:
    """Return a built-in scene by its name."""
    if name not in SCENES:
        raise SceneError(f"there is no scene {name!r}: choose one of {', '.join(SCENES)}, or name a file .toml")
    return SCENES[name]


def scene_with(scene: Scene, values: Mapping[str, Any]) -> Scene:
    """Return a scene with values changed, as given by a file, a command line or a call from Python.

    Values of single hinges that are not given stay. Names of spring files are relative to the current directory.
    """
    names = {field.name for field in fields(Scene)} - {"name"}
    changes: dict[str, Any] = {}
    for key, value in values.items():
        if key not in names:
            raise SceneError(f"a scene has no {key!r}: it has {', '.join(sorted(names))}")
        changes[key] = read_scene_value(key, value)
    if "hinges" in changes:
        before, given = dict(scene.hinges), dict(changes["hinges"])
        merged = {hinge: dict(before.get(hinge, ())) | dict(given.get(hinge, ())) for hinge in before | given}
        changes["hinges"] = tuple((hinge, tuple(own.items())) for hinge, own in merged.items())
    return replace(scene, **changes)


def read_scene_file(path: str) -> dict[str, Any]:
    """Read a TOML file of a scene, and of the design or assembly that is deployed in it, if it names one.

    Keys: `design`, `pattern`, or `assembly` with a table `parameters`, `formulation`, `name`, `panel_mm`, `margin_mm`,
    `flat_pairs`, `held`, tables `springs`, `hinges` and `releases` of single hinges, a table `scene` of all other
    values, which may name a scene to start from, and a table `drive` of driven hinges. Panels and hinges have the names
    used in pictures.
    Files named in laws are relative to the directory of this one and are replaced by their points.
    """
    table = _checked(path, read_toml(path))
    folder = Path(path).parent
    table = with_table_points(table, folder)
    if "scene" in table:
        table["scene"] = with_table_points(table["scene"], folder)
    return table


def read_scene_text(text: str, origin: str) -> dict[str, Any]:
    """Parse the text of such a file; origin : its name in messages."""
    try:
        table = parse_toml(text)
    except ValueError as error:
        raise SceneError(f"{origin} cannot be read: it holds no scene") from error
    return _checked(origin, table)


def _checked(path: str, table: dict[str, Any]) -> dict[str, Any]:
    unknown = set(table) - {*_KINDS, *_ON_TOP, *_IN_MILLIMETRES}
    if unknown:
        raise SceneError(f"{path} has the unknown key {shown_value(min(unknown))}: see docs/reference/scenes.md")
    if sum(key in table for key in SUBJECT_KEYS) > 1:
        raise SceneError(f"{path} must name one design, assembly or pattern, not several: leave the others out")
    for key, (kind, example) in _KINDS.items():
        if key in table and not isinstance(table[key], kind):
            raise SceneError(f"{path} has {key} = {shown_value(table[key])}: write {example}")
    if table.get("formulation", FORMULATIONS[0]) not in FORMULATIONS:
        names = ", ".join(FORMULATIONS)
        raise SceneError(f"{path} has formulation = {shown_value(table['formulation'])}: write one of {names}")
    if not isinstance(table.get("scene", {}).get("name", ""), str):
        raise SceneError(
            f"{path} starts from the scene {shown_value(table['scene']['name'])}: choose one of {', '.join(SCENES)}"
        )
    for key, value in table.get("parameters", {}).items():
        if isinstance(value, bool) or not isinstance(value, str if key == "size" else (int, float)):
            example = "size = '3x2'" if key == "size" else f"a number, such as {key} = 70"
            raise SceneError(f"{path} has {key} = {shown_value(value)}: write {example}")
    return table


def scene_in(table: Mapping[str, Any], *, base: Scene | None = None, grid: str | None = None) -> Scene:
    """Return the scene of a file; base : the scene to start from, in place of the one that the file names.

    grid : the grid of the panels, if known: panels of `rectangle` have three sizes.
    """
    given = dict(table.get("scene", {}))
    name = given.pop("name", DEFAULT_SCENE_NAME)
    values = given | {key: table[key] for key in _ON_TOP if key in table}
    if "panel_mm" in table:
        values["panel"] = table["panel_mm"]
    if isinstance(values.get("panel"), str):
        values["panel"] = read_panel(values["panel"], grid)
    if "margin_mm" in table:
        values["margin"] = _metres("margin_mm", table["margin_mm"])
    scene = scene_with(scene_named(name) if base is None else base, values)
    return replace(scene, name=table.get("name", scene.name))


def _metres(key: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0.0 <= value <= MAX_SCENE_VALUE:
        raise SceneError(f"{key} cannot be {shown_value(value)}: give a number from 0 to {MAX_SCENE_VALUE:g}")
    return float(f"{value * 1e-3:.10g}")


def scene_file_text(facts: Mapping[str, Any], formulation: str | None, scene: Scene) -> str:
    """Return the text of a scene file: the deployed subject, and all values of its scene that differ from `default`.

    facts : the deployed subject, `design`, `pattern`, or `assembly` with its `parameters`; empty for a scene alone.
    """
    import tomli_w  # noqa: PLC0415 - most of what reads scenes writes none

    default = Scene()
    values = {field.name: getattr(scene, field.name) for field in fields(Scene)}
    changed = {key: value for key, value in values.items() if key != "name" and value != getattr(default, key)}
    table: dict[str, Any] = {key: value for key, value in facts.items() if not isinstance(value, Mapping)}
    if scene.name != DEFAULT_SCENE_NAME:
        table["name"] = scene.name
    if formulation is not None:
        table["formulation"] = formulation
    if (panel := changed.pop("panel", None)) is not None:
        table["panel_mm"] = panel_text(panel)
    if "margin" in changed:
        table["margin_mm"] = float(f"{1e3 * changed.pop('margin'):.10g}")
    springs, releases = (dict(changed.pop(name, ())) for name in ("springs", "releases"))
    hinges = {hinge: dict(given) for hinge, given in changed.pop("hinges", ())}
    if "flat_pairs" in changed:
        flat_pairs = changed.pop("flat_pairs")
        table["flat_pairs"] = flat_pairs[0] if len(flat_pairs) == 1 else list(flat_pairs)
    if "held" in changed:
        table["held"] = changed.pop("held")
    tables = {"parameters": facts.get("parameters", {}), "scene": changed, "springs": springs, "hinges": hinges}
    tables["releases"] = releases
    for title, entries in tables.items():
        if entries:
            table[title] = {key: list(value) if isinstance(value, tuple) else value for key, value in entries.items()}
    return tomli_w.dumps(table)
