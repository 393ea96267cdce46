"""The bench `identification`: errors of springs and damping that come out of measurements with noise.

The measurements are made up from known laws: no others have a truth to compare with.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from hcsearch.basics.vocabulary import MotionTerm
from hcsearch.system.figures import figure_for
from hcsearch_bench.run.bench import Bench, Say
from hcsearch_bench.run.table import Table

if TYPE_CHECKING:
    from hcsearch_bench.identification.error_rows import DampingRow, SpringRow
    from hcsearch_bench.identification.film_rows import FilmVerdictRow, ParameterRow

NOISES = (0.0, 1e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1, 0.2, 0.3)
LAWS = {
    "linear": "linear:0.1",
    "linear, preloaded": "linear:0.1+0.02",
    "quadratic": "quadratic:0.02,0.03",
    "table": "table:0@0,0.1@1,0.15@2,0.4@2.8",
}
RECORDS, QUICK = 100, 8
FILMS: tuple[tuple[str, MotionTerm | None, int, int], ...] = (
    ("friction", None, 100, 1),
    ("drag", None, 100, 0),
    ("drag", "drag", 20, 0),
    ("gravity", None, 20, 0),
)
"""Cases of films, a term that is planted and not fitted, and numbers of films: of the bench, and of the quick one."""


@dataclass(frozen=True)
class IdentificationResults:
    """All that one run of the bench measured."""

    damping: list[DampingRow]
    springs: list[SpringRow]
    verdicts: list[FilmVerdictRow]
    parameters: list[ParameterRow]


def tables(results: IdentificationResults) -> list[Table]:
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
            results.damping,
        ),
        Table(
            "identification-springs",
            "Laws of springs from moment-angle pairs, with noise",
            "Springs are loaded and unloaded at every degree up to 13 pi / 15. `noise` is a standard deviation "
            "as a share of the greatest moment. `recognised` is the number of records in which the chosen kind "
            "of law is that of the pairs. `moment_error` is the error of the chosen law over the measured "
            "angles, rms, as a share of the greatest moment.",
            results.springs,
        ),
        Table(
            "identification-films",
            "Parameters from films of a deployment, with noise",
            "Films of 120 frames show all hinges of a deployment, with white noise of 1 % of pi (1.8 degrees), and "
            "begin up to a tenth of the motion before or after the release. `identified` is the number of films in "
            "which the parameter was fitted and identified, `within` the number of these whose 95 % interval holds the "
            "planted value. Errors are relative, of tilts in rad, rms.",
            results.parameters,
        ),
        Table(
            "identification-film-verdicts",
            "Verdicts on these films",
            "`explained`: films that the chosen model explains; `chosen`: those for which it has the planted terms; "
            "`predicted`: those whose model predicts a second film that was held out. The films of the row without "
            "drag are those of the row with it. `misfit_deg`: systematic part of what is left, rms degrees, median.",
            results.verdicts,
        ),
    ]


def draw(results: IdentificationResults, folder: Path) -> None:
    """Write the pictures."""
    plot_identification(results.damping, results.springs, folder / "identification.png")


def measure(*, quick: bool, say: Say) -> IdentificationResults:
    """Run the whole bench: half an hour, or seconds when `quick`."""
    from hcsearch_bench.identification.error_rows import measure_damping, measure_springs
    from hcsearch_bench.identification.film_rows import measure_films

    records = QUICK if quick else RECORDS
    damping = [measure_damping(noise, range(k * records, (k + 1) * records), say=say) for k, noise in enumerate(NOISES)]
    springs = [
        measure_springs(kind, text, noise, range(k * records, (k + 1) * records))
        for kind, text in LAWS.items()
        for k, noise in enumerate(NOISES)
        if noise < 0.1
    ]
    verdicts, parameters = [], []
    for name, without, films, quick_films in FILMS:
        if seeds := range(quick_films if quick else films):
            verdict, rows = measure_films(name, seeds, without=without, say=say)
            verdicts.append(verdict)
            parameters += rows if without is None else []
    return IdentificationResults(damping, springs, verdicts, parameters)


def plot_identification(damping: Sequence[DampingRow], springs: Sequence[SpringRow], path: Path) -> None:
    """Errors against noise, of the damping test and of springs; the standard error that the program reports dashed."""
    with figure_for(path, (11, 4.5)) as figure:
        left, right = figure.subplots(1, 2)
        rows = [row for row in damping if row.noise > 0.0]
        noise = [row.noise for row in rows]
        for colour, name, label in (
            ("C0", "frequency", "frequency f"),
            ("C1", "damping", "damping ratio ζ"),
            ("C2", "coefficient", "damping coefficient c"),
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


IDENTIFICATION = Bench(
    "identification",
    "Measure errors of identified springs, damping and films. Measurements are simulated, with known laws and noise.",
    "hcsearch bench identification --quick --json identification.json",
    measure,
    tables,
    draw,
    peers=("scipy",),
)
