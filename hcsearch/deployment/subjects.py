"""A folding as a linkage of thick panels."""

from __future__ import annotations

from hcsearch.folding import Folding
from hcsearch.linkage import Linkage
from hcsearch.scenes import PanelSize, default_panel


def folding_linkage(
    folding: Folding, panel: PanelSize | None = None, *, hinged: bool = False, merged: bool = False
) -> Linkage:
    """A folding as a linkage whose base is its bottom pair.

    panel : length, width, thickness (m), those of the scene `default` unless given. hinged : flat pairs hinged, not
    rigid. merged : mirror pairs of panels made one.
    """
    pattern = folding.pattern(panel or default_panel(folding.circuit.grid.name), hinged=hinged, merged=merged)
    return Linkage(pattern, base=pattern.panel_of[folding.crease])
