"""What may be said about an export beside its subject. Each format heeds some of it, and lists which (`takes`)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from hcsearch.errors import HcsearchError

End = Literal["flat", "folded"]
State = End | float
"""An end of the motion, or a share of it: 0 packed, 1 flat."""
Sheet = Literal["assembled", "panels"]
SHEETS: tuple[Sheet, ...] = get_args(Sheet)
Profile = Literal["laser", "simulator"]
PROFILES: tuple[Profile, ...] = get_args(Profile)


@dataclass(frozen=True)
class Settings:
    """Settings of an export; lengths in millimetres, as the files have them.

    state : in which solids are written. sheet : the sheet in one piece, or its panels apart. kerf_mm : width of a cut,
        half of which outlines are moved outwards by. hinge_gap_mm : between panels apart, along a hinge.
    profile : colours and kinds of lines, of laser cutters or of Origami Simulator.
    part : name of the one panel that is written; all where it is None. contact : whether panels collide in a simulator.
    timestep_s : of a simulator, s; None for one that fits the scene. stem : name of the file without its ending, by
        which files beside it are named; known when it is written.
    """

    state: State = "flat"
    sheet: Sheet = "assembled"
    kerf_mm: float = 0.0
    hinge_gap_mm: float = 0.0
    profile: Profile = "laser"
    part: str | None = None
    contact: bool = False
    timestep_s: float | None = None
    stem: str = "array"


def read_state(text: str) -> State:
    """The state that a text names; HcsearchError for what is none."""
    if text in get_args(End):
        return "flat" if text == "flat" else "folded"
    try:
        share = float(text)
    except ValueError:
        share = -1.0
    if not 0.0 <= share <= 1.0:
        raise HcsearchError(f"{text!r} is no state: write flat, folded, or a share of the motion, 0 packed to 1 flat")
    return share
