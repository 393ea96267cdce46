"""Typed access to the XML of models and to files of closures; springs and loads of a model, which are not used."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as Xml

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import InputFileError
from hcsearch.basics.vocabulary import listed
from hcsearch.scenes import Scene
from hcsearch.scenes.laws import law_named
from hcsearch.search.own_patterns.fold_values import MAX_COORDINATE, is_finite_number
from hcsearch.system.reading import read_text_file

MAX_MODEL_BYTES = 64 * 2**20
"""Limit of the size of a model, of its file of closures, and of all its meshes together."""


def model_error(path: str | Path, what: str) -> InputFileError:
    """Return the error for a damaged model, or one of another program."""
    return InputFileError(
        f"{path} is no model that hcsearch export wrote: {what}; export it anew, or give the flat pattern as a file "
        ".fold"
    )


@dataclass(frozen=True)
class ModelPart:
    """An element of the XML of a model.

    Parameters
    ----------
    element
        The element.
    path
        The file, for messages.
    within
        The element that it is a part of, in words; empty for the outermost one.
    """

    element: Xml.Element
    path: str
    within: str = ""

    def __str__(self) -> str:
        name = self.element.get("name")
        if name is not None:
            return f"{self.element.tag} {name!r:.60}"
        return f"{self.element.tag} of {self.within}" if self.within else self.element.tag

    def wrong(self, what: str) -> InputFileError:
        """Return the error for this element; what : a clause that follows its name."""
        return model_error(self.path, f"{self} {what}")

    def parts(self, tag: str) -> Iterator[ModelPart]:
        """Yield the parts with a tag, or with a path of tags."""
        return (ModelPart(element, self.path, str(self)) for element in self.element.iterfind(tag))

    def part(self, tag: str) -> ModelPart:
        """Return the first part with a tag; InputFileError without one."""
        found = next(self.parts(tag), None)
        if found is None:
            raise self.wrong(f"has no {tag}")
        return found

    def text(self, attribute: str) -> str:
        """Return an attribute; InputFileError without it."""
        value = self.element.get(attribute)
        if not value:
            raise self.wrong(f"has no {attribute}")
        return value

    def numbers(self, attribute: str) -> Reals:
        """Return the numbers of an attribute, separated by spaces; InputFileError for other texts."""
        try:
            numbers = [float(word) for word in self.text(attribute).split()]
        except ValueError:
            raise self.wrong(f"has something else than numbers in {attribute}") from None
        if not all(map(is_finite_number, numbers)):
            raise self.wrong(f"has a number in {attribute} that is not below {MAX_COORDINATE:g}")
        return np.array(numbers)

    def vector(self, attribute: str) -> Reals:
        """Return the three numbers of an attribute; InputFileError for other texts."""
        numbers = self.numbers(attribute)
        if len(numbers) != 3:
            raise self.wrong(f"has {len(numbers)} numbers in {attribute} in place of 3")
        return numbers


def read_model_file(path: str) -> ModelPart:
    """Return the root of an XML file; InputFileError as in `read_text_file`, and for a file that is no XML."""
    text = read_text_file(path, max_bytes=MAX_MODEL_BYTES)
    if "<!DOCTYPE" in text:  # it can declare entities, which may expand to any size
        raise model_error(path, "it declares a document type (DOCTYPE)")
    try:
        return ModelPart(Xml.fromstring(text), path)
    except Xml.ParseError as error:
        raise InputFileError(f"{path} is no model, which is XML: {error}; write it by hcsearch export") from None


@dataclass(frozen=True)
class ModelClosures:
    """The data that the file of closures adds to a URDF file.

    Parameters
    ----------
    base
        The name of the link that is the root of the tree.
    packed_angles
        The fold angle (rad) of each joint in the packed state, by its name.
    welds
        Pairs of links that are parts of one panel.
    laws
        The springs of the joints, as the file states them.
    gravity
        Gravity as the file states it, m/s^2.
    floats
        Whether the base is free.
    """

    base: str
    packed_angles: dict[str, float]
    welds: list[tuple[str, str]]
    laws: tuple[Any, ...] = ()
    gravity: tuple[Any, ...] = ()
    floats: bool = False


def read_closures(model_path: str) -> ModelClosures:
    """Return the closures of a URDF file, from the file `.closure.json` beside it.

    InputFileError as in `read_text_file`, and for a file that is no JSON or lacks a value.
    """
    path = Path(model_path).with_suffix(".closure.json")
    text = read_text_file(path, "the loops, which URDF cannot hold, in", MAX_MODEL_BYTES)
    try:
        data = json.loads(text)
    except (ValueError, RecursionError):
        raise InputFileError(f"{path} holds no closures, which are JSON; export the model anew") from None
    joints, closures = _value(data, "joints", dict, path), _value(data, "closures", list, path)
    packed_angles = {name: _packed_angle(facts, name, path) for name, facts in joints.items()}
    first, second = (
        [_value(_value(closure, end, dict, path), "link", str, path) for closure in closures]
        for end in ("first", "second")
    )
    gravity = data.get("gravity_m_s2")
    return ModelClosures(
        base=_value(data, "base", str, path),
        packed_angles=packed_angles,
        welds=list(zip(first, second, strict=True)),
        laws=tuple(facts["law"] for facts in joints.values() if "law" in facts),
        gravity=tuple(gravity) if isinstance(gravity, list) else (),
        floats=data.get("base_floats") is True,
    )


def _packed_angle(facts: Any, joint: str, path: Path) -> float:
    """Return the fold angle of a joint in the packed state, rad."""
    angle = facts.get("packed_rad") if isinstance(facts, dict) else None
    if angle is None or not is_finite_number(angle):
        raise model_error(path, f"joint {joint!r:.60} has no number packed_rad")
    return float(angle)


def _value(data: Any, key: str, kind: type[dict[str, Any] | list[Any] | str], path: Path) -> Any:
    """Return a value of an object; InputFileError where it is missing or of another kind."""
    value = data.get(key) if isinstance(data, dict) else None
    if not isinstance(value, kind):
        what = "an object" if kind is dict else "a list" if kind is list else "a text"
        raise model_error(path, f"{key!r} is missing, or not {what}")
    return value


_PLAIN = Scene()
_STIFFNESS = law_named(_PLAIN.spring).mean_stiffness
_DAMPING = _PLAIN.damping_time * _STIFFNESS
_OPTIONS = {"friction": "--friction", "gravity": "--gravity", "floating base": "--held"}
"""The options of most commands for these; all others can be set in a scene only."""


def unused_loads(root: ModelPart, closures: ModelClosures | None) -> tuple[str, ...]:
    """Return a remark on the values of a model that differ from the scene `default`; no remark where none does.

    closures : the closures of a URDF file, which state its springs and gravity.
    """
    stated = _of_mjcf(root) if closures is None else _of_urdf(root, closures)
    names = [name for name, differs in stated.items() if differs]
    if not names:
        return ()
    are, come = ("is", "it comes") if len(names) == 1 and names != ["springs"] else ("are", "they come")
    options = [*(_OPTIONS[name] for name in names if name in _OPTIONS), "--scene"]
    return (f"the {listed(names, 'and')} of the model {are} not used: {come} from {listed(options, 'or')}",)


def _of_mjcf(root: ModelPart) -> dict[str, bool]:
    """Return whether the values of a model of MuJoCo differ, by their names."""
    joints = list(root.parts(".//joint"))
    return {
        "springs": _differ(joints, "stiffness", _STIFFNESS)
        or _differ(joints, "springref", 0.0)
        or next(root.parts("actuator/general"), None) is not None,
        "damping": _differ(joints, "damping", _DAMPING),
        "friction": _differ(joints, "frictionloss", 0.0),
        "gravity": _differ(root.parts("option"), "gravity", 0.0),
        "floating base": next(root.parts("worldbody/body/freejoint"), None) is not None,
    }


def _of_urdf(root: ModelPart, closures: ModelClosures) -> dict[str, bool]:
    """Return whether the values of a URDF file and its closures differ, by their names."""
    dynamics = list(root.parts("joint/dynamics"))
    return {
        "springs": any(law != _PLAIN.spring for law in closures.laws),
        "damping": _differ(dynamics, "damping", _DAMPING),
        "friction": _differ(dynamics, "friction", 0.0),
        "gravity": any(component != 0.0 for component in closures.gravity),
        "floating base": closures.floats,
    }


def _differ(parts: Iterable[ModelPart], attribute: str, plain: float) -> bool:
    """Whether some part states an attribute with anything but a given number, up to rounding."""
    return any(not _is_near(word, plain) for part in parts for word in part.element.get(attribute, "").split())


def _is_near(word: str, plain: float) -> bool:
    try:
        return math.isclose(float(word), plain, rel_tol=1e-9)
    except ValueError:
        return False
