import pytest

from hcsearch.basics.simulation_summaries import (
    SimulationAccuracy,
    TrialAccuracy,
    accuracy_of_trials,
    accuracy_sentences,
)

FLAT, LOOSE = TrialAccuracy(0.5, "deploys", 0.2, 1e-4), TrialAccuracy(0.3, "deploys", 0.5, 2e-3)
UNTIMED, COLLIDES = TrialAccuracy(0.4, "deploys", None, None), TrialAccuracy(0.4, "collides", None, None)


def test_shares_are_averaged_and_the_greatest_error_counts():
    accuracy = accuracy_of_trials([FLAT, LOOSE, COLLIDES])
    assert accuracy == SimulationAccuracy(pytest.approx(0.4), pytest.approx(4e-3), pytest.approx(2.25e-3), 2, 0)
    assert accuracy_sentences(accuracy) == (
        "left out: 40 % of the work of a simulation; error of 2 flat times at most 0.4 %, half of them at most 0.3 %",
    )


def test_errors_that_are_not_known_are_counted():
    (sentence,) = accuracy_sentences(accuracy_of_trials([FLAT, UNTIMED]))
    assert sentence.split("; ")[1:] == ["error of 1 flat time at most 0.05 %", "error of 1 flat time not known"]


def test_without_deployments_nothing_is_said():
    assert accuracy_sentences(accuracy_of_trials([])) == ()


@pytest.mark.parametrize(("error", "words"), [(0.00401, "0.5 %"), (0.0096, "1 %"), (0.123, "20 %"), (0.0, "0 %")])
def test_errors_are_rounded_up(error, words):
    (sentence,) = accuracy_sentences(SimulationAccuracy(None, error, error, 1, 0))
    assert sentence == f"error of 1 flat time at most {words}"
