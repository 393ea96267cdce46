"""Locks: proofs hold what they say, do not depend on sizes, and nothing that moves is ever called locked."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import least_squares

from hcsearch import enumerate_circuits, twist
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, foldings
from hcsearch.library.assemblies import ASSEMBLIES
from hcsearch.motion.locks.end_locks import WRENCH_MARGIN, lock_at
from hcsearch.shape.linkage import Linkage

SIZE = (0.05, 0.05, 0.006)


def untwisted(grid, n):
    return [folding for c in enumerate_circuits(grid, n=n) for folding in foldings(c) if twist(folding) == 0]


def ends(folding: Folding, size=SIZE, **options):
    linkage = Linkage(folding.pattern(size, **options))
    return linkage, [(linkage.folded, lock_at(linkage, linkage.folded)), (linkage.flat, lock_at(linkage, linkage.flat))]


TEN = untwisted("hex", 10)


def test_ten_hexagons_have_fourteen_locked_foldings_of_forty():
    """Of the 25 of 40 that did not deploy in trial runs with springs."""
    orders = [[lock.order for _, lock in ends(folding)[1]] for folding in TEN]
    assert len(orders) == 40
    assert sum(any(pair) for pair in orders) == 14
    assert sum(1 in pair for pair in orders) == 11


@pytest.mark.parametrize("folding", TEN, ids=str)
def test_proofs_hold_what_they_say(folding):
    linkage, locks = ends(folding)
    for angles, lock in locks:
        _, jacobian = linkage.closure(angles)
        senses = np.where(angles > 1.0, -1.0, 1.0)
        power = lock.wrench @ (jacobian * senses) if lock.locked else np.zeros(linkage.n_hinges)
        if lock.order == 1:
            assert power.min() > WRENCH_MARGIN
        elif lock.order == 2:
            assert power[list(lock.held_hinges)].min(initial=1.0) > WRENCH_MARGIN
            assert np.abs(np.delete(power, lock.held_hinges)).max() < 1e-12
            rng = np.random.default_rng(1)
            corners = np.array(list(_motions(jacobian * senses, rng)))
            for shares in [*np.eye(len(corners)), *rng.dirichlet(np.full(len(corners), 0.3), size=30)]:
                assert lock.wrench @ linkage.bend(jacobian, senses * (shares @ corners)) > 0.0
        else:
            assert np.abs(jacobian @ (senses * lock.motion)).max() < 1e-9
            assert lock.motion.min() >= 0.0


def _motions(columns, rng):
    """Some velocities x >= 0 with A x = 0, computed without the module's own rays."""
    from scipy.optimize import linprog

    n = columns.shape[1]
    for _ in range(10):
        result = linprog(
            rng.normal(size=n), A_eq=np.r_[columns, np.ones((1, n))], b_eq=np.r_[np.zeros(len(columns)), 1.0]
        )
        assert result.status == 0
        yield result.x


def least_gap(linkage, angles, opening):
    """Least closure residual of a search, when the hinges leave their stops by `opening` (rad) in all."""
    senses = np.where(angles > 1.0, -1.0, 1.0)
    rng = np.random.default_rng(3)

    def gap(x):
        return np.r_[linkage.closure(angles + senses * x)[0], x.sum() / opening - 1.0]

    def slope(x):
        return np.r_[linkage.closure(angles + senses * x)[1] * senses, np.full((1, len(x)), 1.0 / opening)]

    starts = (opening * rng.dirichlet(np.ones(linkage.n_hinges)) for _ in range(3))
    sharp = {"ftol": 1e-15, "xtol": 1e-15, "gtol": 1e-15, "max_nfev": 1000}
    outcomes = (least_squares(gap, start, slope, bounds=(0.0, math.pi), **sharp) for start in starts)
    return min(math.sqrt(2 * outcome.cost) for outcome in outcomes)


@pytest.mark.parametrize("folding", [f for f in TEN if any(lock.locked for _, lock in ends(f)[1])][::2], ids=str)
def test_what_is_locked_cannot_be_moved_by_force(folding):
    """Held a little open with stops kept, the loops stay apart in proportion to the (square of the) opening."""
    linkage, locks = ends(folding)
    for angles, lock in locks:
        if lock.locked:
            assert least_gap(linkage, angles, 0.05) > 1e-4 * 0.05**lock.order


def test_what_moves_is_not_called_locked_and_closes_when_forced():
    """Assemblies that move between their ends with all stops kept; the thesis's 8R element is one (5.24)."""
    for name in ("element-8r", "unit-i", "unit-ii", "element-6r", "module-i", "module-ii", "module-iii", "thesis-4x4"):
        assembly = ASSEMBLIES[name]
        linkage = Linkage(assembly.build(assembly.defaults))
        for angles in (linkage.folded, linkage.flat):
            assert not lock_at(linkage, angles).locked, name
    for folding in untwisted("triangle", 10):
        linkage, locks = ends(folding)
        for angles, _ in locks:
            assert least_gap(linkage, angles, 0.05) < 1e-8


def test_a_lock_by_a_hair_is_a_lock():
    """Isolated, though it is closed again at 0.106 rad in all and never open by more than a micrometre between."""
    linkage, ((angles, lock), _) = ends(Folding.from_notation("hex:02331323540500:2"))
    assert lock.order == 2
    assert least_gap(linkage, angles, 0.02) > 1e-4 * 0.02**2
    assert least_gap(linkage, angles, 0.12) < 1e-8


@given(st.sampled_from(TEN), st.floats(1e-4, 10.0), st.floats(1e-3, 1e3))
def test_first_order_locks_depend_neither_on_thickness_nor_on_the_unit(folding, thickness, unit):
    _, locks = ends(folding)
    _, scaled = ends(folding, (unit, unit, unit * thickness))
    for (_, one), (_, two) in zip(locks, scaled, strict=True):
        # where the wrench's margin sinks below what is taken for proved, nothing is claimed
        assert (one.order == 1) == (two.order == 1) or min(thickness, 1 / thickness) < 1e-2


def test_hinged_flat_pairs_free_all_but_two():
    hinged = [folding for folding in TEN if any(lock.locked for _, lock in ends(folding, flat_pairs="hinged")[1])]
    rigid = [folding for folding in TEN if any(lock.locked for _, lock in ends(folding)[1])]
    assert set(map(str, hinged)) <= set(map(str, rigid))
    assert len(hinged) == 2


def test_an_open_chain_is_free():
    strip = Folding.from_notation("square:0123:0")
    linkage = Linkage(strip.pattern(SIZE))
    lock = lock_at(linkage, linkage.folded)
    assert not lock.locked
    assert lock.motion == pytest.approx([1.0])


def test_where_no_proof_is_looked_for_it_is_said():
    """Forty squares in two rows, all hinges but two parallel: too many motions at first order."""
    (folding, *_) = foldings(Circuit.from_notation("square:" + "0" * 19 + "1" + "2" * 19 + "3"))
    linkage = Linkage(folding.pattern(SIZE))
    lock = lock_at(linkage, linkage.folded)
    assert not lock.locked
    assert not lock.second_order_tried
    assert "too many" in lock.reason
