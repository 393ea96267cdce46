"""Tables of measurements: CSV files whose columns are named by quantity and unit."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from hcsearch.basics.arrays import Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.scenes import spring_files
from hcsearch.springs.identification.sampling import sampling_rate
from hcsearch.system.columns import HUGE, TINY, Columns, is_number, read_columns, renamed
from hcsearch.system.terminal import short

TIME_COLUMN = "time_s"
MAX_MEASUREMENT_BYTES = 32 * 2**20
"""Size of a file: two million samples of one channel, which take a gigabyte of memory to read."""
DOUBTED_SAMPLING_RATE = 5.0
"""Sampling rate (Hz) up to which times are doubted: no accelerometer is read so seldom, and 5 kHz in ms look so."""
MIN_COUNTER_ROWS = 3
"""Rows from which on a column that always rises is a counter and no channel."""


def read_measured_moments(path: str) -> tuple[Reals, Reals]:
    """Fold angles (rad) and moments (N m) of a file, as a law `table:FILE.csv` reads them, up to a whole turn."""
    return spring_files.read_law_points(path, most=MAX_MEASUREMENT_BYTES, turn=2.0 * math.pi)


def read_accelerations(
    path: str,
    rate: float | None = None,
    start: float | None = None,
    note: Callable[[str], None] = lambda _: None,
) -> tuple[Reals, float]:
    """Accelerations, shape (channels, samples), and their sampling rate (Hz), of a file.

    Every column with a name but `time_s` is a channel, except for columns of text, and for counters beside a channel,
    which rise in every row; `note` is called with a sentence for each that is left out, and for times that may be no
    seconds. rate : Hz; takes the place of `time_s`. start : time (s) from which rows are taken; at a given rate, after
    the first row.
    Errors: HcsearchError for times that do not grow or are not even, for a missing rate, for cells without a number.
    """
    columns = renamed(
        read_columns(path, TIME_COLUMN, most=MAX_MEASUREMENT_BYTES), {TIME_COLUMN: TIME_COLUMN}, TIME_COLUMN
    )
    channels = _channels(columns, note)
    if rate is None and TIME_COLUMN not in columns.names:
        raise HcsearchError(f"{path} has no column {TIME_COLUMN}: add one, or give the sampling rate by --rate HZ")
    if rate is not None:
        _check_rate(rate := float(rate))
        times = np.arange(len(columns.rows)) / rate
    else:
        times = columns.numbers(TIME_COLUMN)
    if start is not None and not math.isfinite(start):
        raise HcsearchError(f"a start at {start:g} s: give a finite time")
    kept = np.flatnonzero(~(times < start)) if start is not None else np.arange(len(times))
    repair = "write what was measured there, leave the column out, or begin after that line by --from SECONDS"
    wanted = {TIME_COLUMN: times} | channels if rate is None else channels
    for name, values in wanted.items():
        for k in kept[np.isnan(values[kept])]:
            raise columns.fault(int(k), name, repair)
    if rate is None:
        # gaps before the start do not count; of too few rows the vibration is refused later
        rate = sampling_rate(times[kept] if len(kept) > 1 else times, path)
        _check_rate(rate)
        if rate <= DOUBTED_SAMPLING_RATE:
            note(
                f"{path} has one sample in {short(1.0 / rate, 3)} s: "
                f"write seconds in {TIME_COLUMN} if these are milliseconds"
            )
    channels = _without_counters({name: values[kept] for name, values in channels.items()}, path, note)
    for name, record in channels.items():
        if len(record) and np.ptp(record) == 0.0:
            raise HcsearchError(f"column {name!r} of {path} is {record[0]:g} all the time: leave it out")
    return np.array(list(channels.values())), rate


def _channels(columns: Columns, note: Callable[[str], None]) -> dict[str, Reals]:
    """The columns that hold numbers, by name; NaN in cells that hold none."""
    names = [name for name in columns.names if name and name != TIME_COLUMN]
    for name in names:
        if names.count(name) > 1:
            raise HcsearchError(
                f"the first line of {columns.path} names no columns: {name} stands there {names.count(name)} times; "
                f"write one name for each, such as {TIME_COLUMN}"
            )
    texts = {name: columns.texts(name) for name in names}
    words = [name for name in names if columns.rows and not any(map(is_number, texts[name]))]
    if len(words) == len(names):
        raise HcsearchError(f"{columns.path} has no accelerations: give a column for each channel beside {TIME_COLUMN}")
    for name in words:
        note(f"column {name!r} of {columns.path} is left out: it holds no numbers")
    return {name: columns.numbers(name) for name in names if name not in words}


def _without_counters(channels: dict[str, Reals], path: str, note: Callable[[str], None]) -> dict[str, Reals]:
    """The channels without those that rise in every row, such as row numbers, unless all do."""
    counters = [
        name for name, values in channels.items() if len(values) >= MIN_COUNTER_ROWS and (np.diff(values) > 0.0).all()
    ]
    if len(counters) == len(channels):
        return channels
    for name in counters:
        note(f"column {name!r} of {path} is left out: it rises in every row, as row numbers and times do")
    return {name: values for name, values in channels.items() if name not in counters}


def _check_rate(rate: float) -> None:
    if not TINY <= rate <= HUGE:
        raise HcsearchError(f"a sampling rate of {rate:g} Hz: give one from {TINY:g} to {HUGE:g}")
