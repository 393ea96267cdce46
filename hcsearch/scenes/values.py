"""Values of a scene: their types and limits, and their parsing from files and command lines."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from numbers import Real
from pathlib import Path
from typing import Any

from hcsearch.basics.errors import SceneError, wrong_kind_message
from hcsearch.basics.vocabulary import WAYS, Way
from hcsearch.designs.panel_sizes import MAX_PANEL_LENGTH, MIN_PANEL_LENGTH, read_panel
from hcsearch.scenes.releases import release_named

Reader = Callable[[str, Any], Any]

MAX_SCENE_VALUE = 1e12
"""Greatest value of all numbers of a scene except shares."""
HARDWARE_VALUES = ("friction", "harness", "latch_stiffness", "stop_tolerance", "play")
"""Values of the hardware of hinges."""
HINGE_VALUES = ("damping", *HARDWARE_VALUES)
"""Values that single hinges may have of their own."""
_ABOVE, _SHARE = (1e-9, MAX_SCENE_VALUE), (0.0, 1.0)
_SMALL_ANGLE, _SMALL_LENGTH = (0.0, 0.1), (0.0, 0.1 * MAX_PANEL_LENGTH)
_LIMITS = {
    "density": _ABOVE,
    "areal_mass": _ABOVE,
    "seconds": _ABOVE,
    "start": _SHARE,
    "restitution": _SHARE,
    "stop_tolerance": _SMALL_ANGLE,
    "play": _SMALL_ANGLE,
    "thickness_tolerance": _SMALL_LENGTH,
    "offset_tolerance": _SMALL_LENGTH,
}
"""Least and greatest value of numbers with limits other than 0 and `MAX_SCENE_VALUE`."""


def checked_scene_values(values: Mapping[str, Any]) -> dict[str, Any]:
    """Check values of a scene constructed in Python; SceneError for invalid ones.

    Names of files in laws, relative to the current directory, are replaced by the points of the files.
    """
    read: dict[str, Any] = {}
    for name, value in values.items():
        if name in _AS_MADE:
            is_right, expected = _AS_MADE[name]
            if not is_right(value):
                raise SceneError(wrong_kind_message(name, value, expected))
        elif name not in _READERS and not isinstance(value, Real):
            raise SceneError(wrong_kind_message(name, value, "a number"))
        read[name] = value if name == "name" else read_scene_value(name, value)
    return with_table_points(read, Path())


def _is_text(value: Any) -> bool:
    return isinstance(value, str)


def _is_name(value: Any) -> bool:
    return isinstance(value, (int, str))


def _is_size(value: Any) -> bool:
    return isinstance(value, tuple) and len(value) == 3 and all(
        isinstance(length, (int, float)) and MIN_PANEL_LENGTH <= length <= MAX_PANEL_LENGTH for length in value
    )  # fmt: skip


def _by_hinge(kind: type) -> Callable[[Any], bool]:
    def is_by_hinge(value: Any) -> bool:
        return isinstance(value, tuple) and all(
            isinstance(pair, tuple) and len(pair) == 2 and isinstance(pair[0], (int, str)) and isinstance(pair[1], kind)
            for pair in value
        )

    return is_by_hinge


_AS_MADE: dict[str, tuple[Callable[[Any], bool], str]] = {
    "name": (_is_text, "a text, such as 'solar'"),
    "panel": (_is_size, "length, width and thickness in m, such as (0.05, 0.05, 0.006)"),
    "springs": (_by_hinge(str), "pairs of a hinge and its law, such as (('7', 'linear:0.2'),)"),
    "releases": (_by_hinge(str), "pairs of a hinge and its release, such as (('7', '0.5 s'),)"),
    "hinges": (_by_hinge(tuple), "pairs of a hinge and its values, such as (('7', (('friction', 0.02),)),)"),
    "held": (_is_name, "'bottom', 'free', or the name of a panel, such as '3'"),
    "root": (_is_name, "'held', 'free', or the name of a panel, such as '3'"),
    "envelope": (_is_text, "a name such as '3U', or three lengths in mm such as '100x100x340'"),
}
"""Values of a scene whose types in Python differ from those in files: the check, and the expected type."""


def read_scene_value(key: str, value: Any) -> Any:
    """Parse one value of a scene; SceneError where it is of another type or out of range."""
    read: Reader = _READERS.get(key, _number)
    try:
        return read(key, value)
    except (TypeError, ValueError, OverflowError) as error:
        if isinstance(error, SceneError):
            raise
        example = _EXAMPLES.get(key) or _from_to(*_LIMITS.get(key, (0.0, MAX_SCENE_VALUE)))
        raise SceneError(f"{key} cannot be {shown_value(value)}: {example}") from error


def shown_value(value: Any) -> str:
    """Return a value for a message, in 60 characters at most."""
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _from_to(low: float, high: float) -> str:
    return f"give a number from {low:g} to {high:g}"


def _number(key: str, value: Any) -> float:
    if isinstance(value, bool):
        raise ValueError
    low, high = _LIMITS.get(key, (0.0, MAX_SCENE_VALUE))
    if not low <= float(value) <= high:
        raise ValueError
    return float(value)


def _vector(key: str, value: Any) -> tuple[float, ...]:
    parts = value.split(",") if isinstance(value, str) else value
    x, y, z = (float(number) for number in parts)
    _check_limits(key, value, (x, y, z), 0.0 if key == "base_inertia" else -MAX_SCENE_VALUE)
    return (x, y, z)


def _range(key: str, value: Any) -> tuple[float, float]:
    parts = value.split(",") if isinstance(value, str) else value
    low, high = (float(number) for number in parts)
    _check_limits(key, value, (low, high), 0.0)
    if not 0.0 < low < high:
        raise ValueError
    return (low, high)


def _check_limits(key: str, value: Any, numbers: tuple[float, ...], low: float) -> None:
    if not all(low <= number <= MAX_SCENE_VALUE for number in numbers):
        raise SceneError(f"{key} cannot be {shown_value(value)}: give numbers from {low:g} to {MAX_SCENE_VALUE:g}")


def _springs(key: str, value: Any) -> tuple[tuple[str, str], ...]:
    texts: dict[str, str] = {}
    for hinge, text in dict(value).items():
        if not isinstance(text, str):
            raise ValueError
        name = _name(str(hinge))
        if name in texts:
            raise SceneError(f"{key} names hinge {name} twice: leave one out")
        texts[name] = text
    return tuple(texts.items())


def _releases(key: str, value: Any) -> tuple[tuple[str, str], ...]:
    releases = _springs(key, value)
    for _, text in releases:
        release_named(text)  # refuses what is no release
    return releases


def _hinges(_key: str, value: Any) -> tuple[tuple[str, tuple[tuple[str, float], ...]], ...]:
    hinges: dict[str, tuple[tuple[str, float], ...]] = {}
    for hinge, given in dict(value).items():
        name = _name(str(hinge))
        if name in hinges:
            raise SceneError(f"hinges names hinge {name} twice: leave one out")
        values = dict(given)
        for key in values:
            if key not in HINGE_VALUES:
                raise SceneError(f"hinge {name} has no {key!r}: it has {', '.join(HINGE_VALUES)}")
        hinges[name] = tuple((key, read_scene_value(key, number)) for key, number in values.items())
    return tuple(hinges.items())


def _craft(key: str, value: Any) -> tuple[tuple[float, ...], ...]:
    boxes = []
    for box in value:
        numbers = tuple(float(number) for number in box)
        if len(numbers) != 6 or isinstance(box, str):
            raise ValueError
        _check_limits(key, box, numbers[:3], -MAX_SCENE_VALUE)
        _check_limits(key, box, numbers[3:], 0.0)
        boxes.append(numbers)
    return tuple(boxes)


def _name(text: str) -> str:
    """Parse the name of a panel or hinge, removing leading zeros."""
    from hcsearch.shape.labels import is_label  # noqa: PLC0415 - loads kernels, which scenes of the program do without

    if not is_label(text):
        raise ValueError
    return "+".join(str(int(part)) for part in text.split("+"))


def _panel_or(*words: str) -> Reader:
    """Return the reader of a panel's name, or one of some words in its place."""

    def read(_key: str, value: Any) -> str:
        if isinstance(value, bool) or not isinstance(value, (str, int)):
            raise ValueError
        return str(value) if value in words else _name(str(value))

    return read


