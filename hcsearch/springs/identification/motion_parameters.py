"""Parameters of a scene that are fitted to films, as coordinates near 1 that a least-squares method can vary."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import MotionTerm
from hcsearch.motion.collision.panel_prisms import REFERENCE_EDGE_LENGTH, scale_of
from hcsearch.scenes.laws import FREE_LAW, Law, linear_law, scaled_law
from hcsearch.scenes.scene import SceneVector
from hcsearch.scenes.setup import Setup, with_dampings, with_resistance
from hcsearch.shape.labels import labels_of
from hcsearch.shape.linkage import Linkage

GRAVITY = 9.81
"""Acceleration of gravity (m/s^2) whose direction is fitted where the scene has none."""
DAMPING_SECONDS = 0.043
"""Damping over stiffness (s) at the coordinate 1 of a damper, as in the scene `default`."""
FRICTION_SHARE = 0.1
"""Friction at the coordinate 1, as a share of the greatest mean moment of the springs."""
STIFFNESS_TERMS: tuple[MotionTerm, ...] = ("stiffness", "stiffness-by-law", "stiffness-by-hinge")
"""Terms that fit springs; only one of them can be taken."""
AXES = ("+x", "-x", "+y", "-y", "+z", "-z")
_VECTORS = np.concatenate([[row, -row] for row in np.eye(3)])


@dataclass(frozen=True)
class Parameter:
    """A fitted number.

    kind : `factor`, the value is scale exp(x), above 0; `amount`, scale x, 0 or more; `tilt`, x (rad), the angle of
    gravity from an axis towards another. unit : of the value. hinges : those whose springs a factor changes.
    """

    name: str
    unit: str
    term: MotionTerm
    kind: Literal["factor", "amount", "tilt"]
    scale: float = 1.0
    hinges: tuple[int, ...] = ()

    def value(self, x: float) -> float:
        """Return the value at a coordinate."""
        return self.scale * (math.exp(x) if self.kind == "factor" else x)


@dataclass(frozen=True)
class MotionParameters:
    """The parameters of some terms, and the setup whose other values they leave as they are.

    axis : number in `AXES` of the direction from which tilts of gravity count.
    """

    setup: Setup
    parameters: tuple[Parameter, ...]
    axis: int = 5

    def setup_at(self, x: Reals) -> Setup:
        """Return the setup with the values at coordinates, (n_parameters,)."""
        setup, laws = self.setup, list(self.setup.laws)
        changes: dict[str, object] = {}
        tilts = [float(at) for at, parameter in zip(x, self.parameters, strict=True) if parameter.kind == "tilt"]
        for at, parameter in zip(x, self.parameters, strict=True):
            value = parameter.value(float(at))
            if parameter.kind == "factor":
                for hinge in parameter.hinges:
                    laws[hinge] = _changed_law(laws[hinge], value, parameter.unit)
            elif parameter.term == "damping":
                setup = with_dampings(setup, [value] * len(laws))
            elif parameter.term == "friction":
                setup = with_resistance(setup, value)
            elif parameter.term == "drag":
                changes["drag"] = value
        if tilts:
            changes["gravity"] = tilted(_magnitude(setup), self.axis, tilts)
        return replace(setup, laws=tuple(laws), **changes)  # type: ignore[arg-type]

    @property
    def lower(self) -> Reals:
        """Least values of the coordinates: amounts are 0 or more."""
        return np.array([0.0 if parameter.kind == "amount" else -math.inf for parameter in self.parameters])

    def about_axis(self, axis: int) -> MotionParameters:
        """Return the parameters with tilts of gravity from another axis."""
        names = iter(_tilt_names(axis))
        parameters = tuple(
            replace(parameter, name=next(names)) if parameter.kind == "tilt" else parameter
            for parameter in self.parameters
        )
        return replace(self, parameters=parameters, axis=axis)


def motion_parameters(linkage: Linkage, setup: Setup, terms: Sequence[MotionTerm]) -> MotionParameters:
    """Return the parameters of terms; HcsearchError for several terms of springs, or without any spring."""
    springs = [term for term in terms if term in STIFFNESS_TERMS]
    if len(springs) > 1:
        raise HcsearchError(f"springs are fitted by {springs[0]} or by {springs[1]}, not both: leave one out")
    scales = _scales(linkage, setup)
    parameters: list[Parameter] = []
    for term in terms:
        if term in STIFFNESS_TERMS:
            parameters += _springs(linkage, setup.laws, term)
        elif term == "gravity":
            parameters += [Parameter(name, "rad", term, "tilt") for name in _tilt_names(5)]
        else:
            unit = {"damping": "N m s/rad", "friction": "N m", "drag": "kg/m^3"}[term]
            parameters.append(Parameter(term, unit, term, "amount", scales[term]))
    return MotionParameters(setup, tuple(parameters))


def tilted(magnitude: float, axis: int, tilts: Sequence[float]) -> SceneVector:
    """Return gravity (m/s^2) tilted from an axis by an angle (rad) whose parts are towards the two axes that follow."""
    angle = math.hypot(*tilts)
    share = math.sin(angle) / angle if angle else 1.0
    first, second = _across(axis)
    x, y, z = (magnitude * (math.cos(angle) * _VECTORS[axis] + share * (tilts[0] * first + tilts[1] * second))).tolist()
    return (x, y, z)


def nearest_axis(gravity: SceneVector) -> int:
    """Return the number in `AXES` of the axis that is nearest to gravity."""
    return int((_VECTORS @ np.array(gravity)).argmax())


def tilts_of(gravity: SceneVector, axis: int) -> tuple[float, float]:
    """Return the tilts of gravity from an axis (rad); the inverse of `tilted`."""
    direction = np.array(gravity) / math.hypot(*gravity)
    first, second = (float(direction @ part) for part in _across(axis))
    across = math.hypot(first, second)
    angle = math.atan2(across, float(direction @ _VECTORS[axis]))
    share = angle / across if across else 1.0
    return share * first, share * second


def _across(axis: int) -> tuple[Reals, Reals]:
    """Return the unit vectors of the two axes that follow an axis, cyclically."""
    k = axis // 2
    return np.eye(3)[(k + 1) % 3], np.eye(3)[(k + 2) % 3]


def _tilt_names(axis: int) -> list[str]:
    return [f"gravity, from {AXES[axis]} to {'xyz'[(axis // 2 + step) % 3]}" for step in (1, 2)]


def _magnitude(setup: Setup) -> float:
    return math.hypot(*setup.gravity) or GRAVITY


def _springs(linkage: Linkage, laws: Sequence[Law], term: MotionTerm) -> list[Parameter]:
    """Return a parameter for each group of springs."""
    names = labels_of(linkage).hinges
    sprung = [hinge for hinge, law in enumerate(laws) if law != FREE_LAW]
    if not sprung:
        raise HcsearchError("the scene has no spring to fit: give hinges one, such as spring = 'linear:0.1'")
    groups: dict[object, list[int]] = {}
    for hinge in sprung:
        key = {"stiffness": None, "stiffness-by-law": laws[hinge], "stiffness-by-hinge": hinge}[term]
        groups.setdefault(key, []).append(hinge)
    parameters = []
    for hinges in groups.values():
        name = "stiffness" if len(groups) == 1 else f"stiffness of {', '.join(names[hinge] for hinge in hinges)}"
        stiffness = _linear_stiffness([laws[hinge] for hinge in hinges])
        unit, scale = ("", 1.0) if stiffness is None else ("N m/rad", stiffness)
        parameters.append(Parameter(name, unit, term, "factor", scale, tuple(hinges)))
    return parameters


def _linear_stiffness(laws: Sequence[Law]) -> float | None:
    """Return the stiffness of laws (N m/rad) that are all one linear law through the origin; else None."""
    stiffness = laws[0].straight.moment(1.0)
    same = stiffness > 0.0 and all(law == linear_law(stiffness) for law in laws)
    return stiffness if same else None


def _changed_law(law: Law, value: float, unit: str) -> Law:
    return linear_law(value) if unit else scaled_law(law, value)


def _scales(linkage: Linkage, setup: Setup) -> dict[MotionTerm, float]:
    """Return the values at which damping, friction and drag count as much as springs and inertia do."""
    stiffness = max(float(np.mean([law.mean_stiffness for law in setup.laws])), 1e-12)
    return {
        "damping": DAMPING_SECONDS * stiffness,
        "friction": FRICTION_SHARE * stiffness * math.pi,
        # a panel that moves by its edge sweeps air of this density times its volume
        "drag": setup.density * linkage.pattern.thickness / scale_of(linkage) / REFERENCE_EDGE_LENGTH,
    }
