"""Pictures of the tables."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from hcsearch.bench.arrays import ArrayRow
from hcsearch.bench.engines import ENGINES
from hcsearch.bench.listing import GrowthRow, ListingRow
from hcsearch.bench.work import OURS
from hcsearch.outputs import replacing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from hcsearch.bench.folding import FoldingRow
    from hcsearch.bench.identification import DampingRow, SpringRow

    WorkPoint = tuple[str, str, str, float, float]
    """A run of a bench of error against time: problem, engine, label of its curve, seconds, error."""

_COLOURS = {"hex": "tab:blue", "square": "tab:orange", "triangle": "tab:green"}


def save_figure(figure: Figure, path: Path, dpi: int = 120) -> None:
    """Write a picture to a file, in the place of an older one."""
    with replacing(path, (path.suffix,)) as part:
        figure.savefig(part, dpi=dpi)


def plot_growth(listed: Sequence[ListingRow], growth: Sequence[GrowthRow], path: Path) -> None:
    """Seconds and nanoseconds a circuit against n, with the fitted factor a cell beside the connective constant."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - the process that starts jobs stays small

    figure = Figure(figsize=(11, 4.5), layout="constrained")
    total, each = figure.subplots(1, 2)
    for fit in growth:
        rows = [row for row in listed if row.grid == fit.grid]
        ns = [row.n for row in rows]
        colour = _COLOURS[fit.grid]
        label = f"{fit.grid}: time x{fit.seconds_factor:.2f}, circuits x{fit.circuits_factor:.2f} a cell"
        label += f" (connective constant {fit.connective:.2f})"
        total.plot(ns, [row.list_s for row in rows], "o", color=colour, label=label)
        first, last = map(int, fit.points.split(".."))
        fitted = [row for row in rows if row.n >= first]
        middle = math.exp(sum(math.log(row.list_s) for row in fitted) / len(fitted))
        centre = sum(row.n for row in fitted) / len(fitted)
        ends = [first, last]
        total.plot(ends, [middle * fit.seconds_factor ** (n - centre) for n in ends], "-", color=colour)
        each.plot(ns, [1e9 * row.list_s / row.free for row in rows], "o-", color=colour, label=f"{fit.grid}, listing")
        folding = [1e3 * row.fold_twist_us for row in rows]
        each.plot(ns, folding, "s--", color=colour, mfc="white", label=f"{fit.grid}, two-stack and twist")
    total.set(
        xlabel="cells n", ylabel="processor seconds, one core", yscale="log", title="All arrays of n cells: listing"
    )
    each.set(xlabel="cells n", ylabel="nanoseconds a free circuit", yscale="log", title="The same, a circuit")
    each.legend(fontsize="small", ncols=1)
    total.legend(fontsize="x-small", loc="upper left")
    top = max(row.list_s for row in listed)
    total.set_ylim(top=60 * top)  # room for the legend
    for axes in (total, each):
        axes.grid(alpha=0.3)
    save_figure(figure, path)


def plot_arrays(rows: Sequence[ArrayRow], limit: float, path: Path) -> None:
    """Seconds and memory of each engine that lists, against the number of circuits of the array."""
    from matplotlib.figure import Figure  # noqa: PLC0415

    figure = Figure(figsize=(11, 4.5), layout="constrained")
    seconds, memory = figure.subplots(1, 2)
    circuits = {(row.grid, row.array): row.circuits for row in rows if row.circuits}
    colours = iter(f"C{k}" for k in range(10))
    for engine in (engine for engine in ENGINES if engine.kind == "list"):
        name = f"{engine.name} ({engine.task.removeprefix('list: ')})"
        ours = [row for row in rows if (row.engine, row.task) == (engine.name, engine.task)]
        marker, colour = "s--" if engine.peer else "o-", next(colours)
        for grid in ("square", "hex"):
            points = [
                (circuits[row.grid, row.array], row.seconds, row.peak_mib)
                for row in ours
                if row.seconds and row.grid == grid
            ]
            style = {"color": colour, "mfc": colour if grid == "square" else "white"}
            label = name if grid == "square" else None
            seconds.plot([p[0] for p in points], [p[1] for p in points], marker, label=label, **style)
            memory.plot([p[0] for p in points], [p[2] for p in points], marker, **style)
        late = [circuits.get((row.grid, row.array)) for row in ours if row.note.startswith("over")]
        seconds.plot([c for c in late if c], [limit] * len([c for c in late if c]), "^", color=colour)
    seconds.axhline(limit, color="grey", lw=0.8, ls=":")
    seconds.annotate(
        f"limit {limit:g} s: ▲ not finished", (0.02, limit), xycoords=("axes fraction", "data"), va="bottom"
    )
    seconds.set(
        xlabel="circuits of the array", ylabel="processor seconds", title="One array: squares filled, hexagons hollow"
    )
    memory.set(xlabel="circuits of the array", ylabel="peak MiB of the process", title="Memory")
    for axes in (seconds, memory):
        axes.set_xscale("log")
        axes.grid(alpha=0.3)
    seconds.set_yscale("log")
    memory.set_ylim(bottom=0)
    figure.legend(*seconds.get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize="small")
    save_figure(figure, path)


