"""Follow the motions of a folding or an assembly from a state."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from hcsearch.api.kinds import check_kinds
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import Until, Way
from hcsearch.motion.paths.branches import follow_branch
from hcsearch.motion.paths.linkage_motion import LinkageMotion, row_step
from hcsearch.motion.paths.start_states import resolve_start
from hcsearch.scenes import Scene
from hcsearch.subjects.case import Case, CaseSubject
from hcsearch.subjects.names import Place
from hcsearch.subjects.resolve import resolve
from hcsearch.system.terminal import write_notice
from hcsearch.system.work_steps import Progress

_STEPS = ("branches at the start", "motion")


def follow_motion(
    what: CaseSubject | Case,
    scene: Scene | str | None = None,
    *,
    start: str | Path | Sequence[float] | np.ndarray = "folded",
    row: int | None = None,
    branch: int | None = None,
    until: Until = "end",
    stops: bool = True,
    length: float | None = None,
    step: float | None = None,
    panel: str | None = None,
    flat_pairs: Way | None = None,
    db: Place | None = None,
    progress: Progress | None = None,
) -> LinkageMotion:
    """Follow the motion of a folding, an assembly or a Linkage from a state, as `hcsearch motion` does.

    Parameters
    ----------
    what, scene, panel, flat_pairs, db
        As in `deploy`; a pattern without a packed state is followed from other states than `folded`. Panels may pass
        through each other.
    start
        `folded`, `flat`, a table .csv of states with the columns of `LinkageMotion.table`, or the fold angles of a
        closed state, rad.
    row
        The row of the table, from 0 on; the last one by default.
    branch
        Number of the branch, from 1 on, in the order of `LinkageMotion.branches`; without stops -k is branch k in the
        opposite sense. By default the finite one that leads most directly to flat, or from flat to folded.
    until
        `flat`, `folded`, `end` for either of these, `stop` for neither, `event` for the first singular state on the
        way, `bifurcation` for the first at which motions branch. A motion ends at a stop in any case.
    stops
        Whether hinges stop at 0 and pi, else they turn on.
    length
        Greatest arc length, rad.
    step
        Greatest arc length between two states, rad; 0.05 times the square root of the number of hinges by default.
    progress
        Called with the numbers of steps that are done and of all, and the next step.

    Returns
    -------
    LinkageMotion
        The states on the way, the singular ones, and the branches at the start.

    Examples
    --------
    >>> from hcsearch import follow_motion
    >>> motion = follow_motion("unit-ii")
    >>> motion.followed.path.outcome, [event.kind for event in motion.events]
    ('flat', ['shaky', 'shaky', 'shaky'])
    """
    check_kinds(follow_motion, locals())
    _check_positive("length", length)
    _check_positive("step", step)
    given = start if isinstance(start, str | Path) else np.array(start, float).ravel()
    packed = "folded" in (until, *([str(start)] if isinstance(start, str | Path) else ()))
    case = resolve(what, db, scene=scene, panel=panel, flat_pairs=flat_pairs, packed=packed)
    linkage, labels = case.linkage, case.labels
    angles, words = resolve_start(linkage, labels, given, row=row, stops=stops)
    if progress is not None:
        progress(0, len(_STEPS), _STEPS[0])
    followed = follow_branch(
        linkage,
        angles,
        branch=branch,
        until=until,
        stops=stops,
        length=math.inf if length is None else length,
        max_step=row_step(linkage) if step is None else step,
        found=None if progress is None else lambda _: progress(1, len(_STEPS), _STEPS[1]),
    )
    write_notice(case.driven_sentence)
    return LinkageMotion(case.title, linkage, labels, words, until, followed)


def _check_positive(name: str, value: float | None) -> None:
    if value is not None and not 0.0 < value < math.inf:
        raise HcsearchError(f"{name} cannot be {value}: give a number above 0, in rad")
