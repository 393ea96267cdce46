"""Two-stack foldings and their twist, in O(n) integer steps a circuit.

Sums along the circuit are taken from one alternating prefix sum P[k] = sum over i < k of (-1)^i d_i: the alternating
sum of d_a, d_{a+1}, ..., d_{b-1} that begins with a plus is (-1)^a (P[b] - P[a]). n is even, so that a sum that runs
past the end keeps its signs: there P[b] is P[n] + P[b - n].
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcsearch.kernels.compiled import compiled, lean


@compiled
def fold_words(words: NDArray[np.int8], directions: int, rows: NDArray[np.int32], creases: NDArray[np.int16]) -> int:
    """Write circuit and first flat crease of every two-stack folding; return how many there are.

    `rows` and `creases` have room for n / 2 foldings a circuit. n is even.
    """
    n_words, n = words.shape
    half = n // 2
    folds = half - 1  # reflections on the way from one flat crease to the other
    flip = directions // 2
    sign = 1 if folds % 2 == 0 else -1
    constant = flip if folds % 2 == 1 else 0
    parity = half * flip % 2
    prefix = np.zeros(n + 1, np.int64)
    most = (
        n + 4
    ) * directions  # no sum below is further from zero; looked up, as a division takes longer than the rest
    divisible = np.zeros(2 * most + 1, np.bool_)
    divisible[most % directions :: directions] = True
    written = 0
    for row in range(n_words):
        for k in range(0, n, 2):
            prefix[k + 1] = prefix[k] + words[row, k]
            prefix[k + 2] = prefix[k + 1] - words[row, k + 1]
        for j in range(half):
            crease, opposite = np.int64(words[row, j]), np.int64(words[row, j + half])
            if (crease ^ opposite) & 1 != parity:  # both congruences, mod 2
                continue
            # forward over creases j + 1 .. j + half - 1; the last one enters with a plus: r = 2 d + flip - r'
            ahead = prefix[j + half] - prefix[j + 1]
            if (j + half) % 2 == 0:  # the plus belongs to index j + half - 1
                ahead = -ahead
            if not divisible[most + 2 * ahead + constant + sign * (crease + flip) - opposite]:
                continue
            # backward over creases j - 1 .. j - half + 1
            back = prefix[n] + prefix[j] - prefix[j + half + 1]
            if (j + half + 1) % 2 == 1:  # the plus belongs to index j - half + 1
                back = -back
            if not divisible[most + 2 * back + constant + sign * crease - opposite - flip]:
                continue
            rows[written] = row
            creases[written] = j
            written += 1
    return written


@lean
def twist_words(words: NDArray[np.int8], directions: int, rows: NDArray[np.int32], twist: NDArray[np.int16]) -> None:
    """Write |Lk| of each folding, |T_even - T_odd| / m of its circuit; `rows` ascends, so a circuit is summed once."""
    n = words.shape[1]
    flip = directions // 2
    known = -1
    linking = np.int64(0)
    for i in range(len(rows)):
        row = rows[i]
        if row != known:
            known = row
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
