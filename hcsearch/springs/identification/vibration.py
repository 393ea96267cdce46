"""Identification of natural frequencies and damping ratios from free vibration, and of the damping of a hinge."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lstsq, qr
from scipy.signal import firwin, oaconvolve

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.springs.identification.measurements import MIN_VIBRATION_SAMPLES

ComplexNumbers = NDArray[np.complex128]

MAX_DECOMPOSED_SAMPLES = 2000
"""Samples to which longer records are cut and decimated: the time of the decomposition grows with their cube."""
DECAY_VARIANCE_SHARE = 0.8
"""A record still decays if its last quarter has less than this share of the variance of the quarter before."""
MAX_MODEL_ORDER = 20
MIN_STABLE_ORDERS = 10
"""Successive orders in which a physical pole must occur; poles of noise seldom occur in seven."""
FREQUENCY_TOLERANCE, DAMPING_TOLERANCE = 0.01, 0.05
"""Greatest relative changes of frequency and damping of such a pole from one order to the next."""
MIN_MODE_ASSURANCE = 0.95
"""Least modal assurance criterion of the shapes of a pole over the channels in successive orders."""
MIN_MODE_ENERGY_SHARE = 1e-6
"""Least share of the energy of a mode; aliases of higher modes after decimation have less."""
MIN_DAMPING_SIGNIFICANCE = 3.0
"""Least ratio of a mode's damping ratio to its standard error; most remaining poles of noise have less."""


@dataclass(frozen=True)
class Mode:
    """A damped sinusoid exp(-decay t) cos(2 pi frequency sqrt(1 - damping^2) t) common to all channels.

    frequency : natural (undamped) frequency, Hz. damping : damping ratio. decay : damping times angular frequency, 1/s.
    The three `_error`s are standard errors. share : of the energy of all channels about their means.
    """

    frequency: float
    damping: float
    decay: float
    frequency_error: float
    damping_error: float
    decay_error: float
    share: float


@dataclass(frozen=True)
class FreeVibration:
    """The modes of a record, lowest frequency first, and its noise: the rms residual, in the unit of the record."""

    modes: tuple[Mode, ...]
    noise: float


