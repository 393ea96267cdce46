"""Solutions of the problems A01 to A05 from reduced equations of motion, which share nothing with the engines.

Each gives the place of the measured point, (k, 3) in m, at times (k,) in s that begin with 0. A motion is solved once
for all times up to its end.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from hcsearch.basics.array_values import Reals

Solution = Callable[[Reals], Reals]
"""Values, one row a time, at times (k,), s."""

GRAVITY = 9.81
_NEXT, _LAST = [1, 2, 0], [2, 0, 1]
"""Components of a vector, from the next and from the last one on."""

ANGLES = ("beta", "theta", "gamma", "phi", "delta", "omega", "epsilon")
SQUEEZER_START = (
    -0.0617138900142764496358948458001,
    0.0,
    0.455279819163070380255912382449,
    0.222668390165885884674473185609,
    0.487364979543842550225598953530,
    -0.222668390165885884674473185609,
    1.23054744454982119249735015568,
)
_SQUEEZER_DATA = """
m1 0.04325 m2 0.00365 m3 0.02373 m4 0.00706 m5 0.07050 m6 0.00706 m7 0.05498
i1 2.194e-6 i2 4.410e-7 i3 5.255e-6 i4 5.667e-7 i5 1.169e-5 i6 5.667e-7 i7 1.912e-5
xa -0.06934 ya -0.00227 xb -0.03635 yb 0.03273 xc 0.014 yc 0.072 c0 4530.0
d 0.028 da 0.0115 e 0.02 ea 0.01421 rr 0.007 ra 0.00092 l0 0.07785 ss 0.035
sa 0.01874 sb 0.01043 sc 0.018 sd 0.02 ta 0.02308 tb 0.00916 u 0.04 ua 0.01228
ub 0.00449 zf 0.02 zt 0.04 fa 0.01421 mom 0.033
"""
_WORDS = _SQUEEZER_DATA.split()
SQUEEZER = {name: float(value) for name, value in zip(_WORDS[::2], _WORDS[1::2], strict=True)}
"""Andrews' squeezer: masses, inertias, geometry, spring and torque (SI); the angles are those of the IVP test set.

Source: E. Hairer and G. Wanner, Solving Ordinary Differential Equations II, section VII.7; IVP test set (CWI, Bari).
"""

BRICARD_CORNERS = ((0, 0, 0), (1, 0, 0), (1, -1, 0), (1, -1, 1), (0, -1, 1), (0, 0, 1))
BRICARD_AXES = (1, 2, 0, 1, 2, 0)


@dataclass(frozen=True)
class Governor:
    """A05: lengths m, angles rad, density kg/m^3, mass of a ball kg, N/m, Ns/m, rad/s."""

    length: float = 1.0
    section: float = 0.01
    cube: float = 0.1
    density: float = 3000.0
    ball: float = 5.0
    pivot: float = 0.05
    alpha: float = math.pi / 6
    slide: float = 0.5
    stiffness: float = 8e5
    damping: float = 4e4
    rest: float = 0.5
    spin: float = 2 * math.pi

    @property
    def rod(self) -> float:
        """Mass of a rod, and of the shaft."""
        return self.density * self.length * self.section**2


GOVERNOR = Governor()


def pendulum(times: Reals) -> Reals:
    """A01 by Jacobi's elliptic functions: a swing of 90 degrees."""
    from scipy.special import ellipj, ellipk

    part = 0.5  # square of the sine of half the amplitude
    sn, *_ = ellipj(ellipk(part) - math.sqrt(GRAVITY) * times, part)
    angle = 2 * np.arcsin(math.sqrt(part) * sn)
    return np.column_stack([-np.sin(angle), -np.cos(angle), 0 * times])


def four_bars(loops: int, times: Reals) -> Reals:
    """A02: the uprights stay parallel, and the bars between them level."""
    angle = _four_bars(loops, float(times[-1]))(times)[:, 0]
    return np.column_stack([np.sin(angle), np.cos(angle), 0 * times])


