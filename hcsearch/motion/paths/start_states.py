"""Closed states from which a motion is followed: the ends of a linkage, given fold angles, and rows of a table."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.motion.kinematics.closing import CLOSED_LOOP_RESIDUAL
from hcsearch.motion.kinematics.local import local_at
from hcsearch.motion.kinematics.numerical_rank import NEAR_ZERO_SHARE, kept_beside_singular
from hcsearch.motion.kinematics.within_stops import close_within_stops
from hcsearch.motion.paths.motions import STOP_TOLERANCE, stop_margins
from hcsearch.shape.labels import Labels, named_hinges
from hcsearch.shape.linkage import Linkage
from hcsearch.system.csv_columns import is_number, read_columns

MAX_CLOSING_TURN = 0.05
"""Greatest turn of a hinge (rad) by which given fold angles are changed to close the loops: they may be rounded."""
MAX_CLOSING_STEPS = 30
MAX_STATES_BYTES = 64 * 2**20
"""Limit of the size of a table of states: thousands of states of hundreds of hinges."""


def resolve_start(
    linkage: Linkage, labels: Labels, start: str | Path | Reals, *, row: int | None = None, stops: bool
) -> tuple[Reals, str]:
    """Return the closed state that a start names, and its description in words.

    start : `folded`, `flat`, the name of a CSV table of states (`read_start_state`), or fold angles in rad.
    row : of the table. stops : whether the state must lie within the stops 0 and pi.
    """
    if row is not None and (isinstance(start, np.ndarray) or str(start) in {"folded", "flat"}):
        raise HcsearchError(f"row {row} is one of a table of states: name the table as the start, or leave out the row")
    if isinstance(start, np.ndarray):
        return closed_start(linkage, start, stops=stops), "the given state"
    if str(start) in {"folded", "flat"}:
        angles = linkage.folded if str(start) == "folded" else linkage.flat
        residual = np.abs(linkage.closure(angles)[0]).max(initial=0.0)
        if residual > CLOSED_LOOP_RESIDUAL:
            raise HcsearchError(
                f"the {start} state is not closed, its residual is {residual:.2g}: give fold angles of a closed state"
            )
        return angles, str(start)
    if not str(start).endswith(".csv"):
        raise HcsearchError(f"{str(start)!r} names no state: write folded, flat, or the name of a table .csv of states")
    angles, number = read_start_state(str(start), labels, row)
    return closed_start(linkage, angles, stops=stops), f"row {number} of {start}"


def near_singular_threshold(linkage: Linkage, angles: Reals) -> float | None:
    """Return a bound between singular values that vanish at a singular state near by, and all others.

    None where the state is in general position, or singular itself, so that rounding alone decides its rank.
    """
    rank = local_at(linkage, angles).rank
    kept = kept_beside_singular(rank)
    values = rank.singular_values
    if not kept or kept == len(values) or values[kept] <= rank.noise:
        return None
    return float(math.sqrt(values[kept - 1] * values[kept]))


def closed_start(linkage: Linkage, angles: Reals, *, stops: bool) -> Reals:
    """Return the closed state nearest to given fold angles, which may be rounded.

    stops : whether it must lie within the stops 0 and pi. Errors: HcsearchError for another number of angles, for
    angles that no closed state is near to, and for a state beyond the stops.
    """
    if not np.isfinite(angles).all():
        raise HcsearchError("a fold angle of the start is not a finite number: give rad, or degrees with --degrees")
    if angles.shape != (linkage.n_hinges,):
        raise HcsearchError(
            f"a state has {linkage.n_hinges} fold angles, one of each hinge, and {angles.size} are given: give numbers "
            f"for {named_hinges(linkage, range(linkage.n_hinges))}"
        )
    closed = _closed(linkage, angles)
    if stops and closed is not None and stop_margins(closed).min(initial=math.inf) < -STOP_TOLERANCE:
        local, _ = close_within_stops(linkage, angles)
        if local is None or np.abs(local.angles - angles).max() > MAX_CLOSING_TURN:
            beyond = np.flatnonzero(stop_margins(closed) < -STOP_TOLERANCE)
            raise HcsearchError(
                f"the start is beyond the stops, 0 and pi, of hinges {named_hinges(linkage, beyond)}: give another "
                "state, or --no-stops"
            )
        closed = local.angles
    turn = np.inf if closed is None else float(np.abs(closed - angles).max(initial=0.0))
    if closed is None or turn > MAX_CLOSING_TURN:
        residual = float(np.abs(linkage.closure(angles)[0]).max())
        raise HcsearchError(
            f"the loops are not closed at these fold angles, their residual is {residual:.2g}, and no closed state is "
            f"within {MAX_CLOSING_TURN} rad: give a closed state, such as a row of a table of this command"
        )
    return closed


def _closed(linkage: Linkage, angles: Reals) -> Reals | None:
    """The closed state near to fold angles, by Newton's method; None where it does not converge.

    Singular values that are zero at a singular state near by are left out: by the others the state stays beside it.
    """
    closed = np.array(angles, float)
    for _ in range(MAX_CLOSING_STEPS):
        local = local_at(linkage, closed)
        if local.residual <= CLOSED_LOOP_RESIDUAL:
            return closed
        if not math.isfinite(local.residual):
            return None
        residual = linkage.closure(closed)[0]
        kept = local.values > NEAR_ZERO_SHARE * local.values.max(initial=0.0)
        closed = closed - local.right[kept].T @ ((local.left[:, kept].T @ residual) / local.values[kept])
    return None


def read_start_state(path: str, labels: Labels, row: int | None = None) -> tuple[Reals, int]:
    """Read the fold angles (rad) of a row of a CSV table, with columns `angle_HINGE_rad` or `angle_HINGE_deg`.

    row : from 0 on, also returned; None for the last one. Errors: HcsearchError for a missing column, row or number;
    InputFileError.
    """
    names = labels.hinges
    table = read_columns(path, "angle_0_rad", what="the states", max_bytes=MAX_STATES_BYTES)
    if not table.rows:
        raise HcsearchError(f"{path} has no states: give a table with a row for each, as hcsearch motion writes it")
    number = len(table.rows) - 1 if row is None else row
    if not 0 <= number < len(table.rows):
        raise HcsearchError(f"{path} has no row {number}: its rows are 0 to {len(table.rows) - 1}")
    angles = np.empty(len(names))
    for k, name in enumerate(names):
        column = next((column for column in (f"angle_{name}_rad", f"angle_{name}_deg") if column in table.names), None)
        if column is None:
            raise HcsearchError(f"{path} has no column angle_{name}_rad or angle_{name}_deg: give one for each hinge")
        text = table.texts(column)[number]
        if not is_number(text):
            raise table.cell_error(number, column, "give another row")
        angles[k] = math.radians(float(text)) if column.endswith("_deg") else float(text)
    return angles, number
