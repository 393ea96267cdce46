"""Integer hinge lines of two-stack foldings at both ends of the motion, and their exact ranks.

A line through p and q at height z is (u, m) with u = q - p and m = p x q. In lattice coordinates, with heights in panel
thicknesses, all components are integers; and as affine maps act linearly on lines, ranks and the signs of powers equal
those of the true panels, whatever their size and thickness. Lines are horizontal: the z component of u is 0 and left
out.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import Integers16, Integers32, Reals, WholeNumbers
from hcsearch.kernels.compiling.compiled import compiled

StepWords = NDArray[np.int8]


class EdgeTables(NamedTuple):
    """The edges that the steps of a tiling cross, in whole numbers.

    directions : number of directions in a full turn. directed : direction of each step. kinds : kind of cell that it
    leaves. towards : shape (n_kinds, directions), the step in each direction from a cell of each kind, -1 for none.
    vectors : shape (L, 2). edges : shape (L, 4), start and end of the edge, counterclockwise about the cell's centre.
    scale : units of edges per unit of vectors.
    """

    directions: int
    directed: WholeNumbers
    kinds: WholeNumbers
    towards: WholeNumbers
    vectors: WholeNumbers
    edges: WholeNumbers
    scale: int


@compiled
def _put_line(line: WholeNumbers, px: int, py: int, qx: int, qy: int, z: int, sign: int) -> None:
    dx, dy = sign * (qx - px), sign * (qy - py)
    line[0], line[1], line[2], line[3], line[4] = dx, dy, -z * dy, z * dx, px * dy - py * dx


@compiled
def write_flat_lines(word: StepWords, crease: int, tables: EdgeTables, lines: WholeNumbers) -> None:
    """Write the lines about which hinges fold in the flat state, from crease + 1 on around the circuit.

    lines : shape (n, 5); when a crease folds, the panel after it turns about its line relative to the panel before.
        The flat creases come in the middle and at the end, on the faces that continue the alternation.
    """
    n = len(word)
    scale, edges = tables.scale, tables.edges
    x = y = 0
    for k in range(n):
        d = word[k]
        t = (k - crease) % n  # 0 at the crease in the lowest layer
        t = min(t, n - t)
        top = t % 2 == 1
        row = (k - crease - 1) % n
        px, py = scale * x + edges[d, 0], scale * y + edges[d, 1]
        qx, qy = scale * x + edges[d, 2], scale * y + edges[d, 3]
        _put_line(lines[row], px, py, qx, qy, 1 if top else 0, -1 if top else 1)
        x += tables.vectors[d, 0]
        y += tables.vectors[d, 1]


@compiled
def write_folded_lines(word: StepWords, crease: int, tables: EdgeTables, lines: WholeNumbers) -> None:
    """Write the lines about which hinges open in the folded state, in the order of `write_flat_lines`.

    The lowest panels are those at the crease; layer t lies between the heights t and t + 1. An opening hinge turns the
    panels above it upwards, about the edge with the panel on its left; the second stack is traversed downwards, with
    edges reversed. A flat crease folds as its hinge allows, out of the package.
    """
    n = len(word)
    m, scale, edges = tables.directions, tables.scale, tables.edges
    half = n // 2
    d = word[crease]
    for stack in range(2):
        # the lowest panel lies as in the flat state: of the first stack beyond the crease, of the second before it
        cx, cy = (scale * tables.vectors[d, 0], scale * tables.vectors[d, 1]) if stack == 0 else (0, 0)
        kind = tables.kinds[word[(crease + 1) % n] if stack == 0 else d]
        turn, offset = 1, 0  # direction i of a panel now faces turn * i + offset
        for t in range(half - 1):
            if stack == 0:
                k = (crease + 1 + t) % n
                direction = tables.directed[word[k]]
            else:
                k = (crease - 1 - t) % n
                direction = (tables.directed[word[k]] + m // 2) % m
            r = tables.towards[kind, (turn * direction + offset) % m]
            row = (k - crease - 1) % n
            px, py, qx, qy = edges[r, 0], edges[r, 1], edges[r, 2], edges[r, 3]
            _put_line(lines[row], cx + px, cy + py, cx + qx, cy + qy, t + 1, 1 if stack == 0 else -1)
            # the next panel: reflect its directions in the crease, then turn them as this one
            offset = (turn * (2 * direction + m // 2) + offset) % m
            turn = -turn
    # the edge between the stacks, seen from the second: the first stack's panel lies on its right
    px, py, qx, qy = edges[d, 0], edges[d, 1], edges[d, 2], edges[d, 3]
    _put_line(lines[half - 1], px, py, qx, qy, half, 1)
    _put_line(lines[n - 1], px, py, qx, qy, 0, 1)


@compiled
def whole_rank(lines: WholeNumbers) -> int:
    """Return the exact rank of the integer lines of a loop, shape (n, 5): the greater of two ranks modulo primes.

    The primes lie near 2^31. A nonzero determinant is a multiple of both only from 4.6e18 on. Over common factors of
    their entries, which neither prime divides, the determinants of lines of n panels are below
    5! 2^2 (n + 2)^2 (9 n / 2 + 15), which is less for n up to 120,000 (docs/explanation/theory.md, 25).
    """
    rank = _rank_modulo(lines, 2147483647)
    if rank == min(lines.shape):
        return rank
    return max(rank, _rank_modulo(lines, 2147483629))


@compiled
def _rank_modulo(lines: WholeNumbers, prime: int) -> int:
    """Return the rank modulo a prime below 2^31, by fraction-free elimination: all products fit in 63 bits."""
    rows = lines % prime
    n, width = rows.shape
    rank = 0
    for column in range(width):
        pivot = rank
        while pivot < n and rows[pivot, column] == 0:
            pivot += 1
        if pivot == n:
            continue
        for c in range(column, width):
            rows[rank, c], rows[pivot, c] = rows[pivot, c], rows[rank, c]
        p = rows[rank, column]
        for i in range(rank + 1, n):
            q = rows[i, column]
            if q != 0:
                for c in range(column, width):
                    rows[i, c] = (rows[i, c] * p - rows[rank, c] * q) % prime
        rank += 1
        if rank == n:
            break
    return rank


@compiled
def true_screws(lines: WholeNumbers, basis: Reals, thickness: float, size: float, screws: Reals) -> None:
    """Write the unit screws of integer lines: direction, and moment divided by `size`.

    basis : shape (2, 2), maps lattice coordinates to metres. screws : shape (n, 6).
    """
    area = basis[0, 0] * basis[1, 1] - basis[0, 1] * basis[1, 0]
    for i in range(len(lines)):
        dx, dy = lines[i, 0], lines[i, 1]
        z = lines[i, 3] // dx if dx != 0 else -lines[i, 2] // dy
        ux = basis[0, 0] * dx + basis[0, 1] * dy
        uy = basis[1, 0] * dx + basis[1, 1] * dy
        length = np.sqrt(ux * ux + uy * uy)
        ux, uy = ux / length, uy / length
        height = z * thickness / size
        screws[i, 0], screws[i, 1], screws[i, 2] = ux, uy, 0.0
        screws[i, 3], screws[i, 4] = -height * uy, height * ux
        screws[i, 5] = area * lines[i, 4] / (length * size)


@compiled
def _mirror(word: StepWords, crease: int, tables: EdgeTables) -> tuple[int, int]:
    """Count pairs of panels that meet on a mirror axis, flat and folded, and adjacent pairs of such pairs."""
    n, m, directed = len(word), tables.directions, tables.directed
    across = directed[word[crease]]
    for t in range(n // 2):
        if (directed[word[(crease + 1 + t) % n]] + directed[word[(crease - t - 1) % n]] - 2 * across) % m != 0:
            return 0, 0
    inwards = across + m // 2  # from the first stack to the second
    # from the second stack's panel to the first's, in the flat state
    x, y = tables.vectors[word[crease], 0], tables.vectors[word[crease], 1]
    turn, offset = 1, np.int64(0)  # folded, direction i of the first now faces turn * i + offset
    pairs = adjacent_pairs = 0
    met_last = False
    for t in range(n // 2):
        # the walk stays on its side of the axis
        step = tables.towards[tables.kinds[word[(crease - t) % n]], across]
        do_meet = step >= 0 and x == tables.vectors[step, 0] and y == tables.vectors[step, 1]
        do_meet = do_meet and (turn * inwards + offset - inwards) % m == 0
        pairs += do_meet
        adjacent_pairs += do_meet and met_last
        met_last = do_meet
        forward, backward = word[(crease + 1 + t) % n], word[(crease - t - 1) % n]
        x += tables.vectors[forward, 0] + tables.vectors[backward, 0]
        y += tables.vectors[forward, 1] + tables.vectors[backward, 1]
        offset = (turn * (2 * directed[forward] + m // 2) + offset) % m
        turn = -turn
    return pairs, adjacent_pairs


@compiled
def survey_ends(
    words: StepWords,
    rows: Integers32,
    creases: Integers16,
    tables: EdgeTables,
    basis: Reals,
    thickness: float,
    size: float,
    ranks: WholeNumbers,
    mirrors: WholeNumbers,
    lines: WholeNumbers,
    screws: Reals,
) -> None:
    """Write lines, screws, ranks and mirror pairs at the two ends, folded and flat, of many foldings.

    rows, creases : circuit and crease of each folding.
    tables, basis : of the grid; basis as in `true_screws`.
    ranks : shape (n_foldings, 2), of all n hinges, folded and flat. mirrors : shape (n_foldings, 2), number of pairs of
        panels that meet on a mirror axis, and of adjacent such pairs. lines, screws : shape (n_foldings, 2, n, 5) and
        (n_foldings, 2, n, 6).
    """
    for i in range(len(rows)):
        word, crease = words[rows[i]], int(creases[i])
        mirrors[i, 0], mirrors[i, 1] = _mirror(word, crease, tables)
        write_folded_lines(word, crease, tables, lines[i, 0])
        write_flat_lines(word, crease, tables, lines[i, 1])
        for end in range(2):
            ranks[i, end] = whole_rank(lines[i, end])
            true_screws(lines[i, end], basis, thickness, size, screws[i, end])
