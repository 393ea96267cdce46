"""Drives against friction: their torques by its work, and their simulation, which sticks where the course begins."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.integrate import trapezoid

from hcsearch.designs.folding import Folding
from hcsearch.scenes import SCENES
from hcsearch.springs.drive.driven_folding import drive_along, find_drive_motion

FRICTION = 0.05


@cache
def drive_of(name, friction):
    folding, scene = Folding.from_notation(name), replace(SCENES["default"], friction=friction)
    return drive_along(folding, scene, find_drive_motion(folding, scene))


@pytest.mark.parametrize("name", ["hex:0234550132:4", "square:012230:1"])
def test_motors_do_the_work_of_friction_on_the_way(name):
    free, slowed = drive_of(name, 0.0).torques, drive_of(name, FRICTION).torques
    assert slowed.driven == free.driven
    assert np.array_equal(slowed.angles, free.angles)
    work = trapezoid(slowed.power - free.power, free.times)
    assert work == pytest.approx(FRICTION * trapezoid(np.abs(free.rates), free.times, axis=0).sum(), rel=1e-6)
    assert slowed.imbalance < 1e-5 * np.ptp(slowed.stored)
    resisting = (slowed.hinge_moments - free.hinge_moments) * free.rates
    assert resisting == pytest.approx(FRICTION * np.abs(free.rates), abs=1e-9)


@pytest.mark.parametrize("name", ["hex:0234550132:4", "square:012230:1"])
def test_motors_under_control_follow_their_course_against_friction(name):
    found = drive_of(name, FRICTION)
    facts, driven = found.facts(), found.deployment.driven
    assert facts["verdict"] == "deploys"
    assert facts["follows"]
    assert facts["missed_rad"] < 1e-3
    assert driven.drift < 1e-6 * driven.motion.largest_energy
    assert {event.kind for event in driven.motion.events} <= {"stuck", "slips"}
    travelled = np.abs(np.diff(driven.motion.q, axis=0)).sum()
    taken = driven.motion.damped[-1]
    assert taken > FRICTION * travelled
