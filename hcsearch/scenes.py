"""Scenes: what a verdict on a folding depends on, beside the folding itself."""

from __future__ import annotations

PanelSize = tuple[float, float, float]


def default_panel(grid: str) -> PanelSize:
    """Length, width and thickness of a panel in the scene `default`, in metres."""
    return (0.050, 0.040 if grid == "rectangle" else 0.050, 0.006)
