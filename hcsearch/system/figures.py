"""Figures with matplotlib: one palette and one style for all plots, whatever settings a machine or a notebook has."""

from __future__ import annotations

import logging
import math
import os
import re
import sys
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from logging.handlers import BufferingHandler
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from hcsearch.basics.errors import HcsearchError
from hcsearch.system.outputs import PICTURE_SUFFIXES, check_output, replacing_file

if TYPE_CHECKING:
    import matplotlib.axes
    import matplotlib.figure
    from matplotlib.lines import Line2D

    Axes: TypeAlias = matplotlib.axes.Axes
    Figure: TypeAlias = matplotlib.figure.Figure

CURVE_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#c061a0", "#b58900", "#3a9bdc", "#8c5a3c", "#808080")
"""The palette, after Okabe and Ito: distinguishable by colour-blind readers, in mid tones for light and dark pages."""
CURVE_DASHES: tuple[tuple[float, ...], ...] = ((), (4.0, 1.5), (1.0, 1.5), (5.0, 1.5, 1.0, 1.5))
"""Lengths of strokes and gaps in line widths; empty for a solid line."""
CURVE_LOOK_COUNT = len(CURVE_COLOURS) * len(CURVE_DASHES)
"""Number of distinct pairs of colour and dashes; further curves repeat them."""


class CurveLook(NamedTuple):
    """The colour and the dash pattern (one of `CURVE_DASHES`) of a curve."""

    colour: str
    dashes: tuple[float, ...]


