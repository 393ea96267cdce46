"""Proofs of locks in whole numbers: the same as floating point has, and refused where anything in them is wrong."""

import math
from dataclasses import replace
from itertools import combinations
from unittest import mock

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hcsearch.basics.vocabulary import WAYS
from hcsearch.designs.folding import Folding
from hcsearch.designs.records import CircuitBatch, FoldingBatch
from hcsearch.kernels.linkage.cones import cone_rays
from hcsearch.library.assemblies import ASSEMBLIES
from hcsearch.library.unit_search.elements import untwisted_foldings_of
from hcsearch.motion.kinematics.local import bilinear_products
from hcsearch.motion.locks import end_locks, exact_checks
from hcsearch.motion.locks.end_locks import lock_at
from hcsearch.motion.locks.lattice import lattice_frame_of, whole_end
from hcsearch.search.stages.mobility import locked_in_every_way, mobility_of_batch
from hcsearch.shape.linkage import Linkage
from tests.locks.test_layers import clamp, contact_rows

SIZE = (0.05, 0.05, 0.006)
SIZES = {"hex": 10, "square": 12, "triangle": 14, "rhombus": 12, "kite": 12, "right45": 12, "right30": 12, "obtuse": 14}
TILINGS = [folding for grid, n in SIZES.items() for folding in untwisted_foldings_of(grid, n)]
TEN = [folding for folding in TILINGS if folding.circuit.grid.name == "hex"]


def both_ends(folding, size=SIZE, **options):
    linkage = Linkage(folding.pattern(size, **options))
    return [(linkage, linkage.folded), (linkage, linkage.flat)]


def screws(linkage, angles):
    """Jacobian in the sense in which hinges leave their stops, and the sense."""
    senses = np.where(angles > 1.0, -1.0, 1.0)
    return linkage.closure(angles)[1] * senses, senses


def agree(linkage, angles, rng):
    """Powers and bends of a wrench are those of floating point, but for one positive factor each."""
    end = whole_end(linkage, angles)
    columns, senses = screws(linkage, angles)
    wrench, x = rng.normal(size=linkage.n_rows), rng.random(linkage.n_hinges)
    exact = end.wrench(wrench)
    assert (end.columns @ exact).astype(float) / end.lengths == pytest.approx(wrench @ columns, abs=1e-11)
    turns = x / end.lengths
    bend = float(0.5 * turns @ end.bends(exact) @ turns) / math.sqrt(end.frame.q)
    assert bend == pytest.approx(wrench @ linkage.bend(linkage.closure(angles)[1], senses * x), abs=1e-10)


@given(
    st.sampled_from(TILINGS),
    st.booleans(),
    st.decimals("0.001", 10, places=3).map(float),
    st.decimals("0.01", 3, places=2).map(float),
    st.floats(-3.0, 3.0),
    st.integers(0, 2**32 - 1),
)
def test_whole_screws_are_the_true_ones_wherever_the_pattern_is_drawn(folding, hinged, side, thick, turn, seed):
    pattern = folding.pattern((side, side, round(side * thick, 6)), flat_pairs="hinged" if hinged else "rigid")
    linkage = Linkage(pattern.moved(turn, (0.3 * side, -side), over=seed % 2 == 0))
    for angles in (linkage.folded, linkage.flat):
        agree(linkage, angles, np.random.default_rng(seed))


def test_rectangles_and_many_loops_have_whole_screws_too_and_other_tilings_none():
    rng = np.random.default_rng(1)
    rectangle = Folding.from_notation("rectangle:0122233300012210:2")
    for linkage, angles in both_ends(rectangle, (0.05, 0.0412, 0.0061)):
        agree(linkage, angles, rng)
    for name in ("fig-5.10a", "thesis-4x4", "array-6r"):
        linkage = Linkage(ASSEMBLIES[name].build(ASSEMBLIES[name].defaults))
        agree(linkage, linkage.folded, rng)
        agree(linkage, linkage.flat, rng)
    element = Linkage(ASSEMBLIES["element-8r"].build(ASSEMBLIES["element-8r"].defaults))
    assert whole_end(element, element.folded) is None
    linkage, angles = both_ends(TEN[0])[0]
    assert whole_end(linkage, 0.999 * angles) is None
    assert whole_end(linkage, np.where(np.arange(len(angles)) == 1, 0.0, angles)) is None  # open there


@given(st.sampled_from(TILINGS), st.integers(0, 2**32 - 1))
def test_brackets_are_skew_and_bilinear(folding, seed):
    rng = np.random.default_rng(seed)
    frame = lattice_frame_of(Linkage(folding.pattern(SIZE)))
    one, two = (rng.integers(-99, 99, 6).astype(object).tolist() for _ in range(2))
    form = frame.brackets(one)
    assert (form == -form.T).all()
    assert (frame.brackets([3 * a - b for a, b in zip(one, two, strict=True)]) == 3 * form - frame.brackets(two)).all()


