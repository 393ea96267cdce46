"""Films: measured fold angles of a deployment over time, in CSV files."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.shape.labels import Labels
from hcsearch.springs.identification.measurements import MAX_MEASUREMENT_BYTES, TIME_COLUMN, check_rate
from hcsearch.system.csv_columns import CsvColumns, read_columns, rename_columns

MIN_FILM_FRAMES = 8
"""Least number of frames of a film: with fewer, noise and motion cannot be separated."""
MAX_FILM_ANGLE = 2.0 * math.pi
"""Greatest magnitude of a fold angle in a film, rad: hinges turn from 0 (flat) to pi, and beyond these by errors."""
_ANGLE_COLUMN = re.compile(r"(?:(?:angle|hinge|crease)[\s_]*)?(\d+(?:\+\d+)*)[\s_]*[\[(]?(deg|rad)[\])]?", re.ASCII)


@dataclass(frozen=True, eq=False)
class Film(ByValue):
    """Measured fold angles of a deployment.

    name : of the file, for messages. times : (k,), s, increasing, on the clock of the film. angles : (k, n_hinges),
    rad, NaN where nothing was measured.
    """

    name: str
    times: Reals
    angles: Reals

    @property
    def n_angles(self) -> int:
        """Number of measured angles."""
        return int(np.isfinite(self.angles).sum())


def read_film(
    path: str, labels: Labels, rate: float | None = None, note: Callable[[str], None] = lambda _: None
) -> Film:
    """Read a film: a column `time_s`, and one for each measured hinge by its number in pictures, such as `7_deg`.

    `angle_7_rad`, as `hcsearch deploy --output` writes it, is read, too. Empty cells were not measured. Other columns
    are left out; `note` is called with a sentence on them. rate : Hz, of the frames; it replaces `time_s`.
    Errors: HcsearchError for no hinge, a hinge that is given twice or does not exist, times that do not increase, cells
    that hold no number, angles beyond a turn, and fewer than eight frames.
    """
    columns = rename_columns(
        read_columns(path, f"{TIME_COLUMN},7_deg", max_bytes=MAX_MEASUREMENT_BYTES),
        {TIME_COLUMN: TIME_COLUMN},
        TIME_COLUMN,
    )
    angles = np.full((len(columns.rows), len(labels.hinges)), math.nan)
    given: dict[int, str] = {}
    left_out = []
    for name in columns.names:
        match = _ANGLE_COLUMN.fullmatch(name.strip().casefold().replace("°", "deg"))
        if match is None:
            left_out += [name] if name and name != TIME_COLUMN else []
            continue
        hinge = labels.hinge(match[1])
        if hinge in given:
            raise HcsearchError(
                f"{path} gives hinge {labels.hinges[hinge]} twice, {given[hinge]} and {name}: leave one out"
            )
        given[hinge] = name
        angles[:, hinge] = _angles(columns, name, math.radians(1.0) if match[2] == "deg" else 1.0)
    if not given:
        raise HcsearchError(f"{path} has no fold angles: name a column by hinge and unit, such as 7_deg or 7_rad")
    if left_out:
        note(f"columns {', '.join(left_out[:5])} of {path} are left out: they name no hinge and unit, such as 7_deg")
    times = _times(columns, rate)
    kept = np.isfinite(angles).any(axis=1)
    if kept.sum() < MIN_FILM_FRAMES:
        raise HcsearchError(f"{path} has {kept.sum()} frames with an angle: give {MIN_FILM_FRAMES} or more")
    return Film(path, times[kept], angles[kept])


def _angles(columns: CsvColumns, name: str, unit: float) -> Reals:
    """Return the angles of a column, rad; unit : of its numbers, rad."""
    texts, numbers = columns.texts(name), columns.numbers(name)
    for row, text in enumerate(texts):
        if text and math.isnan(numbers[row]):
            raise columns.cell_error(row, name, "leave the cell empty where nothing was measured")
    angles: Reals = numbers * unit
    greatest = float(np.nanmax(np.abs(angles), initial=0.0))
    if greatest > MAX_FILM_ANGLE:
        raise HcsearchError(
            f"column {name!r} of {columns.path} reaches {greatest / unit:.4g}, more than a turn: a fold angle goes "
            "from 0 (flat) to pi or 180 degrees; change the unit in the name of the column"
        )
    return angles


def _times(columns: CsvColumns, rate: float | None) -> Reals:
    if rate is not None:
        check_rate(rate)
        return np.arange(len(columns.rows)) / rate
    if TIME_COLUMN not in columns.names:
        raise HcsearchError(f"{columns.path} has no column {TIME_COLUMN}: add one, or give the frames by --rate HZ")
    times = columns.numbers(TIME_COLUMN)
    for row in np.flatnonzero(np.isnan(times)):
        raise columns.cell_error(int(row), TIME_COLUMN, "leave out the line")
    late = np.flatnonzero(np.diff(times) <= 0.0)
    if len(late):
        k = int(late[0])
        raise HcsearchError(
            f"{times[k + 1]:g} s comes after {times[k]:g} s in {columns.path}: sort the rows, each time once"
        )
    return times
