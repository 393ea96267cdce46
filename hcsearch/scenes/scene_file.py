"""Scenes in TOML files, with the design or assembly that is deployed in them, and values from a command line.

All that files and their reference say of a value is its row of `SCENE_VALUES`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from hcsearch.basics.errors import SceneError
from hcsearch.basics.vocabulary import FORMULATIONS
from hcsearch.designs.panel_sizes import PanelSize, default_panel, read_panel
from hcsearch.scenes.laws import spring_law
from hcsearch.scenes.scene import DEFAULT_SCENE_NAME, SCENE_VALUES, SCENES, Scene
from hcsearch.scenes.values import MAX_SCENE_VALUE, SceneValue, shown_value
from hcsearch.system.reading import parse_toml, read_toml

_ON_TOP = {value.key: value for value in SCENE_VALUES.values() if not value.section or value.is_table}
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
"""Keys of a file that name the design, pattern or assembly to deploy."""


def scene_named(name: str) -> Scene:
    """Return a built-in scene by its name."""
    if name not in SCENES:
        raise SceneError(f"there is no scene {name!r}: choose one of {', '.join(SCENES)}, or name a file .toml")
    return SCENES[name]


def scene_with(scene: Scene, values: Mapping[str, Any]) -> Scene:
    """Return a scene with values changed, as given by a file, a command line or a call from Python.

    Values of single hinges that are not given stay. Names of spring files are relative to the current directory.
    """
    for key in values:
        if key not in SCENE_VALUES or key == "name":
            raise SceneError(f"a scene has no {key!r}: it has {', '.join(sorted(SCENE_VALUES.keys() - {'name'}))}")
    changes = {key: SCENE_VALUES[key].read(value) for key, value in values.items()}
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
    table, folder = _checked(path, read_toml(path)), Path(path).parent
    for part in (table, table.get("scene", {})):
        if isinstance(part.get("spring"), str):
            part["spring"] = spring_law(part["spring"], folder)
        if isinstance(laws := part.get("springs"), dict):
            laws |= {hinge: spring_law(law, folder) for hinge, law in laws.items() if isinstance(law, str)}
    return table


def read_scene_text(text: str, origin: str) -> dict[str, Any]:
    """Parse the text of such a file; origin : its name in messages."""
    try:
        table = parse_toml(text)
    except ValueError as error:
        raise SceneError(f"{origin} cannot be read: it holds no scene") from error
    return _checked(origin, table)


def _checked(path: str, table: dict[str, Any]) -> dict[str, Any]:
    unknown = set(table) - {*_KINDS, *_ON_TOP}
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
    values = given | {value.name: table[key] for key, value in _ON_TOP.items() if key in table and key != "name"}
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

    table: dict[str, Any] = {key: value for key, value in facts.items() if not isinstance(value, Mapping)}
    if scene.name != DEFAULT_SCENE_NAME:
        table["name"] = scene.name
    if formulation is not None:
        table["formulation"] = formulation
    tables: dict[str, Any] = {"parameters": facts.get("parameters", {}), "scene": {}}
    for name in scene.changed():
        value = SCENE_VALUES[name]
        place = tables if value.is_table else tables["scene"] if value.section else table
        place[value.key] = value.kind.write(getattr(scene, name))
    return tomli_w.dumps(table | {title: entries for title, entries in tables.items() if entries})


_HEAD = """\
# A scene of hcsearch: all that a verdict depends on besides the folding. Each value below has its default.
# Lines that begin with # are not read: remove the # to set such a value. docs/reference/scenes.md explains them all.
# Numbers are in SI units, but for those whose names end in _mm.

"""
_OF_ONE_DESIGN = """
# Of single hinges, by their numbers in pictures: for one design, as in hcsearch deploy 17:4 --scene FILE.toml.
"""
_PAGE_HEAD = """\
# Values of a scene

`make docs` writes this page from `hcsearch/scenes/scene.py`. [Files](scenes.md#files) have these values by these names,
and functions of Python take them as keyword arguments, without `_mm`, in SI units.
"""
_COMMENT_COLUMN = 34


def scene_template(panel: PanelSize | None = None, grid: str | None = None) -> str:
    """Return the text of a scene file with all values of the scene `default`, as comments where these are not set.

    panel : the size of the panels, m. grid : their grid, whose default size is shown where no panel is given.
    """
    parts, section = [_HEAD], ""
    for value in SCENE_VALUES.values():
        if value.name == "panel":
            value = replace(value, default=panel, example=None if panel else default_panel(grid or "hex"))  # noqa: PLW2901
        if value.section != section:
            parts.append(f"# {value.section}\n" if section else f"\n[scene]\n# {value.section}\n")
            section = value.section
        if not value.is_table:
            parts.append(_line(value))
    parts.append(_OF_ONE_DESIGN)
    for value in SCENE_VALUES.values():
        if value.is_table:
            lines = [f"# {hinge} = {_written(own)}\n" for hinge, own in value.example.items()]
            parts += [f"# [{value.name}]\n", *lines]
    return "".join(parts)


def _line(value: SceneValue) -> str:
    """Return the line of a value, a comment where it has an example."""
    is_open = value.example is not None
    shown = value.kind.write(value.example if is_open else value.default)
    unset = f"; unless given, {value.unset}" if is_open and value.unset else ""
    words = ", ".join(filter(None, ("mm" if value.kind.in_mm else value.unit, value.meaning)))
    assignment = f"{'# ' if is_open else ''}{value.key} = {_written(shown)}"
    return f"{assignment:{_COMMENT_COLUMN}}# {words}{unset}\n"


def _written(value: Any) -> str:
    """Return a value as TOML writes it in a line."""
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{key} = {_written(own)}' for key, own in value.items())} }}"
    return f'"{value}"' if isinstance(value, str) else str(value)


def values_page() -> str:
    """Return the Markdown page of all values, with a table for each section."""
    parts, section = [_PAGE_HEAD], None
    for value in SCENE_VALUES.values():
        if value.section != section:
            title = value.section or "On top of a file"
            parts.append(f"\n## {title}\n\n| value | unit | default | meaning |\n|---|---|---|---|\n")
            section = value.section
        default = "" if value.default is None or value.is_table else f"`{_written(value.kind.write(value.default))}`"
        key, unit = f"[{value.name}]" if value.is_table else value.key, "mm" if value.kind.in_mm else value.unit
        parts.append(f"| `{key}` | {unit} | {default} | {value.paragraph('')} |\n")
    return "".join(parts)
