"""Replay the motion of a folding or an assembly as a few states."""

from __future__ import annotations

from typing import Any

from hcsearch.api.kinds import check_kinds
from hcsearch.basics.vocabulary import ReplaySource, Way
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding
from hcsearch.motion.paths.linkage_motion import LinkageMotion
from hcsearch.scenes import Scene
from hcsearch.springs.deployment.deployment_facts import Deployed
from hcsearch.subjects.case import Case
from hcsearch.subjects.names import Place
from hcsearch.subjects.replay import Replay
from hcsearch.subjects.replay_sources import replay_of_deployment, replay_of_motion
from hcsearch.subjects.resolve import resolve
from hcsearch.system.terminal import write_notice


def replay(
    what: str | Folding | Circuit | Case | Deployed | LinkageMotion,
    scene: Scene | str | None = None,
    *,
    motion: ReplaySource | None = None,
    panel: str | None = None,
    flat_pairs: Way | None = None,
    db: Place | None = None,
    **values: Any,
) -> Replay:
    """Return a motion as a few states, to play in a notebook: a proved path if there is one, else that of springs.

    Parameters
    ----------
    what
        As in `deploy`, but not a Linkage; or a result of `deploy` with its simulated motion, or of `follow_motion`.
    motion
        `path` for the planned path only, or `springs` for the simulated motion only.
    scene, panel, flat_pairs, db, **values
        As in `deploy`.

    Returns
    -------
    Replay
        The states of the motion.

    Examples
    --------
    >>> from hcsearch import replay
    >>> replay("hex:0234550132:4", motion="springs").ends_flat
    True
    """
    check_kinds(replay, locals())
    if isinstance(what, Deployed):
        return replay_of_deployment(what.deployment, what.name, reason=what.reason)
    if isinstance(what, LinkageMotion):
        return replay_of_motion(what)
    path = motion == "path"
    case = resolve(what, db, scene=scene, panel=panel, flat_pairs=flat_pairs, values=values, path=path)
    shown, note = case.replay(motion)
    write_notice(note)
    return shown
