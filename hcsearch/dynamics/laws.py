"""Moment-angle laws of hinges: linear, quadratic, tabulated, preloaded, and tape springs that snap (thesis 2.4, 4.2.1).

A law gives the moment that drives a hinge back to the flat state, as cubic pieces over the fold angle; its energy is
their integral, so both are exact.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Reals = NDArray[np.float64]
Whole = NDArray[np.int64]
Cubic = tuple[float, float, float, float]


@dataclass(frozen=True)
class Branch:
    """Moment (N m) as cubics: `cubics[k]` holds the coefficients of 1, x, x^2, x^3 with x from `breaks[k]` (rad).

    The first piece serves below its break too, the last above.
    """

    breaks: tuple[float, ...]
    cubics: tuple[Cubic, ...]

    def energies(self) -> list[float]:
        """Energy stored at each break, J: the moment's integral from the flat state."""
        found = [0.0]
        for start, end, cubic in zip(self.breaks, self.breaks[1:], self.cubics, strict=False):
            found.append(found[-1] + _integral(cubic, end - start))
        # counted from angle 0, wherever the pieces begin
        k = max((k for k, start in enumerate(self.breaks) if start <= 0.0), default=0)
        flat = found[k] + _integral(self.cubics[k], -self.breaks[k])
        return [value - flat for value in found]


@dataclass(frozen=True)
class Law:
    """A moment-angle law; with `bent`, one that snaps.

    straight : the branch of the straight hinge, and the only one of most laws. bent : the branch after the snap.
    snap_up, snap_down : fold angles (rad) above which the straight branch is left, and below which the bent one is.
    """

    straight: Branch
    bent: Branch | None = None
    snap_up: float = math.inf
    snap_down: float = -math.inf


FREE = Law(Branch((0.0,), ((0.0, 0.0, 0.0, 0.0),)))
"""No moment."""


def linear(stiffness: float, preload: float = 0.0) -> Law:
    """Moment preload + stiffness angle (thesis eq. 4.20); N m/rad, N m. A preload holds the flat state."""
    return Law(Branch((0.0,), ((preload, stiffness, 0.0, 0.0),)))


def tables_of(laws: Sequence[Law]) -> tuple[Whole, Reals, Reals, Reals]:
    """The laws as tables: pieces (n, 2, 2) of both branches, breaks, cubics, energies at the breaks."""
    pieces = np.zeros((len(laws), 2, 2), np.int64)
    breaks: list[float] = []
    cubics: list[Cubic] = []
    energies: list[float] = []
    known: dict[Branch, tuple[int, int]] = {}
    for i, law in enumerate(laws):
        for k, branch in enumerate((law.straight, law.bent or law.straight)):
            if branch not in known:
                known[branch] = (len(breaks), len(breaks) + len(branch.breaks))
                breaks += branch.breaks
                cubics += branch.cubics
                energies += branch.energies()
            pieces[i, k] = known[branch]
    return pieces, np.array(breaks), np.array(cubics).reshape(-1, 4), np.array(energies)


def _integral(cubic: Cubic, x: float) -> float:
    a, b, c, d = cubic
    return x * (a + x * (b / 2 + x * (c / 3 + x * d / 4)))
