"""Trees of panels: nothing lost or counted twice, and closed, where the linkage is, in the same places."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch import enumerate_circuits
from hcsearch.designs.folding import foldings
from hcsearch.kernels.multibody import sweeps, welds
from hcsearch.kernels.multibody.tree import WORK_PLACE, WORK_ROTATION, work_for
from hcsearch.motion.kinematics.closing import close_linkage
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.dynamics.body_trees import GROUND, joined_body
from hcsearch.springs.dynamics.panels import panel_bodies, panel_tree
from hcsearch.springs.dynamics.system import JointDrive, System

SIZE = (0.05, 0.05, 0.006)
DENSITY = 1200.0


@cache
def some_foldings():
    arrays = [("square", 8), ("square", 12), ("hex", 10), ("triangle", 14)]
    return [f for grid, n in arrays for circuit in enumerate_circuits(grid, n=n) for f in foldings(circuit)]


@st.composite
def linkages(draw):
    """A linkage that holds a panel of any number."""
    folding = draw(st.sampled_from(some_foldings()))
    pattern = folding.pattern(SIZE, flat_pairs=draw(st.sampled_from(["rigid", "hinged", "merged"])))
    return Linkage(pattern, base=draw(st.integers(0, len(pattern.panels) - 1)))


def placed(linkage, angles):
    """The tree, and its work tables in a state of the linkage."""
    tree = panel_tree(linkage, DENSITY, held=linkage.base)
    drives = tuple(JointDrive() for _ in tree.joints)
    system = System(tree.joints, tree.bodies, drives, tree.welds, size=linkage.pattern.size)
    q = np.zeros(len(tree.joints))
    q[tree.joint_of] = angles
    work = work_for(system.mechanism.tree)
    sweeps.place_bodies(system.mechanism.tree, q, work)
    return tree, system.mechanism.tree, work


@settings(max_examples=30)
@given(linkages())
def test_all_panels_but_the_held_one_hang_in_the_tree_once(linkage):
    tree = panel_tree(linkage, DENSITY, held=linkage.base)
    panels = panel_bodies(linkage, DENSITY)
    mass = DENSITY * linkage.pattern.thickness * linkage.pattern.area
    assert sum(panel.mass for panel in panels) == pytest.approx(mass)
    loose = joined_body(panel for k, panel in enumerate(panels) if k != linkage.base)
    body = joined_body(tree.bodies)
    assert body.mass == pytest.approx(loose.mass)
    assert body.centre == pytest.approx(loose.centre, abs=1e-12)
    assert body.inertia == pytest.approx(loose.inertia, rel=1e-9, abs=1e-15)
    assert tree.body_of[linkage.base] == GROUND
    assert (np.sort(tree.joint_of) == np.arange(linkage.n_hinges)).all()
    assert len(tree.welds) == len(linkage.loops)


@settings(max_examples=30)
@given(linkages(), st.integers(0, 99))
def test_panels_are_where_the_linkage_has_them_and_welds_are_closed(linkage, seed):
    rng = np.random.default_rng(seed)
    near = close_linkage(linkage, linkage.folded * rng.uniform(0.9, 1.0) + 0.02 * rng.uniform(-1, 1, linkage.n_hinges))
    for angles in (linkage.flat, linkage.folded, *([near.angles] if near.closed else [])):
        tree, table, work = placed(linkage, angles)
        assert welds.weld_errors(table, work, work.errors) < 1e-10
        poses = linkage.poses(angles)
        panel_of = {body: panel for panel, body in enumerate(tree.body_of) if panel != linkage.base}
        panel_of |= {weld.second: panel_of[weld.first] for weld in tree.welds}
        for body, panel in panel_of.items():
            turn = work.bodies[body, WORK_ROTATION : WORK_ROTATION + 9].reshape(3, 3)
            assert turn == pytest.approx(poses[panel][:, :3], abs=1e-9)
            shift = work.bodies[body, WORK_PLACE : WORK_PLACE + 3] - turn @ tree.joints[body].point
            assert shift == pytest.approx(poses[panel][:, 3], abs=1e-9)


@settings(max_examples=30)
@given(linkages(), st.integers(0, 99))
def test_welds_open_where_the_linkage_does(linkage, seed):
    angles = np.random.default_rng(seed).uniform(0.1, 3.0, linkage.n_hinges)
    residual, _ = linkage.closure(angles)
    _, table, work = placed(linkage, angles)
    opened = welds.weld_errors(table, work, work.errors) > 1e-6
    assert opened == (np.abs(residual).max(initial=0.0) > 1e-6)
