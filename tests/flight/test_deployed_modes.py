"""Modes of flat arrays: by hand, by inverse dynamics, by laws of scale, and against MuJoCo."""

import math

import numpy as np
import pytest
from scipy.linalg import eigh, null_space

from hcsearch.basics.errors import HcsearchError
from hcsearch.designs.folding import Folding
from hcsearch.motion.kinematics.local import local_at
from hcsearch.scenes import SCENES
from hcsearch.scenes.laws import law_named
from hcsearch.shape.labels import labels_of
from hcsearch.springs.deployment.compiled_scene import OMISSIONS, compile_scene
from hcsearch.springs.dynamics.inverse import joint_forces
from hcsearch.springs.flight.deployed_modes import deployed_modes, hinge_stiffness
from hcsearch.springs.flight.mass_matrix import mass_matrix
from hcsearch_bench.flight.frequency_rows import mujoco_frequencies
from tests.flight.arrays import SIDE, THICKNESS, strip
from tests.linkages import linkage_named
from tests.planned import planned

DENSITY = 547.0
NAMES = ("hex:0234550132:4", "hex:0234435011:1", "square:012233230011:4")


def linkage_of(name, way="hinged"):
    return Folding.from_notation(name).linkage(flat_pairs=way)


def naive_masses(linkage, angles, held):
    """The mass matrix by inverse dynamics, a column for each unit acceleration; of closed rates alone."""
    compiled = compile_scene(linkage, SCENES["default"], keep=frozenset(OMISSIONS))
    assert compiled.setup.held == held
    hinge_of = np.argsort(compiled.joint_of)
    n = linkage.n_hinges
    at, still = np.tile(angles[hinge_of], (n, 1)), np.zeros((n, n))
    return joint_forces(compiled.system, at, still, np.eye(n)[:, hinge_of]).joints[:, compiled.joint_of]


