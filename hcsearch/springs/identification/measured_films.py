"""Films: measured fold angles of a deployment over time, in CSV files, and the simulated ones to compare them with."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hcsearch.basics.array_values import ByValue, Flags, Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.scenes.setup import Setup
from hcsearch.shape.labels import Labels
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.compiled_scene import CompiledScene, compile_scene
from hcsearch.springs.deployment.outcomes import MAX_DEPLOYMENT_STEPS, methods_of
from hcsearch.springs.deployment.released_hinges import simulate_releases
from hcsearch.springs.dynamics.time_integration import Motion
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


COURSE_TOLERANCE = 1e-8
"""Error of a step of a fitted motion: its derivatives by differences need more digits than a film has."""
NOISE_NEIGHBOURS = (-2, -1, 1, 2)
"""Frames whose cubic predicts the frame between them."""
MEDIAN_TO_DEVIATION = 1.4826
"""Standard deviation over median magnitude of a normal distribution."""


@dataclass(frozen=True, eq=False)
class FilmedCourse(ByValue):
    """A simulated deployment, from its release at time 0."""

    compiled: CompiledScene
    motion: Motion

    def at(self, times: Reals) -> Reals:
        """Return the fold angles (rad) at times (s) since the release, shape (len(times), n_hinges).

        Before the release the angles are those at the start, after the end of the simulation those at the end; where
        that is the flat state (0.01 rad), each angle that closes decays exponentially from its last rate on, as it does
        with dampers.
        """
        motion, end = self.motion, float(self.motion.times[-1])
        inside = motion.at(np.clip(times, 0.0, end))
        angles, _ = self.compiled.of_hinges(inside, np.zeros_like(inside))
        if motion.ending == "flat":
            last, rates = (part[0] for part in self.compiled.of_hinges(motion.q[-1:], motion.v[-1:]))
            late = times > end
            decays = np.minimum(np.divide(rates, last, out=np.zeros_like(last), where=last != 0.0), 0.0)
            angles[late] = last * np.exp(decays * (times[late] - end)[:, None])
        return angles


def course_of(linkage: Linkage, setup: Setup, seconds: float, tolerance: float = COURSE_TOLERANCE) -> FilmedCourse:
    """Simulate the deployment of a linkage in a setup for some time, s."""
    compiled = compile_scene(linkage, replace(setup, seconds=seconds))
    methods, steps = methods_of(compiled.formulation), MAX_DEPLOYMENT_STEPS[compiled.formulation]
    return FilmedCourse(compiled, simulate_releases(compiled, methods=methods, tolerance=tolerance, max_steps=steps))


def film_noise(films: Sequence[Film]) -> tuple[float, int]:
    """Estimate the noise of films from neighbouring frames alone; return its standard deviation (rad) and the frames.

    Each angle is compared with the cubic through the four frames around it. The estimate is robust (by the median), as
    angles have kinks where stops are hit. Slow films, in which a cubic misses the motion, seem noisier than they are.
    """
    deviations = np.concatenate([_deviations(film.times, column) for film in films for column in film.angles.T])
    if not len(deviations):
        return 0.0, 0
    return float(MEDIAN_TO_DEVIATION * np.median(np.abs(deviations))), len(deviations)


def _deviations(times: Reals, angles: Reals) -> Reals:
    """Return deviations from cubics through neighbours, scaled to the variance of a single angle."""
    known: Flags = np.isfinite(angles)
    t, a = times[known], angles[known]
    k = np.arange(2, len(t) - 2)
    if not len(k):
        return np.zeros(0)
    near = np.stack([t[k + step] for step in NOISE_NEIGHBOURS], axis=1)
    weights = np.ones_like(near)
    for i in range(len(NOISE_NEIGHBOURS)):
        for j in range(len(NOISE_NEIGHBOURS)):
            if i != j:
                weights[:, i] *= (t[k] - near[:, j]) / (near[:, i] - near[:, j])
    predicted = sum(weights[:, i] * a[k + step] for i, step in enumerate(NOISE_NEIGHBOURS))
    return np.asarray((a[k] - predicted) / np.sqrt(1.0 + (weights**2).sum(axis=1)))
