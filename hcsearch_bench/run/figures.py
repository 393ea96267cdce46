"""Pictures: of error against run time, and how any is saved."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from hcsearch.system.outputs import replacing
from hcsearch_bench.run.work_precision import OURS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    WorkPoint = tuple[str, str, str, float, float]
    """A run of a bench of error against time: problem, engine, label of its curve, seconds, error."""


def save_figure(figure: Figure, path: Path, dpi: int = 120) -> None:
    """Write a picture to a file, in the place of an older one."""
    with replacing(path, (path.suffix,)) as part:
        figure.savefig(part, dpi=dpi)


def plot_work(points: Sequence[WorkPoint], ylabel: str, path: Path) -> None:
    """Error against seconds, a picture a problem, a curve an engine and method; ours with dots."""
    from matplotlib.figure import Figure

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
