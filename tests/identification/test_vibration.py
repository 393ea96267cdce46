"""Frequencies and damping ratios of free vibrations: laws, exactness, noise, and another method beside."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import curve_fit

from hcsearch.basics.errors import HcsearchError
from hcsearch.springs.identification.vibration import identify_modes
from hcsearch_bench.identification.rig import Rig

RATE = 200.0


def sinusoid(frequency, ratio, phase, time):
    omega = 2 * math.pi * frequency
    return np.exp(-ratio * omega * time) * np.cos(omega * math.sqrt(1 - ratio**2) * time + phase)


def poles(vibration):
    return [value for mode in vibration.modes for value in (mode.frequency, mode.damping)]


frequencies = st.floats(1.0, 60.0)
ratios = st.floats(0.005, 0.3)
phases = st.floats(0.0, 2 * math.pi)


@settings(max_examples=20)
@given(frequency=frequencies, ratio=ratios, phase=phases, offset=st.floats(-2.0, 2.0))
def test_without_noise_one_mode_comes_out_exactly(frequency, ratio, phase, offset):
    record = sinusoid(frequency, ratio, phase, np.arange(600) / RATE) + offset
    (mode,) = identify_modes(record, RATE).modes
    assert mode.frequency == pytest.approx(frequency, rel=1e-8)
    assert mode.damping == pytest.approx(ratio, rel=1e-8)
    assert mode.decay == pytest.approx(2 * math.pi * frequency * ratio, rel=1e-8)


@settings(max_examples=20)
@given(low=st.floats(1.0, 20.0), apart=st.floats(1.1, 3.0), ratios=st.tuples(ratios, ratios), seed=st.integers(0, 99))
def test_two_modes_are_told_apart(low, apart, ratios, seed):
    time = np.arange(600) / RATE
    sizes = np.random.default_rng(seed).uniform(0.3, 1.0, (2, 2))
    record = np.outer(sizes[0], sinusoid(low, ratios[0], 0.3, time))
    record += np.outer(sizes[1], sinusoid(apart * low, ratios[1], 1.0, time))
    assert poles(identify_modes(record, RATE)) == pytest.approx([low, ratios[0], apart * low, ratios[1]], rel=1e-6)


@settings(max_examples=10)
@given(factor=st.floats(1e-6, 1e6), seed=st.integers(0, 99))
def test_the_unit_of_the_accelerations_changes_nothing(factor, seed):
    record = Rig().record(0.01, seed)
    one, other = identify_modes(record, RATE), identify_modes(factor * record, RATE)
    assert poles(other) == pytest.approx(poles(one), rel=1e-9)
    assert other.noise == pytest.approx(factor * one.noise, rel=1e-6)
    assert [mode.share for mode in other.modes] == pytest.approx([mode.share for mode in one.modes], rel=1e-6)


@settings(max_examples=10)
@given(later=st.integers(0, 150), every=st.integers(1, 5))
def test_a_later_start_and_fewer_samples_change_nothing(later, every):
    rig = Rig()
    time = np.arange(1000) / RATE
    record = sinusoid(rig.frequency, rig.ratio, 0.7, time) + 0.3 * sinusoid(9.0, 0.02, 0.1, time)
    thin = record[later::every]
    assert poles(identify_modes(thin, RATE / every)) == pytest.approx([rig.frequency, rig.ratio, 9.0, 0.02], rel=1e-8)


def test_the_clock_scales_frequencies_and_not_damping_ratios():
    record = Rig().record(0.01, 1)
    slow, fast = identify_modes(record, RATE), identify_modes(record, 3.0 * RATE)
    assert [mode.frequency for mode in fast.modes] == pytest.approx([3.0 * mode.frequency for mode in slow.modes])
    assert [mode.damping for mode in fast.modes] == pytest.approx([mode.damping for mode in slow.modes])


def test_channels_may_come_in_any_order():
    record = Rig().record(0.01, 2)
    assert poles(identify_modes(record[::-1], RATE)) == pytest.approx(poles(identify_modes(record, RATE)), rel=1e-9)


def test_records_that_are_too_long_are_cut_and_thinned():
    time = np.arange(60_000) / 10_000.0
    exact = sinusoid(2.5, 0.1, 0.2, time)
    assert poles(identify_modes(exact, 10_000.0)) == pytest.approx([2.5, 0.1], rel=1e-8)
    # most of this record is noise after the vibration has died away
    long = Rig(seconds=60.0)
    mode = identify_modes(long.record(0.02, 3), long.rate).modes[0]
    assert mode.frequency == pytest.approx(long.frequency, rel=0.005)
    assert mode.damping == pytest.approx(long.ratio, rel=0.03)


@pytest.mark.parametrize("noise", [1e-4, 1e-3, 1e-2, 0.1])
def test_errors_grow_no_faster_than_the_noise_and_are_told(noise):
    rig = Rig()
    errors, stated = [], []
    for seed in range(12):
        vibration = identify_modes(rig.record(noise, seed), rig.rate)
        mode = vibration.modes[0]
        errors.append((mode.frequency / rig.frequency - 1, mode.damping / rig.ratio - 1))
        stated.append((mode.frequency_error / rig.frequency, mode.damping_error / rig.ratio))
        assert vibration.noise == pytest.approx(noise, rel=0.1)
    errors, stated = np.sqrt(np.mean(np.square(errors), axis=0)), np.mean(stated, axis=0)
    assert (errors < np.array([0.06, 0.6]) * noise).all()
    assert (errors < 1.6 * stated).all()
    assert (stated < np.array([0.05, 0.5]) * noise).all()


def test_no_mode_but_those_of_the_rig_is_told():
    for seed in range(12):
        for mode in identify_modes(Rig().record(0.03, seed), RATE).modes:
            assert min(abs(mode.frequency / true - 1) for true in (Rig().frequency, 33.72, 89.64)) < 0.01


def test_noise_and_drift_alone_have_no_modes():
    random = np.random.default_rng(4)
    for _ in range(3):
        white = random.standard_normal((2, 800))
        assert identify_modes(white, RATE).modes == ()
        assert identify_modes(np.cumsum(white, axis=1), RATE).modes == ()
    assert identify_modes(np.arange(800.0), RATE).modes == ()


@pytest.mark.parametrize("disturbance", ["drift", "ramp", "hum"])
def test_the_swing_is_found_through(disturbance):
    rig, random = Rig(), np.random.default_rng(5)
    record = rig.record(0.005, 6)
    time = np.arange(record.shape[1]) / RATE
    record = (
        record
        + {
            "drift": np.cumsum(0.002 * random.standard_normal(record.shape), axis=1),
            "ramp": 0.05 * time,
            "hum": 0.02 * np.sin(2 * math.pi * 50 * time),
        }[disturbance]
    )
    mode = identify_modes(record, RATE).modes[0]
    assert mode.frequency == pytest.approx(rig.frequency, rel=0.01)
    assert mode.damping == pytest.approx(rig.ratio, rel=0.1)


def test_shares_are_of_the_energy():
    vibration = identify_modes(Rig().record(0.001, 7), RATE)
    assert sum(mode.share for mode in vibration.modes) == pytest.approx(1.0, abs=0.05)
    assert vibration.modes[0].share > 0.8


def test_a_fitted_sinusoid_says_the_same():
    rig = Rig()
    time = np.arange(1000) / RATE
    record = sinusoid(rig.frequency, rig.ratio, 0.4, time) + 0.02 * np.random.default_rng(8).standard_normal(1000)
    (mode,) = identify_modes(record, RATE).modes

    def model(time, size, frequency, ratio, phase):
        return size * sinusoid(frequency, ratio, phase, time)

    values, covariance = curve_fit(model, time, record, p0=(1.0, 2.4, 0.1, 0.3))
    fitted = np.sqrt(np.diag(covariance))
    assert abs(mode.frequency - values[1]) < fitted[1]
    assert abs(mode.damping - values[2]) < fitted[2]
    assert mode.frequency_error == pytest.approx(fitted[1], rel=0.05)
    assert mode.damping_error == pytest.approx(fitted[2], rel=0.05)


@pytest.mark.parametrize(
    ("record", "rate", "message"),
    [
        (np.zeros(63) + np.arange(63), RATE, "63 samples"),
        (np.full(100, np.nan), RATE, "not numbers"),
        (np.stack([np.arange(100.0), np.ones(100)]), RATE, "acceleration 1 is 1 all the time"),
        (np.arange(100.0), 0.0, "sampling rate of 0 Hz"),
        (np.arange(100.0), math.nan, "sampling rate"),
    ],
)
def test_wrong_records_are_refused(record, rate, message):
    with pytest.raises(HcsearchError, match=message):
        identify_modes(record, rate)
