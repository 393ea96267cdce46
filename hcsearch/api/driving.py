"""Drive a folding along its certified path."""

from __future__ import annotations

from typing import Any

from hcsearch.api.kinds import check_kinds
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import Way
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding
from hcsearch.scenes import Scene
from hcsearch.springs.drive.drive_facts import DRIVE_SUFFIXES, Drive
from hcsearch.springs.drive.driven_folding import (
    DRIVE_STAGES,
    DriveOptions,
    NoPathError,
    latch_facts,
)
from hcsearch.subjects.case import Case
from hcsearch.subjects.names import Place
from hcsearch.subjects.resolve import resolve
from hcsearch.system.terminal import write_notice
from hcsearch.system.work_steps import Progress

__all__ = ["DRIVE_SUFFIXES", "DriveOptions", "NoPathError", "drive", "latch_facts"]


def drive(
    what: str | Folding | Circuit | Case,
    scene: Scene | str | None = None,
    *,
    options: DriveOptions | None = None,
    panel: str | None = None,
    flat_pairs: Way | None = None,
    db: Place | None = None,
    progress: Progress | None = None,
    **values: Any,
) -> Drive:
    """Choose motors that open a folding, or a pattern of a file, along a proved path, as `hcsearch drive` does.

    Parameters
    ----------
    what, scene, panel, flat_pairs, db, **values
        As in `deploy`, but not a Linkage or an assembly.
    options
        Rates, driven hinges and more, a `hcsearch.springs.drive.driven_folding.DriveOptions`.
    progress
        Called with the numbers of steps that are done and of all, and the next step.

    Returns
    -------
    Drive
        The motors, their course, and the simulated motion.

    Raises
    ------
    hcsearch.springs.drive.driven_folding.NoPathError
        With the reason, where no path is proved.
    """
    check_kinds(drive, locals())
    case = resolve(what, db, scene=scene, panel=panel, flat_pairs=flat_pairs, values=values, path=True)
    if case.scene.held == "free":
        raise HcsearchError("drives are for an array that is held: hold a panel, such as --held bottom")
    if progress is not None:
        progress(0, len(DRIVE_STAGES), DRIVE_STAGES[0])
    path = case.path()
    try:
        return case.driven(path, options, progress)
    finally:
        write_notice(path.note)
