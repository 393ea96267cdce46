"""What a named assembly is: its source, the parameters it depends on, and how its flat pattern is made."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import PatternError, SizeError
from hcsearch.shape.pattern import Pattern

MIN_ASSEMBLY_LENGTH, MAX_ASSEMBLY_LENGTH = 1e-15, 1e6
"""Lengths (m) whose squares and products still are numbers."""
MIN_BASE_ANGLE, MAX_BASE_ANGLE = 1e-4, 90 - 1e-4
"""Base angles of isosceles triangles, degrees."""
MAX_ASSEMBLY_PARTS = 1000
"""Columns times rows of an array: about a minute and half a gigabyte."""


def check_base_angle(degrees: float) -> None:
    """Refuse what is no base angle of an isosceles triangle; PatternError."""
    if not MIN_BASE_ANGLE <= degrees <= MAX_BASE_ANGLE:
        raise PatternError(
            f"an isosceles triangle has no base angle of {degrees:g} degrees: give one between 0 and 90, from "
            f"{MIN_BASE_ANGLE:g} to {MAX_BASE_ANGLE:g}"
        )


@dataclass(frozen=True)
class Parameters:
    """Everything an assembly can depend on; lengths in metres, angles in rad.

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
    uses : names of the parameters it depends on (fields of `Parameters`).
    build : the flat pattern for given parameters.
    between : fold angles of a generic state of the motion, where it is known in closed form; otherwise the motion is
        followed from the folded state.
    hindrance : why the assembly cannot move without its panels cutting through each other, where that is known.
    elements : whether the pattern's loops are elements whose closure matrix in the D-H form is worth printing.
    apart : number of hinges of its parts before they are joined.
    published : facts that the thesis states for all parameters, under the names of `describe`.
    published_at_defaults : facts that it states for the default parameters.
    notes : what a user should know, where the thesis and the geometry part ways above all.
    """

    name: str
    title: str
    source: str
    uses: tuple[str, ...]
    build: Callable[[Parameters], Pattern]
    between: Callable[[Parameters], Reals] | None = None
    hindrance: Callable[[Parameters], str | None] | None = None
    elements: bool = False
    apart: int | None = None
    published: Mapping[str, object] = field(default_factory=dict)
    published_at_defaults: Mapping[str, object] = field(default_factory=dict)
    defaults: Parameters = field(default_factory=Parameters)
    notes: tuple[str, ...] = ()
