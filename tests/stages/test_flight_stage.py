"""The stage `flight`: figures of the motion that decides each folding's status, and of its ends alone without one."""

from dataclasses import replace

import numpy as np
import pytest

from hcsearch.designs.circuit import Circuit
from hcsearch.designs.records import CircuitBatch, FlightNumbers, StagedDesigns
from hcsearch.scenes import SCENES, Scene
from hcsearch.search.stages.order import STAGES, stages_until
from hcsearch.search.stages.stage import run_stages
from hcsearch.search.stages.statuses import folding_statuses

BUILT = Scene(
    "built", spring="linear:0.1+0.02", friction=0.002, latch_stiffness=50.0, stop_tolerance=1e-3, envelope="3U"
)
OF_TRAVEL = {"torque_margin", "torque_margin_at", "torque_margin_failed", "latch_torque", "latch_impulse"}
OF_ENDS = {"deployed_hz", "soft_modes", "self_stresses", "flatness_mm_per_mrad", "tilt", "mass", "area_per_volume"} | {
    *("stowed_length", "stowed_width", "stowed_height")
}


def staged(notations, scene):
    circuits = [Circuit.from_notation(notation).canonical() for notation in notations]
    words = np.array([circuit.word for circuit in circuits], np.int8)
    symmetry = np.array([circuit.symmetry for circuit in circuits], np.int16)
    batch = CircuitBatch(circuits[0].grid.name, words, symmetry)
    designs, _ = run_stages(
        StagedDesigns(batch, np.array([circuit.n_fixed for circuit in circuits])), stages_until("twist"), scene
    )
    untwisted = designs.twists == 0
    designs = designs.take(designs.with_folding(untwisted), untwisted)
    return run_stages(designs, [STAGES[name] for name in ("mobility", "motion", "deployment", "flight")], scene)[0]


@pytest.fixture(scope="module")
def designs():
    return staged(["hex:0234550132", "hex:0234435011"], BUILT)


def known(numbers: FlightNumbers) -> set[str]:
    return {name for name, value in numbers.items() if value is not None}


def test_what_moves_has_figures_of_its_travel(designs):
    statuses = folding_statuses(designs, BUILT)
    assert {"deploys", "movable"} <= set(statuses)
    for status, numbers in zip(statuses, designs.flight, strict=True):
        if status == "locked":
            assert numbers is None
        else:
            assert known(numbers) >= OF_ENDS
            assert (known(numbers) >= OF_TRAVEL) == (status in ("deploys", "movable"))


def test_a_margin_with_a_failed_spring_is_no_greater(designs):
    for numbers in designs.flight:
        if numbers is not None and numbers["torque_margin"] is not None:
            assert numbers["torque_margin_failed"] <= numbers["torque_margin"] * (1.0 + 1e-9)
            assert 0.0 <= numbers["torque_margin_at"] <= 1.0


def test_without_hardware_only_what_needs_none_is_known():
    designs = staged(["hex:0234550132"], SCENES["default"])
    for numbers in designs.flight:
        if numbers is not None and numbers["torque_margin"] is not None:
            assert numbers["torque_margin"] == 0.0, "linear springs have none when flat, whatever the friction"
            assert known(numbers).isdisjoint({"latch_torque", "clearance_ratio", "craft_clearance"})


def test_verdicts_do_not_depend_on_hardware_that_nothing_simulates():
    plain = staged(["hex:0234550132"], SCENES["default"])
    built = staged(
        ["hex:0234550132"], replace(SCENES["default"], latch_stiffness=50.0, stop_tolerance=1e-3, envelope="1U")
    )
    assert repr(built.motion.margin) == repr(plain.motion.margin)
    assert repr(built.deployment.clearance) == repr(plain.deployment.clearance)
    assert [one.reason for one in built.deployment.trials] == [one.reason for one in plain.deployment.trials]