@cache
def _four_bars(loops: int, end: float) -> Solution:
    inertia, moment = (loops + 1) / 3 + loops, (loops + 1) / 2 + loops
    rate = GRAVITY * moment / inertia
    return solved(lambda _, y: (y[1], rate * math.sin(y[0])), [0.0, 1.0], end)


def squeezer(times: Reals) -> Reals:
    """A03: the pin of the crank."""
    beta = squeezer_angles(times)[:, 0]
    return SQUEEZER["rr"] * np.column_stack([np.cos(beta), np.sin(beta), 0 * times])


def squeezer_angles(times: Reals) -> Reals:
    """The seven angles, (k, 7): equations of index 1."""
    return _squeezer(float(times[-1]))(times)[:, :7]


@cache
def _squeezer(end: float) -> Solution:
    return solved(_squeezer_rate, [*SQUEEZER_START, *7 * [0.0]], end, tolerance=1e-12)


def _squeezer_rate(_: float, y: Reals) -> Reals:
    p = SQUEEZER
    be, th, ga, ph, de, om, ep = y[:7]
    bep, thp, gap, php, dep, omp, epp = y[7:]
    sin, cos = math.sin, math.cos
    e4, z6 = p["e"] - p["ea"], p["zf"] - p["fa"]
    mass = np.zeros((7, 7))
    mass[0, 0] = p["m1"] * p["ra"] ** 2 + p["i1"] + p["i2"]
    mass[0, 0] += p["m2"] * (p["rr"] ** 2 - 2 * p["da"] * p["rr"] * cos(th) + p["da"] ** 2)
    mass[0, 1] = mass[1, 0] = p["m2"] * (p["da"] ** 2 - p["da"] * p["rr"] * cos(th)) + p["i2"]
    mass[1, 1] = p["m2"] * p["da"] ** 2 + p["i2"]
    mass[2, 2] = p["m3"] * (p["sa"] ** 2 + p["sb"] ** 2) + p["i3"]
    mass[3, 3] = p["m4"] * e4**2 + p["i4"]
    mass[3, 4] = mass[4, 3] = p["m4"] * (e4**2 + p["zt"] * e4 * sin(ph)) + p["i4"]
    mass[4, 4] = p["m4"] * (p["zt"] ** 2 + 2 * p["zt"] * e4 * sin(ph) + e4**2) + p["i4"] + p["i5"]
    mass[4, 4] += p["m5"] * (p["ta"] ** 2 + p["tb"] ** 2)
    mass[5, 5] = p["m6"] * z6**2 + p["i6"]
    mass[5, 6] = mass[6, 5] = p["m6"] * (z6**2 - p["u"] * z6 * sin(om)) + p["i6"]
    mass[6, 6] = p["m6"] * (z6**2 - 2 * p["u"] * z6 * sin(om) + p["u"] ** 2) + p["i6"] + p["i7"]
    mass[6, 6] += p["m7"] * (p["ua"] ** 2 + p["ub"] ** 2)
    xd = p["sd"] * cos(ga) + p["sc"] * sin(ga) + p["xb"]
    yd = p["sd"] * sin(ga) - p["sc"] * cos(ga) + p["yb"]
    length = math.hypot(xd - p["xc"], yd - p["yc"])
    pull = -p["c0"] * (length - p["l0"]) / length
    fx, fy = pull * (xd - p["xc"]), pull * (yd - p["yc"])
    force = [
        p["mom"] - p["m2"] * p["da"] * p["rr"] * thp * (thp + 2 * bep) * sin(th),
        p["m2"] * p["da"] * p["rr"] * bep**2 * sin(th),
        fx * (p["sc"] * cos(ga) - p["sd"] * sin(ga)) + fy * (p["sd"] * cos(ga) + p["sc"] * sin(ga)),
        p["m4"] * p["zt"] * e4 * dep**2 * cos(ph),
        -p["m4"] * p["zt"] * e4 * php * (php + 2 * dep) * cos(ph),
        -p["m6"] * p["u"] * z6 * epp**2 * cos(om),
        p["m6"] * p["u"] * z6 * omp * (omp + 2 * epp) * cos(om),
    ]
    # vectors of the loops as complex numbers: pin = crank - bar 2 = end of bar 3 = end of bar 4 = end of bar 6
    crank, two = p["rr"] * _ray(be), p["d"] * _ray(be + th)
    three, four = -1j * p["ss"] * _ray(ga), -1j * p["e"] * _ray(ph + de)
    five, six, seven = p["zt"] * _ray(de), p["zf"] * _ray(om + ep), -1j * p["u"] * _ray(ep)
    row = np.zeros((3, 7), complex)
    row[:, 0], row[:, 1] = 1j * (crank - two), -1j * two
    row[0, 2] = -1j * three
    row[1, 3], row[1, 4] = -1j * four, -1j * (four + five)
    row[2, 5], row[2, 6] = -1j * six, -1j * (six + seven)
    first = -crank * bep**2 + two * (bep + thp) ** 2
    bias = np.array(
        [
            first + three * gap**2,
            first + four * (php + dep) ** 2 + five * dep**2,
            first + six * (omp + epp) ** 2 + seven * epp**2,
        ]
    )
    rows = np.vstack([row.real, row.imag])
    whole = np.block([[mass, rows.T], [rows, np.zeros((6, 6))]])
    solution = np.linalg.solve(whole, np.concatenate([force, -bias.real, -bias.imag]))
    return np.concatenate([y[7:], solution[:7]])


