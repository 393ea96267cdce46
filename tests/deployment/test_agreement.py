"""What two simulations at neighbouring tolerances agree on."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, folding_of
from hcsearch.scenes import SCENES
from hcsearch.springs.deployment.agreement import (
    LOOSE_STATES_SHARE,
    SimulatedCheck,
    SimulationFindings,
    agreement_of_simulations,
    agreement_tolerances,
    confirm_deployment,
    simulations_to_confirm,
)
from hcsearch.springs.deployment.simulated_deployment import simulate_deployment

TIMES = st.floats(1e-6, 1e6)


def seen(time, tolerance=1e-6, outcome="flat", verdict="deploys", loose=0.0):
    return SimulationFindings(tolerance, outcome, verdict, time, loose)


def both(one, two, **changes):
    return agreement_of_simulations([seen(one), seen(two, 1e-7, **changes)])


@pytest.mark.parametrize(
    ("one", "two", "time", "reason"),
    [
        (0.140987, 0.140988, 0.141, "flat after 0.1410 s"),
        (1.747, 1.601, 2.0, "flat after 2 s"),
        (1.554, 1.555, 1.55, "flat after 1.55 s"),
        (0.11666, 0.11644, 0.12, "flat after 0.12 s"),
        (1.24999, 1.25001, 1.25, "flat after 1.250 s"),
        (0.99999, 1.00001, 1.0, "flat after 1.000 s"),
        (0.95, 1.04, 1.0, "flat after about 1 s (0.95 s at tolerance 1e-6, 1 s at 1e-7)"),
        (0.73228, 1.2132, None, "flat, at a time on which tolerances disagree by more than a tenth"),
        (1.6, 2.4, None, "flat, at a time on which tolerances disagree by more than a tenth"),
        (1234.5, 1230.9, 1230.0, "flat after 1230 s"),
        (0.0, 0.0, 0.0, "flat after 0 s"),
    ],
)
def test_times_have_the_digits_that_agree(one, two, time, reason):
    check = both(one, two)
    assert (check.verdict, check.flat_time, check.reason) == ("deploys", time, reason)


@given(TIMES, st.floats(-0.04, 0.04))
def test_the_agreed_time_is_as_far_from_both_as_its_digits_say(time, share):
    other = time * (1.0 + share)
    found = both(time, other)
    assert found.flat_time == both(other, time).flat_time
    assert abs(found.flat_time - time) <= 0.51 * max(time, other)
    if share == 0.0:
        assert found.flat_time == float(f"{time:.3e}")


def test_other_outcomes_leave_it_open():
    found = both(1.5, 0.63, outcome="jammed", verdict="undecided")
    assert (found.verdict, found.flat_time) == ("undecided", None)
    start = "branch-singular: flat at tolerance 1e-6, jammed at 1e-7; the motion passes a state where"
    assert found.reason.startswith(start)
    assert both(1.5, 1.5, verdict="collides").verdict == "undecided"
    assert both(1.5, 1.5, verdict="collides").reason.endswith("but deploys at tolerance 1e-6, collides at 1e-7")
    hits = agreement_of_simulations([seen(1.5, verdict="collides"), seen(0.6, 1e-7, "jammed", "collides")])
    assert (hits.verdict, hits.flat_time) == ("collides", None)


def test_branches_of_singular_states_leave_it_open():
    assert both(1.5, 1.5, loose=0.9 * LOOSE_STATES_SHARE).verdict == "deploys"
    loose = both(1.5, 1.5, loose=0.25)
    assert (loose.verdict, loose.flat_time, loose.outcome) == ("undecided", None, "branch-singular")
    assert loose.reason.startswith("branch-singular: loops stay open at 10% of its states or more")
    assert loose.reason.endswith(": take the compliant formulation")
    # the same word and sentence whichever way it went
    for ending in ("at rest", "moving", "jammed", "diverged", "out of steps"):
        found = agreement_of_simulations([seen(0.3, outcome=ending, verdict="undecided", loose=0.25)])
        assert (found.verdict, found.flat_time, found.outcome, found.reason) == (
            *("undecided", None, "branch-singular"),
            loose.reason,
        )
    hits = agreement_of_simulations([seen(1.5, verdict="collides", loose=0.25), seen(1.5, verdict="collides")])
    assert hits.verdict == "collides"


def test_what_jams_or_diverges_is_compared_as_what_becomes_flat():
    jams, diverges, comes_flat = (
        [seen(0.5, t, ending, "undecided") for t in (1e-6, 1e-7)] for ending in ("jammed", "diverged", "flat")
    )
    assert agreement_of_simulations(jams) is None
    assert agreement_of_simulations(diverges) is None
    assert agreement_of_simulations([seen(0.5, 1e-6, "jammed", "collides"), seen(1.5, verdict="collides")]) is None
    for pair in ((jams[0], diverges[1]), (diverges[0], jams[1]), (diverges[0], comes_flat[1])):
        found = agreement_of_simulations(pair)
        assert (found.verdict, found.flat_time, found.outcome) == ("undecided", None, "branch-singular")
        assert found.reason.startswith(f"branch-singular: {pair[0].outcome} at tolerance 1e-6, {pair[1].outcome} at ")
        assert found.reason.endswith(": take other springs, or the compliant formulation")


def test_the_neighbours_are_tolerances_that_there_are():
    assert agreement_tolerances(1e-6) == pytest.approx((1e-7, 1e-8))
    assert agreement_tolerances(1e-6, "penalty") == pytest.approx((1e-7,))
    assert agreement_tolerances(1e-11) == pytest.approx((1e-12, 1e-13))
    assert agreement_tolerances(1e-12) == pytest.approx((1e-11, 1e-10))


@pytest.mark.parametrize(
    ("name", "crease", "verdict"),
    [
        ("hex:0234550132", 4, "deploys"),
        ("hex:0223335500", 0, "undecided"),  # flat at 1e-6 and 1e-7, diverged at 1e-8, or as rounding has it
        ("hex:0122334550", 1, "undecided"),
    ],
)
def test_motions_along_branches_of_singular_states_are_found(name, crease, verdict):
    linkage = folding_of(Circuit.from_notation(name).canonical(), crease).linkage()
    found = simulate_deployment(linkage, SCENES["default"])
    assert (found.outcome, found.verdict) == ("flat", "deploys")
    agreement = confirm_deployment(found)
    assert agreement.verdict == verdict
    assert agreement.reason.startswith("branch-singular: ") == (verdict == "undecided")
    assert len(agreement.others) == 2


def test_what_the_tightest_tolerance_confirms_is_simulated_no_further():
    linkage = Folding.from_notation("hex:0234550132:4").linkage()
    exact, rough = (simulate_deployment(linkage, SCENES["default"], tolerance=at) for at in (1e-6, 1e-3))
    assert rough.outcome == "flat"
    assert exact.motion.events
    smooth, rough = (replace(one, motion=replace(one.motion, events=())) for one in (exact, rough))

    def tolerances(*outcomes, first=smooth):
        """The tolerances of all simulations; outcomes : at 1e-8 and at 1e-7."""
        endings = iter(outcomes)

        def simulated(tolerance):
            return SimulatedCheck(tolerance, replace(exact.check, outcome=next(endings)), exact)

        start = SimulatedCheck(1e-6, first.check, first)
        return [simulation.tolerance for simulation in simulations_to_confirm(start, simulated)]

    assert tolerances("flat") == pytest.approx([1e-6, 1e-8])
    assert tolerances("jammed", "flat") == pytest.approx([1e-6, 1e-7, 1e-8])
    assert tolerances("flat", "flat", first=exact) == pytest.approx([1e-6, 1e-7, 1e-8])
    assert tolerances("flat", "flat", first=rough) == pytest.approx([1e-6, 1e-7, 1e-8])


def test_what_does_not_come_flat_is_not_simulated_again():
    linkage = Folding.from_notation("hex:023350:1").linkage()
    assert confirm_deployment(simulate_deployment(linkage, replace(SCENES["default"], seconds=0.02))) is None
