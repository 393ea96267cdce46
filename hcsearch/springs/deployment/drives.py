"""Drives of a deployment: the driven hinges, their course and gains, also as a table of a TOML file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import HcsearchError, SceneError
from hcsearch.shape.labels import Labels, is_label, label_data
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.compiled_scene import CompiledScene
from hcsearch.springs.dynamics.position_control import DriveDemand, JointCommands

START_CLOSURE_TOLERANCE = 1e-6
"""Greatest closure residual of a closed start."""
MAX_COURSE_TIMES = 100_000
"""Greatest number of times of a course."""
MIN_CONTROL_PERIOD, MAX_CONTROL_PERIOD = 1e-5, 0.1
"""Bounds of the period of a controller (s)."""
MIN_COURSE_TIME_STEP = 1e-9
"""Least distance of the times of a course (s)."""
_NO_NUMBERS = "[drive] holds what is no table of numbers: write it with hcsearch drive"


_DEMAND = tuple(field.name for field in fields(DriveDemand))
_NUMBERS = ("start", *_DEMAND)
_NAMES = ("driven", *_NUMBERS)
"""Keys of the table, in this order: the driven hinges by their names on pictures, and numbers."""


@dataclass(frozen=True, eq=False)
class Drives(DriveDemand):
    """Driven hinges with their targets and gains.

    hinges : (n_driven,), numbers. start : (n_hinges,), fold angles at which the motion starts, at rest.
    """

    hinges: tuple[int, ...]
    start: Reals

    def commands(self, compiled: CompiledScene) -> JointCommands:
        """Return the commands of the joints of a compiled scene."""
        joints = tuple(int(compiled.joint_of[hinge]) for hinge in self.hinges)
        return JointCommands(joints=joints, **{name: getattr(self, name) for name in _DEMAND})

    def start_in(self, compiled: CompiledScene) -> Reals:
        """Return the start as coordinates of the joints."""
        angles = compiled.start.copy()
        angles[compiled.joint_of] = self.start
        return angles

    def check(self, linkage: Linkage) -> None:
        """Refuse drives that do not belong to a linkage."""
        n = linkage.n_hinges
        if len(self.start) != n or not all(0 <= hinge < n for hinge in self.hinges):
            raise SceneError(f"the drive is not one of this design, which has {n} hinges: write it with hcsearch drive")
        gap = float(np.abs(linkage.closure(self.start)[0]).max(initial=0.0))
        least, greatest = self.start.min(initial=0.0), self.start.max(initial=0.0)
        if gap > START_CLOSURE_TOLERANCE or least < -0.01 or greatest > np.pi + 0.01:
            raise SceneError(
                "the drive does not start from a closed state within the stops: give the panels and flat pairs that it "
                "was made for, or write it with hcsearch drive"
            )


def drives_in(table: Mapping[str, Any], labels: Labels) -> Drives:
    """Read drives from a table of a file, for a linkage with these labels; SceneError for an invalid table."""
    wrong = [name for name in _NAMES if name not in table] + [key for key in table if key not in _NAMES]
    if wrong:
        raise SceneError(f"[drive] has, or lacks, {wrong[0]!r}: it holds {', '.join(_NAMES)}; see hcsearch drive")
    hinges = _driven(table["driven"], labels)
    values = {name: _numbers(table[name]) for name in _NUMBERS}
    times = values["times"]
    k, d = times.size, len(hinges)
    shapes = {"times": (k,), "angles": (k, d), "torques": (k, d), "stiffness": (d,), "damping": (d,)}
    valid = all(values[name].shape == shape for name, shape in shapes.items())
    valid = valid and values["start"].ndim == 1 and values["period"].ndim == 0 and 2 <= k <= MAX_COURSE_TIMES and d > 0
    if not valid or not all(np.isfinite(value).all() for value in values.values()):
        raise SceneError("[drive] must hold as many numbers for each hinge and time: write it with hcsearch drive")
    if len(set(hinges)) < d:
        raise SceneError("[drive] must name each driven hinge once, by its number: write it with hcsearch drive")
    gains = (values["stiffness"] >= 0.0).all() and (values["damping"] >= 0.0).all()
    if times[0] != 0.0 or (np.diff(times) < MIN_COURSE_TIME_STEP).any() or not gains:
        raise SceneError(
            f"[drive] needs times that grow from 0, by {MIN_COURSE_TIME_STEP:g} s at least, and gains of 0 or more"
        )
    period = float(values["period"])
    if not MIN_CONTROL_PERIOD <= period <= MAX_CONTROL_PERIOD:
        raise SceneError(
            f"[drive] has a period of {period:g} s: give one from {MIN_CONTROL_PERIOD:g} to {MAX_CONTROL_PERIOD:g} s"
        )
    arrays = {name: values[name] for name in _NUMBERS if name != "period"}
    return Drives(hinges=tuple(hinges), period=period, **arrays)


def _driven(names: Any, labels: Labels) -> list[int]:
    """Return the numbers of hinges by their names, as `drives_text` writes them."""
    if not isinstance(names, list) or not all(_is_named(name) for name in names):
        raise SceneError("[drive] must name each driven hinge once, as pictures do: write it with hcsearch drive")
    try:
        return [labels.hinge(str(name)) for name in names]
    except HcsearchError as error:
        raise SceneError(f"the drive is not one of this design: {error}; write it with hcsearch drive") from error


def _is_named(name: Any) -> bool:
    """Return whether a value of a file is the name of a hinge, a number or a text."""
    return isinstance(name, int | str) and not isinstance(name, bool) and is_label(str(name))


def _numbers(value: Any) -> Reals:
    """Convert a value to an array of numbers; SceneError for other values."""
    try:
        numbers = np.array(value)
    except ValueError as error:
        raise SceneError(_NO_NUMBERS) from error
    if numbers.dtype.kind not in "iuf" or _holds_truth(value):  # NumPy takes true among numbers for 1
        raise SceneError(_NO_NUMBERS)
    return numbers.astype(float)


def _holds_truth(value: Any) -> bool:
    return isinstance(value, bool) or (isinstance(value, list) and any(map(_holds_truth, value)))


def drives_text(drives: Drives, labels: Labels) -> str:
    """Write drives as the table that `drives_in` reads; angles of the course to 1e-9 rad, torques to 1e-9 N m."""
    lines = ["[drive]", f"driven = {json.dumps([label_data(labels.hinges[hinge]) for hinge in drives.hinges])}"]
    for name in _NUMBERS:
        value = getattr(drives, name)
        if name in {"times", "angles", "torques"}:
            value = np.round(value, 9) + 0.0
        data = value.tolist() if isinstance(value, np.ndarray) else value
        if name in {"angles", "torques"}:
            rows = ",\n".join(f"  {json.dumps(row)}" for row in data)
            lines.append(f"{name} = [\n{rows},\n]")
        else:
            lines.append(f"{name} = {json.dumps(data)}")
    return "".join(f"{line}\n" for line in lines)
