"""Canonical circuits, canonical arrays and fingerprints for batches of step words."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import Bitsets, Integers16, WholeNumbers
from hcsearch.kernels.circuits.step_tables import StepTables
from hcsearch.kernels.compiling.compiled import compiled


@compiled
def _least_rotation(letters: NDArray[np.int8], n: int) -> tuple[int, int]:
    """Return start of the least rotation and period of a cyclic word, in O(n); `letters` holds the word twice."""
    i, j, k = 0, 1, 0  # two candidates, equal over k letters; all other starts below the greater one are ruled out
    while i < n and j < n and k < n:
        order = letters[i + k] - letters[j + k]
        if order == 0:
            k += 1
            continue
        if order > 0:
            i += k + 1
        else:
            j += k + 1
        if i == j:
            j += 1
        k = 0
    return min(i, j), abs(i - j) if k == n else n


@compiled
def _least_rotations(
    letters: NDArray[np.int8], mirror_letters: NDArray[np.int8], n: int, bits: int
) -> tuple[int, int, int]:
    """Return start and period of the least rotation of a word, and start of that of its mirror image.

    Letters have some bits. Windows of them, packed into integers, decide most words quickly: if the least window is
    unique, the least rotation begins with it. The mirror image is walked backwards: letter k of one corresponds to
    letter -1 - k of the other.
    """
    window = min(n, 63 // bits)
    width = np.uint64(bits)
    top = np.uint64(bits * (window - 1))
    mask = (np.uint64(1) << np.uint64(bits * window)) - np.uint64(1)
    forward, backward = np.uint64(0), np.uint64(0)
    for k in range(window - 1):
        forward = (forward << width) | np.uint64(letters[k])
        backward = (backward >> width) | (np.uint64(mirror_letters[2 * n - 1 - k]) << top)
    least, least_back = ~np.uint64(0), ~np.uint64(0)
    start, start_back, ties, ties_back = 0, 0, 0, 0
    for k in range(n):
        forward = ((forward << width) | np.uint64(letters[k + window - 1])) & mask
        backward = (backward >> width) | (np.uint64(mirror_letters[2 * n - k - window]) << top)
        if forward < least:
            least, start, ties = forward, k, 1
        elif forward == least:
            ties += 1
        if backward < least_back:
            least_back, start_back, ties_back = backward, k, 1
        elif backward == least_back:
            ties_back += 1
    period = n
    if ties > 1:
        start, period = _least_rotation(letters, n)
    if ties_back > 1:
        return start, period, _least_rotation(mirror_letters, n)[0]
    return start, period, n - 1 - (start_back + window - 1) % n


@compiled
def canonicalise(
    words: NDArray[np.int8], steps: StepTables, classes: int, canonical: NDArray[np.int8], symmetry: Integers16
) -> None:
    """Write the canonical form of each word and the order of its symmetry group.

    The key of a word is the least cyclic sequence of turns, as codes, walked counterclockwise, of the word or its
    mirror image; then the class of the first step (see `Grid.step_classes`). The canonical word is the one with this
    key whose first step is the least that leaves a cell of kind 0.
    """
    n = words.shape[1]
    letters = np.empty(2 * n, np.int8)
    mirror_letters = np.empty(2 * n, np.int8)
    for row in range(len(words)):
        total = np.int64(0)
        at = np.uint64(words[row, n - 1])
        before = n - 1
        for k in range(n):  # letters[k] is the turn after step k
            to = np.uint64(words[row, k])
            code = np.uint64(steps.codes[at, to])
            letters[before] = code
            total += steps.code_turns[code]
            at = to
            before = k
        if total < 0:
            for k in range(n):
                letters[k] = steps.mirrored[np.uint64(letters[k])]
        for k in range(n):  # the mirror image, counterclockwise, meets the turns backwards
            letters[n + k] = letters[k]
            mirror_letters[n - 1 - k] = mirror_letters[2 * n - 1 - k] = steps.reversed[np.uint64(letters[k])]
        start, period, mirrored = _least_rotations(letters, mirror_letters, n, steps.code_bits)
        order = 0
        for k in range(n):
            order = letters[start + k] - mirror_letters[mirrored + k]
            if order != 0:
                break
        first = classes
        ties = 0
        for rotation in range(start % period, n, period):  # `letters` from `rotation` on follow step `rotation`
            for side in range(2):
                # `mirror_letters` from position p on follow step n - p
                step = rotation if side == 0 else (n - (mirrored + rotation - start)) % n
                if (side == 0 and order > 0) or (side == 1 and order < 0):
                    continue
                step_class = words[row, step] % classes
                if step_class < first:
                    first = step_class
                    ties = 0
                ties += step_class == first
        best, first_letter = (letters, start) if order <= 0 else (mirror_letters, mirrored)
        at = np.uint64(steps.starts[best[first_letter]] + first)
        for k in range(n):
            canonical[row, k] = at
            at = steps.after[np.uint64(best[first_letter + k]), at]
        symmetry[row] = ties


@compiled
def label_words(
    words: NDArray[np.int8], labels: WholeNumbers, after: WholeNumbers, first: int, digits: NDArray[np.uint8]
) -> None:
    """Write the labels of the edges that words cross, as ASCII digits, from the first frame on.

    labels, after : shape (n_frames, L), the label that a step's edge has in a frame, and the frame after the step.
    """
    for row in range(len(words)):
        frame = first
        for k in range(words.shape[1]):
            step = words[row, k]
            digits[row, k] = 48 + labels[frame, step]
            frame = after[frame, step]


@compiled
def _are_equal(first: WholeNumbers, second: WholeNumbers, sign: int) -> bool:
    """Whether increments are those of another image, times a sign.

    A loop in place of `numpy.all`, for which numba loads scipy.linalg in each process.
    """
    for step in range(len(first)):  # noqa: SIM110 - numba compiles no generator in `all`
        if first[step] != sign * second[step]:
            return False
    return True


@compiled
def array_rows(
    words: NDArray[np.int8],
    moves: WholeNumbers,
    block: tuple[int, int],
    rows: Bitsets,
    heights: WholeNumbers,
    symmetry: Integers16,
) -> None:
    """Write the canonical array of each circuit as rows of bits (`Array.rows`), and the order of its symmetry group.

    moves : shape (order of the point group, L, 4), `Grid.row_moves`: increments of bit column and row by a step in each
            image of the grid, and column and row, within those of a lattice point, of the cell that the step leaves.
    block : columns and rows to a lattice point. rows : shape (n_words, height), with room for all rows.
    """
    columns_per_cell, rows_per_cell = block
    n_words, n = words.shape
    n_images = len(moves)
    column = np.empty(n, np.int64)
    level = np.empty(n, np.int64)
    low = np.empty(n_images, np.int64)
    height = np.empty(n_images, np.int64)
    # images that differ by mirroring columns or rows have the same number of rows: only one of these is measured
    measured = np.empty(n_images, np.int64)
    upright = np.ones(n_images, np.bool_)
    for g in range(n_images):
        for earlier in range(g + 1):
            upward = _are_equal(moves[g, :, 1], moves[earlier, :, 1], 1)
            same = upward and _are_equal(moves[g, :, 3], moves[earlier, :, 3], 1)
            if same or (rows_per_cell == 1 and _are_equal(moves[g, :, 1], moves[earlier, :, 1], -1)):
                measured[g] = earlier
                upright[g] = same
                break
    image = np.zeros(rows.shape[1], np.uint64)
    one = np.uint64(1)
    for row in range(n_words):
        least = rows.shape[1] + 1
        for g in range(n_images):  # first only rows: few images have the least number
            if measured[g] != g:
                height[g] = height[measured[g]]
                low[g] = low[measured[g]] if upright[g] else 1 - height[g] - low[measured[g]]
                continue
            y = moves[g, words[row, 0], 3]
            bottom, top = y, y
            for k in range(n):
                y += moves[g, words[row, k], 1]
                bottom = min(bottom, y)
                top = max(top, y)
            bottom -= bottom % rows_per_cell
            low[g] = bottom
            height[g] = top - bottom + 1
            least = min(least, height[g])
        ties = 0
        for g in range(n_images):
            if height[g] != least:
                continue
            x = moves[g, words[row, 0], 2]
            leftmost, y = x, moves[g, words[row, 0], 3]
            for k in range(n):
                column[k] = x
                level[k] = y - low[g]
                leftmost = min(leftmost, x)
                x += moves[g, words[row, k], 0]
                y += moves[g, words[row, k], 1]
            leftmost -= leftmost % columns_per_cell
            image[:least] = 0
            for k in range(n):
                image[level[k]] |= one << np.uint64(column[k] - leftmost)
            is_less = ties == 0
            is_equal = not is_less
            if is_equal:
                for k in range(least):
                    if image[k] != rows[row, k]:
                        is_less = image[k] < rows[row, k]
                        is_equal = False
                        break
            if is_less:
                rows[row, :least] = image[:least]
                ties = 1
            elif is_equal:
                ties += 1
        heights[row] = least
        symmetry[row] = ties


@compiled
def write_rows(rows: Bitsets, heights: WholeNumbers, prefix: NDArray[np.uint8], text: NDArray[np.uint8]) -> int:
    """Write rows as hexadecimal text after a prefix; return the greatest length. The caller must zero `text`."""
    longest = 0
    for i in range(len(rows)):
        length = len(prefix)
        text[i, :length] = prefix
        for y in range(heights[i]):
            if y > 0:
                text[i, length] = 46
                length += 1
            bits = 4
            while bits < 64 and rows[i, y] >> np.uint64(bits) != 0:
                bits += 4
            while bits > 0:
                bits -= 4
                digit = (rows[i, y] >> np.uint64(bits)) & np.uint64(15)
                text[i, length] = digit + (48 if digit < 10 else 87)
                length += 1
        longest = max(longest, length)
    return longest


@compiled
def fingerprint_rows(rows: Bitsets, heights: WholeNumbers, fingerprints: Bitsets) -> None:
    """Write a 128-bit fingerprint of each canonical array, shape (n, 2).

    Two different arrays have equal fingerprints with probability 2^-128; a collision among a hundred million has a
    probability below 2^-74.
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
            fingerprints[i, half] = h


