"""Names of panels and hinges, as pictures and files write them.

Panels of a design have the numbers of its circuit, and hinges those of its creases, whatever is rigid or merged: panels
that are one are named together, `3+4`, and so are creases that are one hinge. Panels and hinges of an assembly have the
numbers of its pattern.
"""

from __future__ import annotations

from dataclasses import dataclass

from hcsearch.linkage import Linkage


@dataclass(frozen=True)
class Labels:
    """A name for each panel and for each hinge of a linkage, in their order."""

    panels: tuple[str, ...]
    hinges: tuple[str, ...]


def labels_of(linkage: Linkage, *, design: bool) -> Labels:
    """The names of a linkage's panels and hinges.

    design : whether its facets are the panels of a circuit, in order; crease k joins facets k and k + 1, cyclically.
    """
    pattern = linkage.pattern
    if not design:
        return Labels(tuple(map(str, range(linkage.n_panels))), tuple(map(str, range(linkage.n_hinges))))
    n = len(pattern.facets)
    creases: list[list[int]] = [[] for _ in range(linkage.n_hinges)]
    for pair, crease in pattern.creases.items():
        if crease.face is not None:
            creases[pattern.hinge_of(pair)].append(n - 1 if pair == (0, n - 1) and n > 2 else pair[0])
    return Labels(
        tuple("+".join(map(str, panel)) for panel in pattern.panels),
        tuple("+".join(map(str, sorted(own))) for own in creases),
    )