def curve_look(number: int) -> CurveLook:
    """Return the look of a curve; `CURVE_LOOK_COUNT` looks differ, consecutive ones in both colour and dashes."""
    return CurveLook(
        CURVE_COLOURS[number % len(CURVE_COLOURS)],
        CURVE_DASHES[(number + number // len(CURVE_COLOURS)) % len(CURVE_DASHES)],
    )


DEGREE_STEPS = (1, 1.5, 3, 4.5, 6, 9, 10)
"""Distances of ticks for angles in degrees, times a power of ten."""
LINE_WIDTH, LINE_WIDTH_STEP = 1.4, 1.2
"""Line width, and its increment each time the looks repeat, pt."""
_LETTER_WIDTH, _LABEL_HEIGHT = 5.2, 10.0
"""Width of a letter and height of a label on a curve, pt."""
TITLE_WIDTH = 92
"""Maximum number of characters in a line of a title."""
LEGEND_WIDTH = 30
"""Maximum number of characters in a line of a legend."""
_UNBROKEN = re.compile(r"(?<=\d) (?=(?:s|rad|mm)\b|to \d)|(?<=\d to) (?=\d)")
"""Spaces at which no line breaks."""
_BACKEND = "MPLBACKEND"
_STYLE = {
    "axes.prop_cycle": f"cycler('color', {list(CURVE_COLOURS)})",
    "axes.grid": True,
    "grid.alpha": 0.3,
    "svg.hashsalt": "hcsearch",
}
"""Settings that differ from matplotlib's defaults; with the salt, names within SVG files are the same in every run."""
_UNDATED = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
"""By the ending of a file: metadata without the time, so that equal figures are equal files."""


def check_picture(path: str) -> None:
    """Check, before anything is computed, that a picture can be drawn and written."""
    check_output(path, PICTURE_SUFFIXES)
    load_matplotlib()


@contextmanager
def figure_for(
    path: str | Path, size: tuple[float, float], dpi: int = 120, simpler: float | None = None
) -> Iterator[Figure]:
    """Yield an empty figure, and save it after the block as .svg, .png or .pdf.

    size : width and height, inches. simpler : deviation in pixels up to which lines may be simplified.
    """
    load_matplotlib()
    from matplotlib import style  # noqa: PLC0415 - only where a picture is wanted
    from matplotlib.figure import Figure  # noqa: PLC0415 - as above

    settings = _STYLE if simpler is None else _STYLE | {"path.simplify_threshold": simpler}
    # some settings are read as lines are made, some as they are written
    with style.context(["default", settings]):
        figure = Figure(figsize=size, layout="constrained")
        yield figure
        with replacing_file(path, PICTURE_SUFFIXES) as part:
            figure.savefig(part, dpi=dpi, metadata=_UNDATED.get(Path(path).suffix))


def line_style(number: int) -> dict[str, Any]:
    """Return colour, dashes and width of a line, different for each number; neighbours differ in colour and dashes."""
    colour, dashes = curve_look(number)
    return {
        "color": colour,
        "linestyle": (0, dashes) if dashes else "-",
        "linewidth": LINE_WIDTH + LINE_WIDTH_STEP * (number // CURVE_LOOK_COUNT),
    }


def add_legend(axes: Axes, title: str, lines: Sequence[Line2D]) -> None:
    """Add a legend of some lines beside the plot, with long labels wrapped, in as many columns as needed."""
    labels = [_wrapped(str(line.get_label()), LEGEND_WIDTH) for line in lines]
    if labels:
        row_count = sum(1 + label.count("\n") for label in labels)
        position: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (1.01, 1.0), "borderaxespad": 0.0}
        look: dict[str, Any] = {"fontsize": "x-small", "ncols": 1 + (row_count - 1) // 20, "handlelength": 3.5}
        axes.legend(lines, labels, title=title, **look, **position)


def label_curves(titles: Mapping[Axes, str]) -> None:
    """Write the label of each curve on it where it covers no other curve, and add legends of those without room.

    titles : of the legends, by the plots, which are all complete.
    """
    on_curves = {
        axes: [line for line in axes.get_lines() if not str(line.get_label()).startswith("_")] for axes in titles
    }
    in_legends: dict[Axes, list[Line2D]] = {axes: [] for axes in titles}
    while True:
        places = {axes: _label_places(axes, on_curves[axes], in_legends[axes]) for axes in titles}
        crowded = [axes for axes in titles if len(places[axes]) < len(on_curves[axes])]
        if not crowded:
            break
        for axes in crowded:  # a legend takes room from all plots, so that places are found anew
            in_legends[axes] += [line for line in on_curves[axes] if line not in places[axes]]
            on_curves[axes] = list(places[axes])
            add_legend(axes, titles[axes], [line for line in axes.get_lines() if line in in_legends[axes]])
    for axes in titles:
        _write_labels(axes, places[axes])


def _label_places(
    axes: Axes, labelled: Sequence[Line2D], others: Sequence[Line2D]
) -> dict[Line2D, tuple[float, float]]:
    """Return the centres, in pixels, of the labels that have room on their curves in the present layout.

    others : further curves, which labels must not cover.
    """
    from hcsearch.system.curve_labels import LabelFrame, label_places  # noqa: PLC0415 - loads NumPy

    figure: Any = axes.figure
    figure.draw_without_rendering()  # places of curves are known only then
    bounds, point = axes.bbox, figure.dpi / 72.0
    frame = LabelFrame(bounds.x0, bounds.x1, bounds.y0, bounds.y1, _LABEL_HEIGHT * point)
    widths = [_LETTER_WIDTH * point * len(str(line.get_label())) for line in labelled]
    found = label_places([_pixels(axes, line) for line in (*labelled, *others)], widths, frame)
    return {line: place for line, place in zip(labelled, found, strict=True) if place is not None}


def _write_labels(axes: Axes, places: Mapping[Line2D, tuple[float, float]]) -> None:
    """Write the labels of curves at their centres, in pixels, in the colours of the curves."""
    from matplotlib.patheffects import withStroke  # noqa: PLC0415 - only where a picture is wanted

    look: dict[str, Any] = {"fontsize": "x-small", "fontweight": "bold", "ha": "center", "va": "center"}
    look["path_effects"] = [withStroke(linewidth=3.0, foreground="white")]
    for line, place in places.items():
        x, y = axes.transData.inverted().transform(place)
        axes.text(x, y, str(line.get_label()), color=line.get_color(), **look)


def _pixels(axes: Axes, line: Line2D) -> list[tuple[float, float]]:
    """Return the points of a curve in pixels, without values that overflowed."""
    points = axes.transData.transform(line.get_xydata())
    return [(x, y) for x, y in points.tolist() if math.isfinite(x) and math.isfinite(y)]


def set_title(axes: Axes, title: str) -> None:
    """Set a title, wrapped."""
    text = _wrapped(title, TITLE_WIDTH)
    axes.set_title(text, fontsize="medium", parse_math=False)  # names of files may hold dollar signs


def unbroken(text: str) -> str:
    """Return a text with no-break spaces between a number and its unit, and within ranges such as `3 to 8`."""
    return _UNBROKEN.sub("\N{NO-BREAK SPACE}", text)


def _wrapped(text: str, width: int) -> str:
    return textwrap.fill(unbroken(text), width).replace("\N{NO-BREAK SPACE}", " ")


def text_font_file() -> str:
    """Return the file of the font of figures, which has Latin, Greek and Cyrillic letters."""
    load_matplotlib()
    import matplotlib  # noqa: PLC0415 - only where a picture is wanted

    return str(Path(matplotlib.get_data_path(), "fonts", "ttf", "DejaVuSans.ttf"))


def load_matplotlib() -> None:
    """Import matplotlib without its interactive backend; HcsearchError where that fails.

    Warnings about settings files are suppressed, since figures do not use these settings.
    """
    if "matplotlib.style" in sys.modules:
        return
    first_import, backend = "matplotlib" not in sys.modules, os.environ.pop(_BACKEND, None)
    log, messages = logging.getLogger("matplotlib"), BufferingHandler(sys.maxsize)
    log.addHandler(messages)
    try:
        import matplotlib.style  # noqa: PLC0415 - only where a picture is wanted
    except Exception as error:
        reason = " ".join(record.getMessage() for record in messages.buffer) or f"{type(error).__name__}: {error}"
        raise HcsearchError(
            f"matplotlib cannot be loaded ({reason.rstrip('.')}): mend or move its settings (a file matplotlibrc in "
            "this folder or your own), or install it anew"
        ) from error
    finally:
        log.removeHandler(messages)
        if backend is not None:
            os.environ[_BACKEND] = backend
    if first_import and backend:  # as the import itself does, so that plots in a notebook are still shown
        with suppress(ValueError):
            matplotlib.rcParams["backend"] = backend
