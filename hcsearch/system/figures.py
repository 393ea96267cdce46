"""Pictures of curves: one palette for all plots, and one look, whatever a machine or a notebook set for matplotlib."""

from __future__ import annotations

import logging
import os
import re
import sys
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from logging.handlers import BufferingHandler
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from hcsearch.basics.errors import HcsearchError
from hcsearch.system.outputs import PICTURE_SUFFIXES, check_output, replacing_file

if TYPE_CHECKING:
    import matplotlib.axes
    import matplotlib.figure

    Axes: TypeAlias = matplotlib.axes.Axes
    Figure: TypeAlias = matplotlib.figure.Figure

CURVE_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#c061a0", "#b58900", "#3a9bdc", "#8c5a3c", "#808080")
"""After Okabe and Ito, so that colour-blind readers tell them apart; mid tones, for light and dark pages."""
CURVE_DASHES: tuple[tuple[float, ...], ...] = ((), (4.0, 1.5), (1.0, 1.5), (5.0, 1.5, 1.0, 1.5))
"""Strokes and gaps, in widths of the line; solid lines have none."""
CURVE_LOOK_COUNT = len(CURVE_COLOURS) * len(CURVE_DASHES)
"""Looks there are; the next ones are the first again."""


class CurveLook(NamedTuple):
    """A colour, and one of `CURVE_DASHES`."""

    colour: str
    dashes: tuple[float, ...]


def curve_look(number: int) -> CurveLook:
    """Look of a curve; those of `CURVE_LOOK_COUNT` curves differ, and of neighbours in both colour and dashes."""
    return CurveLook(
        CURVE_COLOURS[number % len(CURVE_COLOURS)],
        CURVE_DASHES[(number + number // len(CURVE_COLOURS)) % len(CURVE_DASHES)],
    )


LINE_WIDTH, LINE_WIDTH_STEP = 1.4, 1.2
"""Of lines, pt, and by how much they are wider where looks begin anew."""
TITLE_WIDTH = 92
"""Characters in a line of a title."""
_BACKEND = "MPLBACKEND"
_STYLE = {"axes.prop_cycle": f"cycler('color', {list(CURVE_COLOURS)})", "axes.grid": True, "grid.alpha": 0.3}
"""What differs from matplotlib's defaults."""


def check_picture(path: str) -> None:
    """Refuse a picture that could not be drawn or written, before anything is computed."""
    check_output(path, PICTURE_SUFFIXES)
    load_matplotlib()


@contextmanager
def figure_for(
    path: str | Path, size: tuple[float, float], dpi: int = 120, simpler: float | None = None
) -> Iterator[Figure]:
    """Give an empty figure, and write what the block draws on it to a file .svg, .png or .pdf.

    size : width and height, inches. simpler : pixels by which a line may be drawn aside, to have fewer points.
    """
    load_matplotlib()
    from matplotlib import style  # noqa: PLC0415 - only where a picture is wanted
    from matplotlib.figure import Figure  # noqa: PLC0415 - as above

    own = _STYLE if simpler is None else _STYLE | {"path.simplify_threshold": simpler}
    # some settings are read as lines are made, some as they are written
    with style.context(["default", own]):
        figure = Figure(figsize=size, layout="constrained")
        yield figure
        with replacing_file(path, PICTURE_SUFFIXES) as part:
            figure.savefig(part, dpi=dpi)


def line_style(number: int) -> dict[str, Any]:
    """Colour, style and width of a line; those of two numbers differ, and of neighbours in colour and style."""
    colour, dashes = curve_look(number)
    return {
        "color": colour,
        "linestyle": (0, dashes) if dashes else "-",
        "linewidth": LINE_WIDTH + LINE_WIDTH_STEP * (number // CURVE_LOOK_COUNT),
    }


def add_legend(axes: Axes, title: str) -> None:
    """The legend of lines, beside the plot, in as many columns as they need."""
    lines = len(axes.get_legend_handles_labels()[0])
    if lines:
        where: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (1.01, 1.0), "borderaxespad": 0.0}
        axes.legend(title=title, fontsize="x-small", ncols=1 + (lines - 1) // 20, handlelength=3.5, **where)


def set_title(axes: Axes, title: str) -> None:
    """The title, in lines that fit and keep numbers with their units."""
    joined = re.sub(r"(\d) (s|rad|mm)\b", "\\1\N{NO-BREAK SPACE}\\2", title)
    text = textwrap.fill(joined, TITLE_WIDTH).replace("\N{NO-BREAK SPACE}", " ")
    axes.set_title(text, fontsize="medium", parse_math=False)  # names of files may hold dollar signs


def load_matplotlib() -> None:
    """Import matplotlib, for files alone: it need not have the windows of the environment. HcsearchError: it cannot be.

    Remarks on settings in files are kept to ourselves, as pictures do without these settings.
    """
    if "matplotlib.style" in sys.modules:
        return
    first, backend = "matplotlib" not in sys.modules, os.environ.pop(_BACKEND, None)
    log, said = logging.getLogger("matplotlib"), BufferingHandler(sys.maxsize)
    log.addHandler(said)
    try:
        import matplotlib.style  # noqa: PLC0415 - only where a picture is wanted
    except Exception as error:
        reason = " ".join(record.getMessage() for record in said.buffer) or f"{type(error).__name__}: {error}"
        raise HcsearchError(
            f"matplotlib cannot be loaded ({reason.rstrip('.')}): mend or move its settings (a file matplotlibrc in "
            "this folder or your own), or install it anew"
        ) from error
    finally:
        log.removeHandler(said)
        if backend is not None:
            os.environ[_BACKEND] = backend
    if first and backend:  # as its import does, so that plots of a notebook are shown as before
        with suppress(ValueError):
            matplotlib.rcParams["backend"] = backend
