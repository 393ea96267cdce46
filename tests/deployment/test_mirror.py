"""Mirrors of patterns against a search over all axes through the middle."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, foldings
from hcsearch.designs.grid import GRIDS
from hcsearch.library.assemblies import ASSEMBLIES
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.dynamics.panels import mirror_of
from tests.strategies import circuits

NAMES = sorted(set(ASSEMBLIES) - {"modules-ii-five", "modules-i-four-b", "modules-i-four-c", "modules-i-four-d"})


def assembly(name):
    return Linkage(ASSEMBLIES[name].build(ASSEMBLIES[name].defaults))


def key(points):
    # shifted, as corners of kites lie half way between two steps, where rounding would choose
    return frozenset(map(tuple, np.rint(points * 1e5 + 0.2371).astype(int).tolist()))


def mirrors(linkage, held):
    """All mirrors through the middle that keep pattern and panel, and no hinge in them: their normals."""
    pattern = linkage.pattern
    middle = np.mean([np.mean(facet, axis=0) for facet in pattern.facets], axis=0)
    facets = [np.array(facet) - middle for facet in pattern.facets]
    number = {key(facet): k for k, facet in enumerate(facets)}
    found = []
    farthest = max((corner for facet in facets for corner in facet), key=np.linalg.norm)
    for corner in {tuple(np.round(corner, 9)) for facet in facets for corner in facet}:
        normal = np.array(corner) - farthest
        if np.linalg.norm(normal) < 1e-6:
            normal = np.array([-farthest[1], farthest[0]])
        normal = normal / np.linalg.norm(normal)
        images = [number.get(key(facet - 2 * np.outer(facet @ normal, normal))) for facet in facets]
        if None in images:
            continue
        creases = {tuple(sorted((images[i], images[j]))): crease for (i, j), crease in pattern.creases.items()}
        if creases != dict(pattern.creases):
            continue
        panels = [pattern.panel_of[images[parts[0]]] for parts in pattern.panels]
        if panels[held] == held and not any(panels[hinge.first] == hinge.second for hinge in pattern.hinges):
            found.append(normal)
    return found


def check(linkage, held):
    """A mirror is found just where there is one, and is one of them; it maps onto and back."""
    found, all_of_them = mirror_of(linkage, held), mirrors(linkage, held)
    assert (found is None) == (not all_of_them)
    if found is None:
        return False
    assert any(abs(abs(normal @ found.normal[:2]) - 1.0) < 1e-6 for normal in all_of_them)
    assert np.linalg.norm(found.normal) == pytest.approx(1.0)
    assert found.normal[2] == 0.0
    assert found.panels[held] == held
    assert [found.panels[image] for image in found.panels] == list(range(linkage.n_panels))
    assert [found.hinges[image] for image in found.hinges] == list(range(linkage.n_hinges))
    for hinge, image in zip(linkage.pattern.hinges, (linkage.pattern.hinges[k] for k in found.hinges), strict=True):
        assert {found.panels[hinge.first], found.panels[hinge.second]} == {image.first, image.second}
        assert (hinge.face, hinge.closes) == (image.face, image.closes)
    for panel, image in enumerate(found.panels):
        # of two images one lies beyond, and none that is its own
        assert found.beyond[panel] + found.beyond[image] == (panel != image)
    return True


@pytest.mark.parametrize("name", NAMES)
def test_assemblies_have_the_mirrors_that_a_search_finds(name):
    linkage = assembly(name)
    for panel in range(linkage.n_panels):
        check(linkage, panel)


def test_the_thesis_array_has_one():
    assert check(assembly("thesis-4x4"), 0)


@settings(max_examples=60)
@given(st.data(), st.sampled_from(["rigid", "hinged", "merged"]))
def test_foldings_have_the_mirrors_that_a_search_finds(data, flat_pairs):
    found = foldings(data.draw(circuits(even=True)))
    if not found:
        return
    linkage = data.draw(st.sampled_from(found)).linkage(flat_pairs=flat_pairs)
    for panel in range(linkage.n_panels):
        check(linkage, panel)


@pytest.mark.parametrize("name", ["square:012230:1", "square:01222300:3", "square:0122230301:3", "hex:0122334550:1"])
def test_foldings_with_mirror_pairs_have_a_mirror(name):
    folding = named(name)
    assert folding.mirror_pairs
    assert check(folding.linkage(), folding.linkage().base)


@pytest.mark.parametrize("name", ["hex:023350:1", "hex:0234550132:4"])
def test_chiral_patterns_have_none(name):
    linkage = named(name).linkage()
    assert not named(name).mirror_pairs
    assert not any(check(linkage, panel) for panel in range(linkage.n_panels))


def test_a_folding_of_kites_has_the_mirror_that_a_search_finds():
    circuit = Circuit(GRIDS["kite"], (0, 9, 11, 13, 21, 14, 19, 23, 3, 7))
    linkage = next(one for one in foldings(circuit) if one.crease == 2).linkage()
    assert any(check(linkage, panel) for panel in range(linkage.n_panels))


def test_a_mirror_needs_the_held_panel_in_it():
    linkage = named("square:012230:1").linkage()
    assert [panel for panel in range(4) if check(linkage, panel)] == [1, 3]


def test_a_mirror_stays_where_the_sheet_is_turned_or_moved():
    linkage = assembly("thesis-4x4")
    normal = mirror_of(linkage, 0).normal
    for turn in (0.3, 2.0):
        moved = Linkage(linkage.pattern.moved(turn, (0.7, -0.2)))
        assert check(moved, 0)
        x, y, _ = mirror_of(moved, 0).normal
        turned = (math.cos(turn) * normal[0] - math.sin(turn) * normal[1]) * x
        turned += (math.sin(turn) * normal[0] + math.cos(turn) * normal[1]) * y
        assert abs(turned) == pytest.approx(1.0)


def named(name):
    return Folding.from_notation(name)
