"""One evaluation many times over, so that its time can be measured: a call from Python takes longer than it does."""

from __future__ import annotations

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.multibody.accelerations import DiscreteState, Mechanism, accelerate
from hcsearch.kernels.multibody.tree import Work


@compiled
def accelerate_often(
    mechanism: Mechanism, hold: DiscreteState, q: Reals, v: Reals, scale: float, times: int, work: Work, a: Reals
) -> None:
    """Evaluate the accelerations of one state so many times, as the stages of a step do; after `accelerate`."""
    for _ in range(times):
        accelerate(mechanism, hold, q, v, scale, False, work, a)
