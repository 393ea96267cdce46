"""Named assemblies: their source, parameters, and the construction of their flat patterns."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import PatternError, SizeError
from hcsearch.shape.pattern import Pattern

MIN_ASSEMBLY_LENGTH, MAX_ASSEMBLY_LENGTH = 1e-15, 1e6
"""Range of lengths (m) whose squares and products neither overflow nor underflow."""
MIN_BASE_ANGLE, MAX_BASE_ANGLE = 1e-4, 90 - 1e-4
"""Range of base angles of isosceles triangles, degrees."""
MAX_ASSEMBLY_PARTS = 1000
"""Limit of columns times rows of an array, which takes about a minute and half a gigabyte."""


def check_base_angle(degrees: float) -> None:
    """Check a base angle of an isosceles triangle, degrees; PatternError where it is out of range."""
    if not MIN_BASE_ANGLE <= degrees <= MAX_BASE_ANGLE:
        raise PatternError(
            f"an isosceles triangle has no base angle of {degrees:g} degrees: give one between 0 and 90, from "
            f"{MIN_BASE_ANGLE:g} to {MAX_BASE_ANGLE:g}"
        )


@dataclass(frozen=True)
class Parameters:
    """The parameters of assemblies; lengths in metres, angles in rad.

    alpha : base angle of the isosceles triangles of chapter 5.
    base : base of those triangles.
    thickness : of all panels.
    side : of the squares of chapter 6, or the length of its rectangles.
    width : of rectangles.
    size : columns and rows of an array.
    """

    alpha: float = math.radians(70)
    base: float = 0.030
    thickness: float = 0.010
    side: float = 0.050
    width: float = 0.040
    size: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        check_base_angle(math.degrees(self.alpha))
        for name in ("base", "thickness", "side", "width"):
            length = getattr(self, name)
            if not MIN_ASSEMBLY_LENGTH <= length <= MAX_ASSEMBLY_LENGTH:
                bounds = f"from {MIN_ASSEMBLY_LENGTH * 1e3:g} to {MAX_ASSEMBLY_LENGTH * 1e3:g} mm"
                raise PatternError(f"a {name} of {length * 1e3:g} mm does not exist: give a positive length, {bounds}")
        if self.size is not None and min(self.size) < 1:
            raise PatternError(f"{self.size[0]} x {self.size[1]} is no array: give positive whole numbers")
        if self.size is not None and self.size[0] * self.size[1] > MAX_ASSEMBLY_PARTS:
            raise SizeError(
                f"{self.size[0]} x {self.size[1]} is too large an array: give columns and rows whose product is at "
                f"most {MAX_ASSEMBLY_PARTS}"
            )


@dataclass(frozen=True)
class Assembly:
    """A named assembly of the thesis.

    source : section and figure of the thesis.
    parameter_names : the parameters on which it depends (fields of `Parameters`).
    build : returns the flat pattern for given parameters.
    generic_angles : returns fold angles of a generic state of the motion, where these are known in closed form;
        otherwise the motion is followed from the folded state.
    hindrance : returns why the panels cannot move without interference, where that is known.
    has_element_loops : whether the pattern's loops are elements whose D-H closure matrix is worth printing.
    separate_hinge_count : number of hinges of its parts before they are joined.
    published : facts that the thesis states for all parameters, under the names of `describe`.
    published_at_defaults : facts that it states for the default parameters.
    notes : remarks for users, above all where the thesis and the geometry disagree.
    """

    name: str
    title: str
    source: str
    parameter_names: tuple[str, ...]
    build: Callable[[Parameters], Pattern]
    generic_angles: Callable[[Parameters], Reals] | None = None
    hindrance: Callable[[Parameters], str | None] | None = None
    has_element_loops: bool = False
    separate_hinge_count: int | None = None
    published: Mapping[str, object] = field(default_factory=dict)
    published_at_defaults: Mapping[str, object] = field(default_factory=dict)
    defaults: Parameters = field(default_factory=Parameters)
    notes: tuple[str, ...] = ()
