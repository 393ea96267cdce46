"""Springs and loads of a model, which are not used: the scene has its own."""

from __future__ import annotations

import math
from collections.abc import Iterable

from hcsearch.basics.vocabulary import listed
from hcsearch.scenes import Scene
from hcsearch.scenes.laws import law_named
from hcsearch.search.own_patterns.model_parts import ModelClosures, ModelPart

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
