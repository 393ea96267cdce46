"""What is planned: a linkage whose panels are shrunk by a margin, as the kernels take it, and how large it may be."""

from __future__ import annotations

import numpy as np

from hcsearch.basics.errors import SizeError
from hcsearch.kernels.linkage.prisms import Prisms
from hcsearch.kernels.planning.closed_states import Loops
from hcsearch.kernels.planning.space import Space
from hcsearch.motion.collision.panel_prisms import REFERENCE_EDGE_LENGTH, kept_apart, prisms_of, scale_of, solid_pairs
from hcsearch.shape.linkage import Linkage

LEVER_PER_EDGE = 0.45 / REFERENCE_EDGE_LENGTH
"""What points move by where one hinge turns by 1 rad, over the longest edge; pairs further apart do not meet."""
MEASURED_DISTANCE_PER_EDGE = 0.03 / REFERENCE_EDGE_LENGTH
"""Pairs further apart than this, over the longest edge, are not measured."""
MIN_STATE_GAP_SHARE, MIN_STEP_GAP_SHARE, MIN_DIRECTION_GAP_SHARE = 0.01, 0.05, 0.005
"""Gaps of shrunk panels over the margin: that each state has, that a step leaves, that a direction has at both ends."""
MAX_PLANNING_MEMORY_BYTES = 2_000_000_000
"""Memory that a search may take."""
_FIXED_BYTES, _PANEL_BYTES, _PAIR_BYTES = 250_000_000, 300_000, 900
"""Bytes: without panels; for each panel, as of states in trees; for each two, as of gaps in a state."""


def check_memory(n: int) -> None:
    """Refuse more panels than fit into the memory, before anything is computed; SizeError."""
    wanted = _memory(n)
    if wanted > MAX_PLANNING_MEMORY_BYTES:
        most = next(k for k in range(n - n % 100, 0, -100) if _memory(k) <= MAX_PLANNING_MEMORY_BYTES)
        raise SizeError(
            f"planning the motions of {n:,} panels takes about {wanted / 1e9:.1f} GB of memory, more than "
            f"{MAX_PLANNING_MEMORY_BYTES / 1e9:g} GB: take at most {most:,} panels"
        )


def _memory(n: int) -> int:
    """Memory that a search among n panels takes, at most."""
    return _FIXED_BYTES + n * (_PANEL_BYTES + _PAIR_BYTES * n)


def loops_of(linkage: Linkage) -> Loops:
    """The loops of a linkage as the kernels take them."""
    return Loops(linkage.chain, *linkage.loop_arrays, float(linkage.pattern.size))


def space_of(linkage: Linkage, margin: float, *, collide: bool = True) -> Space:
    """A linkage with its panels shrunk by a margin (m) on every face; collide : whether they must keep apart at all."""
    pairs = solid_pairs(linkage, prisms_of(linkage), kept_apart(linkage)).prisms
    prisms = prisms_of(linkage, margin)
    if not collide:
        pairs, prisms = pairs[:0], _none_of(prisms)
    chain, edge = linkage.chain, REFERENCE_EDGE_LENGTH * scale_of(linkage)
    across = np.zeros((linkage.n_panels, linkage.n_hinges))
    for panel in chain.order:
        if chain.parents[panel] >= 0:
            across[panel] = across[chain.parents[panel]]
            across[panel, chain.hinges[panel]] = chain.signs[panel]
    return Space(
        loops=loops_of(linkage),
        folded=linkage.folded.astype(float),
        across=across,
        prisms=prisms,
        pairs=np.ascontiguousarray(pairs),
        lever=LEVER_PER_EDGE * edge,
        near=MEASURED_DISTANCE_PER_EDGE * edge,
        least=MIN_STATE_GAP_SHARE * margin,
        kept=MIN_STEP_GAP_SHARE * margin,
        parted=MIN_DIRECTION_GAP_SHARE * margin,
    )


def _none_of(prisms: Prisms) -> Prisms:
    """No prisms, so that none are placed where panels pass through each other."""
    panels, counts = prisms.panels[:0], prisms.counts[:0]
    vertices, middles, reaches = prisms.vertices[:0], prisms.middles[:0], prisms.reaches[:0]
    return Prisms(panels, counts, vertices, middles, reaches, prisms.normals[:0], prisms.edges[:0])
