"""The motion of a folding or an assembly in few states, to show or to hand on."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hcsearch.api.asking import Setting
from hcsearch.api.kinds import check_kinds
from hcsearch.api.places import located
from hcsearch.circuit import Circuit
from hcsearch.deployment.deployed import Deployed
from hcsearch.folding import Folding
from hcsearch.replays.recording import replay_of_deployment
from hcsearch.replays.replay import Replay
from hcsearch.replays.sources import By, find_replay
from hcsearch.scenes import FlatPairs, Scene
from hcsearch.system.terminal import say


def replay(
    what: str | Folding | Circuit | Deployed,
    scene: Scene | str | None = None,
    *,
    motion: By | None = None,
    panel: str | None = None,
    across: str | None = None,
    flat_pairs: FlatPairs | None = None,
    merge: bool = False,
    db: str | Path | None = None,
    **values: Any,
) -> Replay:
    """Give a motion as a few states, to play in a notebook: a proved path if there is one, else that of springs.

    what : as in `deploy`, but not a Linkage; or a result of `deploy`, whose simulated motion is taken.
    motion : `path` for the planned path, or `springs` for the motion that springs cause; the other is not tried then.
    scene, panel, across, flat_pairs, merge, db, values : as in `deploy`.

    >>> from hcsearch import replay
    >>> replay("hex:0234550132:4", motion="springs").ends_flat
    True
    """
    check_kinds(replay, locals())
    if isinstance(what, Deployed):
        return replay_of_deployment(what.deployment, what.name, reason=what.reason)
    setting = Setting(scene, located(db), panel, across, flat_pairs, merge, values)
    shown, said = find_replay(setting.request(what), motion)
    say(said)
    return shown
