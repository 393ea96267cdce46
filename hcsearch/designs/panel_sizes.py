"""Sizes of panels: length, width and thickness, in metres as values and in millimetres as texts of users."""

from __future__ import annotations

import re

from hcsearch.basics.errors import SceneError
from hcsearch.designs.grid import GRIDS

PanelSize = tuple[float, float, float]
"""Length, width and thickness of a panel, m."""
MIN_PANEL_LENGTH, MAX_PANEL_LENGTH = 1e-6, 1e4
"""Range of allowed lengths, widths and thicknesses, m."""
LIKELY_MIN_SIDE, LIKELY_MAX_SIDE = 0.005, 20.0
"""Sides below or above which a size was probably meant in another unit, m."""
LIKELY_MAX_THICKNESS = 0.2
"""Greatest thickness that is likely to be meant, m."""
ACROSS_FLATS_PREFIX = "across "
"""Prefix of a text that gives the width across flats and the thickness, as in `across 1000x20`."""
_NUMBER = r"\d+(?:\.\d+)?(?:[eE][+-]?\d+)?"
_PANEL = re.compile(rf"({_NUMBER})x({_NUMBER})(?:x({_NUMBER}))?", re.ASCII)


def _side_lengths(grid: str) -> list[float]:
    """The lengths of a panel's sides over the given length."""
    corners = [complex(*corner) for corner in GRIDS[grid].corners((0, 0, 0))]
    return [abs(corner - before) for before, corner in zip(corners[-1:] + corners, corners, strict=False)]


def _across(grid: str) -> float | None:
    """The distance across flats (of a triangle its height) over the side; None where lengths of sides differ."""
    if GRIDS[grid].given_edge or GRIDS[grid].stretched:
        return None
    first, second, *others = (complex(*corner) for corner in GRIDS[grid].corners((0, 0, 0)))
    return max(((corner - first) * (second - first).conjugate()).imag for corner in others)


def default_panel(grid: str) -> PanelSize:
    """Length, width and thickness of a panel in the scene `default`, in metres."""
    return (0.050, 0.040 if GRIDS[grid].stretched else 0.050, 0.006)


def read_panel(text: str, grid: str | None = None) -> PanelSize:
    """Read the size of a panel (m) in millimetres: length x width x thickness, or side x thickness.

    Length and width are the same except for rectangles: the side, or the grid's given edge. grid : of the panel, if
    known; panels of `rectangle` have three sizes. For a known grid with equal sides, `across 1000x20` gives the width
    across flats (of a triangle its height) and the thickness.
    """
    if text.startswith(ACROSS_FLATS_PREFIX) and grid is not None:
        return _read_across(text.removeprefix(ACROSS_FLATS_PREFIX).strip(), grid)
    match = _PANEL.fullmatch(text)
    if match is None:
        raise SceneError(
            f"{text!r} is no panel: write length x width x thickness in mm, such as 50x40x6, or side x "
            "thickness, such as 50x6"
        )
    sizes = [float(f"{float(part):.10g}") * 1e-3 for part in match.groups() if part is not None]
    if len(sizes) == 2 and grid is not None and GRIDS[grid].stretched:
        likely = "50x40x6" if _faults((sizes[0], sizes[1], 0.006)) else f"{match[1]}x{match[2]}x6"
        raise SceneError(
            f"{text!r} is no rectangle, which has a length, a width and a thickness: write three numbers in mm, such "
            f"as {likely}"
        )
    length, width, thickness = sizes if len(sizes) == 3 else (sizes[0], *sizes)
    if not all(MIN_PANEL_LENGTH <= size <= MAX_PANEL_LENGTH for size in sizes):
        raise SceneError(
            f"{text!r} is no panel: write length x width x thickness, from {1e3 * MIN_PANEL_LENGTH:g} to "
            f"{1e3 * MAX_PANEL_LENGTH:g} mm, such as 50x40x6"
        )
    return (length, width, thickness)


