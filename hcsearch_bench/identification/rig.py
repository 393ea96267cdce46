"""Made-up measurements with known truths: free vibrations of the thesis's rig (4.5.3), moments of a spring (4.5.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.scenes.laws import Law

MOST_ANGLE = 13.0 * math.pi / 15.0
"""Where the thesis's rig for springs ends, rad."""


@dataclass(frozen=True)
class Rig:
    """A block on equal hinges under a frame, with an accelerometer on each, as in the thesis.

    inertia : of the block about the hinges, kg m^2. stiffness : of all that drives it back, N m/rad.
    damping : of each hinge, N m s/rad. rate : of samples, Hz. seconds : of a record. The frame rings in two modes.
    """

    inertia: float = 0.0051
    stiffness: float = 1.26
    damping: float = 0.0043
    hinges: int = 4
    rate: float = 200.0
    seconds: float = 5.0

    @property
    def frequency(self) -> float:
        """Natural frequency of the swing, Hz: I x'' + N c x' + K x = 0."""
        return math.sqrt(self.stiffness / self.inertia) / (2.0 * math.pi)

    @property
    def ratio(self) -> float:
        """Damping ratio of the swing."""
        return self.hinges * self.damping / (2.0 * math.sqrt(self.stiffness * self.inertia))

    def record(self, noise: float, seed: int) -> Reals:
        """Accelerations of block and frame, shape (2, samples): at any phase, with offsets and white noise.

        noise : standard deviation, as a share of the swing's amplitude at the start.
        """
        random = np.random.default_rng(seed)
        time = np.arange(round(self.rate * self.seconds)) / self.rate
        modes = ((self.frequency, self.ratio, 1.0, 0.02), (33.72, 0.01, 0.2, 0.1), (89.64, 0.008, 0.1, 0.08))
        accelerations = np.tile(random.uniform(-0.1, 0.1, (2, 1)), len(time))
        for frequency, ratio, block, frame in modes:
            omega = 2.0 * math.pi * frequency
            wave = np.exp(-ratio * omega * time)
            wave *= np.cos(omega * math.sqrt(1.0 - ratio**2) * time + random.uniform(0.0, 2.0 * math.pi))
            accelerations += np.outer([block, frame], wave)
        return np.asarray(accelerations + noise * random.standard_normal(accelerations.shape))


def pairs(law: Law, noise: float, seed: int) -> tuple[Reals, Reals]:
    """Angles at every degree (rad) and moments (N m) of a spring that is loaded and unloaded, with white noise.

    noise : standard deviation, as a share of the greatest moment.
    """
    random = np.random.default_rng(seed)
    up = np.arange(0.0, MOST_ANGLE, math.pi / 180.0)
    angles = np.concatenate([up, up[::-1]])
    moments = np.array([law.straight.moment(angle) for angle in angles])
    return angles, moments + noise * abs(moments).max() * random.standard_normal(len(angles))
