"""Tables of measurements: CSV files whose columns are named by quantity and unit."""

from __future__ import annotations

import csv
import io
import math

import numpy as np

from hcsearch.errors import HcsearchError
from hcsearch.system.reading import read_text
from hcsearch.typing import Reals

ANGLES = {"angle_rad": 1.0, "angle_deg": math.pi / 180.0}
MOMENTS = {"moment_N_m": 1.0, "moment_N_mm": 1e-3}
TIME = "time_s"
TINY, HUGE = 1e-30, 1e30
"""Sizes of numbers that are taken for measured: squares of others overflow or are nothing."""
MOST_BYTES = 32 * 2**20
"""Size of a file: two million samples of one channel, which take a gigabyte of memory to read."""
JITTER = 0.1
"""How far a time may be from even sampling, as a share of a step: what rounding leaves of it."""


def read_moments(path: str) -> tuple[Reals, Reals]:
    """Fold angles (rad) and moments (N m) of a file with one column of each, in any of the units named above."""
    table = _read(path)
    return _only(table, ANGLES, path), _only(table, MOMENTS, path)


def read_accelerations(path: str, rate: float | None = None, start: float | None = None) -> tuple[Reals, float]:
    """Accelerations, shape (channels, samples), and their sampling rate (Hz), of a file.

    Every column but `time_s` is a channel, whatever its name. rate : Hz, for files without times. start : time (s) from
    which rows are taken; without times, after the first row.
    Errors: HcsearchError for times that do not grow or are not even, or for a rate that is missing or given twice.
    """
    table = _read(path)
    times = table.pop(TIME, None)
    if not table:
        raise HcsearchError(f"{path} has no accelerations: give a column for each channel beside {TIME}")
    if times is None and rate is None:
        raise HcsearchError(f"{path} has no column {TIME}: add one, or give the sampling rate by --rate HZ")
    if times is not None and rate is not None:
        raise HcsearchError(f"{path} has a column {TIME}: leave out --rate")
    rate = float(rate) if rate is not None else _rate(np.asarray(times), path)
    if not TINY <= rate <= HUGE:
        raise HcsearchError(f"a sampling rate of {rate:g} Hz: give one from {TINY:g} to {HUGE:g}")
    records = np.array(list(table.values()))
    if start is not None:
        if not math.isfinite(start):
            raise HcsearchError(f"a start at {start:g} s: give a finite time")
        when = times if times is not None else np.arange(records.shape[1]) / rate
        records = records[:, when >= start]
    for name, record in zip(table, records, strict=True):
        if len(record) and np.ptp(record) == 0.0:
            raise HcsearchError(f"column {name!r} of {path} is {record[0]:g} all the time: leave it out")
    return records, rate


def _read(path: str) -> dict[str, Reals]:
    """Columns of a file by name."""
    try:
        reader = csv.reader(io.StringIO(read_text(path, most=MOST_BYTES), newline=""))
        lines = [(number, row) for number, row in enumerate(reader, 1) if any(map(str.strip, row))]
    except csv.Error as error:
        raise HcsearchError(f"{path} is no table: give a CSV file with a line of column names") from error
    if not lines:
        raise HcsearchError(f"{path} is empty: give a CSV file with a line of column names")
    names = [name.strip() for name in lines[0][1]]
    if len(names) == 1 and any(mark in names[0] for mark in ";\t"):
        raise HcsearchError(f"the columns of {path} are not separated by commas: write them so, and decimals by points")
    if len(set(names)) < len(names) or any(map(_is_number, names)) or "" in names:
        raise HcsearchError(f"the first line of {path} names no columns: write one name for each, such as {TIME}")
    values = np.empty((len(lines) - 1, len(names)))
    for k, (number, row) in enumerate(lines[1:]):
        if len(row) != len(names):
            raise HcsearchError(f"line {number} of {path} has {len(row)} values for {len(names)} columns: complete it")
        for name, text in zip(names, row, strict=True):
            if not _is_measured(text):
                raise HcsearchError(
                    f"line {number} of {path} has {text.strip()!r} for {name}: write 0 or a number of size {TINY:g} to "
                    f"{HUGE:g}"
                )
        values[k] = [float(text) for text in row]
    return dict(zip(names, values.T, strict=True))


def _is_measured(text: str) -> bool:
    return _is_number(text) and (float(text) == 0.0 or TINY <= abs(float(text)) <= HUGE)


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def _only(table: dict[str, Reals], units: dict[str, float], path: str) -> Reals:
    """The one column of a quantity, in SI units."""
    names = [name for name in units if name in table]
    if len(names) != 1:
        quantity = next(iter(units)).partition("_")[0]
        raise HcsearchError(
            f"{path} has {len(names) or 'no'} columns of the {quantity} (its columns are {', '.join(table)}): "
            f"name one of them {' or '.join(units)}"
        )
    return table[names[0]] * units[names[0]]


def _rate(times: Reals, path: str) -> float:
    """The sampling rate of even times, Hz."""
    if len(times) < 2:
        raise HcsearchError(f"{path} has {len(times)} rows: a vibration needs many")
    steps = np.diff(times)
    if not (steps > 0.0).all():
        k = int(np.argmin(steps > 0.0))
        raise HcsearchError(f"{times[k + 1]:g} s comes after {times[k]:g} s in {path}: sort the rows, each time once")
    step = (times[-1] - times[0]) / len(steps)
    off = abs(times - times[0] - step * np.arange(len(times)))
    if off.max() > JITTER * step:
        k = int(np.argmax(off > JITTER * step))
        raise HcsearchError(f"{path} is not sampled evenly, near {times[k]:g} s: fill gaps and resample it first")
    return float(1.0 / step)
