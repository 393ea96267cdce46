"""What becomes of a deployment: how it ends, in which words, and which verdict follows."""

from __future__ import annotations

from hcsearch.dynamics.simulation import Ending
from hcsearch.vocabulary import Formulation, Integrator, Outcome, Verdict

FLAT = 0.01
"""The array is flat when every fold angle is within this of 0 (rad): 0.6 degrees."""
STILL = 1e-4
"""It is at rest when speeds and accelerations would move no hinge by more in the time left, or in 1 s (rad)."""
STEPS: dict[Formulation, int] = {"constrained": 20_000, "compliant": 100_000, "penalty": 400_000, "quasistatic": 20_000}
"""Steps until a simulation is given up; the thesis's springs need 140 for a millisecond."""
_OUTCOMES: dict[Ending, Outcome] = {
    "flat": "flat",
    "time": "moving",
    "rest": "at rest",
    "jammed": "jammed",
    "steps": "out of steps",
}


def outcome_of(ending: Ending) -> Outcome:
    """What an ending of a simulation means for a deployment."""
    return _OUTCOMES.get(ending, "diverged")


def verdict_of(outcome: Outcome, clear: bool | None) -> Verdict:
    """The verdict on a deployment; clear : None where it is undecided whether panels collide, or nobody asked.

    What a simulation says that diverges counts for nothing, collisions included.
    """
    if outcome == "diverged" or clear is None:
        return "undecided"
    if not clear:
        return "collides"
    return "deploys" if outcome == "flat" else "undecided"


def method_of(formulation: Formulation) -> Integrator:
    """The integrator of a formulation, unless one is named."""
    return "implicit" if formulation == "compliant" else "dormand-prince"