@compiled
def insert_fingerprints(fingerprints: Bitsets, table: Bitsets) -> int:
    """Insert fingerprints into a hash table with room for all, in which (0, 0) is free; return how many are new.

    Fingerprints (0, 0), as from an old table, are skipped. Entries of a block are looked up in advance, before anything
    depends on them, so that the cache misses of a large table overlap.
    """
    mask = np.uint64(len(table) - 1)
    block = 32
    is_known = np.empty(block, np.bool_)
    new_count = 0
    for start in range(0, len(fingerprints), block):
        stop = min(start + block, len(fingerprints))
        for i in range(start, stop):
            entry = fingerprints[i, 0] & mask
            is_known[i - start] = (table[entry, 0] == fingerprints[i, 0]) & (table[entry, 1] == fingerprints[i, 1])
        for i in range(start, stop):
            if is_known[i - start] or (fingerprints[i, 0] == 0 and fingerprints[i, 1] == 0):
                continue
            entry = fingerprints[i, 0] & mask
            while table[entry, 0] != 0 or table[entry, 1] != 0:
                if table[entry, 0] == fingerprints[i, 0] and table[entry, 1] == fingerprints[i, 1]:
                    break
                entry = (entry + np.uint64(1)) & mask
            else:
                table[entry, 0] = fingerprints[i, 0]
                table[entry, 1] = fingerprints[i, 1]
                new_count += 1
    return new_count
