"""The parameters of an assembly, from degrees, millimetres and columns x rows."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from hcsearch.basics.errors import HcsearchError
from hcsearch.library.assemblies.named_assembly import Assembly, Parameters
from hcsearch.scenes.scene import warn_of_panel_size

if TYPE_CHECKING:
    from hcsearch.designs.panel_sizes import PanelSize

LENGTH_PARAMETERS = ("base", "thickness", "side", "width")


def parameters_of(assembly: Assembly, given: Mapping[str, Any]) -> Parameters:
    """The assembly's own parameters, with those changed that are given: degrees, millimetres, columns x rows.

    HcsearchWarning for lengths that are probably not meant.
    """
    changes: dict[str, Any] = {}
    for name, value in given.items():
        if value is None:
            continue
        if name not in (*LENGTH_PARAMETERS, "alpha", "size"):
            raise HcsearchError(f"assemblies have no {name!r}: they have alpha, size, {', '.join(LENGTH_PARAMETERS)}")
        if name == "size":
            changes[name] = _size(str(value))
        else:
            changes[name] = math.radians(float(value)) if name == "alpha" else 1e-3 * float(value)
    for name in changes:
        if name not in assembly.uses:
            option = "SIZE" if name == "size" else f"--{name}"
            raise HcsearchError(f"{assembly.name} does not depend on {option}: leave it out")
    parameters = replace(assembly.defaults, **changes)
    if changes.keys() & {*LENGTH_PARAMETERS}:
        warn_of_panel_size(_panel(assembly, parameters), None)
    return parameters


def _panel(assembly: Assembly, parameters: Parameters) -> PanelSize:
    """The sizes of an assembly's panels, of triangles the base on both sides."""
    side = parameters.base if "base" in assembly.uses else parameters.side
    return (side, parameters.width if "width" in assembly.uses else side, parameters.thickness)


def _size(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"([0-9]{1,4})x([0-9]{1,4})", text)
    if match is None:
        raise HcsearchError(f"{text!r} is no size: write columns x rows, such as 3x2")
    return int(match[1]), int(match[2])