def plot_folding(rows: Sequence[FoldingRow], path: Path) -> None:
    """Seconds of the three ways to designs that fold against n, a picture a grid."""
    from matplotlib.figure import Figure  # noqa: PLC0415

    grids = list(dict.fromkeys(row.grid for row in rows))
    figure = Figure(figsize=(12, 4.5), layout="constrained")
    pictures = figure.subplots(1, len(grids), squeeze=False, sharey=True)[0]
    for axes, grid in zip(pictures, grids, strict=True):
        for keep, marker in (("two-stack", "o-"), ("untwisted", "s--")):
            ours = [row for row in rows if (row.grid, row.keep) == (grid, keep)]
            ways = [("joined", "tab:blue", "join_s"), ("counted", "tab:green", "count_s")]
            if keep == "two-stack":  # the same run as for untwisted ones
                ways.insert(0, ("all circuits listed and filtered", "tab:red", "filter_s"))
            for way, colour, column in ways:
                points = [(row.n, getattr(row, column)) for row in ours if getattr(row, column)]
                label = way if column == "filter_s" else f"{keep} designs {way}"
                axes.plot([n for n, _ in points], [s for _, s in points], marker, color=colour, ms=4, label=label)
        axes.set(xlabel="panels n", yscale="log", title=grid)
        axes.grid(alpha=0.3)
    pictures[0].set_ylabel("processor seconds, one core")
    figure.legend(*pictures[0].get_legend_handles_labels(), loc="outside lower center", ncols=5, fontsize="small")
    save_figure(figure, path)


def plot_work(points: Sequence[WorkPoint], ylabel: str, path: Path) -> None:
    """Error against seconds, a picture a problem, a curve an engine and method; ours with dots."""
    from matplotlib.figure import Figure  # noqa: PLC0415

    names = list(dict.fromkeys(point[0] for point in points))
    curves = list(dict.fromkeys((engine, label) for _, engine, label, _, _ in points))
    figure = Figure(figsize=(15, 7.5), layout="constrained")
    pictures = figure.subplots(2, -(-len(names) // 2), squeeze=False).ravel()
    for axes, name in zip(pictures, names, strict=False):
        for k, (engine, label) in enumerate(curves):
            mine = [(s, max(e, 1e-16)) for at, _, own, s, e in points if (at, own) == (name, label)]
            style = "o-" if engine == OURS else "s--"
            axes.plot([s for s, _ in mine], [e for _, e in mine], style, color=f"C{k}", ms=4, label=label)
        axes.set(title=name, xlabel="seconds", ylabel=ylabel, xscale="log", yscale="log")
        axes.grid(alpha=0.3)
    for axes in pictures[len(names) :]:
        axes.set_axis_off()
    figure.legend(*pictures[0].get_legend_handles_labels(), loc="outside lower center", ncols=5, fontsize="small")
    save_figure(figure, path)


def plot_identification(damping: Sequence[DampingRow], springs: Sequence[SpringRow], path: Path) -> None:
    """Errors against noise, of the damping test and of springs; what the program itself tells of them dashed."""
    from matplotlib.figure import Figure  # noqa: PLC0415

    figure = Figure(figsize=(11, 4.5), layout="constrained")
    left, right = figure.subplots(1, 2)
    rows = [row for row in damping if row.noise > 0.0]
    noise = [row.noise for row in rows]
    for colour, name, label in (
        ("tab:blue", "frequency", "frequency f"),
        ("tab:orange", "damping", "damping ratio ζ"),
        ("tab:green", "coefficient", "damping coefficient c"),
    ):
        left.plot(noise, [getattr(row, f"{name}_error") for row in rows], "o-", color=colour, label=label)
    left.plot(noise, [row.told_error for row in rows], "k--", label="standard error of c as told")
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
    save_figure(figure, path)
