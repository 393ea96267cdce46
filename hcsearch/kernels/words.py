"""Canonical circuits and arrays of whole batches of step words."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcsearch.kernels.compiled import compiled


@compiled
def _rotation(
    letters: NDArray[np.int8], first: NDArray[np.int8], best: NDArray[np.int8], score: NDArray[np.int64]
) -> None:
    """Improve `best` by the rotations of a cyclic word.

    score : (found, class of the first step, ties) of the best rotation so far; `first` is the class of each start.
    """
    n = len(letters)
    for start in range(n):
        order = 0
        if score[0] == 0:
            order = -1
        else:
            at = start
            for k in range(n):
                order = letters[at] - best[k]
                if order != 0:
                    break
                at += 1
                if at == n:
                    at = 0
            if order == 0:
                order = first[start] - score[1]
        if order < 0:
            for k in range(n):
                best[k] = letters[(start + k) % n]
            score[0], score[1], score[2] = 1, first[start], 1
        elif order == 0:
            score[2] += 1


@compiled
def canonicalise(
    words: NDArray[np.int8], directions: int, classes: int, found: NDArray[np.int8], symmetry: NDArray[np.int16]
) -> None:
    """Write the canonical form of each word and the order of its symmetry group.

    The key of a word is its least cyclic sequence of turns (left before right), walked counterclockwise, of itself or
    its mirror image;
    then the class of the first step's direction (`classes` of them; see `Grid.first_directions`).
    """
    n = words.shape[1]
    half = directions // 2
    letters = np.empty(n, np.int8)
    first = np.empty(n, np.int8)
    best = np.empty(n, np.int8)
    score = np.zeros(3, np.int64)
    for row in range(len(words)):
        total = 0
        for k in range(n):  # letters[k] is the turn after step k
            turn = words[row, (k + 1) % n] - words[row, k]
            if turn >= half:
                turn -= directions
            elif turn < -half:
                turn += directions
            letters[k] = turn
            first[k] = words[row, k] % classes
            total += turn
        if total > 0:  # a letter is the turn to the right, so sharp left turns come first
            for k in range(n):
                letters[k] = -letters[k]
        score[:] = 0
        _rotation(letters, first, best, score)
        # the mirror image, counterclockwise: from step k on it meets the turns before step k, backwards
        for k in range(n // 2):
            letters[k], letters[n - 1 - k] = letters[n - 1 - k], letters[k]
        # after reversal the sequence that begins at position i follows step (n - i) mod n
        first[1:] = first[1:][::-1].copy()
        _rotation(letters, first, best, score)
        d = score[1]
        for k in range(n):
            found[row, k] = d
            d = (d - best[k]) % directions
            if d < 0:
                d += directions
        symmetry[row] = score[2]


@compiled
def array_rows(
    words: NDArray[np.int8],
    signs: NDArray[np.int64],
    offsets: NDArray[np.int64],
    moves: NDArray[np.int64],
    triangle: bool,
    rows: NDArray[np.uint64],
    heights: NDArray[np.int64],
    symmetry: NDArray[np.int16],
) -> None:
    """Write the canonical array of each circuit as rows of bits (`Array.rows`), and the order of its symmetry group.

    signs, offsets : the point group, direction i goes to signs * i + offsets.
    moves : shape (directions, 2), the lattice move of each direction.
    """
    n_words, n = words.shape
    directions = len(moves)
    x = np.empty(n, np.int64)
    y = np.empty(n, np.int64)
    image = np.zeros(n + 1, np.uint64)
    one = np.uint64(1)
    for row in range(n_words):
        best_height = np.int64(n + 1)
        ties = 0
        for g in range(len(signs)):
            px = py = np.int64(0)
            if triangle:
                px = py = 1 + (signs[g] * words[row, 0] + offsets[g]) % 2
            low_x = high_y = low_y = np.int64(0)
            for k in range(n):
                cx, cy, u = px, py, np.int64(0)
                if triangle:
                    u = px % 3 - 1
                    cx = (px - 1 - u) // 3
                    cy = (py - 1 - u) // 3
                if k == 0:
                    low_x, low_y, high_y = cx, cy, cy
                low_x = min(low_x, cx)
                low_y = min(low_y, cy)
                high_y = max(high_y, cy)
                x[k] = 2 * cx + u if triangle else cx
                y[k] = cy
                d = (signs[g] * words[row, k] + offsets[g]) % directions
                px += moves[d, 0]
                py += moves[d, 1]
            height = high_y - low_y + 1
            if height > best_height:
                continue
            if triangle:
                low_x *= 2
            image[:height] = 0
            for k in range(n):
                image[y[k] - low_y] |= one << np.uint64(x[k] - low_x)
            less = height < best_height
            equal = height == best_height
            if equal:
                for k in range(height):
                    if image[k] != rows[row, k]:
                        less = image[k] < rows[row, k]
                        equal = False
                        break
            if less:
                rows[row, :height] = image[:height]
                best_height = height
                ties = 1
            elif equal:
                ties += 1
        heights[row] = best_height
        symmetry[row] = ties


@compiled
def write_rows(
    rows: NDArray[np.uint64], heights: NDArray[np.int64], prefix: NDArray[np.uint8], text: NDArray[np.uint8]
) -> int:
    """Write rows as hexadecimal text after a prefix; return the longest length. `text` is zeroed by the caller."""
    longest = 0
    for i in range(len(rows)):
        at = len(prefix)
        text[i, :at] = prefix
        for y in range(heights[i]):
            if y > 0:
                text[i, at] = 46
                at += 1
            bits = 4
            while bits < 64 and rows[i, y] >> np.uint64(bits) != 0:
                bits += 4
            while bits > 0:
                bits -= 4
                digit = (rows[i, y] >> np.uint64(bits)) & np.uint64(15)
                text[i, at] = digit + (48 if digit < 10 else 87)
                at += 1
        longest = max(longest, at)
    return longest


@compiled
def fingerprint_rows(rows: NDArray[np.uint64], heights: NDArray[np.int64], found: NDArray[np.uint64]) -> None:
    """Write a 128-bit fingerprint of each canonical array; found : shape (n, 2).

    Two different arrays share one with probability 2^-128, so a hundred million of them collide with odds under 2^-74.
    """
    for i in range(len(rows)):
        for half in range(2):
            h = np.uint64(0x9E3779B97F4A7C15) * np.uint64(2 * half + 1) + np.uint64(heights[i])
            for y in range(heights[i]):
                h ^= rows[i, y]
                h ^= h >> np.uint64(30)
                h *= np.uint64(0xBF58476D1CE4E5B9)
                h ^= h >> np.uint64(27)
                h *= np.uint64(0x94D049BB133111EB) + np.uint64(2 * half)
                h ^= h >> np.uint64(31)
            found[i, half] = h
