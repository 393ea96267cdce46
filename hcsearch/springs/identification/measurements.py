"""Measurements in CSV files whose columns are named by quantity and unit, and the sampling rate of rounded times."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from scipy.optimize import minimize_scalar

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.basics.errors import HcsearchError
from hcsearch.scenes import spring_files
from hcsearch.system.csv_columns import (
    MAX_MEASURED_VALUE,
    MIN_MEASURED_VALUE,
    CsvColumns,
    is_number,
    read_columns,
    refuse_repeated_names,
    rename_columns,
)
from hcsearch.system.terminal import short_number

MIN_VIBRATION_SAMPLES = 64
"""Least number of samples of a vibration."""
MAX_JITTER_SHARE = 0.1
"""Greatest deviation of a time from even sampling, as a share of a step."""
MAX_ROUNDING_UNIT_SHARE = 0.98
"""Share of a step below which the unit of rounding may explain uneven steps: times in whole steps are exact."""
MAX_TIME_DECIMALS = 12
TIME_ROUNDING_SLACK = 1e-4
"""Tolerance of the error of rounding, as a share of its unit, as the narrowest strip is found numerically."""


def sampling_rate(times: Reals, path: str) -> float:
    """Return the sampling rate (Hz) of even times (s), which may be rounded to decimals or to significant digits.

    Errors: HcsearchError for times that do not increase, or are uneven by more than rounding, with the place.
    """
    if len(times) < 2:
        raise HcsearchError(f"{path} has {len(times)} rows: a vibration needs many")
    steps, unit = np.diff(times), _unit(times)
    numbers: Reals = np.arange(len(times), dtype=float) - 0.5 * (len(times) - 1)
    step = float(numbers @ times / (numbers @ numbers))
    width, rounding_width = _strip(times, numbers, step, unit), unit * (1.0 + TIME_ROUNDING_SLACK)
    if not (steps > 0.0).all():
        if (steps >= 0.0).all() and step < MAX_ROUNDING_UNIT_SHARE * unit and width <= rounding_width:
            raise HcsearchError(
                f"the times of {path} are rounded to {unit:g} s, more than a step: give the sampling rate by --rate HZ"
            )
        k = int(np.argmin(steps > 0.0))
        raise HcsearchError(f"{times[k + 1]:g} s comes after {times[k]:g} s in {path}: sort the rows, each time once")
    rounding = rounding_width if unit < MAX_ROUNDING_UNIT_SHARE * step else 0.0
    if width > max(2.0 * MAX_JITTER_SHARE * step, rounding):
        raise HcsearchError(f"{path} is not sampled evenly{_place(times, steps, unit)}")
    return 1.0 / step


def _unit(times: Reals) -> float:
    """Return the unit of the last digit of the largest times, s; 0 for times that are not rounded."""
    decimals = np.full(len(times), -1)
    for k in range(MAX_TIME_DECIMALS + 1):
        scaled = times * 10.0**k
        open_yet = decimals < 0
        decimals[open_yet & (abs(scaled - np.round(scaled)) <= 1e-6)] = k
        if (decimals >= 0).all():
            break
    if (decimals < 0).any():
        return 0.0
    sizes = np.floor(np.log10(np.maximum(abs(times), 1e-300)))
    # equal numbers of decimals, or of significant digits, which are fewer decimals of larger times
    digits = (sizes + 1 + decimals)[times != 0.0].max(initial=1.0)
    return float(max(10.0 ** -decimals.max(), 10.0 ** (sizes.max() + 1 - digits)))


def _strip(times: Reals, numbers: Reals, step: float, unit: float) -> float:
    """Return the width (s) of the narrowest strip between parallel lines over sample numbers that holds all times."""
    level = times - step * numbers

    def width(tilt: float) -> float:
        return float(np.ptp(level - tilt * numbers))

    reach = max(2.0 * unit, width(0.0)) / max(1.0, float(numbers[-1]))
    result = minimize_scalar(width, bounds=(-reach, reach), method="bounded", options={"xatol": 1e-9 * reach})
    return min(width(0.0), float(result.fun))


def _place(times: Reals, steps: Reals, unit: float) -> str:
    """Return words on where times are uneven, with a remedy."""
    usual, gaps = _gaps(times, steps, unit)
    digits = max(6, 2 + math.ceil(math.log10(float(abs(times).max()) / usual)))  # to distinguish adjacent samples
    if len(gaps):
        named = ", ".join(
            f"{short_number(times[k], digits)} to {short_number(times[k + 1], digits)} s" for k in gaps[:3]
        )
        rest = f" and {len(gaps) - 3} more" if len(gaps) > 3 else ""
        return (
            f": samples are missing from {named}{rest}, where a step is {short_number(steps[gaps[0]], 3)} s and not "
            f"{short_number(usual, 3)} s; fill what is missing, or {_without_gaps(times, gaps, digits)}"
        )
    k = int(np.argmax(abs(steps - usual)))
    return (
        f", near {short_number(times[k], digits)} s, where a step is {short_number(steps[k], 3)} s "
        f"and not {short_number(usual, 3)} s: "
        "resample it, or give the sampling rate by --rate HZ if it is even"
    )


def _without_gaps(times: Reals, gaps: WholeNumbers, digits: int) -> str:
    """Return advice on keeping a stretch without gaps: the last if long enough for a vibration, else the longest."""
    begins, ends = np.array([0, *(gaps + 1)]), np.array([*gaps, len(times) - 1])
    lengths = ends - begins + 1
    k = -1 if lengths[-1] >= MIN_VIBRATION_SAMPLES else int(lengths.argmax())
    start, end = short_number(times[begins[k]], digits), short_number(times[ends[k]], digits)
    if lengths[k] < MIN_VIBRATION_SAMPLES:
        return (
            f"measure anew: at most {lengths.max()} samples follow each other, and {MIN_VIBRATION_SAMPLES} are needed"
        )
    if k == -1:
        return f"begin after it by --from {start}"
    return f"leave out what follows {end} s" + (f" and begin by --from {start}" if k else "")


def _gaps(times: Reals, steps: Reals, unit: float) -> tuple[float, WholeNumbers]:
    """Return the usual step (s), the mean of rounded steps, and the numbers of steps with samples missing.

    Steps of one unit and of two are due to rounding if with them all times fit a line; else the longer ones are gaps.
    """
    for limit in (1.5 * np.median(steps) + unit, 1.5 * np.median(steps)):
        usual = float(steps[steps < limit].mean())
        rounding = unit if unit < MAX_ROUNDING_UNIT_SHARE * usual else 0.0
        gaps = np.flatnonzero(steps > usual + max(0.5 * usual, rounding))
        counted = np.ones(len(steps))
        counted[gaps] = np.maximum(1.0, np.round(steps[gaps] / usual))
        numbers = np.concatenate(([0.0], np.cumsum(counted)))
        numbers -= numbers.mean()
        step = float(numbers @ times / (numbers @ numbers))
        if _strip(times, numbers, step, unit) <= max(
            2.0 * MAX_JITTER_SHARE * step, rounding * (1.0 + TIME_ROUNDING_SLACK)
        ):
            break
    return step, gaps


TIME_COLUMN = "time_s"
MAX_MEASUREMENT_BYTES = 32 * 2**20
"""Greatest size of a file: two million samples of one channel, which take a gigabyte of memory to read."""
DOUBTED_SAMPLING_RATE = 5.0
"""Sampling rate (Hz) up to which a doubt is reported: accelerometers are faster, and 5 kHz in ms looks like this."""
MIN_COUNTER_ROWS = 3
"""Least number of rows for which a column that always rises is taken for a counter and not for a channel."""


def read_measured_moments(path: str) -> tuple[Reals, Reals]:
    """Read fold angles (rad) and moments (N m) from a file, as a law `table:FILE.csv` does, up to a whole turn."""
    return spring_files.read_law_points(path, max_bytes=MAX_MEASUREMENT_BYTES, max_angle=2.0 * math.pi)


def read_accelerations(
    path: str, rate: float | None = None, start: float | None = None, note: Callable[[str], None] = lambda _: None
) -> tuple[Reals, float]:
    """Read accelerations, shape (channels, samples), and their sampling rate (Hz) from a file.

    Every named column other than `time_s` is a channel, except columns of text, and counters beside a channel, which
    rise in every row; `note` is called with a sentence for each of these, and for times that may not be in seconds.
    rate : Hz; replaces `time_s`. start : time (s) from which rows are read; at a given rate, after the first row.
    Errors: HcsearchError for times that do not increase or are uneven, for a missing rate, for cells without a number.
    """
    columns = rename_columns(
        read_columns(path, TIME_COLUMN, max_bytes=MAX_MEASUREMENT_BYTES), {TIME_COLUMN: TIME_COLUMN}, TIME_COLUMN
    )
    channels = _channels(columns, note)
    if rate is None and TIME_COLUMN not in columns.names:
        raise HcsearchError(f"{path} has no column {TIME_COLUMN}: add one, or give the sampling rate by --rate HZ")
    if rate is not None:
        check_rate(rate := float(rate))
        times = np.arange(len(columns.rows)) / rate
    else:
        times = columns.numbers(TIME_COLUMN)
    if start is not None and not math.isfinite(start):
        raise HcsearchError(f"a start at {start:g} s: give a finite time")
    rows = np.flatnonzero(~(times < start)) if start is not None else np.arange(len(times))
    repair = "write what was measured there, leave the column out, or begin after that line by --from SECONDS"
    required = {TIME_COLUMN: times} | channels if rate is None else channels
    for name, values in required.items():
        for k in rows[np.isnan(values[rows])]:
            raise columns.cell_error(int(k), name, repair)
    if rate is None:
        # gaps before the start do not count; records of too few rows are refused later
        rate = sampling_rate(times[rows] if len(rows) > 1 else times, path)
        check_rate(rate)
        if rate <= DOUBTED_SAMPLING_RATE:
            note(
                f"{path} has one sample in {short_number(1.0 / rate, 3)} s: "
                f"write seconds in {TIME_COLUMN} if these are milliseconds"
            )
    channels = _without_counters({name: values[rows] for name, values in channels.items()}, path, note)
    for name, record in channels.items():
        if len(record) and np.ptp(record) == 0.0:
            raise HcsearchError(f"column {name!r} of {path} is {record[0]:g} all the time: leave it out")
    return np.array(list(channels.values())), rate


def _channels(columns: CsvColumns, note: Callable[[str], None]) -> dict[str, Reals]:
    """Return the columns of numbers by name, with NaN in cells without a number."""
    names = [name for name in columns.names if name and name != TIME_COLUMN]
    refuse_repeated_names(columns.path, names, names, TIME_COLUMN)
    texts = {name: columns.texts(name) for name in names}
    words = [name for name in names if columns.rows and not any(map(is_number, texts[name]))]
    if len(words) == len(names):
        raise HcsearchError(f"{columns.path} has no accelerations: give a column for each channel beside {TIME_COLUMN}")
    for name in words:
        note(f"column {name!r} of {columns.path} is left out: it holds no numbers")
    return {name: columns.numbers(name) for name in names if name not in words}


def _without_counters(channels: dict[str, Reals], path: str, note: Callable[[str], None]) -> dict[str, Reals]:
    """Remove channels that rise in every row, such as row numbers, unless all do."""
    counters = [
        name for name, values in channels.items() if len(values) >= MIN_COUNTER_ROWS and (np.diff(values) > 0.0).all()
    ]
    if len(counters) == len(channels):
        return channels
    for name in counters:
        note(f"column {name!r} of {path} is left out: it rises in every row, as row numbers and times do")
    return {name: values for name, values in channels.items() if name not in counters}


def check_rate(rate: float) -> None:
    """Raise HcsearchError for a sampling rate (Hz) that no instrument has."""
    if not MIN_MEASURED_VALUE <= rate <= MAX_MEASURED_VALUE:
        raise HcsearchError(
            f"a sampling rate of {rate:g} Hz: give one from {MIN_MEASURED_VALUE:g} to {MAX_MEASURED_VALUE:g}"
        )
