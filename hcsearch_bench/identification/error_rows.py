"""Rows of the bench `identification`: errors of what is identified in records of one noise."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median

import numpy as np

from hcsearch.scenes.laws import law_named
from hcsearch.springs.identification.law_fitting import fit_spring
from hcsearch.springs.identification.vibration import HingeTest, hinge_test, identify_modes
from hcsearch_bench.identification.rig import MOST_ANGLE, Rig, pairs
from hcsearch_bench.run.bench import Say


@dataclass(frozen=True)
class DampingRow:
    """Free vibrations at one level of noise: relative errors, rms over the records in which the swing was recognised.

    recognised : records in which the swing was recognised. reported_error : standard error of the damping coefficient
    that identification reports, rms. within_2 : share of records whose coefficient is within two of those.
    false_modes : reported, but not there. ms : of one record, median.
    """

    noise: float
    records: int
    recognised: int
    false_modes: int
    frequency_error: float
    damping_error: float
    coefficient_error: float
    reported_error: float
    within_2: float | None
    ms: float


@dataclass(frozen=True)
class SpringRow:
    """Springs of one law at one level of noise.

    recognised : records for which the kind of law was chosen that made them. moment_error : of the chosen law over the
    measured angles, rms, as a share of the greatest moment. ms : of one record, median.
    """

    law: str
    noise: float
    records: int
    recognised: int
    moment_error: float
    ms: float


def measure_damping(noise: float, seeds: Sequence[int], *, say: Say) -> DampingRow:
    """A row from a record of the rig for each seed."""
    say(f"free vibration, noise {noise:g}")
    rig = Rig()
    truth = {"frequency": rig.frequency, "damping": rig.ratio, "coefficient": rig.damping}
    true_frequencies = (rig.frequency, 33.72, 89.64)
    tests: list[HingeTest] = []
    false_modes, times = 0, []
    for seed in seeds:
        record = rig.record(noise, seed)
        begun = time.perf_counter()
        modes = identify_modes(record, rig.rate).modes
        times.append(time.perf_counter() - begun)
        false_modes += sum(not any(_near(mode.frequency, true) for true in true_frequencies) for mode in modes)
        tests += [hinge_test(mode, rig.inertia, rig.hinges) for mode in modes if _near(mode.frequency, rig.frequency)]
    within = sum(abs(test.coefficient - rig.damping) < 2.0 * test.coefficient_error for test in tests)
    return DampingRow(
        noise=noise,
        records=len(seeds),
        recognised=len(tests),
        false_modes=false_modes,
        **{f"{name}_error": _rms([getattr(test, name) / true - 1.0 for test in tests]) for name, true in truth.items()},
        reported_error=_rms([test.coefficient_error / rig.damping for test in tests]),
        within_2=within / len(tests) if noise and tests else None,
        ms=1e3 * median(times),
    )


def measure_springs(kind: str, text: str, noise: float, seeds: Sequence[int]) -> SpringRow:
    """A row from a spring of one law for each seed."""
    law = law_named(text)
    angles = np.linspace(0.0, MOST_ANGLE, 100)
    moments = np.array([law.straight.moment(angle) for angle in angles])
    errors, recognised, times = [], 0, []
    for seed in seeds:
        measured = pairs(law, noise, seed)
        begun = time.perf_counter()
        chosen = fit_spring(*measured).chosen
        times.append(time.perf_counter() - begun)
        recognised += chosen.kind == kind
        by_law = np.array([chosen.law.straight.moment(angle) for angle in angles])
        errors.append(_rms((by_law - moments) / abs(moments).max()))
    return SpringRow(text, noise, len(seeds), recognised, _rms(errors), 1e3 * median(times))


def _near(frequency: float, true: float) -> bool:
    return abs(frequency / true - 1.0) < 0.1


def _rms(values: Sequence[float] | np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else math.nan
