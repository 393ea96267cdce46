"""Pictures of error against run time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from hcsearch.system.figures import figure_for
from hcsearch_bench.run.work_precision import OURS

WorkPoint = tuple[str, str, str, float, float]
"""A run of a bench of error against time: problem, engine, label of its curve, seconds, error."""


def plot_work(points: Sequence[WorkPoint], ylabel: str, path: Path) -> None:
    """Error against seconds, a picture a problem, a curve an engine and method; ours with dots."""
    names = list(dict.fromkeys(point[0] for point in points))
    curves = list(dict.fromkeys((engine, label) for _, engine, label, _, _ in points))
    with figure_for(path, (15, 7.5)) as figure:
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
