"""Two-stack foldings of circuits and their twist, in O(n) integer operations per circuit."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import Integers16, Integers32
from hcsearch.kernels.compiling.compiled import compiled


@compiled
def fold_words(words: NDArray[np.int8], directions: int, rows: Integers32, creases: Integers16) -> int:
    """Write circuit and first flat crease of every two-stack folding; return their number.

    With x_i the turn at panel i, sign (-1)^i, crease j is flat when m divides the sum of all x and the sum of
    x_j+1 .. x_j+n/2 is (m / 2) (n / 2), mod m directions (docs/explanation/theory.md, 4). `rows` and
    `creases` have room for n / 2 foldings per circuit. n is even.
    """
    n_words, n = words.shape
    half = n // 2
    goal = half * (directions // 2)
    sums = np.zeros(n, np.int64)  # x_0 + .. + x_k, of turns not reduced mod m, as only residues matter
    max_sum = 2 * n * directions + goal  # greatest absolute value of the sums below
    divisible = np.zeros(2 * max_sum + 1, np.bool_)  # a table, as a division would take longer than the rest
    divisible[max_sum % directions :: directions] = True
    written = 0
    for row in range(n_words):
        before = np.int64(words[row, n - 1])
        total = np.int64(0)
        for k in range(0, n, 2):
            even, odd = np.int64(words[row, k]), np.int64(words[row, k + 1])
            sums[k] = total + even - before
            total = sums[k] - odd + even
            sums[k + 1] = total
            before = odd
        if not divisible[max_sum + total]:
            continue
        for j in range(half):
            if divisible[max_sum + sums[j + half] - sums[j] - goal]:
                rows[written] = row
                creases[written] = j
                written += 1
    return written


@compiled
def twist_words(words: NDArray[np.int8], directions: int, rows: Integers32, twist: Integers16) -> None:
    """Write the twist |Lk| = |T_even - T_odd| / m of each folding, from its circuit; `rows` must ascend."""
    n = words.shape[1]
    flip = directions // 2
    last_row = -1
    linking = np.int64(0)
    for i in range(len(rows)):
        row = rows[i]
        if row != last_row:
            last_row = row
            total = np.int64(0)
            before = np.int64(words[row, n - 1])
            for k in range(n):  # turn at panel k, between steps k - 1 and k
                d = np.int64(words[row, k])
                turn = d - before
                before = d
                if turn >= flip:
                    turn -= directions
                elif turn < -flip:
                    turn += directions
                total += turn if k % 2 == 0 else -turn
            linking = abs(total) // directions
        twist[i] = linking
