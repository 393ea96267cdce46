"""What becomes of a deployment: how it ends, in which words, and which verdict follows."""

from __future__ import annotations

from dataclasses import dataclass, field

from hcsearch.basics.vocabulary import Ending, Formulation, Integrator, Verdict
from hcsearch.shape.labels import Labels
from hcsearch.springs.deployment.reasons import reason_of_check
from hcsearch.springs.dynamics.simulation import SimulationStop

FLAT_FOLD_ANGLE = 0.01
"""The array is flat when every fold angle is within this of 0 (rad): 0.6 degrees."""
REST_ANGLE_TOLERANCE = 1e-4
"""It is at rest when speeds and accelerations would move no hinge by more in the time left, or in 1 s (rad)."""
MAX_DEPLOYMENT_STEPS: dict[Formulation, int] = {
    "constrained": 20_000,
    "compliant": 100_000,
    "penalty": 400_000,
    "quasistatic": 20_000,
}
"""Steps until a simulation is given up; the thesis's springs need 140 for a millisecond."""
_OUTCOMES: dict[SimulationStop, Ending] = {
    "flat": "flat",
    "time": "moving",
    "rest": "at rest",
    "jammed": "jammed",
    "steps": "out of steps",
}


def outcome_of(ending: SimulationStop) -> Ending:
    """What an ending of a simulation means for a deployment."""
    return _OUTCOMES.get(ending, "diverged")


def verdict_of(outcome: Ending, clear: bool | None) -> Verdict:
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


@dataclass(frozen=True)
class DeploymentCheck:
    """What became of one deployment, without its states; `Deployment` keeps those, too.

    outcome : `flat`; `moving` when the time was over; `at rest` elsewhere; `jammed`, stops and loops together let
        nothing move on; `diverged`; `out of steps`.
    clear : whether it is certified clear as long as it lasts; None where undecided, or nobody asked.
    collision : when panels first collide (s) and which, or None. gap : smallest gap of one that becomes flat and clear,
        m (see `Clearance`). speed : at which panels come together where it is not clear, m/s, else 0. remaining : mean
        fold angle over pi then, or where it is clear at the end; end_remaining : at the end. widest : greatest fold
        angle at the end, rad. drift : greatest error of the energy balance, as a share of the largest energy.
    opening : greatest closure residual, rad or gap over the pattern's size. loose : share of the states at which loops
        are open though states are projected (see `docs/explanation/dynamics.md`, singular branches); not kept
            in databases.
    """

    outcome: Ending
    end_time: float
    clear: bool | None
    collision: tuple[float, tuple[int, int]] | None
    gap: float | None
    speed: float
    remaining: float
    end_remaining: float
    widest: float
    drift: float
    opening: float
    steps: int
    evaluations: int
    looks: int
    loose: float = field(default=0.0, compare=False)

    @property
    def verdict(self) -> Verdict:
        """Whether it becomes flat, certified clear; collides; or neither is certain."""
        return verdict_of(self.outcome, self.clear)

    @property
    def deploys(self) -> bool:
        """Whether it becomes flat, certified clear."""
        return self.verdict == "deploys"

    @property
    def flat_time(self) -> float | None:
        """When it was flat, s."""
        return self.end_time if self.outcome == "flat" else None

    def reason(self, labels: Labels) -> str:
        """What became of it, in a sentence, with the names of panels."""
        return reason_of_check(self.outcome, self.end_time, self.clear, self.collision, labels)