def _ray(angle: float) -> complex:
    return complex(math.cos(angle), math.sin(angle))


def bricard(section: float, times: Reals) -> Reals:
    """A04: the third corner; accelerations within the null space of the closure, whose rank is 4 always."""
    states = _bricard(section, float(times[-1]))(times)
    return np.array([_bricard_chain(y[:5], y[5:])[0][2] for y in states])


@cache
def _bricard(section: float, end: float) -> Solution:
    return solved(lambda _, y: _bricard_rate(section, y), np.zeros(10), end, tolerance=1e-12)


def _bricard_chain(q: Reals, v: Reals) -> tuple[Reals, Reals, Reals, Reals, Reals]:
    """Corners (6, 3), axes and spins, and the accelerations (corners, bodies) that velocities alone make."""
    corners, axes, spins = np.zeros((6, 3)), np.zeros((5, 3)), np.zeros((5, 3))
    drifts, spin_drifts = np.zeros((6, 3)), np.zeros((5, 3))
    fixed = np.array(BRICARD_CORNERS, float)
    turn, spin, spin_drift = np.eye(3), np.zeros(3), np.zeros(3)
    for k in range(5):
        axes[k] = turn[:, BRICARD_AXES[k]]
        i, j = ((1, 2), (2, 0), (0, 1))[BRICARD_AXES[k]]
        c, s = math.cos(q[k]), math.sin(q[k])
        own = np.eye(3)
        own[i, i] = own[j, j] = c
        own[j, i], own[i, j] = s, -s
        turn = turn @ own
        spin_drift = spin_drift + _cross(spin, axes[k]) * v[k]
        spin = spin + axes[k] * v[k]
        arm = turn @ (fixed[k + 1] - fixed[k])
        corners[k + 1] = corners[k] + arm
        drifts[k + 1] = drifts[k] + _cross(spin_drift, arm) + _cross(spin, _cross(spin, arm))
        spins[k], spin_drifts[k] = spin, spin_drift
    return corners, axes, spins, drifts, spin_drifts


def _cross(one: Reals, two: Reals) -> Reals:
    """Vector products along the last axis; that of NumPy takes ten times as long for single vectors."""
    product: Reals = one[..., _NEXT] * two[..., _LAST] - one[..., _LAST] * two[..., _NEXT]
    return product


