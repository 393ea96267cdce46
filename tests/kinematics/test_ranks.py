"""Exact ranks of whole hinge lines, at sizes where products of determinants would leave 63 bits."""

from fractions import Fraction

import numpy as np
import pytest

from hcsearch.designs.grid import GRIDS
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.kernels.linkage.hinge_lines import survey_ends, whole_rank
from hcsearch.library.unit_search.elements import untwisted_foldings_of
from hcsearch.search.stages.mobility import _lattice
from hcsearch.shape.linkage import Linkage


def rank(rows):
    """Rank by Gauss elimination over the rationals."""
    left = [[Fraction(int(entry)) for entry in row] for row in rows]
    count = 0
    for column in range(5):
        pivot = next((row for row in left if row[column]), None)
        if pivot is None:
            continue
        count += 1
        left.remove(pivot)
        left = [[a - row[column] / pivot[column] * b for a, b in zip(row, pivot, strict=True)] for row in left]
    return count


@pytest.mark.parametrize("n", [10, 1000, 60_000])
def test_ranks_of_lines_are_those_over_the_rationals(n):
    random = np.random.default_rng(n)
    seen = set()
    for _ in range(100):
        k = int(random.integers(2, 9))
        dx, dy = random.integers(-3, 4, (2, k))
        z = random.integers(0, n // 2 if random.random() < 0.7 else 1, k)
        moment = random.integers(-6 * n, 6 * n, k)
        if random.random() < 0.5:  # all lines belong to one linear complex
            a, b, c, d = random.integers(-2, 3, 4)
            moment = -a * z * dy + b * z * dx + c * n * dx + d * n * dy
        rows = np.stack([dx, dy, -z * dy, z * dx, moment], axis=1)
        seen.add(rank(rows))
        assert whole_rank(rows) == rank(rows)
    assert {2, 3, 4, 5} <= seen


def test_a_determinant_that_a_prime_divides_is_not_zero():
    for prime in (2147483647, 2147483629):
        assert whole_rank(np.diag([1, 1, 1, 1, prime])) == 5


def products(screws):
    """Scalar products of directions and reciprocal products, which tell screws up to a motion in space."""
    return np.concatenate(
        [screws[:, :3] @ screws[:, :3].T, screws[:, :3] @ screws[:, 3:].T + screws[:, 3:] @ screws[:, :3].T]
    )


PANELS = {"triangle": 10, "square": 10, "rectangle": 10, "hex": 8, "rhombus": 12, "kite": 10, "right45": 12}
PANELS |= {"right30": 12, "obtuse": 14}


@pytest.mark.parametrize("grid", GRIDS)
def test_lines_of_both_ends_are_those_of_the_linkage(grid):
    """In the sense in which hinges leave their stops, whatever the edges and kinds of cells that they lie on."""
    panel, n = default_panel(grid), PANELS[grid]
    for folding in untwisted_foldings_of(grid, n):
        linkage = Linkage(folding.pattern(panel, flat_pairs="hinged"))
        ranks, mirrors = np.empty((1, 2), np.int64), np.empty((1, 2), np.int64)
        lines, screws = np.empty((1, 2, n, 5), np.int64), np.empty((1, 2, n, 6))
        words, zero = np.array([folding.circuit.word], np.int8), np.zeros(1, np.int32)
        lattice = _lattice(folding.circuit.grid)
        size = (lattice.basis, lattice.thickness, lattice.size)
        survey_ends(
            words, zero, np.array([folding.crease], np.int16), lattice.tables, *size, ranks, mirrors, lines, screws
        )
        order = (folding.crease + 1 + np.arange(n)) % n
        for end, angles in enumerate((linkage.folded, linkage.flat)):
            own = (linkage.closure(angles)[1] * np.where(angles > 1.0, -1.0, 1.0)).T[order]
            assert products(screws[0, end]) == pytest.approx(products(own), abs=1e-12)
            assert ranks[0, end] == rank(lines[0, end])
        assert mirrors[0, 0] == len(folding.mirror_pairs)


@pytest.mark.parametrize("grid", GRIDS)
def test_determinants_of_lines_stay_below_the_product_of_the_primes(grid):
    """Of lines over the greatest divisors of their directions, which no prime divides (theory.md, 25)."""
    tables = _lattice(GRIDS[grid]).tables
    along = tables.edges[:, 2:] - tables.edges[:, :2]
    unit = np.gcd.reduce(along, axis=None)
    short = np.abs(along // np.gcd(*along.T)[:, None])
    corner, step = np.abs(tables.edges).max(), tables.scale * np.abs(tables.vectors).max()
    n = 120_000
    moment = short.sum(axis=1).max() * (step * n / 2 + 2 * corner) / unit  # about a corner
    assert short.max() <= 2
    assert moment <= 4.5 * n + 15
    assert 120 * 2**2 * (n + 2) ** 2 * (4.5 * n + 15) < 2147483647 * 2147483629
