"""What foldings and deployments show of themselves in a notebook: a picture, and the player of their motion."""

from __future__ import annotations

from hcsearch.cases.resolve import resolve
from hcsearch.deployment.deployed import Deployed
from hcsearch.folding import Folding
from hcsearch.player.page import notebook_html
from hcsearch.replays.recording import replay_of_deployment
from hcsearch.replays.sources import replay_case
from hcsearch.twisting import twist

MOST = 12
"""Panels of a folding whose motion is planned for a notebook: of larger ones that takes long, and `replay` does it."""


def folding_html(folding: Folding) -> str | None:
    """The picture of a folding above its motion; None, for the picture alone, where it is twisted or large."""
    if folding.circuit.n > MOST or twist(folding):
        return None
    replay, _ = replay_case(resolve(folding))
    return f"<div>{folding._repr_svg_()}</div>{notebook_html(replay)}"


def deployed_html(deployed: Deployed) -> str:
    """The motion of a deployment."""
    return notebook_html(replay_of_deployment(deployed.deployment, deployed.name))