@pytest.mark.parametrize("name", [NAMES[0], NAMES[2]])
def test_the_mass_matrix_is_that_of_inverse_dynamics_on_closed_rates(name):
    sample = planned(name)
    linkage = sample.linkage
    held = compile_scene(linkage, SCENES["default"]).setup.held
    for state in (linkage.flat, linkage.folded, sample.states[len(sample.states) // 2]):
        basis = local_at(linkage, state).null_space()
        own = basis.T @ mass_matrix(linkage, state, DENSITY, held) @ basis
        if linkage.twin is None:
            naive = basis.T @ naive_masses(linkage, state, held) @ basis
            assert own == pytest.approx(naive, rel=1e-7, abs=1e-7 * np.abs(naive).max())
        assert np.linalg.eigvalsh(own).min() > 0.0


def test_one_hinge_swings_as_a_pendulum_does():
    linkage = strip(["top"])
    mass = DENSITY * SIDE * SIDE * THICKNESS
    # a plate about an axis on the face at its edge
    inertia = mass * (SIDE**2 + THICKNESS**2) / 12.0 + mass * ((0.5 * SIDE) ** 2 + (0.5 * THICKNESS) ** 2)
    modes = deployed_modes(linkage, np.array([3.0]), DENSITY, 0)
    assert modes.first == pytest.approx(math.sqrt(3.0 / inertia) / (2.0 * math.pi))
    assert (modes.soft_modes, modes.shapes.tolist()) == (0, [[1.0]])
    # two free panels swing against each other, each about the common axis: half the inertia felt, less what moves along
    free = deployed_modes(linkage, np.array([3.0]), DENSITY, None)
    centre = 0.25 * mass * (SIDE**2) / 2.0  # of both, about their common centre, which does not move
    assert free.first > modes.first
    assert centre > 0.0


@pytest.mark.parametrize("root", [0, None])
def test_an_open_chain_is_the_dense_problem(root):
    linkage = strip(["top", "bottom", "top"])
    stiffness = np.array([2.0, 3.0, 0.0])
    squares = eigh(np.diag(stiffness), mass_matrix(linkage, linkage.flat, DENSITY, root), eigvals_only=True)
    modes = deployed_modes(linkage, stiffness, DENSITY, root)
    assert modes.soft_modes == 1
    assert modes.frequencies == pytest.approx(np.sqrt(squares[1:]) / (2.0 * math.pi))


def test_the_kinetic_energy_of_a_free_chain_has_no_momentum():
    """Of all motions with the same rates the one with the least energy, by trying others."""
    linkage, rng = strip(["top", "bottom"]), np.random.default_rng(1)
    free = mass_matrix(linkage, linkage.flat, DENSITY, None)
    for root in range(linkage.n_panels):
        clamped = mass_matrix(linkage, linkage.flat, DENSITY, root)
        for rates in rng.normal(size=(20, 2)):
            assert rates @ free @ rates <= rates @ clamped @ rates * (1.0 + 1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_frequencies_follow_stiffness_and_density(name):
    linkage, rng = linkage_of(name), np.random.default_rng(0)
    stiffness = rng.uniform(50.0, 100.0, linkage.n_hinges)
    modes = deployed_modes(linkage, stiffness, DENSITY, 0)
    stiff, heavy = (
        deployed_modes(linkage, 4.0 * stiffness, DENSITY, 0),
        deployed_modes(linkage, stiffness, 4.0 * DENSITY, 0),
    )
    assert stiff.frequencies == pytest.approx(2.0 * modes.frequencies)
    assert heavy.frequencies == pytest.approx(0.5 * modes.frequencies)
    assert modes.soft_modes == 0
    assert len(modes.frequencies) == local_at(linkage, linkage.flat).nullity
    # a stiffer latch lowers no frequency, and a free array is nowhere slower than a clamped one
    for k in range(linkage.n_hinges):
        more = stiffness.copy()
        more[k] *= 2.0
        assert (deployed_modes(linkage, more, DENSITY, 0).frequencies >= modes.frequencies * (1.0 - 1e-9)).all()
    assert (deployed_modes(linkage, stiffness, DENSITY, None).frequencies >= modes.frequencies * (1.0 - 1e-9)).all()


@pytest.mark.parametrize("name", NAMES)
def test_the_first_frequency_is_the_least_of_all_closed_rates(name):
    linkage, rng = linkage_of(name), np.random.default_rng(0)
    stiffness = rng.uniform(50.0, 100.0, linkage.n_hinges)
    modes = deployed_modes(linkage, stiffness, DENSITY, 0)
    masses, jacobian = mass_matrix(linkage, linkage.flat, DENSITY, 0), linkage.closure(linkage.flat)[1]
    shape = modes.shapes[:, 0]
    assert np.abs(jacobian @ shape).max() < 1e-9
    square = (2.0 * math.pi * modes.first) ** 2
    assert (stiffness * shape**2).sum() / (shape @ masses @ shape) == pytest.approx(square)
    closed = null_space(jacobian, rcond=1e-9)
    for rates in (closed @ rng.normal(size=(closed.shape[1], 200))).T:
        assert (stiffness * rates**2).sum() / (rates @ masses @ rates) >= square * (1.0 - 1e-9)


def test_directions_without_a_stiff_latch_are_soft():
    linkage = linkage_of(NAMES[0])
    nullity = local_at(linkage, linkage.flat).nullity
    none = deployed_modes(linkage, np.zeros(linkage.n_hinges), DENSITY, 0)
    assert (none.soft_modes, none.first) == (nullity, None)
    one = np.zeros(linkage.n_hinges)
    one[0] = 100.0
    assert deployed_modes(linkage, one, DENSITY, 0).soft_modes == nullity - 1
    with pytest.raises(HcsearchError, match="one number of 0 or more"):
        deployed_modes(linkage, -one, DENSITY, 0)


def test_a_hinge_without_a_latch_has_the_slope_of_its_law():
    laws = [law_named(text) for text in ("linear:0.1+0.02", "quadratic:0.02,0.03", "table:0@0,0.1@1.5,0.3@3.1", "free")]
    latches = np.array([0.0, 0.0, 0.0, 0.0])
    slopes = [(law.straight.moment(1e-6) - law.straight.moment(-1e-6)) / 2e-6 for law in laws]
    assert hinge_stiffness(laws, latches) == pytest.approx(slopes, abs=1e-6)
    assert hinge_stiffness(laws, latches + 7.0).tolist() == [7.0] * 4


def test_frequencies_do_not_depend_on_how_a_folding_is_written():
    linkage = Folding.from_notation("hex:0223344000:4").linkage()
    twin = linkage.twin
    assert twin is not None
    stiffness = np.linspace(50.0, 90.0, linkage.n_hinges)
    of_twin = np.empty_like(stiffness)
    of_twin[list(twin.hinges)] = stiffness
    own = deployed_modes(linkage, stiffness, DENSITY, 2)
    other = deployed_modes(twin.linkage, of_twin, DENSITY, twin.panels[2])
    assert own.frequencies == pytest.approx(other.frequencies, rel=1e-8)
    assert len(labels_of(linkage).hinges) == linkage.n_hinges


@pytest.mark.extra
@pytest.mark.parametrize("name", [*NAMES, "thesis-4x4"])
def test_mujoco_has_the_same_frequencies(name):
    """Its own mass matrix, and its own Jacobian of the welds that close the loops."""
    pytest.importorskip("mujoco")
    linkage = linkage_named(name) if name == "thesis-4x4" else linkage_of(name)
    compiled = compile_scene(linkage, SCENES["default"], keep=frozenset(OMISSIONS))
    stiffness = np.random.default_rng(2).uniform(50.0, 100.0, linkage.n_hinges)
    own = deployed_modes(linkage, stiffness, compiled.setup.density, compiled.setup.held)
    assert own.frequencies == pytest.approx(mujoco_frequencies(compiled, stiffness), rel=1e-9)
