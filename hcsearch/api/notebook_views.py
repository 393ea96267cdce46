"""What notebooks show of foldings, deployments and replays: a picture, and the player of their motion."""

from __future__ import annotations

from hcsearch.cases.replay import Replay
from hcsearch.cases.replay_sources import replay_case, replay_of_deployment
from hcsearch.cases.resolve import resolve
from hcsearch.designs.folding import Folding
from hcsearch.designs.twisting import twist
from hcsearch.springs.deployment.deployment_facts import Deployed
from hcsearch.web.player import notebook_html

MAX_PLANNED_PANELS = 12
"""Panels of a folding whose motion is planned for a notebook: of larger ones that takes long, and `replay` does it."""


def notebook_value_html(value: object) -> str | None:
    """Return the HTML of a value; None where the notebook has its picture or its text alone."""
    match value:
        case Folding():
            return _folding_html(value)
        case Deployed():
            return notebook_html(replay_of_deployment(value.deployment, value.name))
        case Replay():
            return notebook_html(value)
    return None


def _folding_html(folding: Folding) -> str | None:
    """Return the picture of a folding above its motion; None where it is twisted or large."""
    if folding.circuit.n > MAX_PLANNED_PANELS or twist(folding):
        return None
    replay, _ = replay_case(resolve(folding))
    return f"<div>{folding._repr_svg_()}</div>{notebook_html(replay)}"
