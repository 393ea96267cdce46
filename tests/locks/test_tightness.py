"""How tight locks are: figures at hand, units, and openings that hold along the way."""

import numpy as np
import pytest
from scipy import optimize

from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, folding_of
from hcsearch.kernels.linkage.openings import open_loops, scale_turns
from hcsearch.motion.locks.tightness import _forward_path, _Loops, tightness
from hcsearch.shape.linkage import Linkage

SIZE = (0.05, 0.05, 0.006)


def built(notation, crease, size=SIZE, **options):
    return Linkage(folding_of(Circuit.from_notation(notation), crease).pattern(size, **options))


def test_a_lock_that_a_hundredth_of_a_millimetre_undoes():
    """Measured before at 0.013 mm, as closure residual times the size of the pattern, with rigid flat pairs."""
    linkage = built("hex:023224534000", 3)
    measured = tightness(linkage, linkage.folded)
    assert measured.opening == pytest.approx(1.00e-5, rel=0.02)
    assert measured.least == pytest.approx(measured.opening, rel=0.02)
    assert 0.2 < measured.turn < 0.3 < measured.closed < 0.5
    assert "0.01 mm" in measured.sentence
    loops = _Loops(linkage, linkage.folded)
    loops.at_stops = loops.at_stops._replace(weights=linkage.pattern.size * np.eye(6)[None])
    assert max(map(loops.opening, _forward_path(loops, 0.006))) == pytest.approx(1.3e-5, rel=0.02)


def test_the_way_out_ends_closed_and_keeps_the_stops():
    linkage = built("hex:0234550132", 3)
    loops = _Loops(linkage, linkage.folded)
    way = np.array(_forward_path(loops, 0.006))
    assert way.min() >= 0.0
    assert way.max() <= np.pi
    assert (np.diff(way.sum(axis=1)) > 0).all()
    assert np.abs(linkage.closure(linkage.folded - way[-1])[0]).max() < 1e-7
    measured = tightness(linkage, linkage.folded)
    assert measured.least <= measured.opening
    assert measured.least > 1e-3
    assert measured.opening < 3e-3


def test_openings_are_lengths():
    """All of a thousand times the size; and the distance by which a turn about a far line moves corners."""
    small, large = (built("hex:023224534000", 3, tuple(k * x for x in SIZE)) for k in (1.0, 1e3))
    one, two = tightness(small, small.folded), tightness(large, large.folded)
    assert two.opening == pytest.approx(1e3 * one.opening, rel=1e-3)
    assert two.closed == pytest.approx(one.closed)
    corners = np.concatenate([solid.reshape(-1, 3) for solid in small.solids(small.flat)])
    (weights,) = _Loops(small, small.flat).at_stops.weights
    rotation, gap = np.array([1e-4, -2e-4, 3e-4]), np.array([1e-3, 0.0, -1e-3])
    moved = np.cross(rotation, corners) + gap * small.pattern.size
    mean = np.sqrt((moved**2).sum(axis=1).mean())
    assert np.linalg.norm(weights @ np.r_[rotation, gap]) == pytest.approx(mean)


def test_it_does_not_matter_which_panel_stays():
    linkage = built("hex:023224534000", 3)
    measured = [tightness(it, it.folded) for it in (linkage, Linkage(linkage.pattern, base=4))]
    assert measured[0].opening == pytest.approx(measured[1].opening, rel=0.02)


def test_a_lock_that_holds_is_given_up_at_the_thickness():
    linkage = built("hex:0223435501", 2)
    measured = tightness(linkage, linkage.flat)
    assert (measured.opening, measured.closed) == (0.006, None)
    assert "more than 6 mm" in measured.sentence


def test_what_is_not_locked_opens_by_nothing_and_open_chains_have_no_loops():
    linkage = built("hex:0234550132", 4)
    assert tightness(linkage, linkage.flat).opening < 1e-9
    strip = built("square:0123", 0)
    assert tightness(strip, strip.folded) is None


@pytest.mark.parametrize("total", [0.01, 3.0, 3.5, 6.2])
def test_turns_are_scaled_within_the_other_stop(total):
    turns = np.empty(4)
    scale_turns(np.array([3.0, 0.1, 0.0, 0.2]), total, turns)
    assert turns.sum() == pytest.approx(total)
    assert turns.max() <= np.pi
    assert turns.min() >= 0.0


def weighted(linkage, loops, turns):
    """The residual in metres and its derivative, in NumPy."""
    senses, weights = loops.at_stops.senses, loops.at_stops.weights
    residual, jacobian = linkage.closure(loops.at_stops.angles + senses * turns)
    both = np.concatenate([residual[:, None], jacobian * senses], axis=1).reshape(len(weights), 6, -1)
    opened = (weights @ both).reshape(6 * len(weights), -1) / np.sqrt(len(weights))
    return opened[:, 0], opened[:, 1:]


@pytest.mark.parametrize("name", ["hex:0234550132:3", "square:012233230011:4", "hex:023224534000:3"])
def test_openings_are_those_of_numpy_and_least_ones_those_of_scipy(name):
    """SciPy minimises over all but the last turn, by sequential quadratic programming from the same start."""
    folding = Folding.from_notation(name)
    linkage = Linkage(folding.pattern(SIZE, flat_pairs="hinged"))
    loops, n = _Loops(linkage, linkage.folded), linkage.n_hinges
    for seed, total in enumerate((0.01, 0.3, 2.0)):
        start = np.random.default_rng(seed).dirichlet(np.ones(n)) * total
        value, slope = np.empty(linkage.n_rows), np.empty((linkage.n_rows, n))
        square = open_loops(loops.at_stops, start, value, slope)
        expected = weighted(linkage, loops, start)
        assert np.allclose(value, expected[0], rtol=1e-12, atol=1e-15)
        assert np.allclose(slope, expected[1], rtol=1e-12, atol=1e-15)
        assert np.sqrt(square) == pytest.approx(np.linalg.norm(expected[0]))
        least = loops.least_opening_turns(start, total)
        assert least.min() >= 0.0
        assert least.sum() == pytest.approx(total)
        found = optimize.minimize(
            lambda x, total=total: 1e6 * weighted(linkage, loops, x)[0] @ weighted(linkage, loops, x)[0],
            start,
            method="SLSQP",
            bounds=[(0.0, np.pi)] * n,
            constraints={"type": "eq", "fun": lambda x, total=total: x.sum() - total},
            options={"maxiter": 1000, "ftol": 1e-14},
        )
        assert loops.opening(least) <= 1.02 * np.sqrt(1e-6 * found.fun) + 1e-9
