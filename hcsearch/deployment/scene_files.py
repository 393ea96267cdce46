"""Scenes and what is deployed in them, as TOML files and as values from a command line."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from numbers import Real
from pathlib import Path
from typing import Any

from hcsearch.deployment.naming import named
from hcsearch.dynamics.laws import spring_law
from hcsearch.errors import SceneError, refusal
from hcsearch.labels import Labels, is_name
from hcsearch.scenes import LARGEST, SCENES, SMALLEST, Scene, panel_text, read_panel
from hcsearch.system.reading import parse_toml, read_toml
from hcsearch.vocabulary import FORMULATIONS

Reader = Callable[[str, Any], Any]

MOST = 1e12
"""Of all numbers of a scene but shares."""
_ABOVE, _SHARE = (1e-9, MOST), (0.0, 1.0)
_LIMITS = {"density": _ABOVE, "areal_mass": _ABOVE, "seconds": _ABOVE, "start": _SHARE, "restitution": _SHARE}
"""The least and the greatest value of numbers that have others than 0 and `MOST`."""


def scene_named(name: str) -> Scene:
    """A scene of the program by its name."""
    if name not in SCENES:
        raise SceneError(f"there is no scene {name!r}: choose one of {', '.join(SCENES)}, or name a file .toml")
    return SCENES[name]


def scene_with(scene: Scene, values: Mapping[str, Any], *, names: bool = True) -> Scene:
    """A scene with some values changed, as a file or a command line gives them; None leaves a value open.

    names : whether hinges and panels go by the names on pictures, or by their numbers in a linkage, as in a table
    [scene].
    """
    known = {field.name for field in fields(Scene)} - {"name"}
    changes: dict[str, Any] = {}
    for key, value in values.items():
        if key not in known:
            raise SceneError(f"a scene has no {key!r}: it has {', '.join(sorted(known))}")
        changes[key] = _read(key, value, names)
    return replace(scene, **changes)


def checked_scene(scene: Scene) -> Scene:
    """A scene made in Python, in which no value has been read yet; SceneError for values that a scene cannot have."""
    read: dict[str, Any] = {}
    for own in fields(Scene):
        value = getattr(scene, own.name)
        if value == own.default:
            continue
        if own.name in _AS_MADE:
            accepted, wanted = _AS_MADE[own.name]
            if not accepted(value):
                raise SceneError(refusal(own.name, value, wanted))
        elif own.name not in _READERS and not isinstance(value, Real):
            raise SceneError(refusal(own.name, value, "a number"))
        else:
            read[own.name] = _read(own.name, value, names=False)
    if "spring" in read:
        read["spring"] = spring_law(read["spring"], Path())
    if scene.springs:
        read["springs"] = tuple((hinge, spring_law(law, Path())) for hinge, law in scene.springs)
    return replace(scene, **read)


def _is_size(value: Any) -> bool:
    return isinstance(value, tuple) and len(value) == 3 and all(
        isinstance(length, (int, float)) and SMALLEST <= length <= LARGEST for length in value
    )  # fmt: skip


def _is_laws(value: Any) -> bool:
    return isinstance(value, tuple) and all(
        isinstance(pair, tuple) and len(pair) == 2 and isinstance(pair[0], (int, str)) and isinstance(pair[1], str)
        for pair in value
    )


_AS_MADE: dict[str, tuple[Callable[[Any], bool], str]] = {
    "name": (lambda value: isinstance(value, str), "a text, such as 'solar'"),
    "panel": (_is_size, "length, width and thickness in m, such as (0.05, 0.05, 0.006)"),
    "springs": (_is_laws, "pairs of a hinge and its law, such as (('7', 'linear:0.2'),)"),
    "held": (lambda value: isinstance(value, (int, str)), "'bottom', 'free', or the name of a panel, such as '3'"),
}
"""Values of a scene in Python that differ from those of files: whether one is right, and what to give."""


def _read(key: str, value: Any, names: bool) -> Any:
    """One value of a scene; SceneError where it is of another kind."""
    kind: Reader = _NAMED.get(key, _number) if names and key in _NAMED else _READERS.get(key, _number)
    try:
        return kind(key, value)
    except (TypeError, ValueError, OverflowError) as error:
        if isinstance(error, SceneError):
            raise
        example = _EXAMPLES.get(key) or _from_to(*_LIMITS.get(key, (0.0, MOST)))
        raise SceneError(f"{key} cannot be {_shown(value)}: {example}") from error


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _from_to(least: float, most: float) -> str:
    return f"give a number from {least:g} to {most:g}"


def _number(key: str, value: Any) -> float:
    if isinstance(value, bool):
        raise ValueError
    least, most = _LIMITS.get(key, (0.0, MOST))
    if not least <= float(value) <= most:
        raise ValueError
    return float(value)


def _vector(key: str, value: Any) -> tuple[float, ...]:
    parts = value.split(",") if isinstance(value, str) else value
    x, y, z = (float(number) for number in parts)
    _check_limits(key, value, (x, y, z), 0.0 if key == "base_inertia" else -MOST)
    return (x, y, z)


def _range(key: str, value: Any) -> tuple[float, float]:
    parts = value.split(",") if isinstance(value, str) else value
    low, high = (float(number) for number in parts)
    _check_limits(key, value, (low, high), 0.0)
    if not 0.0 < low < high:
        raise ValueError
    return (low, high)


def _check_limits(key: str, value: Any, numbers: tuple[float, ...], least: float) -> None:
    if not all(least <= number <= MOST for number in numbers):
        raise SceneError(f"{key} cannot be {_shown(value)}: give numbers from {least:g} to {MOST:g}")


def _springs(_key: str, value: Any) -> tuple[tuple[int, str], ...]:
    laws: dict[int, str] = {}
    for hinge, law in dict(value).items():
        text = str(hinge)
        if not (text.isascii() and text.isdigit() and len(text) < 10 and isinstance(law, str)):
            raise ValueError
        if int(text) in laws:
            raise SceneError(f"springs names hinge {int(text)} twice: leave one out")
        laws[int(text)] = law
    return tuple(laws.items())


def _named_springs(_key: str, value: Any) -> tuple[tuple[str, str], ...]:
    laws: dict[str, str] = {}
    for hinge, law in dict(value).items():
        if not isinstance(law, str):
            raise ValueError
        name = _name(str(hinge))
        if name in laws:
            raise SceneError(f"springs names hinge {name} twice: leave one out")
        laws[name] = law
    return tuple(laws.items())


def _name(text: str) -> str:
    """The name of a panel or hinge, without needless zeros."""
    if not is_name(text):
        raise ValueError
    return "+".join(str(int(part)) for part in text.split("+"))


def _named_held(_key: str, value: Any) -> str:
    if isinstance(value, bool) or not isinstance(value, (str, int)):
        raise ValueError
    return str(value) if value in ("bottom", "free") else _name(str(value))


def _law(_key: str, value: Any) -> str:
    if not isinstance(value, str):
        raise ValueError
    return value


def _held(_key: str, value: Any) -> Any:
    if value in ("bottom", "free"):
        return value
    number = int(str(value))
    if isinstance(value, bool) or not 0 <= number < 10**9:
        raise ValueError
    return number


def _flat_pairs(_key: str, value: Any) -> Any:
    if value not in ("rigid", "hinged", "either"):
        raise ValueError
    return value


def _merge(_key: str, value: Any) -> Any:
    if value is not True and value is not False and value != "either":
        raise ValueError
    return value


def _panel(_key: str, value: Any) -> Any:
    if not isinstance(value, str):
        raise TypeError
    return read_panel(value)


_READERS: dict[str, Reader] = {
    "panel": _panel,
    "flat_pairs": _flat_pairs,
    "merge": _merge,
    "spring": _law,
    "springs": _springs,
    "spring_range": _range,
    "gravity": _vector,
    "base_inertia": _vector,
    "held": _held,
}
_NAMED: dict[str, Reader] = {"springs": _named_springs, "held": _named_held}
_EXAMPLES = {
    "panel": "write panel_mm = '50x50x6'",
    "flat_pairs": "write 'rigid', 'hinged' or 'either'",
    "merge": "write true, false or 'either'",
    "spring": "write a law, such as 'linear:0.1'",
    "springs": "write { 3 = 'linear:0.2' }, a law for each hinge",
    "spring_range": "give the softest and the stiffest, N m/rad, such as 0.001,0.2",
    "gravity": "give x,y,z in m/s^2, such as 0,0,-9.81",
    "base_inertia": "give three moments of inertia, kg m^2, such as 0.0067,0.0067,0.0067",
    "held": "give bottom, free, or the number of a panel",
}
_IN_MILLIMETRES = {"panel_mm": "panel", "margin_mm": "margin"}
_ON_TOP = ("flat_pairs", "merge", "held", "springs")
_KINDS: dict[str, tuple[type, str]] = {
    "design": (str, "design = 'hex:0234550132:4'"),
    "assembly": (str, "assembly = 'unit-i'"),
    "name": (str, "name = 'solar'"),
    "formulation": (str, "formulation = 'compliant'"),
    "parameters": (dict, "a table [parameters] with lines such as alpha = 70"),
    "scene": (dict, "a table [scene] with lines such as spring = 'linear:0.1'"),
    "drive": (dict, "a table [drive], as hcsearch drive --output drive.toml writes it"),
}
"""Keys of a file that are no values of a scene: of which kind, and an example."""


def read_file(path: str) -> dict[str, Any]:
    """A TOML file of a scene, and of the design or assembly that is deployed in it, if it names one.

    Keys: `design` or `assembly` with a table `parameters`, `formulation`, `name`, `panel_mm`, `margin_mm`,
    `flat_pairs`, `merge`, `held`, a table `springs` of single hinges, a table `scene` of all other values, which may
    name a scene to start from, and a table `drive` of driven hinges. Panels and hinges go by the names on pictures; in
    a table `scene`, as files had it before, `held` and `springs` count those of the linkage. Files that are named in
    laws count from the folder of this one; their points take their place.
    """
    table = _checked(path, read_toml(path))
    folder = Path(path).parent
    if isinstance(table.get("springs"), dict):
        table["springs"] = _springs_with_points(table["springs"], folder)
    if "scene" in table:
        table["scene"] = _with_points(table["scene"], folder)
    return table


def given_by_user(values: Mapping[str, Any]) -> dict[str, Any]:
    """Values of a scene from a command line or from Python, in which files of springs count from the current folder."""
    return _with_points(values, Path())


def _with_points(values: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Values of a scene with points of tables in place of files; what is no law is left for `scene_with` to refuse."""
    changed = dict(values)
    if isinstance(changed.get("spring"), str):
        changed["spring"] = spring_law(changed["spring"], folder)
    if "springs" in changed:
        changed["springs"] = _springs_with_points(changed["springs"], folder)
    return changed