def _text(_key: str, value: Any) -> str:
    if not isinstance(value, str):
        raise ValueError
    return value


def _flat_pairs(_key: str, value: Any) -> tuple[Way, ...]:
    if value == "either":
        return WAYS
    ways = (value,) if isinstance(value, str) else tuple(value)
    if not ways or not set(ways) <= set(WAYS) or len(set(ways)) < len(ways):
        raise ValueError
    return ways


def _panel(_key: str, value: Any) -> Any:
    if isinstance(value, str):
        return read_panel(value)
    if not _is_size(value):
        raise ValueError
    return value


_READERS: dict[str, Reader] = {
    "panel": _panel,
    "flat_pairs": _flat_pairs,
    "spring": _text,
    "springs": _springs,
    "releases": _releases,
    "spring_range": _range,
    "gravity": _vector,
    "base_inertia": _vector,
    "held": _panel_or("bottom", "free"),
    "hinges": _hinges,
    "root": _panel_or("held", "free"),
    "craft": _craft,
    "envelope": _text,
}
_EXAMPLES = {
    "panel": "write panel_mm = '50x50x6'",
    "flat_pairs": "write 'rigid', 'hinged', 'merged' or 'either', or a list of ways in the order of trial",
    "spring": "write a law, such as 'linear:0.1'",
    "springs": "write { 3 = 'linear:0.2' }, a law for each hinge",
    "releases": "write { 3 = '0.5 s' }, or { 3 = 'hinge 7 at 0.2 rad' }, a release for each hinge",
    "spring_range": "give the softest and the stiffest, N m/rad, such as 0.001,0.2",
    "gravity": "give x,y,z in m/s^2, such as 0,0,-9.81",
    "base_inertia": "give three moments of inertia, kg m^2, such as 0.0067,0.0067,0.0067",
    "held": "give bottom, free, or the number of a panel",
    "hinges": "write { 3 = { friction = 0.02 } }, the values of each hinge",
    "root": "give held, free, or the number of a panel",
    "craft": "write [[x, y, z, length, width, height]] in m, a list of boxes",
    "envelope": "write '3U', or three lengths in mm such as '100x100x340'",
}


def with_table_points(values: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Replace names of files in laws, relative to a directory, by the points of the files; keep all other values."""
    changed = dict(values)
    if isinstance(changed.get("spring"), str):
        changed["spring"] = _law_with_points(changed["spring"], folder)
    if "springs" in changed:
        changed["springs"] = _springs_with_points(changed["springs"], folder)
    return changed


def _springs_with_points(springs: Any, folder: Path) -> Any:
    try:
        laws = dict(springs)
    except (TypeError, ValueError):
        return springs
    laws = {hinge: _law_with_points(law, folder) if isinstance(law, str) else law for hinge, law in laws.items()}
    return laws if isinstance(springs, Mapping) else tuple(laws.items())


def _law_with_points(law: str, folder: Path) -> str:
    from hcsearch.scenes.laws import law_named, spring_law  # noqa: PLC0415 - as above

    text = spring_law(law, folder)
    law_named(text)  # refuses what is no law
    return text
