"""Laws of springs from moment-angle pairs: exactness, scale, choice of the law, hysteresis, intervals."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import linregress

from hcsearch.basics.errors import HcsearchError
from hcsearch.scenes.laws import law_named
from hcsearch.springs.identification.law_fitting import fit_spring
from hcsearch_bench.identification.rig import pairs

ANGLES = np.linspace(0.0, 2.7, 60)

stiffnesses = st.floats(0.01, 1.0)


@given(stiffness=stiffnesses, preload=st.floats(-0.5, 0.5))
def test_straight_lines_come_out_exactly(stiffness, preload):
    fits = {fit.kind: fit for fit in fit_spring(ANGLES, stiffness * ANGLES + preload).fits}
    estimates = fits["linear, preloaded"].estimates
    assert estimates["stiffness"].value == pytest.approx(stiffness, abs=1e-8)
    assert estimates["preload"].value == pytest.approx(preload, abs=1e-8)
    assert fits["linear, preloaded"].sufficient


@given(stiffness=stiffnesses, growth=st.floats(0.02, 1.0))
def test_parabolas_come_out_exactly(stiffness, growth):
    fits = {fit.kind: fit for fit in fit_spring(ANGLES, stiffness * ANGLES + growth * ANGLES**2).fits}
    estimates = fits["quadratic"].estimates
    assert estimates["stiffness"].value == pytest.approx(stiffness, abs=1e-8)
    assert estimates["growth"].value == pytest.approx(growth, abs=1e-8)
    assert fits["quadratic"].sufficient


@settings(max_examples=30)
@given(factor=st.floats(1e-3, 1e3), seed=st.integers(0, 99))
def test_moments_times_a_factor_give_the_law_times_it(factor, seed):
    angles, moments = pairs(law_named("quadratic:0.02,0.03"), 0.01, seed)
    one, other = fit_spring(angles, moments), fit_spring(angles, factor * moments)
    assert other.chosen.kind == one.chosen.kind
    for name, estimate in one.chosen.estimates.items():
        scaled = other.chosen.estimates[name]
        assert scaled.value == pytest.approx(factor * estimate.value, rel=1e-6, abs=1e-9 * factor)
        assert scaled.error == pytest.approx(factor * estimate.error, rel=1e-6)
    assert other.chosen.misfit == pytest.approx(one.chosen.misfit, rel=1e-5)


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("linear:0.1", "linear"),
        ("linear:0.1+0.02", "linear, preloaded"),
        ("linear:0.1-0.02", "linear, preloaded"),
        ("quadratic:0.02,0.03", "quadratic"),
        ("quadratic:0.02,0.03+0.05", "quadratic, preloaded"),
        ("table:0@0,0.1@1,0.15@2,0.4@2.8", "table"),
    ],
)
@pytest.mark.parametrize("noise", [0.0, 0.001, 0.01])
def test_the_simplest_law_that_suffices_is_chosen(text, kind, noise):
    law = law_named(text)
    chosen = fit_spring(*pairs(law, noise, 11)).chosen
    assert chosen.kind == kind
    assert law_named(chosen.law.text) == chosen.law
    moments = [(law.straight.moment(angle), chosen.law.straight.moment(angle)) for angle in ANGLES]
    greatest = max(abs(true) for true, _ in moments)
    bound = 0.01 if kind == "table" else 0.0
    assert max(abs(true - fitted) for true, fitted in moments) <= (bound + 1e-5 + noise) * greatest


def test_a_spring_that_stiffens_at_large_angles_is_no_line():
    # thesis 4.5.2 sees this in its springs and fits a line all the same
    moments = 0.1 * ANGLES + 0.1 * np.maximum(0.0, ANGLES - 2.0) ** 2
    spring = fit_spring(ANGLES, moments)
    line = spring.fits[0]
    assert not line.sufficient
    assert line.misfit > 0.02
    assert line.estimates["stiffness"].value > 0.1
    assert spring.chosen.kind == "table"


def test_intervals_are_those_of_a_regression():
    moments = 0.1 * ANGLES + 0.03 + 0.002 * np.random.default_rng(3).standard_normal(60)
    estimates = fit_spring(ANGLES, moments).chosen.estimates
    line = linregress(ANGLES, moments)
    assert estimates["stiffness"].value == pytest.approx(line.slope)
    assert estimates["stiffness"].error == pytest.approx(line.stderr)
    assert estimates["preload"].value == pytest.approx(line.intercept)
    assert estimates["preload"].error == pytest.approx(line.intercept_stderr)
    wide = estimates["stiffness"].high - estimates["stiffness"].low
    assert wide == pytest.approx(2 * 2.0017 * line.stderr, rel=1e-4)  # Student's t for 58 degrees of freedom


def test_intervals_hold_as_often_as_they_say():
    law = law_named("linear:0.1")
    held = 0
    for seed in range(200):
        stiffness = fit_spring(*pairs(law, 0.02, seed)).fits[0].estimates["stiffness"]
        held += stiffness.low < 0.1 < stiffness.high
    assert 180 <= held <= 198


@given(gap=st.floats(0.002, 0.05))
def test_the_gap_between_loading_and_unloading_is_told(gap):
    angles = np.concatenate([ANGLES, ANGLES[::-1]])
    moments = 0.1 * angles + np.repeat([gap / 2, -gap / 2], 60)
    spring = fit_spring(angles, moments)
    assert (spring.loading, spring.unloading) == (60, 60)
    assert spring.chosen.law.text == "linear:0.1"
    assert spring.chosen.estimates["hysteresis"].value == pytest.approx(gap, abs=1e-8)


def test_cycles_and_jitter_of_the_angle_are_told_from_turns():
    random = np.random.default_rng(9)
    angles = np.concatenate([ANGLES, ANGLES[::-1], ANGLES, ANGLES[::-1]])
    way = np.repeat([1.0, -1.0, 1.0, -1.0], 60)
    shaken = angles + random.uniform(-0.02, 0.02, angles.size)
    spring = fit_spring(shaken, 0.1 * shaken + 0.005 * way)
    assert spring.unloading == pytest.approx(120, abs=6)
    assert spring.chosen.estimates["hysteresis"].value == pytest.approx(0.01, rel=0.05)


def test_one_way_only_tells_no_hysteresis():
    for angles, counts in ((ANGLES, (60, 0)), (ANGLES[::-1], (0, 60))):
        spring = fit_spring(angles, 0.1 * angles)
        assert (spring.loading, spring.unloading) == counts
        assert set(spring.chosen.estimates) == {"stiffness"}
        assert spring.span == (0.0, 2.7)


def test_five_angles_are_enough():
    angles = np.array([0.0, 0.5, 1.0, 1.5, 2.0])
    assert fit_spring(angles, 0.1 * angles).chosen.law.text == "linear:0.1"


@pytest.mark.parametrize(
    ("angles", "moments", "message"),
    [
        ([0.0, 1.0, 2.0, 2.0, 1.0, 0.5], range(6), "4 different angles"),
        (range(6), [0.2] * 6, "0.2 N m at every angle"),
        ([0.0, 1.0, 2.0, 3.0, math.nan], range(5), "not numbers"),
        (range(5), [0.0, 1.0, 2.0, 3.0, math.inf], "not numbers"),
    ],
)
def test_wrong_pairs_are_refused(angles, moments, message):
    with pytest.raises(HcsearchError, match=message):
        fit_spring(np.array(angles, float), np.array(moments, float))