def _springs_with_points(springs: Any, folder: Path) -> Any:
    try:
        pairs = list(dict(springs).items())
    except (TypeError, ValueError):
        return springs
    return {hinge: spring_law(law, folder) if isinstance(law, str) else law for hinge, law in pairs}


def read_text(text: str, origin: str) -> dict[str, Any]:
    """The same from a text; origin : what it is called in messages."""
    try:
        table = parse_toml(text)
    except ValueError as error:
        raise SceneError(f"{origin} cannot be read: it holds no scene") from error
    return _checked(origin, table)


def _checked(path: str, table: dict[str, Any]) -> dict[str, Any]:
    unknown = set(table) - {*_KINDS, *_ON_TOP, *_IN_MILLIMETRES}
    if unknown:
        raise SceneError(f"{path} has the unknown key {_shown(min(unknown))}: see docs/reference/scenes.md")
    if "design" in table and "assembly" in table:
        raise SceneError(f"{path} must name a design or an assembly, not both: leave one out")
    for key, (kind, example) in _KINDS.items():
        if key in table and not isinstance(table[key], kind):
            raise SceneError(f"{path} has {key} = {_shown(table[key])}: write {example}")
    if table.get("formulation", FORMULATIONS[0]) not in FORMULATIONS:
        names = ", ".join(FORMULATIONS)
        raise SceneError(f"{path} has formulation = {_shown(table['formulation'])}: write one of {names}")
    if not isinstance(table.get("scene", {}).get("name", ""), str):
        raise SceneError(
            f"{path} starts from the scene {_shown(table['scene']['name'])}: choose one of {', '.join(SCENES)}"
        )
    for key, value in table.get("parameters", {}).items():
        if isinstance(value, bool) or not isinstance(value, str if key == "size" else (int, float)):
            example = "size = '3x2'" if key == "size" else f"a number, such as {key} = 70"
            raise SceneError(f"{path} has {key} = {_shown(value)}: write {example}")
    return table


