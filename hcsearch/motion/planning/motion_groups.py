"""The group of motions in which the loops of a linkage close while only some of its hinges turn.

Hinges generate one of four groups: that of the turns about one line, that of plane motions, that of the turns about a
point, or that of all motions (docs/explanation/motion.md, 8). The first two are met with between flat-folded states, at
which axes are known in whole numbers.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.planning.closed_states import Group, Loops
from hcsearch.motion.locks.lattice import WholeEnd, reduced_rows
from hcsearch.shape.linkage import Linkage

VERTICAL_AXIS = np.array([0.0, 0.0, 1.0])


def group_of_all(loops: Loops) -> Group:
    """All hinges, in the group of all motions: six equations a loop."""
    moving = np.ones(len(loops.chain.points), bool)
    return Group(np.eye(6 * (len(loops.starts) - 1)), moving, loops.starts, loops.hinges)


def group_of(linkage: Linkage, loops: Loops, end: WholeEnd, moving: NDArray[np.bool_], jacobian: Reals) -> Group:
    """The least of the groups in which loops close while some hinges stay as they are at a flat-folded closed state.

    end : that state in whole numbers. moving : (n_hinges,), of the hinges that do turn. jacobian : (n_rows, n_hinges),
    screws there. All hinges, and all equations, where the group of some loop is that of all motions.
    """
    rows: list[Reals] = []
    own: list[list[int]] = []
    for loop, order in enumerate(end.order):
        turning = [hinge for hinge in order if moving[hinge]]
        own.append(turning)
        columns = end.columns[turning, 6 * loop : 6 * loop + 6]
        if not turning:
            continue
        x, y = columns[0, 0], columns[0, 1]
        if any(column[0] * y != column[1] * x for column in columns):
            return group_of_all(loops)
        across = np.cross(VERTICAL_AXIS, jacobian[6 * loop : 6 * loop + 3, turning[0]])
        axis = jacobian[6 * loop : 6 * loop + 3, turning[0]]
        parts = [(axis, 0)] if len(reduced_rows(columns)) == 1 else [(axis, 0), (across, 3), (VERTICAL_AXIS, 3)]
        for vector, place in parts:
            row = np.zeros(len(jacobian))
            row[6 * loop + place : 6 * loop + place + 3] = vector
            rows.append(row)
    starts = np.cumsum([0, *map(len, own)])
    hinges = np.array([hinge for turning in own for hinge in turning], np.int64)
    return Group(np.array(rows).reshape(-1, linkage.n_rows), moving.copy(), starts, hinges)


def turns_equally(end: WholeEnd, moving: NDArray[np.bool_]) -> bool:
    """Whether loops stay closed, exactly, while some hinges leave their stops by the same angle, whatever it is.

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
                own = sums.setdefault(level, [0, 0, 0])
                sums[level] = [a + sign * b for a, b in zip(own, screw[3:], strict=True)]
            turn += sense
        if turn or any(any(own) for own in sums.values()):
            return False
    return True
