"""Notebook views of foldings, deployments, motions and replays: a picture, and a player of the motion."""

from __future__ import annotations

from hcsearch.designs.folding import Folding
from hcsearch.designs.twisting import twist
from hcsearch.motion.paths.linkage_motion import LinkageMotion
from hcsearch.springs.deployment.deployment_facts import Deployed
from hcsearch.subjects.replay import Replay
from hcsearch.subjects.replay_sources import replay_of_deployment, replay_of_motion
from hcsearch.subjects.resolve import resolve
from hcsearch.web.player import notebook_html

MAX_PLANNED_PANELS = 12
"""Most panels of a folding whose motion is planned for a notebook; larger ones take long and need `replay`."""


def notebook_value_html(value: object) -> str | None:
    """Return the HTML of a value; None if the notebook shows only its picture or text."""
    match value:
        case Folding():
            return _folding_html(value)
        case Deployed():
            return notebook_html(replay_of_deployment(value.deployment, value.name, reason=value.reason))
        case LinkageMotion() if value.followed.path.steps:
            return notebook_html(replay_of_motion(value))
        case Replay():
            return notebook_html(value)
    return None


def _folding_html(folding: Folding) -> str | None:
    """Return the picture of a folding above its motion; None if it is twisted or large."""
    if folding.circuit.n > MAX_PLANNED_PANELS or twist(folding):
        return None
    replay, _ = resolve(folding).replay()
    return f"<div>{folding._repr_svg_()}</div>{notebook_html(replay)}"
