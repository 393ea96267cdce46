"""Locks: proofs hold what they say, do not depend on sizes, and nothing that moves is ever called locked."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import least_squares

from hcsearch import enumerate_circuits, twist
from hcsearch.circuit import Circuit
from hcsearch.folding import Folding, folding_of, foldings
from hcsearch.kinematics.closing import close
from hcsearch.kinematics.locks import MARGIN, lock_at
from hcsearch.linkage import Linkage

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
    linkage, found = ends(folding)
    for angles, lock in found:
        _, jacobian = linkage.closure(angles)
        senses = np.where(angles > 1.0, -1.0, 1.0)
        power = lock.wrench @ (jacobian * senses) if lock.locked else np.zeros(linkage.n_hinges)
        if lock.order == 1:
            assert power.min() > MARGIN
        elif lock.order == 2:
            assert power.min() > -1e-12
            rng = np.random.default_rng(1)
            for x in _motions(jacobian * senses, rng):
                assert lock.wrench @ linkage.bend(jacobian, senses * x) > 0.0
        else:
            assert np.abs(jacobian @ (senses * lock.motion)).max() < 1e-9
            assert lock.motion.min() >= 0.0


def _motions(columns, rng):
    """Some velocities x >= 0 with A x = 0, found without the module's own rays."""
    from scipy.optimize import linprog

    n = columns.shape[1]
    for _ in range(10):
        result = linprog(
            rng.normal(size=n), A_eq=np.r_[columns, np.ones((1, n))], b_eq=np.r_[np.zeros(len(columns)), 1.0]
        )
        assert result.status == 0
        yield result.x


@pytest.mark.parametrize("folding", [f for f in TEN if any(lock.locked for _, lock in ends(f)[1])][::2], ids=str)
def test_what_is_locked_cannot_be_moved_by_force(folding):
    """Held a little open with stops kept, the loops stay apart in proportion to the (square of the) opening."""
    linkage, found = ends(folding)
    angles, lock = next((angles, lock) for angles, lock in found if lock.locked)
    senses = np.where(angles > 1.0, -1.0, 1.0)
    rng = np.random.default_rng(3)

    def gap(x, opening):
        total = x.sum()
        return np.r_[linkage.closure(angles + senses * x)[0], total / opening - 1.0]

    opening = 0.05
    best = min(
        least_squares(
            gap, opening * rng.dirichlet(np.ones(linkage.n_hinges)), args=(opening,), bounds=(0.0, math.pi)
        ).cost
        for _ in range(2)
    )
    assert math.sqrt(2 * best) > 1e-4 * opening**lock.order


def test_what_moves_is_not_called_locked():
    """The thesis's 8R element deploys along a known path (5.24)."""
    for folding in untwisted("triangle", 10):
        linkage, found = ends(folding)
        assert not any(lock.locked for _, lock in found)
        opened = close(linkage, linkage.folded - 0.3)
        assert opened.success


@given(st.sampled_from(TEN), st.floats(1e-4, 10.0), st.floats(1e-3, 1e3))
def test_first_order_locks_depend_neither_on_thickness_nor_on_the_unit(folding, thickness, unit):
    _, found = ends(folding)
    _, scaled = ends(folding, (unit, unit, unit * thickness))
    for (_, one), (_, two) in zip(found, scaled, strict=True):
        # where the wrench's margin sinks below what is taken for proved, nothing is claimed
        assert (one.order == 1) == (two.order == 1) or min(thickness, 1 / thickness) < 1e-2


def test_hinged_flat_pairs_free_all_but_two():
    hinged = [folding for folding in TEN if any(lock.locked for _, lock in ends(folding, hinged=True)[1])]
    rigid = [folding for folding in TEN if any(lock.locked for _, lock in ends(folding)[1])]
    assert set(map(str, hinged)) <= set(map(str, rigid))
    assert len(hinged) == 2


def test_an_open_chain_is_free():
    strip = folding_of(Circuit.from_notation("square:0123"), 0)
    linkage = Linkage(strip.pattern(SIZE))
    lock = lock_at(linkage, linkage.folded)
    assert not lock.locked
    assert lock.motion == pytest.approx([1.0])
