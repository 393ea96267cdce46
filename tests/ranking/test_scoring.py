"""The weighted score: its naive twin, and laws."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from naive_ranks import dominates, score

from hcsearch.basics.errors import QueryError
from hcsearch.search.ranking import complete_weights, weighted_score
from hcsearch.store.columns import DESIGN_QUANTITIES, RANKING_CRITERIA, VIEWS

NAMES = [quantity.name for quantity in RANKING_CRITERIA]
BETTER = [quantity.better for quantity in RANKING_CRITERIA]
HALVES = [quantity.half for quantity in RANKING_CRITERIA]

VALUES = st.one_of(st.none(), st.integers(0, 3), st.floats(-1.0, 30.0))
EXTREMES = st.one_of(VALUES, st.floats(allow_nan=False))
WEIGHTS = st.lists(st.floats(1e-3, 1e3), min_size=len(NAMES), max_size=len(NAMES))


def rows_of(values, most=8):
    return st.lists(st.lists(values, min_size=len(NAMES), max_size=len(NAMES)), min_size=1, max_size=most)


def scores(rows, weights):
    columns = dict(zip(NAMES, np.array(rows, float).T, strict=True))
    return weighted_score(columns, complete_weights(dict(zip(NAMES, weights, strict=True)))).tolist()


def test_criteria_are_those_that_designs_are_ranked_by():
    assert {(quantity.name, quantity.unit, quantity.better) for quantity in RANKING_CRITERIA} == {
        ("deployment_ratio", "", "higher"),
        ("dof", "", "lower"),
        ("symmetry", "", "higher"),
        ("needed_margin", "mm", "lower"),
        ("min_clearance", "mm", "higher"),
        ("deploy_time", "s", "lower"),
        ("error_angle", "rad", "lower"),
        ("error_time", "s", "lower"),
        ("hinges", "", "lower"),
        ("torque_margin", "", "higher"),
        ("torque_margin_failed", "", "higher"),
        ("deployed_hz", "Hz", "higher"),
        ("latch_torque", "N m", "lower"),
        ("clearance_ratio", "", "higher"),
        ("flatness_mm_per_mrad", "mm/mrad", "lower"),
        ("area_per_volume", "1/m", "higher"),
    }
    assert all(quantity.kind in ("integer", "real") and quantity.half > 0 for quantity in RANKING_CRITERIA)
    assert [quantity for quantity in DESIGN_QUANTITIES if quantity.better and quantity not in RANKING_CRITERIA] == [
        quantity
        for quantity in DESIGN_QUANTITIES
        if quantity.name
        in (
            *("dof_merged", "critical_margin", "least_gap", "score", "soft_modes", "latch_impulse", "self_stresses"),
            *("tilt", "stowed_height", "mass", "craft_clearance"),
        )
    ]


def test_a_criterion_has_one_unit_and_one_direction_in_all_views():
    listed = {(q.name, q.unit, q.better) for view in VIEWS.values() for q in view if q.name in NAMES}
    assert listed == {(quantity.name, quantity.unit, quantity.better) for quantity in RANKING_CRITERIA}


@given(rows_of(VALUES), WEIGHTS)
def test_score_is_the_plain_formula(rows, weights):
    expected = [score(row, weights, BETTER, HALVES) for row in rows]
    assert scores(rows, weights) == pytest.approx(expected, rel=1e-12, abs=1e-15)


def test_worth_of_half_is_a_half_and_of_the_best_is_one():
    assert scores([HALVES], [1.0] * len(NAMES)) == [0.5]
    best = [math.inf if way == "higher" else 0.0 for way in BETTER]
    worst = [0.0 if way == "higher" else math.inf for way in BETTER]
    assert scores([best, worst, [None] * len(NAMES)], [0.1] * len(NAMES)) == [1.0, 0.0, 0.0]


@given(rows_of(EXTREMES), WEIGHTS)
def test_a_dominated_row_never_scores_more(rows, weights):
    """Not even by a rounding error: each pair is also compared with one value made the least bit better."""
    better_by_a_bit = [
        [
            math.nextafter(v, math.inf if way == "higher" else -math.inf) if v is not None else 0.0
            for v, way in zip(row, BETTER, strict=True)
        ]
        for row in rows
    ]
    everyone = rows + better_by_a_bit
    totals = scores(everyone, weights)
    for a, p in zip(everyone, totals, strict=True):
        for b, q in zip(everyone, totals, strict=True):
            if dominates(a, b, BETTER):
                assert p >= q


@given(rows_of(VALUES, most=3), WEIGHTS, st.integers(0, len(NAMES) - 1))
def test_a_missing_value_is_never_an_advantage(rows, weights, gap):
    without = [[None if k == gap else value for k, value in enumerate(row)] for row in rows]
    assert all(p >= q for p, q in zip(scores(rows, weights), scores(without, weights), strict=True))


@given(rows_of(EXTREMES), WEIGHTS, st.integers(-900, 900))
def test_only_ratios_of_weights_count(rows, weights, power):
    scaled = [weight * 2.0**power for weight in weights]
    assert scores(rows, scaled) == scores(rows, weights)


@given(rows_of(EXTREMES), WEIGHTS)
def test_scores_lie_between_zero_and_one_and_do_not_depend_on_other_rows(rows, weights):
    shares = scores(rows, weights)
    assert all(0.0 <= value <= 1.0 for value in shares)
    assert [scores([row], weights)[0] for row in rows] == shares


def test_a_weight_of_zero_leaves_a_criterion_out():
    rows = [[1.0] * len(NAMES), [1.0, 5.0, *[1.0] * (len(NAMES) - 2)]]
    weights = dict.fromkeys(NAMES, 1.0) | {NAMES[1]: 0.0}
    first, second = scores(rows, list(weights.values()))
    assert first == second
    columns = dict(zip(NAMES, np.array(rows).T, strict=True))
    del columns[NAMES[1]]
    assert weighted_score(columns, weights).tolist() == [first, second]


def test_weights_that_are_not_given_are_one_or_none_for_figures_of_hardware_and_of_errors():
    unweighed = {"torque_margin", "torque_margin_failed", "deployed_hz", "latch_torque"}
    unweighed |= {"clearance_ratio", "flatness_mm_per_mrad", "area_per_volume", "error_angle", "error_time"}
    usual = {name: 0.0 if name in unweighed else 1.0 for name in NAMES}
    assert complete_weights({}) == usual
    assert complete_weights({"dof": 3, "deployed_hz": 2}) == usual | {"dof": 3.0, "deployed_hz": 2.0}
    assert list(complete_weights({"hinges": 2, "dof": 0})) == NAMES


@pytest.mark.parametrize(
    ("weights", "message"),
    [
        ({"doff": 1}, r"no criterion 'doff' \(did you mean dof\?\): weigh symmetry, dof, "),
        ({"n": 1}, "no criterion 'n': weigh"),
        ({"dof": -1}, "the weight -1 of dof is out of range: give 0 or more"),
        ({"dof": math.nan}, "the weight nan of dof"),
        ({"dof": math.inf}, "the weight inf of dof"),
        (dict.fromkeys(NAMES, 0), "give one criterion a positive weight"),
    ],
)
def test_weights_that_cannot_be(weights, message):
    with pytest.raises(QueryError, match=message):
        complete_weights(weights)
