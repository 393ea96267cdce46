"""Trees from several roots: paths through them are paths, and what they reach is what a search without contacts may."""

import math

import numpy as np
import pytest

from hcsearch.kernels.collision.gaps import deepest_overlap
from hcsearch.kernels.planning.space import new_space_work, new_state_stack
from hcsearch.kernels.planning.tree_search import add_state, new_tree
from hcsearch.motion.collision.panel_prisms import prisms_of
from hcsearch.motion.planning.planner import Forest, Planner, TreeConnection, _between, forest_roots
from hcsearch.motion.planning.problems import space_of
from hcsearch.motion.searching import Budget
from tests.planned import joined, open_by

BY_JUNCTIONS = "square:012123230301:0"
"""Its packed and flat state are joined by states of a junction's tree: searches of the two trees alone find no path."""


def test_junctions_give_a_path_that_two_trees_do_not_find():
    linkage = joined(BY_JUNCTIONS, "hinged")
    planner = Planner(linkage, 1e-4)
    assert all(planner.plan(Budget(100, seed=seed)).states is None for seed in range(3))
    plan = planner.plan(Budget(300, seed=100), roots=6)
    assert plan.states is not None
    assert plan.growth.roots > 0
    states = plan.states
    assert (states[0] == linkage.folded).all()
    assert (states[-1] == 0).all()
    assert open_by(linkage, states).max() < 1e-8
    assert states.min() >= 0
    assert states.max() <= math.pi
    assert np.abs(np.diff(states, axis=0)).max() <= 0.15
    assert deepest_overlap(linkage.chain, prisms_of(linkage, 1e-4), planner.space.pairs, states) == 0


def test_the_same_seed_gives_the_same_path_through_junctions():
    linkage = joined(BY_JUNCTIONS, "hinged")
    one = Planner(linkage, 1e-4).plan(Budget(300, seed=100), roots=6)
    planner = Planner(linkage, 1e-4)
    planner.plan(Budget(50, seed=4), roots=3)
    two = planner.plan(Budget(300, seed=100), roots=6)
    assert (one.states == two.states).all()
    assert one.growth == two.growth


@pytest.mark.parametrize("collide", [True, False])
def test_clouds_are_closed_states_of_both_ends(collide):
    linkage = joined("hex:0232335050:2", "hinged")
    plan = Planner(linkage, 1e-4, collide=collide).plan(Budget(100, seed=1), roots=4)
    assert plan.states is None
    assert tuple(map(len, plan.clouds)) == plan.growth.sizes
    for cloud, end in zip(plan.clouds, (linkage.folded, linkage.flat), strict=True):
        assert (cloud[0] == end).all()
        assert open_by(linkage, cloud).max() < 1e-8
        assert cloud.min() >= 0
        assert cloud.max() <= math.pi
    assert len(set(map(tuple, plan.clouds[0].tolist())) & set(map(tuple, plan.clouds[1].tolist()))) == 0


def test_panels_that_pass_through_each_other_join_what_contacts_keep_apart():
    """The first is blocked by contacts alone, the second by its loops and stops."""
    for name, joins in (("hex:0233435001:3", True), ("hex:0232335050:2", False)):
        linkage = joined(name, "hinged")
        assert (Planner(linkage, 1e-4, collide=False).plan(Budget(300)).states is not None) == joins
        assert Planner(linkage, 1e-4).plan(Budget(100)).states is None
        assert len(space_of(linkage, 1e-4, collide=False).pairs) == 0


def test_ways_within_a_tree_turn_back_at_the_last_common_state():
    tree = new_tree(10, np.zeros(1))
    for parent, angle in ((0, 1.0), (1, 2.0), (2, 3.0), (1, 4.0), (4, 5.0)):
        add_state(tree, parent, np.array([angle]))
    assert _between(tree, 3, 5).ravel().tolist() == [3, 2, 1, 4, 5]
    assert _between(tree, 5, 0).ravel().tolist() == [5, 4, 1, 0]
    assert _between(tree, 1, 3).ravel().tolist() == [1, 2, 3]
    assert _between(tree, 3, 3).ravel().tolist() == [3]
    assert _between(tree, 0, 0).ravel().tolist() == [0]


def test_a_path_goes_through_the_trees_that_met():
    """Packed met the third tree at its first state, and this met flat at its second, from flat's side."""
    linkage = joined("hex:0232335050:2", "hinged")
    space = space_of(linkage, 1e-4)
    states = np.arange(8.0)[:, None] * np.ones(linkage.n_hinges)
    roots = np.array([space.folded, linkage.flat, states[2]])
    forest = Forest(space, roots, new_state_stack(space, 4), new_space_work(space))
    add_state(forest.trees[2], 0, states[3])
    forest.joints = [TreeConnection((1, 2), (0, 1), states[5:4:-1]), TreeConnection((0, 2), (0, 0), states[6:7])]
    assert forest.path()[1:-1].tolist() == states[[6, 2, 3, 5]].tolist()


def test_seeds_take_all_junctions_in_turn():
    ends, junctions = (np.array([8.0]), np.array([9.0])), np.arange(5.0)[:, None]
    assert forest_roots(ends, junctions, 2, 0).ravel().tolist() == [8, 9, 0, 1]
    assert forest_roots(ends, junctions, 2, 2).ravel().tolist() == [8, 9, 4, 0]
    assert forest_roots(ends, junctions, 9, 1).ravel().tolist() == [8, 9, 0, 1, 2, 3, 4]
    assert forest_roots(ends, junctions[:0], 2, 1).ravel().tolist() == [8, 9]
