"""Error bars of the default setting, and starts that differ by rounding."""

import numpy as np
import pytest

from hcsearch.scenes import Scene
from hcsearch.springs.accuracy.measured_accuracy import PERTURBATION, default_errors, perturbed
from hcsearch.springs.deployment.compiled_scene import compile_scene
from tests.accuracy.random_scenes import random_scene
from tests.accuracy.subjects import FOLDING, linkage_named


def test_a_smooth_motion_does_not_hang_on_rounding():
    compiled = compile_scene(linkage_named(FOLDING), Scene())
    errors = default_errors(compiled, 1e-6)
    assert errors.perturbed_until is None
    assert errors.estimates.angle < 1e-4
    assert errors.estimates.clearance.value == pytest.approx(errors.deployment.play.least_gap)


def test_a_start_is_changed_by_as_much_as_stated_and_within_the_stops():
    compiled = compile_scene(linkage_named(FOLDING), Scene())
    changed = perturbed(compiled)
    assert np.abs(changed.start - compiled.start).max() == pytest.approx(PERTURBATION, rel=1e-3)
    assert (changed.start < np.pi).all()


def test_impacts_that_hang_on_rounding_are_told():
    compiled = compile_scene(linkage_named("thesis-4x4"), Scene())
    errors = default_errors(compiled, 1e-6)
    assert errors.perturbed_until is not None
    assert 0.15 < errors.perturbed_until < 1.0


def test_motions_that_diverge_have_no_estimates():
    linkage, scene = random_scene(6)
    assert default_errors(compile_scene(linkage, scene), 1e-6).estimates is None
