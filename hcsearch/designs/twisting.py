"""Twist of foldings: the linking number of the folded band of panels, which must be 0 to open it (thesis 3.3.2)."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.errors import expect_kind
from hcsearch.designs.folding import Folding
from hcsearch.designs.grid import grid_named
from hcsearch.designs.grid.turning import directed_words
from hcsearch.designs.records import CircuitBatch, FoldingBatch
from hcsearch.kernels.circuits.folds import twist_words

LatticeVector = tuple[int, int, int]


def twist_batch(circuits: CircuitBatch, foldings: FoldingBatch) -> NDArray[np.int16]:
    """The twist |Lk| of each folding of a batch, by the alternating sum of its circuit's turns.

    Source: docs/explanation/theory.md, statement 10.
    """
    twists = np.empty(len(foldings), np.int16)
    grid = grid_named(circuits.grid)
    directed = directed_words(grid, circuits.words)
    twist_words(directed, grid.directions, foldings.row, twists)  # type: ignore[arg-type]
    return twists


def twist(folding: Folding) -> int:
    """The twist of a folding: the number of full turns of its folded band of panels; no motion opens it unless 0.

    It is the absolute value of the linking number of the band's centre line and a parallel line.

    Parameters
    ----------
    folding
        The folding.

    Returns
    -------
    int
        The number of full turns, 0 or more.

    Examples
    --------
    >>> from hcsearch import Folding, twist
    >>> twist(Folding.from_notation("hex:0234550132:4"))
    0
    """
    _expect_folding(folding)
    turns = folding.circuit.turns
    return abs(sum(turns[::2]) - sum(turns[1::2])) // folding.circuit.grid.directions


def _expect_folding(folding: Folding) -> None:
    """Raise HcsearchError for anything but a folding."""
    expect_kind(
        "the folding to measure", folding, Folding, "a Folding, such as Folding.from_notation('hex:0234550132:4')"
    )


def gauss_linking(folding: Folding) -> int:
    """The linking number of the folded band's centre line and a parallel line, by counting signed crossings exactly.

    This does not use `twist`, whose value is the absolute value of this number. The band is laid out in its two stacks
    in integer coordinates (an affine image, which changes no linking number) and projected along a direction in which
    no two points coincide; the crossings are counted with integer determinants. The sign changes under reflection.

    Parameters
    ----------
    folding
        The folding.

    Returns
    -------
    int
        The linking number.
    """
    _expect_folding(folding)
    centre, parallel = folded_band(folding)
    height = folding.circuit.n
    for trial in range(1, 100):
        # a slant of far less than one lattice unit over the whole height keeps crossings few
        across = (trial, 7 * trial + 3)
        scale = 1000 * height * trial
        count = _crossings(_slant(centre, across, scale), _slant(parallel, across, scale))
        if count is not None:
            return count
    raise AssertionError("no general direction among a hundred")  # pragma: no cover


def folded_band(folding: Folding) -> tuple[list[LatticeVector], list[LatticeVector]]:
    """Corners of the closed centre line and of its parallel in the folded state, in whole numbers.

    The unit is a sixteenth of the unit of `Grid.lattice_corners`.

    A panel of layer z lies at height z; the lines run straight from crease to crease within a panel and straight up
    or down at a hinge. The parallel line crosses each crease on the left-hand side of the circuit, well
    within the edge.
    """
    circuit, n = folding.circuit, folding.circuit.n
    grid, m, directions = circuit.grid, circuit.grid.directions, circuit.directions
    frames = folding.frames
    layer = folding.layers
    lowest = {panel: stack[0] for stack in folding.stacks for panel in stack}

    def corner(panel: int, direction: int, left: int) -> LatticeVector:
        sign, offset = frames[panel]
        place = circuit.points[lowest[panel]]
        cell = circuit.cells[lowest[panel]]
        step = grid.step_towards(grid.kind_of(cell), (sign * direction + offset) % m)
        (x, y), (ex, ey) = place, grid.steps[step]
        # the edge from right to left, as seen from within a panel whose top face is up
        (ax, ay), (bx, by) = grid.edge_corners(cell, step)
        left *= sign
        scale = 8 * grid.corner_scale
        return (
            scale * (2 * x + ex) + left * (bx - ax),
            scale * (2 * y + ey) + left * (by - ay),
            layer[panel],
        )

    lines: tuple[list[LatticeVector], list[LatticeVector]] = ([], [])
    for panel in range(n):
        entry, leaving = (directions[panel - 1] + m // 2) % m, directions[panel]
        for left, line in enumerate(lines):
            # entering, the left-hand side of the walk is the right-hand side of the outward direction
            line.append(corner(panel, entry, -left))
            line.append(corner(panel, leaving, left))
    return lines


def _slant(line: list[LatticeVector], across: tuple[int, int], scale: int) -> list[LatticeVector]:
    """Project a line along a slanted direction: planar coordinates times `scale`, moved in proportion to height."""
    return [(scale * x + across[0] * z, scale * y + across[1] * z, z) for x, y, z in line]


def _crossings(first: list[LatticeVector], second: list[LatticeVector]) -> int | None:
    """Half the signed crossings of two closed lines seen from above; None when the view is not general."""
    total = 0
    for i, a in enumerate(first):
        b = first[i - 1]
        for k, c in enumerate(second):
            d = second[k - 1]
            sides = (_side(a, b, c), _side(a, b, d), _side(c, d, a), _side(c, d, b))
            if a == b or c == d:
                continue
            if 0 in sides:
                if _apart(a, b, c, d):
                    continue
                return None
            if (sides[0] > 0) == (sides[1] > 0) or (sides[2] > 0) == (sides[3] > 0):
                continue
            above = _height(a, b, sides[2], sides[3]) - _height(c, d, sides[0], sides[1])
            if above == 0:
                return None
            turn = 1 if (b[0] - a[0]) * (d[1] - c[1]) - (b[1] - a[1]) * (d[0] - c[0]) > 0 else -1
            total += turn if above > 0 else -turn
    return total // 2


def _side(a: LatticeVector, b: LatticeVector, c: LatticeVector) -> int:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _apart(a: LatticeVector, b: LatticeVector, c: LatticeVector, d: LatticeVector) -> bool:
    """Whether the bounding boxes of segments ab and cd have no point in common."""
    return any(max(a[i], b[i]) < min(c[i], d[i]) or max(c[i], d[i]) < min(a[i], b[i]) for i in (0, 1))


def _height(a: LatticeVector, b: LatticeVector, side_a: int, side_b: int) -> Fraction:
    """The height of segment ab where it crosses a line, given the sides `side_a` and `side_b` of a and b from it."""
    return a[2] + Fraction((b[2] - a[2]) * side_a, side_a - side_b)
