"""Reports of a motion of a linkage, as `hcsearch motion` writes them: a table, plain data and a picture."""

from __future__ import annotations

import json
import math
from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals, WholeNumbers
from hcsearch.basics.vocabulary import Until
from hcsearch.motion.kinematics.numerical_rank import kept_beside_singular, rank_at
from hcsearch.motion.paths.branches import REACHED_OUTCOMES, Branch, FollowedBranch
from hcsearch.motion.paths.motions import STOP_TOLERANCE, SingularEvent, stop_margins
from hcsearch.shape.angle_curves import draw_angle_curves
from hcsearch.shape.labels import Labels, label_data
from hcsearch.shape.linkage import Linkage
from hcsearch.system.figures import figure_for, label_curves, line_style, set_title
from hcsearch.system.notebooks import notebook_view
from hcsearch.system.outputs import write_output, write_table

if TYPE_CHECKING:
    import pandas as pd

MOTION_SUFFIXES = (".csv", ".parquet", ".json")
"""Endings of files with the table of a motion."""

_ROW_SPACING = 0.05
"""Greatest step of a motion, rad in the root mean square of all hinges."""


def row_step(linkage: Linkage) -> float:
    """Return the greatest arc length between two states of a motion by default, rad."""
    return _ROW_SPACING * math.sqrt(linkage.n_hinges)


class MotionRows(NamedTuple):
    """The states of a motion and the singular states between them, in their order.

    angles : (k, n_hinges), rad. lengths : arc length in the space of fold angles, rad. residuals : the greatest closure
    residual. nullities : -1 where the rank is not decided. kinds : kinds of singular states, else empty.
    least_values : (k,), the least of the singular values that vanish at singular states only; NaN where there is none.
    """

    angles: Reals
    lengths: Reals
    residuals: Reals
    nullities: WholeNumbers
    kinds: tuple[str, ...]
    least_values: Reals


