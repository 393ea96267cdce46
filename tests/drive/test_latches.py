"""Latch and release: which hinges wait for which."""

from dataclasses import replace

import numpy as np

from hcsearch.designs.folding import Folding
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.scenes import SCENES
from hcsearch.scenes.setup import setup_of_scene
from hcsearch.springs.deployment.simulated_deployment import compile_driven
from hcsearch.springs.drive.driven_folding import Latch, latches_on, simulate_latched
from tests.linkages import linkage_named


def test_a_hinge_that_leaves_late_waits_for_the_one_furthest_ahead():
    linkage = linkage_named("hex:0234435011:1")
    share = np.linspace(0.0, 1.0, 101)[:, None]
    angles = linkage.folded * (1.0 - share)
    late = np.flatnonzero(linkage.folded)[2]
    angles[:, late] = np.where(share[:, 0] < 0.5, np.pi, 2.0 * np.pi * (1.0 - share[:, 0]))
    (latch,) = latches_on(linkage, angles)
    assert latch.hinge == late
    assert 1.4 < latch.angle < 1.6
    assert latches_on(linkage, linkage.folded * (1.0 - share)) == ()


def test_latched_hinges_stay_until_they_are_let_go():
    folding = Folding.from_notation("square:012233330111:4")
    linkage = folding.linkage(default_panel("square"), flat_pairs="hinged")
    compiled = compile_driven(linkage, setup_of_scene(replace(SCENES["default"], flat_pairs="hinged"), linkage), None)
    latches = (Latch(7, 6, 2.53), Latch(9, 6, 2.15))
    deployment = simulate_latched(compiled, latches)
    start = compiled.start[compiled.joint_of]
    for latch in latches:
        let_go = int((deployment.angles[:, latch.waits_for] <= latch.angle).argmax())
        assert let_go > 0
        assert (deployment.angles[:let_go, latch.hinge] >= start[latch.hinge] - 1e-9).all()
        assert deployment.angles[let_go:, latch.hinge].min() < start[latch.hinge] - 0.1
