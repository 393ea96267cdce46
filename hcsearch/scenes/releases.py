"""Hold-downs of hinges: each keeps its hinge from opening until a time, or until another hinge has opened.

Their notations, times in s and fold angles in rad:

    TIME s                           0.5 s
    hinge HINGE at ANGLE rad         hinge 7 at 0.2 rad
"""

from __future__ import annotations

import re
from typing import NamedTuple

from hcsearch.basics.errors import SceneError
from hcsearch.scenes.laws import UNSIGNED_NUMBER

_AFTER_TIME = re.compile(rf"({UNSIGNED_NUMBER})\s*s", re.ASCII)
_AFTER_HINGE = re.compile(rf"hinge\s+(\d+(?:\+\d+)*)\s+at\s+({UNSIGNED_NUMBER})\s*rad", re.ASCII)
MAX_RELEASE_TIME, MAX_RELEASE_ANGLE = 1e12, 3.14
"""Latest time of a release, s, and greatest fold angle of the hinge that releases another, rad."""


class Release(NamedTuple):
    """When a hinge is released: at a time (s), or, with a time of -1, when another has opened to an angle (rad)."""

    time: float
    hinge: str = ""
    angle: float = 0.0


def release_named(text: str) -> Release:
    """Parse the notation of a release; SceneError for others."""
    after_time, after_hinge = _AFTER_TIME.fullmatch(text.strip()), _AFTER_HINGE.fullmatch(text.strip())
    if after_time is not None and float(after_time[1]) <= MAX_RELEASE_TIME:
        return Release(float(after_time[1]))
    if after_hinge is not None and 0.0 < float(after_hinge[2]) <= MAX_RELEASE_ANGLE:
        return Release(-1.0, after_hinge[1], float(after_hinge[2]))
    raise SceneError(
        f"cannot read the release {text[:60]!r}: write a time, such as '0.5 s', or 'hinge 7 at 0.2 rad', with an angle "
        f"above 0, up to {MAX_RELEASE_ANGLE:g}"
    )