def identify_modes(accelerations: Reals, rate: float) -> FreeVibration:
    """Identify the modes of a free vibration by eigensystem realisation (Juang and Pappa 1985) with stable poles.

    accelerations : shape (channels, samples), in one unit, sampled evenly at `rate` Hz after the excitation has ended.
    The block Hankel matrix of damped sinusoids has the rank of the number of their poles. Its left singular vectors,
    shifted by one time step, equal the unshifted ones times the state matrix, whose eigenvalues exp(s / rate) give the
    frequency abs(s) / 2 pi and the damping ratio -Re s / abs(s) (Reynders 2012). One decomposition serves all orders
    up to 20.

    Departures from the thesis (4.5.3): it takes the frame's acceleration as the input of N4SID and filters below
    0.5 Hz. In free vibration the frame is only one more channel of the same poles; offset and drift have poles of their
    own, without a whole cycle in the record, so no filter is needed that would change the decay. Influences on the
    sensor (weight, its place on the block) change amplitudes, not poles.

    Standard errors are the Cramer-Rao bounds for white noise of the size of the residuals.
    Errors: HcsearchError for too few samples, numbers that are not finite, channels that are constant.
    """
    records = _lively(_checked(accelerations, rate))
    thinning = -(-records.shape[1] // MAX_DECOMPOSED_SAMPLES)
    if thinning > 1:
        records, rate = _thinned(records, thinning), rate / thinning
    poles = _physical_poles(records, rate)
    poles = poles[np.argsort(abs(poles))]
    # poles without a whole cycle in the record cannot be distinguished from drift
    poles = poles[abs(poles) * records.shape[1] > 2.0 * math.pi * rate]
    vibration = _described(records, rate, poles)
    sure = [
        mode.share > MIN_MODE_ENERGY_SHARE and mode.damping > MIN_DAMPING_SIGNIFICANCE * mode.damping_error
        for mode in vibration.modes
    ]
    return vibration if all(sure) else _described(records, rate, poles[sure])


def _checked(accelerations: Reals, rate: float) -> Reals:
    records = np.atleast_2d(np.asarray(accelerations, float))
    if not 0.0 < rate < math.inf:
        raise HcsearchError(f"a sampling rate of {rate:g} Hz: give a positive number")
    if not np.isfinite(records).all():
        raise HcsearchError("accelerations hold values that are not numbers: cut the record before or after them")
    if records.shape[1] < MIN_VIBRATION_SAMPLES:
        raise HcsearchError(f"{records.shape[1]} samples do not show a vibration: give {MIN_VIBRATION_SAMPLES} or more")
    for k, record in enumerate(records):
        if np.ptp(record) == 0.0:
            raise HcsearchError(f"acceleration {k} is {record[0]:g} all the time: leave out what was not measured")
    return records


def _lively(records: Reals) -> Reals:
    """Halve a long record as long as its last quarter does not decay any more and thus holds only noise."""
    while (samples := records.shape[1]) > MAX_DECOMPOSED_SAMPLES:
        third, fourth = np.array_split(records[:, samples // 2 :], 2, axis=1)
        if float(fourth.var(axis=1).sum()) < DECAY_VARIANCE_SHARE * float(third.var(axis=1).sum()):
            break
        records = records[:, : samples // 2]
    return records


def _thinned(records: Reals, factor: int) -> Reals:
    """Decimate records by a factor after a low-pass filter, whose transients at both ends are cut off."""
    low_pass = firwin(20 * factor + 1, 0.75 / factor, window=("kaiser", 8.0))
    return np.asarray(oaconvolve(records, low_pass[None, :], mode="valid", axes=1)[:, ::factor])


def _physical_poles(records: Reals, rate: float) -> ComplexNumbers:
    """Return decaying poles s (1/s, positive imaginary part) that are stable over many orders."""
    channels, samples = records.shape
    block_rows = samples // 2
    windows = np.lib.stride_tricks.sliding_window_view(records, samples - block_rows + 1, axis=1)
    hankel = windows.transpose(1, 0, 2).reshape(block_rows * channels, -1)
    singular_vectors, values, _ = np.linalg.svd(hankel, full_matrices=False)
    # orders beyond the rank of the matrix repeat the last one
    rank = int((values > values[0] * max(hankel.shape) * np.finfo(float).eps).sum())
    chains: list[_Chain] = []
    ended: list[_Chain] = []
    for order in range(1, MAX_MODEL_ORDER + 1):
        extended = []
        poles, shapes = _poles(singular_vectors[:, : min(order, rank)], channels, rate)
        for pole, shape in zip(poles, shapes, strict=True):
            near = [chain for chain in chains if _near(chain.pole, pole)]
            matching = [chain for chain in near if _likeness(chain.shape, shape) > MIN_MODE_ASSURANCE]
            previous = min(matching, key=lambda chain: abs(chain.pole - pole), default=None)
            if previous is not None:
                chains.remove(previous)
            extended.append(_Chain(pole, shape, 1 + (previous.length if previous else 0)))
        ended += chains
        chains = extended
    return np.array([chain.pole for chain in ended + chains if chain.length >= MIN_STABLE_ORDERS], complex)


@dataclass(frozen=True, eq=False)
class _Chain:
    """A pole, its shape over the channels, and the number of successive orders in which it has occurred."""

    pole: complex
    shape: ComplexNumbers
    length: int


def _poles(singular_vectors: Reals, channels: int, rate: float) -> tuple[ComplexNumbers, ComplexNumbers]:
    """Return decaying poles of one order with positive imaginary part, and their shapes over the channels, by rows."""
    state = lstsq(singular_vectors[:-channels], singular_vectors[channels:])[0]
    eigenvalues, vectors = np.linalg.eig(state)
    decaying = (eigenvalues.imag > 0.0) & (abs(eigenvalues) < 1.0)
    poles = rate * np.log(eigenvalues[decaying].astype(complex))
    ascending = np.argsort(abs(poles))
    return poles[ascending], (singular_vectors[:channels] @ vectors[:, decaying]).T[ascending]


def _near(first: complex, second: complex) -> bool:
    dampings = -first.real / abs(first), -second.real / abs(second)
    same_frequency = abs(abs(first) - abs(second)) < FREQUENCY_TOLERANCE * abs(second)
    return same_frequency and abs(dampings[0] - dampings[1]) < DAMPING_TOLERANCE * max(dampings)


def _likeness(first: ComplexNumbers, second: ComplexNumbers) -> float:
    return float(abs(np.vdot(first, second)) ** 2 / (np.vdot(first, first).real * np.vdot(second, second).real))


def _described(records: Reals, rate: float, poles: ComplexNumbers) -> FreeVibration:
    """Return the modes of poles with their shares and standard errors, from amplitudes fitted to the whole record."""
    time = np.arange(records.shape[1]) / rate
    waves = np.exp(np.outer(time, poles))
    columns = np.column_stack([np.ones(len(time)), waves.real, waves.imag])
    amplitudes = lstsq(columns, records.T)[0]
    residuals = records.T - columns @ amplitudes
    freedom = records.size - amplitudes.size - 2 * len(poles)
    noise = float(np.sqrt((residuals**2).sum() / freedom))
    errors = _pole_errors(time, waves, amplitudes, columns) * noise
    energy = float(((records - records.mean(axis=1, keepdims=True)) ** 2).sum())
    modes = []
    for k, pole in enumerate(poles):
        signal = columns[:, [1 + k, 1 + len(poles) + k]] @ amplitudes[[1 + k, 1 + len(poles) + k]]
        modes.append(_mode(complex(pole), errors[2 * k : 2 * k + 2], float((signal**2).sum()) / energy))
    return FreeVibration(tuple(modes), noise)


def _pole_errors(time: Reals, waves: ComplexNumbers, amplitudes: Reals, columns: Reals) -> Reals:
    """Return a root E of the covariance E E^T of decay and angular frequency of all modes, for unit noise."""
    count = waves.shape[1]
    basis = qr(columns, mode="economic")[0]
    slopes = []
    for amplitude in amplitudes.T:
        derivative = time[:, None] * waves * (amplitude[1 : 1 + count] - 1j * amplitude[1 + count :])
        slope = np.stack([-derivative.real, -derivative.imag], axis=2).reshape(len(time), -1)
        slopes.append(slope - basis @ (basis.T @ slope))
    triangle = qr(np.concatenate(slopes), mode="economic")[1]
    return np.asarray(np.linalg.inv(triangle))


def _mode(pole: complex, roots: Reals, share: float) -> Mode:
    """Return the mode of a pole; roots : its two rows of the root of the covariance."""
    size, decay, turning = abs(pole), -pole.real, pole.imag
    changes = np.array([[decay, turning], [turning**2 / size, -decay * turning / size]]) / size
    frequency_error, damping_error = np.linalg.norm(changes @ roots, axis=1)
    return Mode(
        frequency=size / (2.0 * math.pi),
        damping=decay / size,
        decay=decay,
        frequency_error=float(frequency_error) / (2.0 * math.pi),
        damping_error=float(damping_error) / size,
        decay_error=float(np.linalg.norm(roots[0])),
        share=share,
    )


MAX_TESTED_HINGES = 1000


@dataclass(frozen=True)
class HingeTest:
    """The result of one free vibration test: a row of thesis table 4.2.

    frequency : natural frequency, Hz. damping : damping ratio of the block. coefficient : of one hinge, N m s/rad.
    The three `_error`s are standard errors; `coefficient_error` leaves out the error of the inertia.
    stiffness : restoring moment on the block by angle, N m/rad: of springs, and of its weight where it hangs.
    """

    frequency: float
    damping: float
    coefficient: float
    frequency_error: float
    damping_error: float
    coefficient_error: float
    stiffness: float


def hinge_test(mode: Mode, inertia: float, hinges: int) -> HingeTest:
    """Return the damping of each of equal hinges (`hinge_damping`) from the mode of a block that swings on them."""
    coefficient = hinge_damping(mode.frequency, mode.damping, inertia, hinges)
    return HingeTest(
        frequency=mode.frequency,
        damping=mode.damping,
        coefficient=coefficient,
        frequency_error=mode.frequency_error,
        damping_error=mode.damping_error,
        coefficient_error=coefficient * mode.decay_error / mode.decay,
        stiffness=inertia * (2.0 * math.pi * mode.frequency) ** 2,
    )


def hinge_damping(frequency: float, damping: float, inertia: float, hinges: int) -> float:
    """Return the damping coefficient of each of a number of equal parallel hinges, N m s/rad (thesis eq. 4.27).

    frequency : natural frequency, Hz. damping : damping ratio. inertia : of the block about the hinges, kg m^2.
    The ratio times the critical damping 2 I omega is the damping of all hinges together; the thesis's 4 is `hinges`.
    The critical damping depends on the whole restoring moment, weight included, so that the inertia is needed and the
    springs' stiffness is not: 2 k / omega in place of 2 I omega holds where springs alone act, and gives a third of
    table 4.2.
    """
    if not 0.0 < inertia < math.inf:
        raise HcsearchError(f"a moment of inertia of {inertia:g} kg m^2: give a positive number")
    if not 1 <= hinges <= MAX_TESTED_HINGES:
        raise HcsearchError(f"a block on {hinges} hinges: give 1 to {MAX_TESTED_HINGES}")
    critical = 2.0 * inertia * 2.0 * math.pi * frequency
    return damping * critical / hinges
