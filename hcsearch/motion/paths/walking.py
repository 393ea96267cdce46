"""Steps along a motion: predicted, then corrected onto the closed states."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from hcsearch.basics.arrays import Reals
from hcsearch.motion.kinematics.closing import CLOSED_LOOP_RESIDUAL, correction
from hcsearch.motion.kinematics.local import LocalState, local_at
from hcsearch.motion.paths.predictors import PathStep, Predictor, arc_length
from hcsearch.shape.linkage import Linkage

MAX_CORRECTIONS = 12
MIN_TANGENT_COSINE = 0.7
"""The tangents at both ends of a step have a scalar product of at least this much."""


class Advance(NamedTuple):
    """A step: the state it leads to, how far off that was predicted (rad), and the order of the prediction."""

    step: PathStep
    error: float
    order: int


@dataclass
class Walker:
    """Takes steps with one predictor, and counts evaluations of the closure.

    corrections : Newton corrections a step; None for as many as closure needs.
    """

    linkage: Linkage
    predictor: Predictor
    corrections: int | None = None
    evaluations: int = field(default=0, init=False)

    def local(self, angles: Reals) -> LocalState:
        """What the linkage is like at a state."""
        self.evaluations += 1
        return local_at(self.linkage, angles)

    def advance(self, before: PathStep | None, last: PathStep, distance: float) -> Advance | None:
        """The state a distance on; None where there is none to be trusted."""
        predicted, velocity, order = self.predictor.predict(before, last, distance)
        self.evaluations += self.predictor.evaluations
        local = self._closed(predicted) if self.corrections is None else self._corrected(predicted, last.local.kept)
        if local is None:
            return None
        tangent = local.tangent(velocity)
        size = float(np.linalg.norm(tangent))
        if size < MIN_TANGENT_COSINE or tangent @ last.tangent < MIN_TANGENT_COSINE * size:
            return None
        step = PathStep(local, tangent / size, 0.0)
        # where the rank changes the acceleration is not known on one side
        length = arc_length(last, step) if local.kept == last.local.kept else distance
        if not 0.5 * distance < length < 2.0 * distance:  # fallen back or run ahead: on another branch
            return None
        error = float(np.linalg.norm(local.angles - predicted))
        return Advance(PathStep(local, step.tangent, last.length + length), error, order)

    def _closed(self, angles: Reals) -> LocalState | None:
        """The closed state nearest to a prediction; None where Newton's method finds none.

        Corrected once more than closure asks for: near a singular state the angles are known worse by the least
        singular value.
        """
        fine = 50 * np.finfo(float).eps * math.sqrt(self.linkage.n_hinges)
        polished = False
        for _ in range(MAX_CORRECTIONS):
            residual, jacobian = self._closure(angles)
            worst = float(np.abs(residual).max(initial=0.0))
            if worst <= fine or (polished and worst <= CLOSED_LOOP_RESIDUAL):
                return local_at(self.linkage, angles, closure=(residual, jacobian))
            if not math.isfinite(worst):
                return None
            polished = worst <= CLOSED_LOOP_RESIDUAL
            angles = angles + correction(jacobian, residual)
        return None

    def _corrected(self, angles: Reals, kept: int) -> LocalState | None:
        """A prediction after a fixed number of corrections, closed or not."""
        for _ in range(self.corrections or 0):
            residual, jacobian = self._closure(angles)
            angles = angles + correction(jacobian, residual)
        residual, jacobian = self._closure(angles)
        if not np.isfinite(residual).all():
            return None
        return local_at(self.linkage, angles, kept=kept, closure=(residual, jacobian))

    def _closure(self, angles: Reals) -> tuple[Reals, Reals]:
        self.evaluations += 1
        return self.linkage.closure(angles)