def by_hand(equations, n):
    """Extreme rays as the positive solutions of least support, one for every support there is."""
    matrix = np.array(equations, float).reshape(-1, n)
    rays = []
    for size in range(1, n + 1):
        for support in combinations(range(n), size):
            _, s, vt = np.linalg.svd(matrix[:, support])
            kernel = vt[int((s > 1e-9).sum()) :]
            if len(kernel) == 1 and (kernel[0] * np.sign(kernel[0, 0]) > 1e-9).all():
                ray = np.zeros(n)
                ray[list(support)] = kernel[0] / kernel[0].sum()
                rays.append(ray)
    return rays


@given(st.integers(2, 7), st.integers(1, 4), st.data())
def test_rays_are_those_found_support_by_support(n, k, data):
    equations = [data.draw(st.lists(st.integers(-3, 3), min_size=n, max_size=n)) for _ in range(k)]
    rays = exact_checks.extreme_rays(equations)
    assert len(set(rays)) == len(rays)
    exact = np.array(rays, float).reshape(-1, n)
    same(exact / exact.sum(axis=1, keepdims=True), by_hand(equations, n))


def same(one, two):
    assert sorted(map(tuple, np.round(one, 8))) == sorted(map(tuple, np.round(two, 8)))


@pytest.mark.parametrize("folding", TEN[::4], ids=str)
def test_floating_point_misses_no_ray(folding):
    for linkage, angles in both_ends(folding):
        exact = np.array(exact_checks.extreme_rays(whole_end(linkage, angles).columns.T.tolist()), float).reshape(
            -1, linkage.n_hinges
        )
        rays = np.empty((2048, linkage.n_hinges))
        count = cone_rays(np.ascontiguousarray(screws(linkage, angles)[0].T), rays)
        same(exact / exact.sum(axis=1, keepdims=True), rays[:count])


def proofs(order):
    return [
        (linkage, angles, lock)
        for folding in TEN
        for linkage, angles in both_ends(folding)
        if (lock := lock_at(linkage, angles)).order == order
    ]


def none(linkage):
    return np.zeros((0, linkage.n_hinges), object)


def test_every_lock_on_a_tiling_is_proved_in_whole_numbers():
    locked = set()
    for folding in TILINGS:
        for linkage, angles in both_ends(folding):
            lock = lock_at(linkage, angles)
            assert lock.exact == lock.locked
            with mock.patch.object(end_locks, "whole_end", return_value=None):
                assert lock_at(linkage, angles).order == lock.order
            locked |= {(folding.circuit.grid.name, lock.order)} if lock.locked else set()
    assert {("hex", 1), ("hex", 2), ("kite", 1)} <= locked


def first_order(end, rows, wrench):
    return exact_checks.proves_first_order(end, rows, wrench, np.zeros(0))


@pytest.mark.parametrize(("order", "check"), [(1, first_order), (2, exact_checks.proves_second_order)])
def test_a_tampered_wrench_proves_nothing(order, check):
    rng = np.random.default_rng(2)
    for linkage, angles, lock in proofs(order):
        end, rows = whole_end(linkage, angles), none(linkage)
        assert check(end, rows, lock.wrench)
        assert check(end, rows, lock.wrench * (1.0 + 1e-9 * rng.normal(size=6)))  # what is strict survives
        assert not check(end, rows, -lock.wrench)
        assert not check(end, rows, 0.0 * lock.wrench)
        if order == 1:
            held = screws(linkage, angles)[0][:, int(rng.integers(linkage.n_hinges))]
            less = lock.wrench - (1.0 + 1e-12) * (lock.wrench @ held) / (held @ held) * held
            assert not check(end, rows, less)  # one hinge is let go


def test_a_wrench_has_no_power_at_all_on_hinges_that_turn():
    """In floating point it has 1e-17, which would outweigh what is of second order."""
    rounded = 0
    for linkage, angles, lock in proofs(2):
        end = whole_end(linkage, angles)
        turning = np.delete(np.arange(linkage.n_hinges), lock.held_hinges)
        exact = exact_checks._powerless(end.columns[turning], end.wrench(lock.wrench))
        assert not (end.columns[turning] @ exact).any()
        rounded += bool((end.columns[turning] @ end.wrench(lock.wrench)).any())
    assert rounded


def test_a_proof_that_leaves_out_a_ray_is_refused():
    """The three other rays of this end turn the same hinges, and floating point finds a proof for them alone."""
    linkage, angles = both_ends(Folding.from_notation("hex:0223435501:2"))[0]
    columns, senses = screws(linkage, angles)
    end, jacobian = whole_end(linkage, angles), linkage.closure(angles)[1]
    rays = np.array(exact_checks.extreme_rays(end.columns.T.tolist()), float)
    rays /= rays.sum(axis=1, keepdims=True)
    proved = []
    for left_out in range(len(rays)):
        some = np.delete(rays, left_out, axis=0)
        values = bilinear_products(some, lambda x: linkage.bend(jacobian, senses * x))
        proof = end_locks.excluding_wrench(np.ascontiguousarray(columns.T), some, values)
        if proof is not None:
            proved.append(left_out)
            assert not exact_checks.proves_second_order(end, none(linkage), proof[0])
    assert len(proved) == 1
    assert not lock_at(linkage, angles).locked


