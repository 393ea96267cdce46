"""Replays of what the program computes: simulated deployments, and planned paths."""

from __future__ import annotations

import numpy as np

from hcsearch.basics.arrays import Reals
from hcsearch.basics.vocabulary import Formulation
from hcsearch.cases.replays.replay import Replay, accumulated_turn, thin_states
from hcsearch.shape.labels import labels_of
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.deploying import Deployment
from hcsearch.system.terminal import short

REPLAY_SUBSTEP_COUNT = 4
"""States between two of a motion: steps are long where fold angles are smooth, and these are not straight."""
REPLAY_ANGLE_TOLERANCE = 2e-3
"""What interpolation between the states of a replay may miss a hinge by, rad: 0.1 degrees, less than a screen shows."""

_LOOPS: dict[Formulation, str] = {
    "constrained": "loops closed exactly",
    "compliant": "loops closed by stiff springs",
    "penalty": "loops closed by the springs of the thesis",
    "quasistatic": "without inertia",
}


def replay_of_deployment(
    deployment: Deployment, title: str, *, design: bool | None = None, reason: str | None = None
) -> Replay:
    """The replay of a simulated deployment.

    design : as of `labels_of`. reason : what became of it, at other tolerances, too, where they were tried.
    """
    compiled, motion, clearance = deployment.compiled, deployment.motion, deployment.clearance
    shares = np.linspace(0.0, 1.0, REPLAY_SUBSTEP_COUNT, endpoint=False)
    between = (motion.times[:-1, None] + shares * np.diff(motion.times)[:, None]).ravel()
    at = np.append(between, motion.times[-1])
    q = motion.at(at)
    at, angles = _without_repeats(at, compiled.of_hinges(q, np.zeros_like(q))[0])
    kept, error = thin_states(at, angles, REPLAY_ANGLE_TOLERANCE)
    end = float(at[-1]) if clearance is not None and clearance.kind == "clear" else None
    if clearance is not None and clearance.time is not None:
        end = clearance.time
    return Replay(
        linkage=compiled.linkage,
        labels=labels_of(compiled.linkage, design=design),
        axis="time",
        at=at[kept],
        angles=angles[kept],
        certified=() if end is None else ((0.0, end),),
        collision=deployment.check.collision,
        margin=compiled.margin,
        error=error,
        title=title,
        source=f"simulated in the scene {compiled.setup.name!r}, {_LOOPS[compiled.formulation]}: "
        f"{deployment.reason if reason is None else reason}",
    )


def replay_of_path(
    linkage: Linkage,
    states: Reals,
    title: str,
    *,
    margin: float | None,
    design: bool = True,
    near: float = REPLAY_ANGLE_TOLERANCE,
) -> Replay:
    """The replay of a planned path, (k, n_hinges), from packed to flat.

    margin : m, the play at which the path is proved as a whole, None where it is not proved. Places on the axis are
    shares of the path's length, the sum of what the hinges turn by. near : rad, allowed error of interpolation.
    """
    length = accumulated_turn(states)
    at = length / length[-1] if length[-1] > 0.0 else np.linspace(0.0, 1.0, len(states))
    at, states = _without_repeats(at, np.asarray(states, float))
    kept, error = thin_states(at, states, near)
    proved = "not proved" if margin is None else f"proved with {short(1e3 * margin, 2)} mm of play on every face"
    return Replay(
        linkage=linkage,
        labels=labels_of(linkage, design=design),
        axis="path",
        at=at[kept],
        angles=states[kept],
        certified=() if margin is None else ((0.0, 1.0),),
        collision=None,
        margin=margin or 0.0,
        error=error,
        title=title,
        source=f"planned path from packed to flat, {proved}",
    )


def _without_repeats(at: Reals, angles: Reals) -> tuple[Reals, Reals]:
    """States at rising places: of several at one place, as before and after an impact, the last."""
    last = np.append(np.diff(at) > 0.0, True)
    return at[last], angles[last]
