"""Results do not depend on the basis that a decomposition returns, on numbering, or on the last bit."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import scipy.linalg

from hcsearch.designs.folding import Folding
from hcsearch.library.assemblies.eight_r import unit_i, unit_ii
from hcsearch.library.assemblies.named_assembly import Parameters
from hcsearch.library.assemblies.squares import element_6r
from hcsearch.motion.kinematics.closing import ClosingResult
from hcsearch.motion.kinematics.local import LocalState, local_at
from hcsearch.motion.locks.end_locks import lock_at
from hcsearch.motion.paths import branches as branching
from hcsearch.motion.paths.branches import find_branches
from hcsearch.motion.paths.quadrics import MIN_CELL_RADIUS, cover_directions, solve_quadrics
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import Pattern

BUILD = {"I": unit_i, "II": unit_ii, "6R": element_6r}
ENDS = [(name, state, stops) for name in BUILD for state in ("folded", "flat") for stops in (False, True)]


@cache
def linkage(name):
    return Linkage(BUILD[name](Parameters()))


@cache
def known(name, state, stops):
    return find_branches(linkage(name), getattr(linkage(name), state), stops=stops)


def alike(result, other, places=slice(None), senses=(1.0,)):
    """Whether two searches have the same isolated branches with the same verdicts, and families of one kind.

    places : of the other's hinges. senses : in which a direction may be given.
    """
    kinds = [(r.nullity, r.stresses, {b.dimension for b in r.branches}) for r in (result, other)]
    ours, theirs = ([b for b in r.branches if not b.dimension] for r in (result, other))
    matches = [
        [i for i, t in enumerate(theirs) if np.abs(b.direction - sense * t.direction[places]).max() < 1e-6]
        for b in ours
        for sense in senses
    ]
    pairs = [(b, theirs[i]) for b, (i,) in zip(ours, [f for f in matches if f], strict=True)]
    verdicts = all((b.status, b.within_stops) == (t.status, t.within_stops) for b, t in pairs)
    return kinds[0] == kinds[1] and len(ours) == len(theirs) and verdicts


def orthogonal(m, seed):
    return np.linalg.qr(np.random.default_rng(seed).standard_normal((m, m)))[0]


@pytest.mark.parametrize("name", BUILD)
@pytest.mark.parametrize("state", ["folded", "flat"])
def test_the_basis_of_a_null_space_is_that_of_the_space(name, state):
    it = linkage(name)
    local = local_at(it, getattr(it, state))
    basis = local.null_space()
    assert np.abs(basis.T @ basis - np.eye(basis.shape[1])).max() < 1e-14
    assert np.abs(local.jacobian @ basis).max() < 1e-13
    for seed in range(3):
        turned = replace(local, right=orthogonal(local.kept_rank, seed) @ local.right)
        assert turned.null_space() == pytest.approx(basis, abs=1e-12)


@pytest.mark.parametrize(("name", "state", "stops"), ENDS)
def test_branches_are_the_same_in_every_basis(name, state, stops, monkeypatch):
    it = linkage(name)
    real, second_order = LocalState.null_space, branching.second_order_forms
    for seed in range(2):

        def basis(local, seed=seed):
            returned = real(local)
            return returned @ orthogonal(returned.shape[1], seed)

        def forms(local, basis, seed=seed):
            returned = second_order(local, basis)
            return np.einsum("kl,lij->kij", orthogonal(len(returned), seed), returned)

        monkeypatch.setattr(LocalState, "null_space", basis)
        monkeypatch.setattr(branching, "second_order_forms", forms)
        assert alike(known(name, state, stops), find_branches(it, getattr(it, state), stops=stops))


def renumbered(pattern, seed):
    """The same pattern with its facets in another order."""
    order = np.random.default_rng(seed).permutation(len(pattern.facets)).tolist()
    place = {old: new for new, old in enumerate(order)}
    facets = tuple(pattern.facets[old] for old in order)
    creases = {tuple(sorted((place[i], place[j]))): crease for (i, j), crease in pattern.creases.items()}
    return Pattern.from_polygons(facets, creases, pattern.thickness)


@pytest.mark.parametrize(("name", "state", "stops"), ENDS)
def test_branches_are_the_same_with_panels_numbered_otherwise(name, state, stops):
    it = linkage(name)
    other = Linkage(renumbered(it.pattern, 1))
    apart = np.linalg.norm(it.points[:, None] - other.points, axis=2)
    places = apart.argmin(axis=1)
    assert apart.min(axis=1).max() < 1e-12
    result = find_branches(other, getattr(other, state), stops=stops)
    assert alike(known(name, state, stops), result, places, (1.0,) if stops else (1.0, -1.0))


@pytest.mark.parametrize(("name", "state", "stops"), ENDS)
def test_branches_are_the_same_with_noise_in_the_last_bit(name, state, stops):
    other = Linkage(linkage(name).pattern)
    shake = np.random.default_rng(1).integers(-1, 2, other.points.shape) * np.finfo(float).eps
    vars(other)["points"] = other.points * (1.0 + shake)
    assert alike(known(name, state, stops), find_branches(other, getattr(other, state), stops=stops))


@pytest.mark.parametrize(
    ("distances", "power"),
    [
        ((2e-6, 3e-6, 4e-6, 0.0), math.inf),  # as a double root leaves them: rounding, and once nothing
        ((1.6e-3, 4e-4, 1e-4, 2.5e-5), 2.0),
        ((1.6e-4, 4e-5, 9e-6, 0.0), 2.0),  # the last two are blurred
        ((4e-3, 2e-3, 1e-3, 5e-4), 1.0),
    ],
)
def test_distances_that_closure_blurs_say_nothing(distances, power, monkeypatch):
    it = linkage("6R")
    left = iter(distances)

    def closed(_, line, max_steps):
        return ClosingResult(line + next(left) * np.eye(len(line))[0], 0.0, 1, True)

    monkeypatch.setattr(branching, "close_linkage", closed)
    fitted, _ = branching._nudged(local_at(it, it.flat), np.full(it.n_hinges, it.n_hinges**-0.5))
    assert fitted == pytest.approx(power, abs=1e-9)


def test_proofs_of_locks_are_as_good_in_every_basis(monkeypatch):
    it = Linkage(Folding.from_notation("hex:0233534001:3").pattern((0.05, 0.05, 0.006)))
    lock = lock_at(it, it.folded)
    assert lock.order == 2
    real = scipy.linalg.null_space
    for seed in range(3):

        def basis(matrix, seed=seed, **options):
            returned = real(matrix, **options)
            return returned @ orthogonal(returned.shape[1], seed)

        monkeypatch.setattr(scipy.linalg, "null_space", basis)
        assert lock_at(it, it.folded).margin == pytest.approx(lock.margin, rel=1e-6)


def planted(m, seed):
    """Random forms, no more than m of them, that vanish on some random unit vectors, and these."""
    rng = np.random.default_rng(seed)
    vectors = rng.standard_normal((int(rng.integers(1, m + 1)), m))
    vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)
    i, j = np.triu_indices(m)
    monomials = vectors[:, i] * vectors[:, j]
    vanishing = np.linalg.svd(monomials)[2][len(vectors) :]
    rows = rng.standard_normal((min(m, len(vanishing)), len(vanishing))) @ vanishing
    forms = np.zeros((len(rows), m, m))
    forms[:, i, j] = 0.5 * rows
    return forms + forms.transpose(0, 2, 1), vectors


@pytest.mark.parametrize("m", [2, 3, 4])
@pytest.mark.parametrize("seed", range(10))
def test_no_common_point_is_missed(m, seed):
    forms, vectors = planted(m, seed)
    solutions, reach = solve_quadrics(forms)
    listed = np.array([solution.vector for solution in solutions])
    apart = 1.0 - np.abs(vectors @ listed.T).max(axis=1)
    # what is part of a family is near one that is listed
    family = np.array([solution.dimension for solution in solutions]).max() > 0
    assert apart.max() < (0.05 if family else 1e-12)
    assert reach <= MIN_CELL_RADIUS or family


@pytest.mark.parametrize("both", [False, True])
@pytest.mark.parametrize("m", [2, 3, 4])
def test_a_cover_leaves_no_direction_out(m, both):
    everywhere = cover_directions(np.zeros((0, m, m)), None, both=both, slack=0.0)
    rng = np.random.default_rng(m)
    some = rng.standard_normal((300, m))
    some /= np.linalg.norm(some, axis=1, keepdims=True)
    cosines = some @ everywhere.centres.T
    nearest = (np.abs(cosines) if both else cosines).max(axis=1)
    assert nearest.min() >= math.cos(2.0 * math.asin(0.5 * everywhere.radius)) - 1e-12
    assert everywhere.radius < 0.5
