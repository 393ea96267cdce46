"""Pictures of the bench `enumeration`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from hcsearch.system.figures import figure_for
from hcsearch_bench.enumeration.arrays import ArrayRow
from hcsearch_bench.enumeration.listing import GrowthRow, ListingRow
from hcsearch_bench.peers.engines import ENGINES

_COLOURS = {"hex": "C0", "square": "C1", "triangle": "C2"}


def plot_growth(listed: Sequence[ListingRow], growth: Sequence[GrowthRow], path: Path) -> None:
    """Seconds and nanoseconds a circuit against n, with the fitted factor a cell beside the connective constant."""
    with figure_for(path, (11, 4.5)) as figure:
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
            each.plot(
                ns, [1e9 * row.list_s / row.free for row in rows], "o-", color=colour, label=f"{fit.grid}, listing"
            )
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


def plot_arrays(rows: Sequence[ArrayRow], limit: float, path: Path) -> None:
    """Seconds and memory of each engine that lists, against the number of circuits of the array."""
    with figure_for(path, (11, 4.5)) as figure:
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
            xlabel="circuits of the array",
            ylabel="processor seconds",
            title="One array: squares filled, hexagons hollow",
        )
        memory.set(xlabel="circuits of the array", ylabel="peak MiB of the process", title="Memory")
        for axes in (seconds, memory):
            axes.set_xscale("log")
        seconds.set_yscale("log")
        memory.set_ylim(bottom=0)
        figure.legend(*seconds.get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize="small")
