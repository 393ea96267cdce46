"""Theorems on which circuits fold, on every circuit of small lists (docs/explanation/theory.md, 4, 13, section 11)."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import fold, foldings
from hcsearch.designs.grid import GRIDS, parse_array
from hcsearch.designs.twisting import twist
from hcsearch.search.enumeration import ArraySearch, PolygonSearch
from tests import naive
from tests.strategies import circuits, congruences, words

LISTED = {
    "hex": range(4, 13, 2),
    "square": range(4, 17, 2),
    "triangle": range(6, 27, 2),
    "rectangle": range(4, 15, 2),
    "rhombus": range(4, 17, 2),
    "kite": range(4, 15, 2),
    "right45": range(4, 23, 2),
    "right30": range(4, 21, 2),
    "obtuse": range(4, 25, 2),
}
DRAWN = {
    "hex": range(4, 11, 2),
    "square": range(4, 13, 2),
    "triangle": range(6, 21, 2),
    "rectangle": range(4, 11, 2),
    "rhombus": range(4, 15, 2),
    "kite": range(4, 13, 2),
    "right45": range(4, 19, 2),
    "right30": range(4, 17, 2),
    "obtuse": range(4, 23, 2),
}


def sums(circuit):
    """T, and S_j for every j."""
    x = [(-1) ** i * turn for i, turn in enumerate(circuit.turns)]
    return sum(x), [sum((x + x)[j + 1 : j + 1 + circuit.n // 2]) for j in range(circuit.n)]


def flat_creases(circuit):
    """Creases in the first half that are flat in a folding, by the sums of turns."""
    m, half = circuit.grid.directions, circuit.n // 2
    total, parts = sums(circuit)
    return [j for j in range(half) if total % m == 0 and (parts[j] - half * (m // 2)) % m == 0]


def images(words, grid):
    """Whether the reflections ahead and behind carry crease j to its opposite, shape (n_words, n / 2) each."""
    m, words = grid.directions, np.array(grid.step_directions)[words]
    n = words.shape[1]
    agreements = []
    for way in (1, -1):
        face = words + (m // 2 if way == 1 else 0)
        for i in range(1, n // 2):
            face = 2 * np.roll(words, -way * i, axis=1) + m // 2 - face
        agreements.append((face - np.roll(words, n // 2, axis=1) - (0 if way == 1 else m // 2)) % m == 0)
    return [agrees[:, : n // 2] for agrees in agreements]


def listed(grid, n):
    return np.concatenate(
        [np.empty((0, n), np.int8), *(batch.words for batch in PolygonSearch(GRIDS[grid], n).batches())]
    )


@pytest.mark.parametrize("grid", DRAWN)
def test_sums_of_turns_tell_what_folds_as_drawn_edges_do(grid):
    for n in DRAWN[grid]:
        for word in words(grid, n):
            circuit = Circuit(GRIDS[grid], word)
            assert flat_creases(circuit) == naive.folding_creases(circuit)


@pytest.mark.parametrize("grid", LISTED)
def test_sums_of_turns_tell_what_folds_as_repeated_reflections_do(grid):
    m = GRIDS[grid].directions
    for n in LISTED[grid]:
        words = listed(grid, n)
        for word, ahead, behind in zip(words.tolist(), *images(words, GRIDS[grid]), strict=True):
            circuit = Circuit(GRIDS[grid], tuple(word))
            assert flat_creases(circuit) == np.flatnonzero(ahead & behind).tolist()
            if grid != "hex":
                assert sums(circuit)[0] % m == 0
                assert (ahead == behind).all()


@pytest.mark.parametrize("grid", ["rhombus", "kite", "right45", "right30", "obtuse"])
def test_equal_digits_half_a_circuit_apart_tell_what_folds(grid):
    met = 0
    for n in LISTED[grid]:
        for word in words(grid, n):
            circuit = Circuit(GRIDS[grid], word)
            digits = circuit.notation.partition(":")[2]
            same = [j for j in range(n // 2) if digits[j] == digits[j + n // 2]]
            assert same == [folding.crease for folding in foldings(circuit)]
            met += len(same)
    assert met > 50


def test_on_hexagons_one_congruence_holds_without_the_other_where_6_does_not_divide_t():
    words = listed("hex", 10)
    ahead, behind = images(words, GRIDS["hex"])
    divisible = np.array([sums(Circuit(GRIDS["hex"], tuple(word)))[0] % 6 == 0 for word in words.tolist()])
    assert (np.count_nonzero(ahead != behind), np.count_nonzero(ahead & behind)) == (109, 48)
    assert not (ahead != behind)[divisible].any()
    assert not (ahead & behind)[~divisible].any()


@given(st.data())
def test_opposite_sums_add_up_to_t_and_creases_do_not_depend_on_the_way_a_circuit_is_given(data):
    circuit = data.draw(congruences(data.draw(circuits(even=True))))
    total, parts = sums(circuit)
    half = circuit.n // 2
    assert all(parts[j] + parts[j + half] == total for j in range(half))
    assert flat_creases(circuit) == [folding.crease for folding in foldings(circuit)]
    if foldings(circuit):
        assert twist(foldings(circuit)[0]) == abs(total) // circuit.grid.directions


def test_triangles_fail_to_fold_where_all_sums_lie_next_to_half_of_t():
    failing = 0
    for n in range(6, 31, 2):
        for word in words("triangle", n):
            circuit = Circuit(GRIDS["triangle"], word)
            total, parts = sums(circuit)
            assert total % 6 == 0
            fails = {abs(part - total // 2) for part in parts} == {1}
            assert fails == (not foldings(circuit))
            failing += fails
    assert failing == 110


@pytest.mark.parametrize("length", range(1, 9))
def test_alternating_subsequences_are_fewer_than_fibonacci_numbers(length):
    fibonacci = [1, 1]
    while len(fibonacci) < length + 3:
        fibonacci.append(fibonacci[-1] + fibonacci[-2])
    most = max(alternating(x) for x in itertools.product((1, -1), repeat=length))
    assert most == fibonacci[length + 2] - 1


def alternating(x):
    """How many choices of places of a word of signs, none among them, read alternating signs."""
    return sum(
        all(a != b for a, b in itertools.pairwise(itertools.compress(x, chosen)))
        for chosen in itertools.product((0, 1), repeat=len(x))
    )


def most_second_halves(m, turns, steps):
    """The most second halves that never fold, over all first halves of 1, 2, .. steps: by adding a step in front.

    No two equal sharpest turns follow each other on hexagons, where they would close three panels.
    """
    sharp = 2 if m == 6 else None
    states = [(residue, last) for residue in range(1, m) for last in ((0, 2, -2) if sharp else (0,))]
    fronts = {None: np.ones((1, len(states)), np.int64)}
    for _ in range(steps):
        longer = {}
        for x in turns:
            move = np.zeros((len(states), len(states)), np.int64)
            for i, (residue, last) in enumerate(states):
                for y in turns:
                    to = ((residue + y - x) % m, y if abs(y) == sharp else 0)
                    if to in states and not (abs(y) == sharp and y == last):
                        move[i, states.index(to)] += 1
            before = [rows for first, rows in fronts.items() if not (abs(x) == sharp and first == x)]
            longer[x] = maximal(np.concatenate(before) @ move.T)
        fronts = longer
        yield max(int(rows.max()) for rows in fronts.values())


def maximal(rows):
    """Rows that no other row exceeds in all entries."""
    rows = np.unique(rows, axis=0)
    below = (rows[:, None] <= rows[None]).all(axis=2)
    return rows[below.sum(axis=1) == 1]


def test_second_halves_on_squares_are_pell_numbers():
    assert list(most_second_halves(4, (-1, 0, 1), 8)) == [3, 7, 17, 41, 99, 239, 577, 1393]


def test_second_halves_on_hexagons():
    *_, most = most_second_halves(6, (-2, -1, 0, 1, 2), 8)
    assert most == 81_075
    assert most ** (1 / 8) < 4.108


def opened(circuit, up):
    """The circuit, counterclockwise, as a walk whose missing last step is to a topmost panel, and its sum of turns.

    On hexagons that step must have the direction up + 1; None where no step to a topmost panel has.
    """
    m, n = circuit.grid.directions, circuit.n
    word = circuit.word if sum(circuit.turns) > 0 else tuple((d + m // 2) % m for d in reversed(circuit.word))
    rise = [round(2 * math.cos(2 * math.pi * (d - up) / m)) for d in range(m)]
    height = np.concatenate([[0], np.cumsum([rise[d] for d in word])])[:-1]
    ends = [k for k in range(n) if height[k] == height.max() and word[k - 1] == (up + 1) % m]
    if m == 4:  # of the top row's steps the last is from the panel next to its leftmost one
        ends = [k for k in ends if word[k] == (up + 2) % m]
        left = [-sum((d == 0) - (d == 2) for d in word[:k]) for k in ends]
        ends = [ends[left.index(max(left))]]
    if not ends:
        return None
    word = word[ends[0] :] + word[: ends[0]]
    return list(word[:-1]), sum((-1) ** i * t for i, t in enumerate(Circuit(circuit.grid, word).turns))


def polygons(grid, n):
    """All circuits of n panels and their mirror images, opened."""
    for word in words(grid, n):
        for image in (word, tuple(-d % GRIDS[grid].directions for d in word)):
            polygon = opened(Circuit(GRIDS[grid], image), 1)
            if polygon is not None:
                yield polygon


def mirrored(grid, one, two):
    """Two walks from a lower left to a lower right end, the second one reflected, joined by two creases."""
    m = GRIDS[grid].directions
    return Circuit(GRIDS[grid], (*one, 1, *((2 - d) % m for d in reversed(two)), 1 + m // 2))


@pytest.mark.parametrize("n", [4, 6, 8, 10])
def test_squares_join_to_untwisted_designs(n):
    joined = 0
    for (one, s), (two, t) in itertools.product(polygons("square", n), repeat=2):
        if s == t:
            bent = Circuit(GRIDS["square"], (*one, 1, 0, 1, 1, *((d + 2) % 4 for d in two), 3, 2, 3, 3))
            for circuit, crease in ((mirrored("square", one, two), n - 1), (bent, n + 2)):
                assert circuit.n == 2 * crease + 2
                assert [twist(folding) for folding in foldings(circuit) if folding.crease == crease] == [0]
                joined += 1
    assert joined >= 8


@pytest.mark.parametrize("n", [6, 10, 12, 14, 16])
def test_triangles_join_to_circuits_without_t_and_grow_by_ten(n):
    turned = [opened_triangles(Circuit(GRIDS["triangle"], word)) for word in words("triangle", n)]
    for one, two in itertools.product(turned, repeat=2):
        totals = {sums(Circuit(GRIDS["triangle"], (*half, 3)))[0] for half in (one, two)}
        if len(totals) == 1:
            joined = Circuit(GRIDS["triangle"], (*one, 1, 2, *((d + 3) % 6 for d in two), 4, 5))
            assert joined.n == 2 * n + 2
            assert sums(joined)[0] == 0
        assert Circuit(GRIDS["triangle"], (*one, 1, 0, 1, 2, 3, 2, 3, 4, 5, 4, 5)).n == n + 10


def opened_triangles(circuit):
    """The circuit, counterclockwise, as a walk to its leftmost highest panel from the lower left one next to it."""
    n = circuit.n
    word = circuit.word if sum(circuit.turns) > 0 else tuple((d + 3) % 6 for d in reversed(circuit.word))
    points = Circuit(circuit.grid, word).points
    top = max(range(n), key=lambda k: (points[k][1], -points[k][0]))
    assert word[top] == 3
    return word[top + 1 :] + word[:top]


@pytest.mark.parametrize("n", [4, 6, 8])
def test_hexagons_join_to_untwisted_designs(n):
    ways = {0: ([4, 4], [1, 0, 1]), 2: ([4, 4], [1, 1, 0]), 4: ([4, 4, 5, 5, 4], [1, 0, 1, 0, 1, 0])}
    seen = set()
    for (one, s), (two, t) in itertools.product(polygons("hex", n), repeat=2):
        if s == t:
            down, up = ways[s % 6]
            circuit = mirrored("hex", [*down, *one, *up], [*down, *two, *up])
            crease = circuit.n // 2 - 1
            assert circuit.n % 4 == 2
            assert [twist(folding) for folding in foldings(circuit) if folding.crease == crease] == [0]
            seen.add(s % 6)
    assert seen == ({0, 2, 4} if n > 4 else {0, 2, 4} & seen)


@pytest.mark.parametrize(
    "spec",
    ["3x2", "5x2", "8x2", "9x2", *(f"{2 * k}x3" for k in range(2, 10)), "4x4", "5x4", "6x4", "6x5", "8x5", "7x6"],
)
def test_a_circuit_that_crosses_a_middle_line_twice_folds_there(spec):
    array = parse_array(GRIDS["square"], spec)
    sides = tuple(map(int, spec.split("x")))
    narrow = min(sides) <= 3
    met = 0
    for batch in ArraySearch(array).batches():
        folded = set(fold(batch).row.tolist())
        assert not narrow or len(folded) == len(batch)
        for word in batch.words.tolist():
            circuit = Circuit(GRIDS["square"], tuple(word))
            creases = flat_creases(circuit)
            assert sums(circuit)[0] == 0
            low = [min(point[axis] for point in circuit.points) for axis in (0, 1)]
            spread = [max(point[axis] for point in circuit.points) + 1 - low[axis] for axis in (0, 1)]
            for axis in (0, 1):
                middle = 2 * low[axis] + spread[axis] - 1
                ends = zip(circuit.points, circuit.points[1:] + circuit.points[:1], strict=True)
                crossing = [k for k, (p, q) in enumerate(ends) if p[axis] + q[axis] == middle and p[axis] != q[axis]]
                if len(crossing) == 2:
                    assert crossing[1] - crossing[0] == circuit.n // 2
                    assert crossing[0] in creases
                    met += 1
    assert met
