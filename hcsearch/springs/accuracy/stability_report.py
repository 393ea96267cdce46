"""The stability of a scene, judged at many points: the result of `hcsearch accuracy --sweep` and `--stress`."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from hcsearch.basics.vocabulary import finite_or_none
from hcsearch.springs.accuracy.measured_accuracy import facts_table
from hcsearch.springs.accuracy.stability_points import JUDGEMENTS, Judgement, StabilityPoint
from hcsearch.springs.accuracy.swept_values import SWEPT_VALUES
from hcsearch.system.figures import figure_for, set_title
from hcsearch.system.terminal import short_number

if TYPE_CHECKING:
    import pandas as pd

    from hcsearch.system.figures import Axes

JUDGEMENT_COLOURS: dict[Judgement, str] = {
    "accurate": "#7fc97f",
    "degraded": "#ffd54a",
    "refused": "#b8c4d0",
    "wrong": "#e8342a",
}
"""Colours of cells, light enough for the numbers on them."""
_UNITS = {
    "error": "error_rad",
    "bound": "bound_rad",
    "until": "until_s",
    "seconds": "processor_s",
    "drift": "energy_drift",
}
"""Names of fields in data, with their units."""
MIN_SHOWN_ERROR = 1e-16
"""Smaller errors (rad) are shown as this one."""


@dataclass(frozen=True, repr=False)
class MeasuredStability:
    """The stability of a scene: simulations with other values, each accurate, degraded, refused or wrong.

    Parameters
    ----------
    name
        The name of the folding or assembly.
    scene
        The name of the scene.
    swept
        The values that are swept, in the order of the `values` of points; empty for the standard set.
    points
        The judgement at each point.
    """

    name: str
    scene: str
    swept: tuple[str, ...]
    points: tuple[StabilityPoint, ...]

    @property
    def counts(self) -> dict[Judgement, int]:
        """The number of points with each judgement."""
        counted = Counter(point.judgement for point in self.points)
        return {judgement: counted[judgement] for judgement in JUDGEMENTS}

    def facts(self) -> dict[str, Any]:
        """All results as plain data, as `hcsearch accuracy --json` prints them; keys name their units."""
        return {
            "subject": self.name,
            "scene": self.scene,
            "swept": [{"name": name, "unit": SWEPT_VALUES[name].unit} for name in self.swept],
            "counts": self.counts,
            "points": [self._point_facts(point) for point in self.points],
        }

    def _point_facts(self, point: StabilityPoint) -> dict[str, Any]:
        facts = {_UNITS.get(key, key): finite_or_none(value) for key, value in asdict(point).items()}
        return dict(zip(self.swept, facts.pop("values"), strict=True)) | facts

    def table(self) -> pd.DataFrame:
        """A pandas table of all points, as `hcsearch accuracy --output` writes it."""
        texts = ("label", "judgement", "outcome", "reason")
        return facts_table([self._point_facts(point) for point in self.points], texts)

    def picture(self, path: str) -> None:
        """Draw a map of the points into a file .svg, .png or .pdf, with a frame around the scene's own."""
        draw_stability(self, path)

    def __repr__(self) -> str:
        counts = ", ".join(f"{count} {judgement}" for judgement, count in self.counts.items() if count)
        return f"<stability of {self.name}, scene {self.scene}: {counts}>"


def draw_stability(measured: MeasuredStability, path: str) -> None:
    """Draw a map of judgements, one cell for each point: columns and rows for two values, else one column."""
    columns, rows, places = _places(measured)
    with figure_for(path, (max(6.5, 3.0 + 0.9 * len(columns)), 1.6 + 0.4 * len(rows)), dpi=150) as figure:
        axes = figure.subplots()
        for point, place in zip(measured.points, places, strict=True):
            shown = "" if point.error is None or point.judgement == "refused" else decade_text(point.error)
            draw_judged_cell(axes, place, point.judgement, shown, own=point.own)
        axes.set(xlim=(0, len(columns)), ylim=(len(rows), 0))
        axes.set_xticks([x + 0.48 for x in range(len(columns))], columns)
        axes.set_yticks([y + 0.46 for y in range(len(rows))], rows)
        if measured.swept:
            axes.set_ylabel(_axis_label(measured.swept[0]))
        if len(measured.swept) > 1:
            axes.set_xlabel(_axis_label(measured.swept[1]))
        finish_map(axes)
        set_title(axes, f"{measured.name}: log10 of the error, rad; framed: scene {measured.scene}")


def _axis_label(name: str) -> str:
    unit = SWEPT_VALUES[name].unit
    return f"{name}, {unit}" if unit else name


def _places(measured: MeasuredStability) -> tuple[list[str], list[str], list[tuple[float, float]]]:
    """Return the labels of columns and rows of a map, and the place of each point."""
    points = measured.points
    if len(measured.swept) < 2:
        rows = [short_number(point.values[0]) if point.values else point.label for point in points]
        return [""], rows, [(0.0, float(k)) for k in range(len(points))]
    first, second = (sorted({point.values[k] for point in points}) for k in (0, 1))
    places = [(float(second.index(point.values[1])), float(first.index(point.values[0]))) for point in points]
    return list(map(short_number, second)), list(map(short_number, first)), places


def decade_text(error: float) -> str:
    """Return the decimal logarithm of an error with one decimal."""
    return f"{math.log10(max(error, MIN_SHOWN_ERROR)):.1f}"


def draw_judged_cell(
    axes: Axes, place: tuple[float, float], judgement: Judgement, shown: str, *, own: bool = False
) -> None:
    """Draw a cell in the colour of a judgement, with a number on it, and a frame around the user's own point."""
    x, y = place
    line: dict[str, Any] = {"edgecolor": "black", "linewidth": 2.5} if own else {}
    axes.barh(y + 0.46, 0.96, left=x, height=0.92, color=JUDGEMENT_COLOURS[judgement], **line)
    axes.text(x + 0.9, y + 0.86, shown, fontsize=7, ha="right", va="bottom", weight="bold")


def finish_map(axes: Axes) -> None:
    """Remove grid and frame of a map, and add the legend of its colours."""
    axes.grid(visible=False)
    axes.tick_params(length=0, labelsize=7)
    for side in axes.spines.values():
        side.set_visible(False)
    handles = [axes.barh(0.0, 0.0, color=JUDGEMENT_COLOURS[name], label=name) for name in JUDGEMENTS]
    figure: Any = axes.figure
    figure.legend(handles=handles, loc="outside lower center", ncols=len(JUDGEMENTS), fontsize="small")