@given(
    st.integers(1, 5).flatmap(
        lambda k: st.tuples(*(st.lists(st.tuples(*k * [st.integers(-2, 2)]), min_size=m, max_size=6) for m in (1, 0)))
    ),
    st.integers(1, 9),
    st.sampled_from((1.0, 1e-6, 1e5)),
)
def test_the_linear_program_is_left_out_only_where_it_finds_nothing(rows, n_rays, scale):
    """A wrench of its own passes no check where least squares exclude one."""
    positive, nonnegative = (scale * np.array(part, float).reshape(-1, len(rows[0][0])) for part in rows)
    basis, tried = np.eye(positive.shape[1]), []
    with mock.patch.object(end_locks, "_best_wrench", lambda *arguments: tried.append(arguments)):
        quick = list(end_locks._candidate_wrenches(positive, nonnegative, basis, n_rays))
    assert len(quick) <= 1
    for wrench in quick:
        assert (positive @ wrench).min() > 0.0
        assert (nonnegative @ wrench).min(initial=0.0) >= 0.0
    best = end_locks._best_wrench(positive, nonnegative, basis)
    if best is not None and not tried:
        best = best / np.abs(best).max()
        margin = (positive @ best).min()
        assert margin <= end_locks.WRENCH_MARGIN or margin <= -2 * n_rays * (nonnegative @ best).min(initial=0.0)


def test_forms_are_refused_where_the_diagonal_is_outweighed():
    assert exact_checks.has_dominant_diagonal(np.array([[2, -1], [-1, 1]], object), [1, 1]) is False
    assert exact_checks.has_dominant_diagonal(np.array([[2, -1], [-1, 2]], object), [1, 1]) is True
    assert exact_checks.has_dominant_diagonal(np.array([[1, 5], [5, 0]], object), [1, 1]) is False
    assert exact_checks.has_dominant_diagonal(np.array([[200, -10], [-10, 2]], object), [10, 1]) is True


def test_contacts_are_exact_on_the_lattice_and_numerical_beside_it():
    linkage = clamp()
    lock = lock_at(linkage, linkage.folded, contact_rows(linkage))
    assert (lock.order, lock.exact) == (1, True)
    shifted = contact_rows(linkage) + 1e-3 * np.sign(contact_rows(linkage))
    lock = lock_at(linkage, linkage.folded, shifted)
    assert (lock.order, lock.exact) == (1, False)
    end = whole_end(linkage, linkage.folded)
    rows = end.contacts(contact_rows(linkage))
    forces = np.ones(len(rows))
    assert not exact_checks.proves_first_order(end, rows, lock.wrench, -forces)


def test_off_a_tiling_a_proof_is_numerical():
    """Stretched hexagons lock as regular ones do at first order, as an affine map takes their lines to each other."""
    linkage, _, _ = next(proof for proof in proofs(1) if (proof[1] == 0.0).all())
    vertices = tuple((1.1 * x, y) for x, y in linkage.pattern.vertices)
    stretched = Linkage(replace(linkage.pattern, vertices=vertices))
    lock = lock_at(stretched, stretched.flat)
    assert (lock.order, lock.exact) == (1, False)
    assert whole_end(stretched, stretched.flat) is None


def test_what_whole_numbers_refuse_is_not_locked(monkeypatch):
    linkage, angles, _ = proofs(2)[0]
    monkeypatch.setattr(exact_checks, "proves_second_order", lambda *_: False)
    lock = lock_at(linkage, angles)
    assert (lock.locked, lock.second_order_tried, lock.wrench) == (False, True, None)
    assert lock.motion.sum() == pytest.approx(1.0)


def test_locks_with_rigid_and_with_hinged_flat_pairs_are_two_statements():
    """The README's folding deploys with hinged flat pairs; 2 of the 14 locked ones of ten hexagons stay locked."""
    folding = Folding.from_notation("hex:0234550132:3")
    assert any(lock_at(*end).locked for end in both_ends(folding))
    assert not any(lock_at(*end).locked for end in both_ends(folding, flat_pairs="hinged"))
    words = np.array([folding.circuit.word for folding in TEN], np.int8)
    creases = np.array([folding.crease for folding in TEN], np.int16)
    circuits = CircuitBatch("hex", words, np.ones(len(TEN), np.int16))
    batch = FoldingBatch(np.arange(len(TEN), dtype=np.int32), creases)
    freedoms = mobility_of_batch(circuits, batch, np.zeros(len(TEN), np.int16))
    hinged = [any(lock_at(*end).locked for end in both_ends(folding, flat_pairs="hinged")) for folding in TEN]
    assert freedoms.locked_hinged.tolist() == hinged
    assert (freedoms.locked.sum(), freedoms.locked_hinged.sum()) == (14, 2)
    assert locked_in_every_way(freedoms, ("rigid", "merged")).tolist() == freedoms.locked.tolist()
    assert locked_in_every_way(freedoms, ("hinged",)).tolist() == locked_in_every_way(freedoms, WAYS).tolist() == hinged
