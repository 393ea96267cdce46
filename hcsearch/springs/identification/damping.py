"""The damping coefficient of one hinge, from the free vibration of a block that swings on some (thesis 4.5.3)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hcsearch.basics.errors import HcsearchError
from hcsearch.springs.identification.vibration import Mode

MAX_TESTED_HINGES = 1000


@dataclass(frozen=True)
class HingeTest:
    """What one free vibration gives: a row of thesis table 4.2.

    frequency : natural frequency, Hz. damping : damping ratio of the block. coefficient : of one hinge, N m s/rad.
    The three `_error`s are standard errors; that of the coefficient leaves the inertia's out.
    stiffness : what drives the block back for each radian, N m/rad: springs, and its weight where it hangs.
    """

    frequency: float
    damping: float
    coefficient: float
    frequency_error: float
    damping_error: float
    coefficient_error: float
    stiffness: float


def hinge_test(mode: Mode, inertia: float, hinges: int) -> HingeTest:
    """The damping of each of so many hinges (`hinge_damping`) from the mode in which the block swings on them."""
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
    """Damping coefficient of each of so many equal hinges in parallel, N m s/rad (thesis eq. 4.27).

    frequency : natural frequency, Hz. damping : damping ratio. inertia : of the block about the hinges, kg m^2.
    The ratio times the critical damping 2 I omega is what all hinges give together; the thesis's 4 is `hinges`.
    Damping is critical for all that drives the block back, weight included, so that inertia is needed and the springs'
    stiffness is not: 2 k / omega in place of 2 I omega holds where springs alone drive, and gives a third of table 4.2.
    """
    if not 0.0 < inertia < math.inf:
        raise HcsearchError(f"a moment of inertia of {inertia:g} kg m^2: give a positive number")
    if not 1 <= hinges <= MAX_TESTED_HINGES:
        raise HcsearchError(f"a block on {hinges} hinges: give 1 to {MAX_TESTED_HINGES}")
    critical = 2.0 * inertia * 2.0 * math.pi * frequency
    return damping * critical / hinges
