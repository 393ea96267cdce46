"""Frequencies of flat arrays: hand formulas, laws of scale, roots that are held or float, and lower bounds."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch.basics.errors import HcsearchError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import foldings
from hcsearch.scenes.laws import law_named
from hcsearch.springs.flight.deployed_modes import (
    FloatingBase,
    deployed_modes,
    flat_rates,
    flat_stiffness,
    geometric_stiffness,
    panel_rates,
)
from tests.flight.arrays import SIDE, THICKNESS, strip
from tests.flight.vibrating import closed_states_near_flat
from tests.linkages import linkage_named
from tests.strategies import rewritten

DENSITY, LATCH = 547.0, 20.0
MASS = DENSITY * SIDE**2 * THICKNESS
OWN = MASS * (SIDE**2 + THICKNESS**2) / 12.0
"""Moment of inertia of a panel about a line through its centre, along a hinge."""
NAMES = ("thesis-4x4", "hex:023224350400:4", "square:0121222323030001:5")


def modes_of(linkage, root=0, latch=LATCH, density=DENSITY, **options):
    return deployed_modes(linkage, np.full(linkage.n_hinges, latch), density, root, **options)


def hertz(eigenvalues):
    return np.sqrt(eigenvalues) / (2.0 * math.pi)


@pytest.mark.parametrize("face", ["top", "bottom"])
def test_one_hinge_has_its_own_frequency(face):
    modes = modes_of(strip([face]))
    inertia = OWN + MASS * (SIDE**2 + THICKNESS**2) / 4.0
    assert modes.deployed_hz == pytest.approx(hertz(LATCH / inertia), rel=1e-12)
    assert (modes.soft_modes, modes.gap) == (0, None)


def test_two_panels_that_float_swing_against_each_other():
    modes = modes_of(strip(["top"]), base=FloatingBase())
    assert modes.deployed_hz == pytest.approx(hertz(2.0 * LATCH / (OWN + MASS * THICKNESS**2 / 4.0)), rel=1e-12)


def test_three_panels_held_at_one_end():
    s, t = SIDE, THICKNESS
    own = MASS * (s**2 + t**2) / 12.0
    far, near, both = ((9.0 * s**2 + t**2) / 4.0, (s**2 + t**2) / 4.0, (3.0 * s**2 + t**2) / 4.0)
    outer, inner, coupled = own + MASS * near, 2.0 * own + MASS * (far + near), own + MASS * both
    expected = np.sort(np.linalg.eigvals(np.linalg.inv([[inner, coupled], [coupled, outer]]) * LATCH))
    modes = modes_of(strip(["top", "top"]))
    assert modes.frequencies == pytest.approx(hertz(expected), rel=1e-11)
    assert modes.gap == pytest.approx(expected[1] / expected[0])


def test_three_panels_held_in_the_middle_swing_apart():
    modes = modes_of(strip(["top", "bottom"]), root=1)
    assert modes.frequencies == pytest.approx(2 * [hertz(LATCH / (OWN + MASS * (SIDE**2 + THICKNESS**2) / 4.0))])


@pytest.mark.parametrize("name", NAMES)
@settings(max_examples=15, deadline=None)
@given(latch=st.floats(0.1, 1e4), by=st.floats(0.1, 10.0), heavier=st.floats(0.1, 10.0))
def test_frequencies_scale_with_stiffness_and_density(name, latch, by, heavier):
    linkage = linkage_named(name)
    one, other = modes_of(linkage, latch=latch), modes_of(linkage, latch=by * latch, density=heavier * DENSITY)
    assert other.frequencies == pytest.approx(one.frequencies * math.sqrt(by / heavier), rel=1e-8)


@pytest.mark.parametrize("base", [FloatingBase(), FloatingBase(0.05, (1e-5, 1e-5, 2e-5))])
@pytest.mark.parametrize("name", NAMES)
def test_a_floating_array_is_never_slower_than_a_held_one(name, base):
    linkage = linkage_named(name)
    for root in range(0, linkage.n_panels, 3):
        held, floating = modes_of(linkage, root), modes_of(linkage, root, base=base)
        assert (floating.frequencies >= held.frequencies * (1.0 - 1e-12)).all()
        heavy = modes_of(linkage, root, base=FloatingBase(1e6, (1e6, 1e6, 1e6)))
        assert heavy.frequencies == pytest.approx(held.frequencies, rel=1e-4)


@pytest.mark.parametrize("name", NAMES)
def test_an_array_that_floats_by_itself_has_no_root(name):
    linkage = linkage_named(name)
    first = modes_of(linkage, 0, base=FloatingBase()).frequencies
    for root in range(1, linkage.n_panels):
        assert modes_of(linkage, root, base=FloatingBase()).frequencies == pytest.approx(first, rel=1e-9)


@pytest.mark.parametrize("name", NAMES)
@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_no_closed_rates_have_a_lower_rayleigh_quotient(name, seed):
    linkage, rng = linkage_named(name), np.random.default_rng(seed)
    latches, root = rng.uniform(1.0, 50.0, linkage.n_hinges), int(rng.integers(linkage.n_panels))
    modes = deployed_modes(linkage, latches, DENSITY, root)
    basis = flat_rates(linkage)
    rates = basis @ rng.normal(size=basis.shape[1])
    mass = panel_rates(linkage, DENSITY, root, linkage.flat).mass_matrix
    quotient = rates @ (latches * rates) / (rates @ mass @ rates)
    assert modes.deployed_hz <= hertz(quotient) * (1.0 + 1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_true_motions_beside_the_flat_state_are_not_slower(name):
    linkage, distance = linkage_named(name), 1e-5
    lowest = modes_of(linkage).deployed_hz
    mass = panel_rates(linkage, DENSITY, 0, linkage.flat).mass_matrix
    for rates in closed_states_near_flat(linkage, 20, distance):
        quotient = LATCH * (rates @ rates) / (rates @ mass @ rates)
        assert lowest <= hertz(quotient) * (1.0 + 100.0 * distance)


@pytest.mark.parametrize("name", NAMES)
def test_modes_are_closed_vibrations(name):
    linkage = linkage_named(name)
    modes, jacobian = modes_of(linkage), linkage.closure(linkage.flat)[1]
    motions = panel_rates(linkage, DENSITY, 0, linkage.flat)
    assert jacobian @ modes.rates.T == pytest.approx(np.zeros((len(jacobian), len(modes.rates))), abs=1e-9)
    assert modes.rates @ motions.mass_matrix @ modes.rates.T == pytest.approx(np.eye(len(modes.rates)), abs=1e-9)
    assert LATCH * modes.rates @ modes.rates.T == pytest.approx(
        np.diag(modes.eigenvalues), abs=1e-9 * modes.eigenvalues.max()
    )
    energies = np.einsum("mpi,pij,mpj->m", modes.panels, motions.inertias, modes.panels)
    assert energies == pytest.approx(np.ones(len(modes.rates)))
    assert (modes.panels[:, 0] == 0.0).all()


@settings(max_examples=30, deadline=None)
@given(latched=st.lists(st.booleans(), min_size=12, max_size=12))
def test_directions_without_latches_are_soft(latched):
    linkage = linkage_named("thesis-4x4")
    latches = np.where(latched, LATCH, 0.0)
    modes = deployed_modes(linkage, latches, DENSITY, 0)
    held = flat_rates(linkage)[np.array(latched)]
    stiff = int(np.linalg.matrix_rank(held, tol=1e-9)) if len(held) else 0
    assert modes.soft_modes == len(modes.eigenvalues) - stiff
    assert (modes.deployed_hz is None) == (stiff == 0)
    assert modes.deployed_hz is None or modes.deployed_hz > 1.0


def test_a_chain_is_soft_where_latches_are_missing():
    linkage = strip(["top", "bottom", "top"])
    modes = deployed_modes(linkage, np.array([LATCH, 0.0, 0.0]), DENSITY, 0)
    assert modes.soft_modes == 2
    assert len(modes.frequencies) == 1


@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize("notation", ["hex:0234550132", "square:0112223300"])
def test_frequencies_do_not_depend_on_how_a_design_is_written(notation, backwards):
    circuit = Circuit.from_notation(notation)
    own = rewritten(circuit, circuit.grid.point_group[1], 3, backwards)
    linkage = foldings(own)[0].linkage(flat_pairs="hinged")
    twin = linkage.twin
    latches = np.random.default_rng(1).uniform(1.0, 50.0, linkage.n_hinges)
    for base in (None, FloatingBase(0.1, (1e-4, 1e-4, 1e-4))):
        one = deployed_modes(linkage, latches, DENSITY, 3, base=base)
        other = deployed_modes(twin.linkage, latches[np.argsort(twin.hinges)], DENSITY, twin.panels[3], base=base)
        assert one.frequencies == pytest.approx(other.frequencies, rel=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_balanced_moments_change_the_energy_of_closed_states_by_their_stiffness(name):
    linkage = linkage_named(name)
    jacobian = linkage.closure(linkage.flat)[1]
    moments = jacobian.T @ np.random.default_rng(3).normal(size=len(jacobian))
    stiffness = geometric_stiffness(linkage, moments)
    errors = []
    for distance in (1e-2, 1e-3):
        closed = np.array(closed_states_near_flat(linkage, 10, distance))
        energies, expected = closed @ moments, 0.5 * np.einsum("ki,ij,kj->k", closed, stiffness, closed)
        errors.append(np.abs(energies - expected).max() / distance**2)
    assert errors[1] < 0.2 * errors[0]  # what is left is of third order


def test_moments_raise_frequencies_or_lower_them():
    linkage = linkage_named("thesis-4x4")
    jacobian = linkage.closure(linkage.flat)[1]
    moments = 0.05 * jacobian.T @ np.random.default_rng(3).normal(size=len(jacobian))
    plain = modes_of(linkage).eigenvalues
    one, other = (modes_of(linkage, moments=sign * moments).eigenvalues for sign in (1.0, -1.0))
    assert one == pytest.approx(modes_of(linkage, moments=moments).eigenvalues)
    # both matrices add up to twice that of the latches
    assert one[0] + other[0] <= 2.0 * plain[0] * (1.0 + 1e-12)
    assert one[-1] + other[-1] >= 2.0 * plain[-1] * (1.0 - 1e-12)
    assert np.abs(one / plain - 1.0).max() > 1e-3


def test_moments_without_balance_are_refused():
    linkage = linkage_named("thesis-4x4")
    with pytest.raises(HcsearchError, match="without balance"):
        modes_of(linkage, moments=np.full(linkage.n_hinges, 0.1))
    with pytest.raises(HcsearchError, match="give 12 finite ones"):
        modes_of(linkage, moments=np.ones(3))


def test_the_stiffness_of_a_flat_hinge_is_that_of_latch_and_spring():
    laws = [law_named(text) for text in ("free", "linear:0.1+0.2", "quadratic:0.02,0.03", "tape:0.2@0.05,0.03@0.01")]
    assert flat_stiffness(laws, np.array([1.0, 0.0, 0.0, 2.0])) == pytest.approx([1.0, 0.1, 0.02, 2.0 + 0.2 / 0.05])
    table = law_named("table:0.2@-1,0.1@0,0.3@2")
    step = 1e-7
    slope = (table.straight.moment(step) - table.straight.moment(0.0)) / step
    assert flat_stiffness([table], np.zeros(1)) == pytest.approx([slope], abs=1e-6)


@pytest.mark.parametrize("latches", [np.zeros(2), np.array([-1.0]), np.array([math.nan])])
def test_wrong_latches_are_refused(latches):
    with pytest.raises(HcsearchError, match="latch"):
        flat_stiffness([law_named("free")], latches)
    with pytest.raises(HcsearchError, match="latch"):
        flat_stiffness([law_named("free")], np.full(1, -1.0))


def test_wrong_numbers_of_stiffnesses_are_refused():
    with pytest.raises(HcsearchError, match="give 1 finite"):
        deployed_modes(strip(["top"]), np.ones(2), DENSITY, 0)
