"""Latch and release: which hinges wait for which."""

import numpy as np

from hcsearch.deployment.deploying import compile_driven
from hcsearch.deployment.scales import settled
from hcsearch.drive.latches import Latch, latches_on, release
from hcsearch.scenes import SCENES
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
    linkage = linkage_named("hex:0234435011:1")
    scene = settled(SCENES["default"], linkage)
    compiled = compile_driven(linkage, scene, None)
    latch = Latch(3, 6, 2.0)
    found = release(compiled, (latch,))
    waits = found.angles[:, 6] > 2.0 + 0.1
    start = compiled.start[compiled.joint_of]
    assert (found.angles[waits, 3] >= start[3] - 1e-9).all()
    assert found.outcome in {"flat", "moving", "at rest", "jammed", "diverged"}