def _bricard_rate(section: float, y: Reals) -> Reals:
    v = y[5:]
    corners, axes, spins, drifts, spin_drifts = _bricard_chain(y[:5], v)
    along, across = section**2 / 6, (1 + section**2) / 12
    mass, force = np.zeros((5, 5)), np.zeros(5)
    for k in range(5):  # rods of 1 kg and 1 m
        centre = (corners[k] + corners[k + 1]) / 2
        way = corners[k + 1] - corners[k]
        inertia = across * np.eye(3) + (along - across) * np.outer(way, way)
        turns = np.where(np.arange(5)[:, None] <= k, axes, 0.0)
        flows = _cross(turns, centre - corners[:5])
        couple = inertia @ spin_drifts[k] + _cross(spins[k], inertia @ spins[k])
        mass += flows @ flows.T + turns @ inertia @ turns.T
        force -= flows @ ((drifts[k] + drifts[k + 1]) / 2 + [0.0, GRAVITY, 0.0]) + turns @ couple
    rows = np.vstack([_cross(axes, corners[5] - corners[:5]).T, axes[:, 1:].T])
    bias = np.concatenate([drifts[5], spin_drifts[4][1:]])
    left, values, right = np.linalg.svd(rows)
    free = right[4]
    part = -right[:4].T @ ((left[:, :4].T @ bias) / values[:4])
    rate = free @ (force - mass @ part) / (free @ mass @ free)
    return np.concatenate([v, part + rate * free])


def governor(times: Reals) -> Reals:
    """A05: height of the slider; the rods mirror each other, and the spin follows from its momentum."""
    return np.column_stack([0 * times, 0 * times, _governor(float(times[-1]))(times)[:, 1]])


@cache
def _governor(end: float) -> Solution:
    d, m = GOVERNOR, GOVERNOR.rod
    cube = d.density * d.cube**3
    half, along, across = d.length / 2, m * d.section**2 / 6, m * (d.length**2 + d.section**2) / 12
    lift = across + m * half**2 + d.ball * d.length**2
    still = cube * d.cube**2 / 6 + m * d.section**2 / 6

    def spun(c: float, s: float) -> tuple[float, float]:
        """Inertia of both rods about the shaft, and its slope."""
        rod, ball = d.pivot + half * c, d.pivot + d.length * c
        whole = across * c * c + along * s * s + m * rod**2 + d.ball * ball**2
        return 2 * whole, -4 * s * ((across - along) * c + m * rod * half + d.ball * ball * d.length)

    momentum = (still + spun(math.cos(d.alpha), math.sin(d.alpha))[0]) * d.spin

    def rate(_: float, y: Reals) -> tuple[float, ...]:
        alpha, height, alpha_rate, speed = y.tolist()
        c, s = math.cos(alpha), math.sin(alpha)
        inertia, slope = spun(c, s)
        out, up = half * c + d.pivot - d.cube / 2, d.length - half * s - height
        spring = math.hypot(out, up)
        by_alpha, by_height = -half * (out * s + up * c) / spring, -up / spring
        growth = by_alpha * alpha_rate + by_height * speed
        pull = d.stiffness * (spring - d.rest) + d.damping * growth
        couple = 0.5 * slope * (momentum / (still + inertia)) ** 2 + 2 * GRAVITY * c * (m * half + d.ball * d.length)
        return alpha_rate, speed, (couple - 2 * pull * by_alpha) / (2 * lift), -GRAVITY - 2 * pull * by_height / cube

    return solved(rate, [d.alpha, d.slide, 0.0, 0.0], end, tolerance=1e-11)


def solved(
    rate: Callable[[float, Reals], Reals | tuple[float, ...]],
    start: Reals | list[float],
    end: float,
    tolerance: float = 1e-13,
) -> Solution:
    """States (k, n) at times (k,) from 0 to the end, by DOP853 of SciPy."""
    from scipy.integrate import solve_ivp

    solution = solve_ivp(rate, (0.0, end), start, "DOP853", dense_output=True, rtol=tolerance, atol=tolerance).sol

    def states(times: Reals) -> Reals:
        at_times: Reals = solution(times).T
        return at_times

    return states
