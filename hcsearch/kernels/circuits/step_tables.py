"""Tables of a tiling's steps, on which all kernels of circuits run; they follow from its polygon alone."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import WholeNumbers
from hcsearch.kernels.compiling.compiled import compiled


class StepTables(NamedTuple):
    """The steps of a tiling, numbered 0 .. L - 1, and the turns of circuits at its panels.

    A turn leads from the step into a panel to the step out of it. Turns that a rotation maps onto each other have one
    code. Codes are ordered by the edge that the first step crosses, as one of the panel that it leaves, then from the
    sharpest turn left to the right.

    directions : number of directions in a full turn. directed : direction of each step. back : the step back.
    leaving : shape (kinds, sides), steps that leave a cell of each kind.
    following : shape (L, sides - 1), steps that can follow each, the sharpest turn left first. turns : the turn to
        each of these, in units of 2 pi / directions, left positive.
    codes : shape (L, L), code of the turn from one step to another, -1 where there is none. first_codes : code of the
        sharpest turn left after each step; the others follow.
    code_turns : the turn of each code. mirrored, reversed : code of the mirror image of the turn, and of that
        walked backwards. starts : the first step of a canonical circuit whose first turn has the code, -1 where none
        has.
    carried : shape (L, L), for a step and another one across an edge of the same panel: the step across the mirror
        image of that edge in the edge that the first one crosses; -1 for edges of other panels.
    after : shape (C, L), the step to which a turn of each code leads from each step, 0 where there is no such turn.
    code_bits : bits of a code.
    """

    directions: int
    directed: WholeNumbers
    back: WholeNumbers
    leaving: WholeNumbers
    following: WholeNumbers
    turns: WholeNumbers
    codes: WholeNumbers
    first_codes: WholeNumbers
    code_turns: WholeNumbers
    mirrored: WholeNumbers
    reversed: WholeNumbers
    starts: WholeNumbers
    carried: WholeNumbers
    after: NDArray[np.uint64]
    code_bits: int


@compiled
def turn_moves(steps: StepTables, moves: WholeNumbers) -> WholeNumbers:
    """Return the increments of the place number, shape (L, sides - 1), by the step before and the number of the turn.

    moves : increment by each step.
    """
    increments = np.empty_like(steps.following)
    for step in range(len(increments)):
        for turn in range(steps.following.shape[1]):
            increments[step, turn] = moves[steps.following[step, turn]]
    return increments
