"""Settings of an export beside its subject. Each format takes some of them, and lists which (`takes`)."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any, Literal, get_args

from hcsearch.basics.errors import HcsearchError

ExportEnd = Literal["flat", "folded"]
ExportState = ExportEnd | float
"""An end of the motion, or a share of it: 0 packed, 1 flat."""
SheetKind = Literal["assembled", "panels"]
SHEET_KINDS: tuple[SheetKind, ...] = get_args(SheetKind)
SheetProfile = Literal["laser", "simulator"]
SHEET_PROFILES: tuple[SheetProfile, ...] = get_args(SheetProfile)
MAX_KERF_MM = 10.0
MIN_TIMESTEP_S, MAX_TIMESTEP_S = 1e-9, 1.0


@dataclass(frozen=True)
class ExportSettings:
    """Settings of an export; lengths in millimetres, as the files have them.

    state : in which solids are written. sheet : the sheet in one piece, or its panels apart. kerf_mm : width of a cut,
        half of which outlines are moved outwards by. hinge_gap_mm : between panels apart, along a hinge.
    profile : colours and kinds of lines, of laser cutters or of Origami Simulator.
    part : name of the one panel that is written; all where it is None. contact : whether panels collide in a simulator.
    timestep_s : of a simulator, s; None for one that fits the scene. stem : name of the file without its ending, by
        which files beside it are named. ending : of the file, which sets the style of a list. Both are known when the
        file is written.
    Errors: HcsearchError for values that the options of `hcsearch export` do not take.
    """

    state: ExportState = "flat"
    sheet: SheetKind = "assembled"
    kerf_mm: float = 0.0
    hinge_gap_mm: float = 0.0
    profile: SheetProfile = "laser"
    part: str | None = None
    contact: bool = False
    timestep_s: float | None = None
    stem: str = "array"
    ending: str = ""

    def __post_init__(self) -> None:
        """Check the values, as Python may give others than the command line."""
        if self.state not in get_args(ExportEnd):
            object.__setattr__(self, "state", read_export_state(str(self.state)))
        _check_word("sheet", self.sheet, SHEET_KINDS)
        _check_word("profile", self.profile, SHEET_PROFILES)
        _check_number("kerf_mm", self.kerf_mm, 0.0, MAX_KERF_MM)
        _check_number("hinge_gap_mm", self.hinge_gap_mm, 0.0, math.inf)
        if self.timestep_s is not None:
            _check_number("timestep_s", self.timestep_s, MIN_TIMESTEP_S, MAX_TIMESTEP_S)


SETTING_NAMES = tuple(field.name for field in fields(ExportSettings) if field.name not in {"stem", "ending"})
"""What users set; the others are known from the name of the file."""


def read_export_state(text: str) -> ExportState:
    """The state that a text names; HcsearchError for what is none."""
    if text in get_args(ExportEnd):
        return "flat" if text == "flat" else "folded"
    try:
        share = float(text)
    except ValueError:
        share = -1.0
    if not 0.0 <= share <= 1.0:
        raise HcsearchError(f"{text!r} is no state: write flat, folded, or a share of the motion, 0 packed to 1 flat")
    return share


def _check_word(name: str, value: object, words: tuple[str, ...]) -> None:
    if value not in words:
        raise HcsearchError(f"{name} cannot be {value!r}: choose {' or '.join(words)}")


def _check_number(name: str, value: Any, least: float, most: float) -> None:
    known = isinstance(value, int | float) and not isinstance(value, bool)
    if not (known and least <= value <= most and math.isfinite(value)):
        bounds = f"from {least:g}" + ("" if math.isinf(most) else f" to {most:g}")
        raise HcsearchError(f"{name} cannot be {value!r}: give a number {bounds}")
