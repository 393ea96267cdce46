"""Ways between panels through the tree of hinges, and the reaches along them, against networkx and random states."""

import itertools

import networkx as nx
import numpy as np
import pytest
from naive_clearance import chain, fan, hinged, pairs_looked_at

from hcsearch.motion.collision.panel_prisms import prisms_of, solid_pairs
from hcsearch.shape.linkage import Linkage
from tests.linkages import linkage_named

LINKAGES = {
    "chain": chain([0.02, 0.03, 0.02, 0.01, 0.04], ["top", "bottom", "bottom", "top"]),
    "chain held inside": Linkage(chain([0.02, 0.03, 0.02, 0.01], ["top", "top", "bottom"]).pattern, base=2),
    "branches": fan(),
    "branch held": Linkage(fan().pattern, base=3),
    "loop": linkage_named("hex:0234550132:4"),
    "loops and branches": linkage_named("thesis-4x4"),
    "several loops": linkage_named("unit-i"),
}


def tree_of(linkage):
    """The tree of hinges that places panels."""
    tree = nx.Graph()
    tree.add_nodes_from(range(linkage.n_panels))
    chain = linkage.chain
    for panel in chain.order:
        if chain.parents[panel] >= 0:
            tree.add_edge(int(chain.parents[panel]), int(panel), hinge=int(chain.hinges[panel]))
    assert nx.is_tree(tree)
    return tree


def way_between(pairs, one, two):
    """The hinges from one panel to another."""
    way = []
    while one != two:
        way.append(int(pairs.hinges[two, one]))
        one = int(pairs.nexts[two, one])
    return way


@pytest.mark.parametrize("apart", [False, True])
@pytest.mark.parametrize("name", LINKAGES)
def test_ways_are_those_of_the_tree(name, apart):
    linkage = LINKAGES[name]
    tree, panel = tree_of(linkage), linkage.pattern.panel_of
    left_out = hinged(linkage) if apart else set()
    pairs = solid_pairs(linkage, prisms_of(linkage), left_out)
    assert [tuple(pair) for pair in pairs.prisms] == pairs_looked_at(linkage, left_out)
    for f, g in pairs.prisms:
        path = nx.shortest_path(tree, panel[f], panel[g])
        assert way_between(pairs, panel[f], panel[g]) == [
            tree.edges[a, b]["hinge"] for a, b in itertools.pairwise(path)
        ]


@pytest.mark.parametrize("name", LINKAGES)
def test_no_corner_is_further_from_a_hinge_than_its_reach(name):
    linkage = LINKAGES[name]
    pairs = solid_pairs(linkage, prisms_of(linkage))
    rng = np.random.default_rng(5)
    panel, facets = linkage.pattern.panel_of, len(linkage.pattern.facets)
    greatest = np.zeros((facets, linkage.n_hinges))
    for _ in range(60):
        angles = rng.uniform(-np.pi, np.pi, linkage.n_hinges)
        poses, solids = linkage.poses(angles), linkage.solids(angles)
        corners = [solid.reshape(-1, 3) for solid in solids]
        for hinge, between in enumerate(linkage.pattern.hinges):
            # every hinge moves with the panels it joins
            pose = poses[between.first]
            point = pose[:, :3] @ linkage.points[hinge] + pose[:, 3]
            line = pose[:, :3] @ linkage.directions[hinge]
            away = [np.linalg.norm(np.cross(one - point, line), axis=1).max() for one in corners]
            np.maximum(greatest[:, hinge], away, out=greatest[:, hinge])
    in_tree = sorted(hinge for *_, hinge in tree_of(linkage).edges.data("hinge"))
    assert (greatest <= pairs.reaches * (1 + 1e-12))[:, in_tree].all()
    assert (np.delete(pairs.reaches, in_tree, axis=1) == 0.0).all()
    for f in range(facets):
        # of the hinge next to the prism it is exact
        for other in tree_of(linkage)[panel[f]]:
            hinge = way_between(pairs, panel[f], other)[0]
            assert greatest[f, hinge] == pytest.approx(pairs.reaches[f, hinge], rel=1e-12)


def test_tables_grow_with_the_square_of_the_panels():
    long = Linkage(chain([0.02] * 120, ["top", "bottom"] * 59 + ["top"]).pattern, base=60)
    pairs = solid_pairs(long, prisms_of(long))
    assert sum(table.nbytes for table in pairs) <= 4 * 120**2 * 8


def test_one_panel_has_no_pairs():
    one = chain([0.02], [])
    pairs = solid_pairs(one, prisms_of(one))
    assert pairs.prisms.shape == (0, 2)
    assert pairs.reaches.shape == (1, 0)
