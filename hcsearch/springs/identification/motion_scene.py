"""Fitted values in the form that a scene file takes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import tomli_w

from hcsearch.scenes.laws import Law, linear_law, scaled_law
from hcsearch.scenes.setup import Setup
from hcsearch.shape.labels import labels_of
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.identification.motion_parameters import MotionParameters

ON_TOP = ("springs",)
"""Values that stand above the table `scene` of a file."""


def scene_values(linkage: Linkage, fitted: MotionParameters, setup: Setup, x: Any) -> dict[str, Any]:
    """Return the fitted values by the names of a scene file, with six digits.

    fitted : the parameters, at coordinates x. setup : with the values there. Friction replaces that of the scene and
    its harness.
    """
    values: dict[str, Any] = {}
    terms = {parameter.term for parameter in fitted.parameters}
    laws = list(fitted.setup.laws)
    for at, parameter in zip(x, fitted.parameters, strict=True):
        if parameter.kind == "factor":
            value = _six_digits(parameter.value(float(at)))
            for hinge in parameter.hinges:
                laws[hinge] = linear_law(value) if parameter.unit else scaled_law(laws[hinge], value)
        elif parameter.kind == "amount":
            values[parameter.term] = _six_digits(parameter.value(float(at)))
    if any(term.startswith("stiffness") for term in terms):
        values = _laws(linkage, laws) | values
    if "friction" in terms and any(fitted.setup.resistance):
        values["harness"] = 0.0
    if "gravity" in terms:
        values["gravity"] = [_six_digits(part) for part in setup.gravity]
    return values


def scene_lines(values: Mapping[str, Any]) -> str:
    """Return fitted values as lines of a scene file."""
    on_top = {key: value for key, value in values.items() if key in ON_TOP}
    return tomli_w.dumps({"scene": {key: value for key, value in values.items() if key not in on_top}} | on_top)


def _laws(linkage: Linkage, laws: list[Law]) -> dict[str, Any]:
    """Return one law of all hinges, or those of single hinges by their names."""
    texts = [law.text for law in laws]
    if len(set(texts)) == 1:
        return {"spring": texts[0]}
    return {"springs": dict(zip(labels_of(linkage).hinges, texts, strict=True))}


def _six_digits(value: float) -> float:
    return float(f"{value:.6g}")
