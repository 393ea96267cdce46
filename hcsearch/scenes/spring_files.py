"""Files of angles and moments of a spring: measurements for `hcsearch identify spring`, points of a `table:` law."""

from __future__ import annotations

import math

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.system.csv_columns import CsvColumns, canonical_name, read_columns, rename_columns
from hcsearch.system.reading import MAX_INPUT_BYTES

ANGLE_COLUMN_UNITS = {"angle_rad": 1.0, "angle_deg": math.pi / 180.0}
MOMENT_COLUMN_UNITS = {"moment_N_m": 1.0, "moment_N_mm": 1e-3}
_SPELLINGS = {"angle_degrees": "angle_deg", "moment_nm": "moment_N_m", "moment_nmm": "moment_N_mm"}
_NAMES = {canonical_name(name): name for name in (*ANGLE_COLUMN_UNITS, *MOMENT_COLUMN_UNITS)} | _SPELLINGS
MAX_FOLD_ANGLE = math.pi + 0.01
"""The greatest fold angle (rad), above pi as gauges are set to zero by eye and pi is rounded."""


def read_law_points(
    path: str, *, max_bytes: int = MAX_INPUT_BYTES, max_angle: float = MAX_FOLD_ANGLE
) -> tuple[Reals, Reals]:
    """Read fold angles (rad) and moments (N m) from a file with one column of each, in any of the units named above.

    Other columns are ignored. The rows keep their order. max_bytes : greatest size of the file. max_angle : greatest
    angle (rad); a rig may turn a spring further than its hinge does.
    Errors: HcsearchError for columns of other names, for rows without a number in one of the two columns, for angles
    that no hinge has, and for moments that drive a hinge away from the flat state.
    """
    columns = rename_columns(
        read_columns(path, "angle_rad,moment_N_m", what="the table", max_bytes=max_bytes), _NAMES, "angle_rad"
    )
    names = _only(columns, ANGLE_COLUMN_UNITS), _only(columns, MOMENT_COLUMN_UNITS)
    texts = zip(*map(columns.texts, names), strict=True)
    rows = tuple(row for row, cells in zip(columns.rows, texts, strict=True) if any(cells))
    columns = CsvColumns(path, columns.names, rows)
    angles, moments = map(columns.numbers, names)
    for k in np.flatnonzero(np.isnan(angles) | np.isnan(moments)):
        name = names[0] if math.isnan(angles[k]) else names[1]
        raise columns.cell_error(int(k), name, "leave the row out, or write the number that was measured")
    angles, moments = angles * ANGLE_COLUMN_UNITS[names[0]], moments * MOMENT_COLUMN_UNITS[names[1]]
    hint = ", or name the column angle_deg if it is in degrees" if names[0] == "angle_rad" else ""
    check_angles(angles, path, hint, max_angle)
    _check_signs(angles, moments, path)
    return angles, moments


def check_angles(angles: Reals, source: str, hint: str = "", max_angle: float = MAX_FOLD_ANGLE) -> None:
    """Refuse angles (rad) that no hinge has; source : their origin, and hint : a remedy for large ones, in messages."""
    if not len(angles):
        return
    low, high = float(np.min(angles)), float(np.max(angles))
    if max(-low, high) > max_angle:
        angle = low if -low > high else high
        raise HcsearchError(
            f"{source} has an angle of {angle:.6g} rad, and hinges turn from 0 (flat) to pi: leave it out{hint}"
        )


def _check_signs(angles: Reals, moments: Reals, path: str) -> None:
    """Refuse signs that contradict a hinge and its spring, and name the signs to reverse."""
    if not len(angles):
        return
    low, high = float(angles.min()), float(angles.max())
    drives = float(angles @ moments)  # positive where moments drive the hinge back to the flat state
    if -low > high:
        signs = "angles and moments" if drives > 0.0 else "angles"
        raise HcsearchError(
            f"{path} has angles from {low:.4g} to {high:.4g} rad, and hinges turn from 0 (flat) to pi: turn the sign "
            f"of its {signs}"
        )
    if drives < 0.0:
        raise HcsearchError(
            f"{path} has moments that drive a hinge from the flat state (0 rad) to {high:.4g} rad, which no spring of "
            "a deployment does: turn the sign of its moments"
        )


def _only(columns: CsvColumns, units: dict[str, float]) -> str:
    """Return the name of the only column of a quantity."""
    names = [name for name in columns.names if name in units]
    if len(names) != 1:
        quantity = next(iter(units)).partition("_")[0]
        there = ", ".join(name for name in columns.names if name)
        raise HcsearchError(
            f"{columns.path} has {len(names) or 'no'} columns of the {quantity} (its columns are {there}): "
            f"name one of them {' or '.join(units)}"
        )
    return names[0]