@dataclass(frozen=True, eq=False, repr=False)
class LinkageMotion(ByValue):
    """The result of `follow_motion`: a motion of a linkage from a state, and the branches that begin there.

    Parameters
    ----------
    name
        The name of the folding or assembly.
    linkage
        The linkage that moves.
    labels
        Names of its panels and hinges.
    start
        The state at which the motion begins, in words.
    until
        Where the motion was to end.
    followed
        Branches, and the path with its singular states.
    """

    name: str
    linkage: Linkage
    labels: Labels
    start: str
    until: Until
    followed: FollowedBranch

    @property
    def events(self) -> tuple[SingularEvent, ...]:
        """The singular states on the way."""
        return self.followed.path.events

    @property
    def branches(self) -> tuple[Branch, ...]:
        """The branches at the start; branch k is `branches[k - 1]`."""
        return self.followed.branches.branches

    @property
    def reached(self) -> bool:
        """Whether the motion came to where it was followed until."""
        return self.followed.path.outcome in REACHED_OUTCOMES[self.until]

    @property
    def sentence(self) -> str:
        """The outcome in a sentence: where the motion ended, its length, its branch, and the singular states passed."""
        path, number = self.followed.path, self.followed.number
        if number is None:
            return path.sentence
        counts = Counter(event.kind for event in self.events)
        passed = ", ".join(f"{count} {kind}" for kind, count in counts.items()) or "none"
        ended = f"stopped, {path.sentence}" if path.outcome == "stopped" else path.sentence
        return (
            f"{ended}; arc length {path.lengths[-1]:.6g} rad along branch {number} of {len(self.branches)}; "
            f"singular states: {passed}"
        )

    @cached_property
    def rows(self) -> MotionRows:
        """The states and singular states as arrays."""
        path = self.followed.path
        # a path that ends at a singular state has it as its last state, too
        ends_singular = path.outcome in {"branch", "singular"}
        count = len(path.angles) - ends_singular
        order = np.argsort(np.r_[path.lengths[:count], [event.length for event in self.events]], kind="stable")
        angles = np.array([*path.angles[:count], *(event.angles for event in self.events)])[order]
        lengths = np.array([*path.lengths[:count], *(event.length for event in self.events)])[order]
        kinds = [*[""] * count, *(event.kind for event in self.events)]
        ranks = [rank_at(self.linkage, state) for state in angles]
        kept = [kept_beside_singular(rank) for rank in ranks]
        of_states = [-1 if number is None else self.linkage.n_hinges - number for number in kept]
        of_events = [None] * count + [event.nullity for event in self.events]
        nullities = np.array([of_events[k] or of_states[row] for row, k in enumerate(order)], np.int64)
        generic = max((number for number in kept if number is not None), default=0)
        least_values = np.array([rank.singular_values[generic - 1] if generic else math.nan for rank in ranks])
        residuals = np.array([np.abs(self.linkage.closure(state)[0]).max(initial=0.0) for state in angles])
        return MotionRows(angles, lengths, residuals, nullities, tuple(kinds[k] for k in order), least_values)

    def table(self, *, degrees: bool = False) -> pd.DataFrame:
        """Return the motion as a pandas table, one row per state, with the singular states on the way.

        Columns: `arc_length_rad` in the space of fold angles; `angle_LABEL_rad`, or `angle_LABEL_deg`, of each hinge;
        `closure_residual`, the greatest of all loops (rad, or gap over the pattern's size); `nullity`, the first-order
        degrees of freedom, missing where rounding leaves them undecided; `least_singular_value`, the least of the
        singular values that are zero at singular states only; `event`, the kind of a singular state, else empty;
        `at_stops`, the hinges at 0 or pi.
        """
        import pandas as pd  # noqa: PLC0415 - only for tables

        rows, unit = self.rows, "deg" if degrees else "rad"
        angles = np.degrees(rows.angles) if degrees else rows.angles
        columns: dict[str, Any] = {"arc_length_rad": rows.lengths}
        columns |= {f"angle_{name}_{unit}": angles[:, k] for k, name in enumerate(self.labels.hinges)}
        nullities = pd.array([None if nullity < 0 else nullity for nullity in rows.nullities.tolist()], dtype="Int64")
        at_stops = [" ".join(self._hinges_at_stops(state)) for state in rows.angles]
        return pd.DataFrame(
            {
                **columns,
                "closure_residual": rows.residuals,
                "nullity": nullities,
                "least_singular_value": rows.least_values,
                "event": list(rows.kinds),
                "at_stops": at_stops,
            }
        )

    def _hinges_at_stops(self, angles: Reals) -> list[str]:
        return [self.labels.hinges[k] for k in np.flatnonzero(np.abs(stop_margins(angles)) <= STOP_TOLERANCE)]

    def facts(self, *, degrees: bool = False) -> dict[str, Any]:
        """All results but the table as plain data, as `hcsearch motion --json` prints them; keys name their units."""
        path, branches = self.followed.path, self.followed.branches
        return {
            "linkage": self.name,
            "panels": self.linkage.n_panels,
            "hinges": self.linkage.n_hinges,
            "loops": len(self.linkage.loops),
            "start": self.start,
            "until": self.until,
            "stops": branches.keeps_stops,
            "nullity": None if branches.nullity < 0 else branches.nullity,
            "self_stresses": branches.stresses,
            "first_and_second_order": branches.sentence,
            "branches": [self._branch_facts(k, branch) for k, branch in enumerate(self.branches, 1)],
            "branch": self.followed.number,
            "outcome": path.outcome,
            "reached": self.reached,
            "reason": self.sentence,
            "arc_length_rad": float(path.lengths[-1]),
            "states": len(path.angles),
            "greatest_closure_residual": float(path.residuals.max()),
            "events": [self._event_facts(event, degrees=degrees) for event in self.events],
            "stopped_hinges": [label_data(self.labels.hinges[hinge]) for hinge in path.stopped_hinges],
        }

    def _branch_facts(self, number: int, branch: Branch) -> dict[str, Any]:
        return {
            "branch": number,
            "status": branch.status,
            "family_dimension": branch.dimension,
            "within_stops": branch.within_stops,
            "second_order_residual": float(branch.residual),
            "direction": dict(zip(self.labels.hinges, branch.direction.tolist(), strict=True)),
        }

    def _event_facts(self, event: SingularEvent, *, degrees: bool) -> dict[str, Any]:
        angles = np.degrees(event.angles) if degrees else event.angles
        return {
            "kind": event.kind,
            "arc_length_rad": float(event.length),
            "nullity": int(event.nullity),
            "least_nonzero_singular_value": float(event.least_singular_value) if event.nullity < len(angles) else None,
            "angles_deg" if degrees else "angles_rad": dict(zip(self.labels.hinges, angles.tolist(), strict=True)),
            "at_stops": [label_data(name) for name in self._hinges_at_stops(event.angles)],
        }

    def save(self, path: str | Path, *, degrees: bool = False) -> None:
        """Write the table to a file .csv or .parquet, or all results with the table to a file .json."""
        table = self.table(degrees=degrees)
        if str(path).endswith(".json"):
            rows = json.loads(table.to_json(orient="records", double_precision=15))
            text = json.dumps({**self.facts(degrees=degrees), "rows": rows}, indent=1, allow_nan=False)
            write_output(path, text + "\n", MOTION_SUFFIXES)
        else:
            write_table(path, table, MOTION_SUFFIXES)

    def picture(self, path: str | Path) -> None:
        """Draw fold angles and the least singular value over arc length, with singular states, into a picture."""
        rows = self.rows
        with figure_for(path, (9, 7)) as figure:
            above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
            draw_angle_curves(above, rows.lengths, rows.angles, self.labels.hinges)
            set_title(above, f"{self.name} from {self.start}: {self.sentence}")
            below.plot(rows.lengths, rows.least_values, marker=".", markersize=3, **line_style(0))
            below.set(xlabel="arc length, rad", ylabel="least singular value", ylim=(0.0, None))
            for event in self.events:
                for axes in (above, below):
                    axes.axvline(event.length, color="grey", linewidth=0.8, linestyle="--")
                below.annotate(
                    f"{event.kind}, nullity {event.nullity}",
                    (event.length, 0.97),
                    xycoords=below.get_xaxis_transform(),
                    fontsize="x-small",
                    rotation=90,
                    ha="right",
                    va="top",
                )
            label_curves({above: "hinge"})

    def _repr_html_(self) -> str | None:
        return notebook_view(self)

    def __repr__(self) -> str:
        return f"<{self.name} from {self.start}: {self.sentence}>"
