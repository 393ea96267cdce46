"""Pictures of curves: matplotlib draws them by its own defaults, whatever machine, folder or notebook set for it."""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from logging.handlers import BufferingHandler
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from hcsearch.basics.errors import HcsearchError
from hcsearch.system.outputs import PICTURES, check_output, replacing

if TYPE_CHECKING:
    import matplotlib.axes
    import matplotlib.figure

    Axes: TypeAlias = matplotlib.axes.Axes
    Figure: TypeAlias = matplotlib.figure.Figure

_BACKEND = "MPLBACKEND"


def check_picture(path: str) -> None:
    """Refuse a picture that could not be drawn or written, before anything is computed."""
    check_output(path, PICTURES)
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

    own = {} if simpler is None else {"path.simplify_threshold": simpler}
    # some settings are read as lines are made, some as they are written
    with style.context(["default", own]):
        figure = Figure(figsize=size, layout="constrained")
        yield figure
        with replacing(path, PICTURES) as part:
            figure.savefig(part, dpi=dpi)


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
