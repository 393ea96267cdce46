"""Penetration of prisms: the compiled search against all directions in NumPy, and states one knows."""

import math

import numpy as np
import pytest

from hcsearch.motion.collision.distances import cuts_through, first_cut
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import Crease, Pattern
from tests.linkages import linkage_named, penetration

NAMES = ("thesis-4x4", "unit-i", "element-8r")


def depth_of(one, two):
    """Least overlap of two prisms, (2, m, 3) each, along the normals of all faces and across all pairs of edges."""
    axes, sides = [], []
    for solid in (one, two):
        edges = [*(np.roll(solid[0], -1, axis=0) - solid[0]), solid[1, 0] - solid[0, 0]]
        axes += [*(np.cross(edge, edges[-1]) for edge in edges[:-1]), edges[-1]]
        sides.append(edges)
    axes += [np.cross(a, b) for a in sides[0] for b in sides[1]]
    least = math.inf
    for axis in axes:
        length = np.linalg.norm(axis)
        if length > 1e-6 * np.linalg.norm(sides[0][0]) ** 2:
            a, b = one.reshape(-1, 3) @ axis / length, two.reshape(-1, 3) @ axis / length
            least = min(least, a.max() - b.min(), b.max() - a.min())
    return least


def depths(linkage, angles, apart=()):
    """Depths of all pairs of panels that cut into each other."""
    solids, panels = linkage.solids(angles), linkage.pattern.panel_of
    depths = {}
    for i in range(len(solids)):
        for j in range(i + 1, len(solids)):
            pair = tuple(sorted((panels[i], panels[j])))
            if pair[0] != pair[1] and pair not in apart:
                depths[pair] = max(depths.get(pair, 0.0), depth_of(solids[i], solids[j]))
    return depths


@pytest.mark.parametrize("name", [*NAMES, "hex:02234400:1", "triangle:0123434501:1", "square:01222300:0"])
def test_the_deepest_cut_is_that_along_all_directions(name):
    linkage = linkage_named(name)
    rng = np.random.default_rng(len(name))
    hinged = {(hinge.first, hinge.second) for hinge in linkage.pattern.hinges}
    seen = 0
    for size in (0.05, 0.5, 3.0, 3.0, 3.0):
        angles = size * rng.normal(size=linkage.n_hinges)
        for apart in ((), hinged):
            expected = depths(linkage, angles, apart)
            worst = max(expected.values())
            cut = first_cut(linkage, angles[None], 0.0, apart)
            if cut is None:
                assert worst <= 1e-12
                continue
            assert cut.depth == pytest.approx(worst, abs=1e-12)
            assert expected[cut.panels] == pytest.approx(worst, abs=1e-12)
            seen += 1
    assert seen >= 5


@pytest.mark.parametrize("name", NAMES)
def test_the_first_of_many_states_is_the_first_that_cuts_too_deep(name):
    linkage = linkage_named(name)
    rng = np.random.default_rng(7)
    # back and forth about the flat state, wider and wider: directions that separated once are tried first
    swings = np.sin(np.arange(200) / 5)[:, None] * np.arange(200)[:, None] / 100 * rng.normal(size=linkage.n_hinges)
    allowed = 1e-3
    expected = next(k for k, angles in enumerate(swings) if max(depths(linkage, angles).values()) > allowed)
    cut = first_cut(linkage, swings, allowed)
    assert cut.state == expected > 0
    assert cut.depth == pytest.approx(max(depths(linkage, swings[expected]).values()))
    assert first_cut(linkage, swings[:expected], allowed) is None
    assert cuts_through(linkage, swings)


def test_packed_and_flat_panels_only_touch():
    linkage = linkage_named("thesis-4x4")
    for angles in (np.zeros(linkage.n_hinges), linkage.folded):
        assert penetration(linkage, angles) < 1e-12
        assert not cuts_through(linkage, angles[None])


def test_facets_may_have_different_numbers_of_corners():
    square = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
    triangle = ((1.0, 0.0), (2.0, 0.5), (1.0, 1.0))
    pattern = Pattern.from_polygons((square, triangle), {(0, 1): Crease("top")}, thickness=0.1)
    linkage = Linkage(pattern)
    for angle in (-0.3, 0.5, 3.0, math.pi + 0.1):
        expected = depth_of(*linkage.solids(np.array([angle])))
        assert penetration(linkage, np.array([angle])) == pytest.approx(max(0.0, expected), abs=1e-12)
    assert penetration(linkage, np.array([math.pi + 0.1])) > 1e-2


def test_nothing_is_looked_for_without_pairs():
    linkage = linkage_named("element-8r")
    n = linkage.n_panels
    everything = {(i, j) for i in range(n) for j in range(i + 1, n)}
    states = np.random.default_rng(1).normal(size=(3, linkage.n_hinges))
    assert first_cut(linkage, states, 0.0) is not None
    assert first_cut(linkage, states, 0.0, everything) is None
    assert first_cut(linkage, states[:0], 0.0) is None