def scene_in(table: Mapping[str, Any], *, base: Scene | None = None, grid: str | None = None) -> Scene:
    """The scene that a file holds; base : to start from, unless that is the one the file names.

    grid : of the panels, where that is known: those of `rectangle` have three sizes.
    """
    given = dict(table.get("scene", {}))
    for size in (table.get("panel_mm"), given.get("panel")):
        if grid is not None and isinstance(size, str):
            read_panel(size, grid)
    start = given.pop("name", None)
    scene = base or scene_named("default" if start is None else start)
    scene = scene_with(scene, given, names=False)
    values = {key: table[key] for key in _ON_TOP if key in table}
    for key, name in _IN_MILLIMETRES.items():
        if key in table:
            values[name] = table[key] if name == "panel" else _metres(key, table[key])
    return replace(scene_with(scene, values), name=table.get("name", scene.name))


def _metres(key: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0.0 <= value <= MOST:
        raise SceneError(f"{key} cannot be {_shown(value)}: {_from_to(0.0, MOST)}")
    return float(f"{value * 1e-3:.10g}")


def file_text(facts: Mapping[str, Any], formulation: str | None, scene: Scene, labels: Labels | None = None) -> str:
    """A file that `read_file` reads: what is deployed, and all of its scene that counts.

    facts : what is deployed, `design` or `assembly`, with its `parameters`; empty for a scene alone. labels : of the
    linkage that numbers in the scene are of; without them these are written as such, in the table `scene`.
    """
    scene = scene if labels is None else named(scene, labels)
    lines = [f"{key} = {_toml(value)}" for key, value in facts.items() if not isinstance(value, dict)]
    if scene.name != "default":
        lines.append(f"name = {_toml(scene.name)}")
    if formulation is not None:
        lines.append(f"formulation = {_toml(formulation)}")
    plain = Scene()
    values = {field.name: getattr(scene, field.name) for field in fields(Scene)}
    changed = {name: value for name, value in values.items() if name != "name" and value != getattr(plain, name)}
    if scene.panel is not None:
        lines.append(f"panel_mm = {_toml(panel_text(scene.panel))}")
    if "margin" in changed:
        millimetres = float(f"{1e3 * changed['margin']:.10g}")
        lines.append(f"margin_mm = {_toml(millimetres)}")
    on_top = {key: value for key, value in changed.items() if key in _ON_TOP and _has_names(key, value)}
    lines += [f"{key} = {_toml(value)}" for key, value in on_top.items() if key != "springs"]
    own = {key: value for key, value in changed.items() if key not in {"panel", "margin", *on_top}}
    springs = {json.dumps(name): law for name, law in on_top.get("springs", ())}
    for title, table in {"parameters": facts.get("parameters", {}), "scene": own, "springs": springs}.items():
        if table:
            lines += ["", f"[{title}]", *(f"{key} = {_toml(value)}" for key, value in table.items())]
    return "".join(f"{line}\n" for line in lines)


def _has_names(key: str, value: Any) -> bool:
    """Whether a value stands on top of a file: numbers of a linkage are for the table `scene`."""
    if key == "springs":
        return all(isinstance(name, str) for name, _ in value)
    return value not in ("bottom", "free") if key == "held" and isinstance(value, str) else key != "held"


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple) and value and isinstance(value[0], tuple):  # springs of single hinges
        return "{ " + ", ".join(f"{hinge} = {_toml(law)}" for hinge, law in value) + " }"
    if isinstance(value, tuple):
        return "[" + ", ".join(map(_toml, value)) + "]"
    if isinstance(value, float) and not math.isfinite(value):
        raise SceneError(f"{value} cannot be written to a file: give finite numbers")
    return json.dumps(value)
