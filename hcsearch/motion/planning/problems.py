"""The planning problem: a linkage with panels shrunk by a margin, and the group of motions in which its loops close.

Hinges generate one of four groups: turns about one line, plane motions, turns about a point, or all motions
(docs/explanation/motion.md, 8). The first two occur between flat-folded states, at which axes are known in whole
numbers.
"""

from __future__ import annotations

import numpy as np

from hcsearch.basics.array_values import Flags, Reals
from hcsearch.basics.errors import SizeError
from hcsearch.kernels.linkage.prisms import Prisms
from hcsearch.kernels.planning.closed_states import Group, Loops
from hcsearch.kernels.planning.space import Space
from hcsearch.motion.collision.panel_prisms import REFERENCE_EDGE_LENGTH, kept_apart, prisms_of, scale_of, solid_pairs
from hcsearch.motion.locks.lattice import WholeEnd, reduced_rows
from hcsearch.shape.linkage import Linkage

LEVER_PER_EDGE = 0.45 / REFERENCE_EDGE_LENGTH
"""Greatest displacement of a point where one hinge turns by 1 rad, over the longest edge; pairs further apart do not
meet."""
MEASURED_DISTANCE_PER_EDGE = 0.03 / REFERENCE_EDGE_LENGTH
"""Pairs further apart than this, over the longest edge, are not measured."""
MIN_STATE_GAP_SHARE, MIN_STEP_GAP_SHARE, MIN_DIRECTION_GAP_SHARE = 0.01, 0.05, 0.005
"""Gaps of shrunk panels over the margin: in each state, after a step, and along one direction at a chord's ends."""
MAX_PLANNING_MEMORY_BYTES = 2_000_000_000
"""Memory limit of a search."""
_FIXED_BYTES, _PANEL_BYTES, _PAIR_BYTES = 250_000_000, 300_000, 900
"""Bytes without panels; for each panel (states in trees); and for each pair of panels (gaps in a state)."""


def check_memory(n: int) -> None:
    """Refuse more panels than fit into memory, before anything is computed; SizeError."""
    memory = _memory(n)
    if memory > MAX_PLANNING_MEMORY_BYTES:
        max_panels = next(k for k in range(n - n % 100, 0, -100) if _memory(k) <= MAX_PLANNING_MEMORY_BYTES)
        raise SizeError(
            f"planning the motions of {n:,} panels takes about {memory / 1e9:.1f} GB of memory, more than "
            f"{MAX_PLANNING_MEMORY_BYTES / 1e9:g} GB: take at most {max_panels:,} panels"
        )


def _memory(n: int) -> int:
    """Upper bound of the memory of a search among n panels."""
    return _FIXED_BYTES + n * (_PANEL_BYTES + _PAIR_BYTES * n)


def loops_of(linkage: Linkage) -> Loops:
    """Return the loops of a linkage in the format of the kernels."""
    return Loops(linkage.chain, *linkage.loop_arrays, float(linkage.pattern.size))


def space_of(linkage: Linkage, margin: float, *, collide: bool = True) -> Space:
    """Return a linkage with its panels shrunk by a margin (m) on every face; collide : whether they must keep apart."""
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
        measured_distance=MEASURED_DISTANCE_PER_EDGE * edge,
        min_gap=MIN_STATE_GAP_SHARE * margin,
        step_gap=MIN_STEP_GAP_SHARE * margin,
        parting_gap=MIN_DIRECTION_GAP_SHARE * margin,
    )


def _none_of(prisms: Prisms) -> Prisms:
    """Return an empty set of prisms, for panels that pass through each other."""
    panels, counts = prisms.panels[:0], prisms.counts[:0]
    vertices, middles, reaches = prisms.vertices[:0], prisms.middles[:0], prisms.reaches[:0]
    return Prisms(panels, counts, vertices, middles, reaches, prisms.normals[:0], prisms.edges[:0])


VERTICAL_AXIS = np.array([0.0, 0.0, 1.0])


def group_of_all(loops: Loops) -> Group:
    """Return all hinges, in the group of all motions: six equations per loop."""
    moving = np.ones(len(loops.chain.points), bool)
    return Group(np.eye(6 * (len(loops.starts) - 1)), moving, loops.starts, loops.hinges)


def group_of(linkage: Linkage, loops: Loops, end: WholeEnd, moving: Flags, jacobian: Reals) -> Group:
    """Return the smallest group in which loops close while some hinges stay fixed at a flat-folded closed state.

    end : that state in whole numbers. moving : (n_hinges,), the hinges that turn. jacobian : (n_rows, n_hinges),
    screws there. All hinges, and all equations, where some loop needs the group of all motions.
    """
    rows: list[Reals] = []
    turning_hinges: list[list[int]] = []
    for loop, order in enumerate(end.order):
        turning = [hinge for hinge in order if moving[hinge]]
        turning_hinges.append(turning)
        columns = end.columns[turning, 6 * loop : 6 * loop + 6]
        if not turning:
            continue
        x, y = columns[0, 0], columns[0, 1]
        if any(column[0] * y != column[1] * x for column in columns):
            return group_of_all(loops)
        normal = np.cross(VERTICAL_AXIS, jacobian[6 * loop : 6 * loop + 3, turning[0]])
        axis = jacobian[6 * loop : 6 * loop + 3, turning[0]]
        parts = [(axis, 0)] if len(reduced_rows(columns)) == 1 else [(axis, 0), (normal, 3), (VERTICAL_AXIS, 3)]
        for vector, place in parts:
            row = np.zeros(len(jacobian))
            row[6 * loop + place : 6 * loop + place + 3] = vector
            rows.append(row)
    starts = np.cumsum([0, *map(len, turning_hinges)])
    hinges = np.array([hinge for turning in turning_hinges for hinge in turning], np.int64)
    return Group(np.array(rows).reshape(-1, linkage.n_rows), moving.copy(), starts, hinges)


def turns_equally(end: WholeEnd, moving: Flags) -> bool:
    """Whether loops stay closed, exactly, while the moving hinges leave their stops by any one common angle.

    They turn about parallel lines. Before hinge k the hinges of a loop have turned by j_k times the angle, and T moves
    a point by the sum of (e^(i j_k angle) - e^(i j_(k+1) angle)) p_k, p_k the places of lines in the plane across: so
    for each j the places have to sum to 0, a sum of whole numbers.
    """
    for loop, order in enumerate(end.order):
        sums: dict[int, list[int]] = {}
        turn, first = 0, None
        for hinge in order:
            if not moving[hinge]:
                continue
            screw = end.columns[hinge, 6 * loop : 6 * loop + 6].tolist()
            first = first or screw
            if screw[:2] not in (first[:2], [-first[0], -first[1]]):
                return False
            sense = 1 if screw[:2] == first[:2] else -1
            for level, sign in ((turn, sense), (turn + sense, -sense)):
                total = sums.setdefault(level, [0, 0, 0])
                sums[level] = [a + sign * b for a, b in zip(total, screw[3:], strict=True)]
            turn += sense
        if turn or any(any(total) for total in sums.values()):
            return False
    return True
