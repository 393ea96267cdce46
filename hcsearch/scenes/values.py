"""The table of a scene's values: what each one is, and how kinds of them are read and written."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from numbers import Real
from pathlib import Path
from typing import Any

from hcsearch.basics.errors import HcsearchError, SceneError, wrong_kind_message
from hcsearch.basics.vocabulary import WAYS, Way
from hcsearch.designs.panel_sizes import MAX_PANEL_LENGTH, MIN_PANEL_LENGTH, panel_text, read_panel

MAX_SCENE_VALUE = 1e12
"""Greatest value of all numbers of a scene except shares."""


@dataclass(frozen=True)
class ValueKind:
    """A kind of values: how one is read and written.

    read : reads one, given the name of the value; TypeError, ValueError or OverflowError for anything else. remedy :
    what to write, in messages. types : what Python may give, and made : what else to give, in messages; files and
    command lines may give others, too. write : converts one to what files hold. in_mm : whether files hold mm.
    """

    read: Callable[[str, Any], Any]
    remedy: str
    types: tuple[type, ...] = (object,)
    made: str = ""
    write: Callable[[Any], Any] = lambda value: list(value) if isinstance(value, tuple) else value
    in_mm: bool = False


@dataclass(frozen=True)
class SceneValue:
    """A value of a scene: a row of the table that `Scene` is.

    unit : in SI; empty without one. meaning : a phrase, for files, help and the reference. more : sentences for the
    reference alone. unset : what holds where the value is not given, if it is not the default. example : shown in files
    to start from in place of the default. section : of files and of the reference; empty on top of a file. by_hinge :
    whether single hinges may have their own. option : the commands that have an option for it (with `loads`, `springs`
    or a `time`), and its metavar.
    """

    unit: str
    meaning: str
    kind: ValueKind
    default: Any
    name: str = ""
    more: str = ""
    unset: str = ""
    example: Any = None
    section: str = ""
    by_hinge: bool = False
    option: tuple[str, str] = ("", "")

    @property
    def key(self) -> str:
        """The key in a file."""
        return f"{self.name}_mm" if self.kind.in_mm else self.name

    @property
    def is_number(self) -> bool:
        """Whether it is one number."""
        return isinstance(self.default, float) or isinstance(self.example, float)

    @property
    def is_table(self) -> bool:
        """Whether files give it as a table by hinge."""
        return isinstance(self.example, dict)

    @property
    def help(self) -> str:
        """The help of its option."""
        default = f"{self.default:g}" if self.is_number and not self.unset else self.unset or self.default
        return f"{self.sentence(self.unit)}  [default: {default}]"

    def sentence(self, unit: str) -> str:
        """Return the meaning with a unit."""
        return f"{self.meaning[0].upper()}{self.meaning[1:]}{f', {unit}' if unit else ''}."

    def paragraph(self, unit: str) -> str:
        """Return all that the reference says, with a unit."""
        unset = f"Unless given: {self.unset}." if self.unset else ""
        return " ".join(filter(None, (self.sentence(unit), unset, self.more)))

    def read(self, value: Any) -> Any:
        """Parse a value; SceneError where it is of another type or out of range."""
        try:
            return self.kind.read(self.name, value)
        except (TypeError, ValueError, OverflowError) as error:
            if isinstance(error, HcsearchError):
                raise
            raise SceneError(f"{self.name} cannot be {shown_value(value)}: {self.kind.remedy}") from error

    def checked(self, value: Any) -> Any:
        """Parse a value that Python gives; SceneError as above."""
        if not isinstance(value, self.kind.types):
            raise SceneError(wrong_kind_message(self.name, value, self.kind.made))
        return self.read(value)


def shown_value(value: Any) -> str:
    """Return a value for a message, in 60 characters at most."""
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _refused(key: str, value: Any, low: float) -> SceneError:
    return SceneError(f"{key} cannot be {shown_value(value)}: give numbers from {low:g} to {MAX_SCENE_VALUE:g}")


def _number(low: float = 0.0, high: float = MAX_SCENE_VALUE) -> ValueKind:
    """Return the kind of numbers between limits."""

    def read(_key: str, value: Any) -> float:
        if isinstance(value, bool) or not low <= float(value) <= high:
            raise ValueError
        return float(value)

    remedy = f"give a number from {low:g} to {high:g}"
    return ValueKind(read, remedy, (Real,), "a number")


def numbers(count: int, remedy: str, low: float = -MAX_SCENE_VALUE, *, rising: bool = False) -> ValueKind:
    """Return the kind of several numbers, a list or a text; rising : whether they are positive, each above the last."""

    def read(key: str, value: Any) -> tuple[float, ...]:
        parts = tuple(float(part) for part in (value.split(",") if isinstance(value, str) else value))
        if len(parts) != count:
            raise ValueError
        if not all(low <= part <= MAX_SCENE_VALUE for part in parts):
            raise _refused(key, value, low)
        if rising and not all(before < after for before, after in pairwise((0.0, *parts))):
            raise ValueError
        return parts

    return ValueKind(read, remedy)


def panel_or(*words: str) -> ValueKind:
    """Return the kind of names of panels, with words in their place."""

    def read(_key: str, value: Any) -> str:
        if isinstance(value, bool):
            raise ValueError
        return str(value) if value in words else _label(value)

    remedy = f"give {', '.join(words)}, or the number of a panel"
    made = f"{', '.join(map(repr, words))}, or the name of a panel, such as '3'"
    return ValueKind(read, remedy, (int, str), made)


def by_hinge(read: Callable[[str, Any], Any], remedy: str, made: str, write: Callable[[Any], Any]) -> ValueKind:
    """Return the kind of tables by hinge; read : reads one entry, given the name of its hinge."""

    def read_all(key: str, value: Any) -> tuple[tuple[str, Any], ...]:
        entries: dict[str, Any] = {}
        for hinge, own in dict(value).items():
            name = _label(hinge)
            if name in entries:
                raise SceneError(f"{key} names hinge {name} twice: leave one out")
            entries[name] = read(name, own)
        return tuple(entries.items())

    return ValueKind(read_all, remedy, (tuple,), f"pairs of a hinge and its {made}", write)


def _label(name: int | str) -> str:
    """Parse the name of a panel or hinge, removing leading zeros."""
    from hcsearch.shape.labels import is_label  # noqa: PLC0415 - loads kernels, which scenes of the program do without

    if not is_label(str(name)):
        raise ValueError
    return "+".join(str(int(part)) for part in str(name).split("+"))


def read_text(_key: str, value: Any) -> str:
    """Return a text; ValueError for other values."""
    if not isinstance(value, str):
        raise ValueError
    return value


def read_law(key: str, value: Any) -> str:
    """Parse a law, with the points of a table in place of the name of its file, relative to the current directory."""
    from hcsearch.scenes.laws import law_named, spring_law  # noqa: PLC0415 - as above

    text = spring_law(read_text(key, value), Path())
    law_named(text)  # refuses what is no law
    return text


def read_release(key: str, value: Any) -> str:
    """Parse when a hinge is released; SceneError for anything else."""
    from hcsearch.scenes.releases import release_named  # noqa: PLC0415 - as above

    release_named(read_text(key, value))
    return str(value)


def _read_ways(_key: str, value: Any) -> tuple[Way, ...]:
    if value == "either":
        return WAYS
    ways = (value,) if isinstance(value, str) else tuple(value)
    if not ways or not set(ways) <= set(WAYS) or len(set(ways)) < len(ways):
        raise ValueError
    return ways


def _written_ways(ways: tuple[Way, ...]) -> str | list[str]:
    return "either" if ways == WAYS else ways[0] if len(ways) == 1 else list(ways)


def _read_size(key: str, value: Any) -> Any:
    if not isinstance(value, tuple):
        return read_panel(read_text(key, value))
    length, width, thickness = value
    if not all(MIN_PANEL_LENGTH <= side <= MAX_PANEL_LENGTH for side in (length, width, thickness)):
        raise ValueError
    return (length, width, thickness)


def _read_boxes(key: str, value: Any) -> tuple[tuple[float, ...], ...]:
    boxes = []
    for box in value:
        parts = tuple(float(part) for part in box)
        if len(parts) != 6 or isinstance(box, str):
            raise ValueError
        for low, some in ((-MAX_SCENE_VALUE, parts[:3]), (0.0, parts[3:])):
            if not all(low <= part <= MAX_SCENE_VALUE for part in some):
                raise _refused(key, box, low)
        boxes.append(parts)
    return tuple(boxes)


POSITIVE, AMOUNT, FRACTION = _number(1e-9), _number(), _number(0.0, 1.0)
SMALL_ANGLE, SMALL_LENGTH = _number(0.0, 0.1), _number(0.0, 0.1 * MAX_PANEL_LENGTH)
LENGTH_IN_MM = replace(AMOUNT, write=lambda value: float(f"{1e3 * value:.10g}"), in_mm=True)
NAME = ValueKind(read_text, "", (str,), "a text, such as 'solar'")
LAW = ValueKind(read_law, "write a law, such as 'linear:0.1'")
JOININGS = ValueKind(
    _read_ways,
    "write 'rigid', 'hinged', 'merged' or 'either', or a list of ways in the order of trial",
    write=_written_ways,
)
SIZE = ValueKind(
    _read_size,
    "write panel_mm = '50x50x6'",
    (tuple,),
    "length, width and thickness in m, such as (0.05, 0.05, 0.006)",
    panel_text,
    in_mm=True,
)
BOXES = ValueKind(_read_boxes, "write [[x, y, z, length, width, height]] in m, a list of boxes")
ENVELOPE = replace(
    NAME,
    remedy="write '3U', or three lengths in mm such as '100x100x340'",
    made="a name such as '3U', or three lengths in mm such as '100x100x340'",
)
