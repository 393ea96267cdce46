"""The motion of a folding or an assembly in few states, to show or to hand on."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hcsearch.api.asking import Setting
from hcsearch.api.places import located
from hcsearch.circuit import Circuit
from hcsearch.deployment.deployed import Deployed
from hcsearch.folding import Folding
from hcsearch.replays.recording import replay_of_deployment
from hcsearch.replays.replay import Replay
from hcsearch.replays.sources import By, replay_named
from hcsearch.scenes import FlatPairs, Scene


def replay(
    what: str | Folding | Circuit | Deployed,
    scene: Scene | str | None = None,
    *,
    by: By | None = None,
    panel: str | None = None,
    across: str | None = None,
    flat_pairs: FlatPairs | None = None,
    merge: bool = False,
    db: str | Path | None = None,
    **values: Any,
) -> Replay:
    """The motion of a folding, an assembly or a file: its planned path if it has one, else what springs do.

    by : `path` or `springs`, for one of them alone. The others as of `deploy`, of whose results it takes the motion.
    """
    if isinstance(what, Deployed):
        return replay_of_deployment(what.deployment, what.name)
    setting = Setting(scene, located(db), panel, across, flat_pairs, merge, values)
    return replay_named(setting.request(what), by)
