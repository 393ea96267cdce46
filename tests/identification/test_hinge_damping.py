"""Damping coefficients of hinges: thesis table 4.2, and what its numbers say of each other."""

import json
import math
from pathlib import Path
from statistics import mean, stdev

import pytest

from hcsearch.basics.errors import HcsearchError
from hcsearch.springs.identification.vibration import Mode, hinge_damping, hinge_test

GOLDEN = json.loads((Path(__file__).parent.parent / "golden" / "thesis_table_4_2.json").read_text(encoding="utf-8"))


def coefficients():
    return [hinge_damping(f, zeta, GOLDEN["inertia"], GOLDEN["hinges"]) for f, _, zeta, _ in GOLDEN["tests"]]


def test_table_4_2_comes_out_to_its_last_digit():
    assert [round(c, 4) for c in coefficients()] == [row[3] for row in GOLDEN["tests"]]
    assert round(mean(coefficients()), 4) == GOLDEN["average"][3] == 0.0043
    assert round(stdev(coefficients()), 4) == GOLDEN["deviation"][3] == 0.0002


def test_its_damping_ratios_have_a_sample_deviation():
    ratios = [row[2] for row in GOLDEN["tests"]]
    assert round(mean(ratios), 3) == GOLDEN["average"][2]
    assert round(stdev(ratios), 3) == GOLDEN["deviation"][2]


def test_its_average_frequency_is_not_that_of_its_rows():
    frequencies, omegas = ([row[k] for row in GOLDEN["tests"]] for k in (0, 1))
    assert omegas == pytest.approx([2 * math.pi * f for f in frequencies], abs=2 * math.pi * 0.0005)
    for k, (values, digits) in enumerate(((frequencies, 3), (omegas, 2))):
        average, deviation = GOLDEN["departures"]["average"][k], GOLDEN["departures"]["deviation"][k]
        assert round(mean(values), digits) == average != GOLDEN["average"][k]
        assert round(stdev(values), digits) == deviation != round(GOLDEN["deviation"][k], digits)


def test_springs_and_weight_as_printed_do_not_make_its_frequencies():
    # no mass is further from an axis, in the mean, than its radius of gyration: so far at most hangs its weight
    arm = math.sqrt(GOLDEN["inertia"] / GOLDEN["block_mass"])
    most = GOLDEN["hinges"] * GOLDEN["stiffness"] + GOLDEN["block_mass"] * 9.81 * arm
    highest = math.sqrt(most / GOLDEN["inertia"]) / (2 * math.pi)
    assert highest < min(row[0] for row in GOLDEN["tests"])


def test_critical_damping_from_the_springs_alone_would_be_another():
    f, _, zeta, c = GOLDEN["tests"][0]
    assert 2 * zeta * GOLDEN["stiffness"] / (2 * math.pi * f) == pytest.approx(0.31 * c, rel=0.01)


def test_a_test_holds_coefficient_stiffness_and_errors():
    omega = math.sqrt(1.26 / 0.0051)
    mode = Mode(omega / (2 * math.pi), 0.1, 0.1 * omega, 0.01, 0.002, 0.02 * 0.1 * omega, 1.0)
    test = hinge_test(mode, 0.0051, 4)
    assert test.stiffness == pytest.approx(1.26)
    assert test.coefficient == pytest.approx(2 * 0.1 * math.sqrt(1.26 * 0.0051) / 4)
    assert test.coefficient_error == pytest.approx(0.02 * test.coefficient)
    assert (test.frequency, test.damping) == (mode.frequency, mode.damping)
    assert (test.frequency_error, test.damping_error) == (0.01, 0.002)


@pytest.mark.parametrize(("inertia", "hinges"), [(0.0, 4), (-1.0, 4), (math.nan, 4), (math.inf, 4), (0.0051, 0)])
def test_no_inertia_or_no_hinge_is_refused(inertia, hinges):
    with pytest.raises(HcsearchError, match="give"):
        hinge_damping(2.5, 0.1, inertia, hinges)
