"""Replays: motions of a linkage as few states with linear interpolation of fold angles; stacks of facets."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Literal

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.shape.labels import Labels
from hcsearch.shape.linkage import Linkage
from hcsearch.system.notebooks import notebook_view

if TYPE_CHECKING:
    import pandas as pd

ReplayAxis = Literal["time", "path"]
REPLAY_FLAT_ANGLE = 0.02
"""Largest fold angle of a state that counts as flat, rad; springs are simulated until all are below half of it."""


@dataclass(frozen=True, eq=False)
class Replay(ByValue):
    """A motion from the packed towards the flat state, as few states with linear interpolation of fold angles.

    Parameters
    ----------
    linkage
        The panels and hinges that move.
    labels
        Their names.
    axis
        `time` or `path`.
    at
        The place of each state on this axis, shape (k,), rising: a time in s, or the share of the path's length in fold
        angles from 0 (packed) to 1 (flat).
    angles
        Fold angles of the states in rad, shape (k, n_hinges).
    certified
        Intervals of the axis in which panels are certified to keep apart.
    margin
        The play on every face, in m, with which they do so.
    error
        The greatest error of a fold angle by interpolation, in rad.
    collision
        The place of the first collision and the numbers of its two panels; None if there is none or it is not known.
    title
        The name of the folding or assembly.
    source
        Where the motion comes from, in words.
    """

    linkage: Linkage
    labels: Labels
    axis: ReplayAxis
    at: Reals
    angles: Reals
    certified: tuple[tuple[float, float], ...]
    collision: tuple[float, tuple[int, int]] | None
    margin: float
    error: float
    title: str
    source: str

    def __repr__(self) -> str:
        return f"<{self.title}: {self.source}; {len(self.at)} states>"

    def _repr_html_(self) -> str | None:
        return notebook_view(self)

    def table(self) -> pd.DataFrame:
        """Return the motion as a pandas table, one row per state.

        Columns: `time_s`, or `path_share` from packed 0 to flat 1; `angle_LABEL_rad` of each hinge; `gap_mm` of the
        nearest panels among pairs that share no hinge and do not touch, negative for an overlap; `nearest`, the labels
        of these two; `touching`, the number of pairs that touch.
        """
        import pandas as pd  # noqa: PLC0415 - only for tables, as what follows

        from hcsearch.motion.collision.distances import nearest_panels  # noqa: PLC0415

        columns = {"time_s" if self.axis == "time" else "path_share": self.at}
        columns |= {f"angle_{name}_rad": self.angles[:, k] for k, name in enumerate(self.labels.hinges)}
        near, panels = nearest_panels(self.linkage, self.angles), self.labels.panels
        names = [None if i < 0 else f"{panels[i]} {panels[j]}" for i, j in near.pairs.tolist()]
        return pd.DataFrame({**columns, "gap_mm": 1e3 * near.gaps, "nearest": names, "touching": near.touching})

    @property
    def ends_flat(self) -> bool:
        """Whether the last state is flat to within `REPLAY_FLAT_ANGLE`; springs may be too slow or blocked."""
        return bool(np.abs(self.angles[-1] - self.linkage.flat).max(initial=0.0) <= REPLAY_FLAT_ANGLE)

    @property
    def faults(self) -> str:
        """The faults of the motion in a sentence: a collision, an end that is not flat, a missing certificate.

        Empty if it is certified as a whole and ends flat.
        """
        sentences = []
        if self.collision is not None:
            position, (first, second) = self.collision
            place = f"{position:.4g} s" if self.axis == "time" else f"{position:.3g} of the path"
            sentences.append(f"panels {self.labels.panels[first]} and {self.labels.panels[second]} collide at {place}")
        elif not self._certified:
            sentences.append("it is not certified that panels keep apart")
        if not self.ends_flat:
            sentences.append("not flat at the end")
        return "; ".join(sentences)

    @property
    def _certified(self) -> bool:
        """Return whether panels are certified to keep apart during the whole motion."""
        return any(begin <= self.at[0] and end >= self.at[-1] for begin, end in self.certified)

    def at_time(self, at: Reals) -> Reals:
        """Return the fold angles at places of the axis, shape (len(at), n_hinges)."""
        return np.stack([np.interp(at, self.at, column) for column in self.angles.T], axis=1)


def thin_states(at: Reals, angles: Reals, tolerance: float) -> tuple[np.ndarray, float]:
    """Return indices of states whose interpolation approximates all others within a tolerance (rad), and its error.

    at : (k,), nondecreasing; of a step without length both states are kept. Each interval is split at its largest
    error (Ramer 1972, Douglas and Peucker 1973). The error is the largest that remains.
    """
    keep = np.zeros(len(at), bool)
    keep[[0, -1]] = True
    jumps = np.flatnonzero(np.diff(at) <= 0.0)
    keep[jumps] = keep[jumps + 1] = True
    ends = np.flatnonzero(keep)
    todo, worst = list(pairwise(ends)), 0.0
    while todo:
        begin, end = todo.pop()
        if end - begin < 2:
            continue
        share = ((at[begin + 1 : end] - at[begin]) / (at[end] - at[begin]))[:, None]
        line = angles[begin] + share * (angles[end] - angles[begin])
        errors = np.abs(angles[begin + 1 : end] - line).max(axis=1)
        if errors.max() <= tolerance:
            worst = max(worst, float(errors.max()))
            continue
        middle = begin + 1 + int(errors.argmax())
        keep[middle] = True
        todo += [(begin, middle), (middle, end)]
    return np.flatnonzero(keep), worst


def stacks_of(linkage: Linkage) -> list[int] | None:
    """Return the stack of each facet in the folded state, 0 for that of facet 0; None unless there are two stacks.

    Stacks are of facets, since the panels of a rigid flat pair and merged mirror panels belong to both stacks.
    """
    middles = np.array([solid.mean(axis=(0, 1))[:2] for solid in linkage.solids(linkage.folded)])
    tolerance = 1e-3 * linkage.pattern.size
    first = np.linalg.norm(middles - middles[0], axis=1) < tolerance
    if first.all():
        return None
    second = np.linalg.norm(middles - middles[np.flatnonzero(~first)[0]], axis=1) < tolerance
    return (~first).astype(int).tolist() if (first | second).all() else None
