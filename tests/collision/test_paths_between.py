"""Ways between panels through the tree of hinges, and the reaches along them, against networkx and random states."""

import itertools

import networkx as nx
import numpy as np
import pytest
from naive_clearance import chain, fan, hinged, pairs_looked_at

from hcsearch.collision.prisms import prisms_of
from hcsearch.collision.solids import pairs_of
from hcsearch.linkage import Linkage
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


@pytest.mark.parametrize("apart", [False, True])
@pytest.mark.parametrize("name", LINKAGES)
def test_ways_are_those_of_the_tree(name, apart):
    linkage = LINKAGES[name]
    tree, panel = tree_of(linkage), linkage.pattern.panel_of
    left_out = hinged(linkage) if apart else set()
    pairs = pairs_of(linkage, prisms_of(linkage), left_out)
    assert [tuple(pair) for pair in pairs.prisms] == pairs_looked_at(linkage, left_out)
    for (f, g), count, hinges in zip(pairs.prisms, pairs.lengths, pairs.hinges, strict=True):
        path = nx.shortest_path(tree, panel[f], panel[g])
        assert hinges[:count].tolist() == [tree.edges[a, b]["hinge"] for a, b in itertools.pairwise(path)]


@pytest.mark.parametrize("name", LINKAGES)
def test_no_corner_is_further_from_a_hinge_than_its_reach(name):
    linkage = LINKAGES[name]
    pairs = pairs_of(linkage, prisms_of(linkage))
    rng = np.random.default_rng(5)
    greatest = np.zeros((2, *pairs.beyond.shape))
    for _ in range(60):
        angles = rng.uniform(-np.pi, np.pi, linkage.n_hinges)
        poses, solids = linkage.poses(angles), linkage.solids(angles)
        corners = [solid.reshape(-1, 3) for solid in solids]
        away = np.empty((linkage.n_hinges, len(corners)))
        for hinge, between in enumerate(linkage.pattern.hinges):
            # every hinge moves with the panels it joins
            pose = poses[between.first]
            point = pose[:, :3] @ linkage.points[hinge] + pose[:, 3]
            line = pose[:, :3] @ linkage.directions[hinge]
            away[hinge] = [np.linalg.norm(np.cross(one - point, line), axis=1).max() for one in corners]
        for p, (f, g) in enumerate(pairs.prisms):
            way = pairs.hinges[p, : pairs.lengths[p]]
            for side, facet in enumerate((g, f)):
                distances = greatest[side, p, : len(way)]
                np.maximum(distances, away[way, facet], out=distances)
    on_the_way = np.arange(pairs.beyond.shape[1]) < pairs.lengths[:, None]
    for distances, reach, last in ((greatest[0], pairs.beyond, pairs.lengths - 1), (greatest[1], pairs.before, 0)):
        assert (distances <= reach * (1 + 1e-12))[on_the_way].all()
        # of the hinge next to the prism it is exact
        rows = np.arange(len(reach))
        assert distances[rows, last] == pytest.approx(reach[rows, last], rel=1e-12)
        assert (reach[~on_the_way] == 0.0).all()


def test_one_panel_has_no_pairs():
    one = chain([0.02], [])
    pairs = pairs_of(one, prisms_of(one))
    assert pairs.prisms.shape == (0, 2)
    assert pairs.hinges.shape == (0, 0)
