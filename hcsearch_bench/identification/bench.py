"""The bench `identification`: errors of springs and damping that come out of measurements with noise.

The measurements are made up from known laws: no others have a truth to compare with.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import ClassVar

import numpy as np

from hcsearch.scenes.laws import law_named
from hcsearch.springs.identification.damping import HingeTest, hinge_test
from hcsearch.springs.identification.springs import identify_spring
from hcsearch.springs.identification.vibration import identify_modes
from hcsearch.system.figures import figure_for
from hcsearch_bench.identification.rig import MOST_ANGLE, Rig, pairs
from hcsearch_bench.run.machine import this_machine
from hcsearch_bench.run.report import BenchReport, Say
from hcsearch_bench.run.tables import Table

NOISES = (0.0, 1e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1, 0.2, 0.3)
LAWS = {
    "linear": "linear:0.1",
    "linear, preloaded": "linear:0.1+0.02",
    "quadratic": "quadratic:0.02,0.03",
    "table": "table:0@0,0.1@1,0.15@2,0.4@2.8",
}
RECORDS, QUICK = 100, 8


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


@dataclass(frozen=True)
class IdentificationReport(BenchReport):
    """All that one run of the bench measured."""

    page: ClassVar[str] = "identification"

    damping: list[DampingRow]
    springs: list[SpringRow]

    @property
    def tables(self) -> list[Table]:
        """What is shown and saved."""
        return [
            Table(
                "identification-damping",
                "Damping from free vibration, with noise",
                "The thesis's rig: a block of 0.0051 kg m^2 on four hinges of 0.0043 N m s/rad, 2.50 Hz, ratio "
                "0.107, under a frame that rings at 33.7 and 89.6 Hz; two accelerometers, five seconds at 200 Hz. "
                "`noise` is a standard deviation as a share of the swing's amplitude at the start. Errors are "
                "relative, rms over the records in which the swing was recognised (`recognised`). `reported_error` "
                "is the reported standard error of the coefficient, `within_2` the share of coefficients within "
                "two standard errors. `false_modes` is the number of reported modes that do not exist.",
                self.damping,
            ),
            Table(
                "identification-springs",
                "Laws of springs from moment-angle pairs, with noise",
                "Springs are loaded and unloaded at every degree up to 13 pi / 15. `noise` is a standard deviation "
                "as a share of the greatest moment. `recognised` is the number of records in which the chosen kind "
                "of law is that of the pairs. `moment_error` is the error of the chosen law over the measured "
                "angles, rms, as a share of the greatest moment.",
                self.springs,
            ),
        ]

    def draw(self, folder: Path) -> None:
        """Write the pictures."""
        plot_identification(self.damping, self.springs, folder / "identification.png")


def measure(*, quick: bool = False, say: Say = print) -> IdentificationReport:
    """Run the whole bench: some minutes, or seconds when `quick`."""
    machine = this_machine(("scipy",))
    records = QUICK if quick else RECORDS
    damping = [measure_damping(noise, range(k * records, (k + 1) * records), say=say) for k, noise in enumerate(NOISES)]
    springs = [
        measure_springs(kind, text, noise, range(k * records, (k + 1) * records))
        for kind, text in LAWS.items()
        for k, noise in enumerate(NOISES)
        if noise < 0.1
    ]
    return IdentificationReport(machine, damping, springs)


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
        chosen = identify_spring(*measured).chosen
        times.append(time.perf_counter() - begun)
        recognised += chosen.kind == kind
        by_law = np.array([chosen.law.straight.moment(angle) for angle in angles])
        errors.append(_rms((by_law - moments) / abs(moments).max()))
    return SpringRow(text, noise, len(seeds), recognised, _rms(errors), 1e3 * median(times))


def _near(frequency: float, true: float) -> bool:
    return abs(frequency / true - 1.0) < 0.1


def _rms(values: Sequence[float] | np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else math.nan


def plot_identification(damping: Sequence[DampingRow], springs: Sequence[SpringRow], path: Path) -> None:
    """Errors against noise, of the damping test and of springs; the standard error that the program reports dashed."""
    with figure_for(path, (11, 4.5)) as figure:
        left, right = figure.subplots(1, 2)
        rows = [row for row in damping if row.noise > 0.0]
        noise = [row.noise for row in rows]
        for colour, name, label in (
            ("tab:blue", "frequency", "frequency f"),
            ("tab:orange", "damping", "damping ratio ζ"),
            ("tab:green", "coefficient", "damping coefficient c"),
        ):
            left.plot(noise, [getattr(row, f"{name}_error") for row in rows], "o-", color=colour, label=label)
        left.plot(noise, [row.reported_error for row in rows], "k--", label="standard error of c as reported")
        left.set(xlabel="noise, share of the swing's amplitude", ylabel="relative error, rms", title="Free vibration")
        for k, law in enumerate(dict.fromkeys(row.law for row in springs)):
            own = [row for row in springs if row.law == law and row.noise > 0.0]
            label = law if len(law) < 30 else f"{law[:27]}..."
            right.plot([row.noise for row in own], [row.moment_error for row in own], "o-", color=f"C{k}", label=label)
        right.set(
            xlabel="noise, share of the greatest moment",
            ylabel="error of the moment, share of the greatest",
            title="Springs",
        )
        for axes in (left, right):
            axes.set(xscale="log", yscale="log")
            axes.legend(fontsize="small")
            axes.grid(alpha=0.3)