def _read_across(text: str, grid: str) -> PanelSize:
    match = _PANEL.fullmatch(text)
    if match is None or match[3] is not None:
        raise SceneError(f"{text!r} is no width across flats: write width x thickness in mm, such as 1000x20")
    factor = _across(grid)
    if factor is None:
        sizes = "50x40x6" if GRIDS[grid].stretched else f"50x6, where 50 is the {GRIDS[grid].given_edge}"
        raise SceneError(f"panels of the {grid} grid have no width across flats: write --panel {sizes}")
    return read_panel(f"{float(match[1]) / factor:.10g}x{match[2]}")


def panel_size_doubt(panel: PanelSize, grid: str | None = None, *, across: bool = False) -> str | None:
    """A sentence on sizes that are probably a mistake, with the likely ones; None where there is no doubt.

    Sides below 5 mm, as from a size in metres, or above 20 m are doubtful, and so are panels thicker than half their
    shortest side, as from sizes in another order. grid : of the panels, if known. across : whether the width across
    flats was given.
    """
    factor = (_across(grid) or 1.0) if across and grid is not None else 1.0
    share = 1.0 if grid is None else min(1.0, *_side_lengths(grid))
    faults = _faults(panel, share)
    if not faults:
        return None
    given = (factor * panel[0], factor * panel[1], panel[2])
    sizes = f"{_brief(given)} mm" + (" across flats" if across else "")
    likely = _likely(given, factor, share)
    if likely is not None:
        meant = f"; did you mean {_brief(likely)}?"
    elif given[0] == given[1] and not across and panel[2] > 0.5 * panel[0]:
        meant = f"; a thickness is missing where both are sides, as in {_brief(given)}x6"
    else:
        meant = ""
    order = "sizes are in mm, sides first, then the thickness"
    return f"panels of {sizes} have {' and '.join(faults)}: {order}{meant}"


def _faults(panel: PanelSize, share: float = 1.0) -> list[str]:
    """The doubtful features of a panel's sizes, in words; share : shortest side over the given one."""
    length, width, thickness = panel
    shortest, longest = share * min(length, width), max(length, width)
    faults = [f"a side of less than {1e3 * LIKELY_MIN_SIDE:g} mm"] if shortest < LIKELY_MIN_SIDE else []
    faults += [f"a side of more than {LIKELY_MAX_SIDE:g} m"] if longest > LIKELY_MAX_SIDE else []
    side = "side" if share == 1.0 else "shortest side"
    return faults + ([f"a thickness of more than half their {side}"] if thickness > 0.5 * shortest else [])


def _likely(panel: PanelSize, factor: float, share: float) -> PanelSize | None:
    """The probable meaning of doubtful sizes: the same in another order or unit, if that is not doubtful; else None.

    factor : ratio of the given sides to the sides of the panel.
    """
    length, width, thickness = panel
    side, reordered = min(length, width), [length, width, thickness]
    if thickness > side:
        reordered = [thickness, thickness, side] if length == width else sorted(panel, reverse=True)
    for scale in (1.0, 1e3, 1e-3):  # millimetres, metres, or millimetres that Python took for metres
        first, second, last = (scale * size for size in reordered)
        if last <= LIKELY_MAX_THICKNESS and not _faults((first / factor, second / factor, last), share):
            return (first, second, last)
    return None


def _brief(panel: PanelSize) -> str:
    """Side x thickness, or length x width x thickness, in millimetres, rounded for readers."""
    sizes = panel[1:] if panel[0] == panel[1] else panel
    return "x".join(f"{float(f'{1e3 * size:.4g}'):.10g}" for size in sizes)


def panel_text(panel: PanelSize) -> str:
    """Length x width x thickness in millimetres; `read_panel` reads it."""
    return "x".join(f"{1e3 * size:.10g}" for size in panel)


def is_panel(text: str) -> bool:
    """Whether a text is the size of a panel."""
    return _PANEL.fullmatch(text) is not None
