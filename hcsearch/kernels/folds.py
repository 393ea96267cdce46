"""Two-stack foldings and their twist, in O(n) integer steps a circuit.

Sums along the circuit are taken from one alternating prefix sum P[k] = sum over i < k of (-1)^i x_i, with x wrapped
around twice: the alternating sum of x_a, x_{a+1}, ..., x_{b-1} that begins with a plus is (-1)^a (P[b] - P[a]).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcsearch.kernels.compiled import compiled


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
    prefix = np.zeros(2 * n + 1, np.int64)
    written = 0
    for row in range(n_words):
        for k in range(2 * n):
            d = np.int64(words[row, k % n])
            prefix[k + 1] = prefix[k] + (d if k % 2 == 0 else -d)
        for j in range(half):
            opposite = np.int64(words[row, j + half])
            # forward over creases j + 1 .. j + half - 1; the last one enters with a plus: r = 2 d + flip - r'
            a, b = j + 1, j + half
            ahead = prefix[b] - prefix[a]
            if b % 2 == 0:  # the plus belongs to index b - 1
                ahead = -ahead
            face = 2 * ahead + constant + sign * (words[row, j] + flip)
            if (face - opposite) % directions != 0:
                continue
            # backward over creases j - 1 .. j - half + 1, taken one turn further round to stay above zero
            a, b = j + n - half + 1, j + n
            back = prefix[b] - prefix[a]
            if a % 2 == 1:  # the plus belongs to index a
                back = -back
            face = 2 * back + constant + sign * words[row, j]
            if (face - opposite - flip) % directions != 0:
                continue
            rows[written] = row
            creases[written] = j
            written += 1
    return written


@compiled
def twist_words(
    words: NDArray[np.int8],
    directions: int,
    rows: NDArray[np.int32],
    creases: NDArray[np.int16],
    twist: NDArray[np.int16],
) -> None:
    """Write |Lk| of each folding; `rows` ascends, so a circuit's prefix sums are made once."""
    n = words.shape[1]
    half = n // 2
    flip = directions // 2
    prefix = np.zeros(2 * n + 2, np.int64)
    known = -1
    for i in range(len(rows)):
        row = rows[i]
        if row != known:
            known = row
            for k in range(2 * n + 1):  # turn at panel k, between steps k - 1 and k
                turn = np.int64(words[row, k % n]) - np.int64(words[row, (k - 1) % n])
                if turn >= flip:
                    turn -= directions
                elif turn < -flip:
                    turn += directions
                prefix[k + 1] = prefix[k] + (turn if k % 2 == 0 else -turn)
        j = creases[i]
        # panels j + 1 .. j + half, the first with a plus
        up = prefix[j + half + 1] - prefix[j + 1]
        if (j + 1) % 2 == 1:
            up = -up
        # panels j, j - 1, .., j - half + 1, the first of these with a plus; one turn further round
        down = prefix[j + n + 1] - prefix[j + n - half + 1]
        if (j + n) % 2 == 1:
            down = -down
        twist[i] = abs(up - down) // directions
