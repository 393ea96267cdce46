"""Take a pattern or a circuit of the user through every stage."""

from __future__ import annotations

from typing import Any

from hcsearch.api.kinds import check_kinds
from hcsearch.basics.vocabulary import Way
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding
from hcsearch.scenes import Scene
from hcsearch.search.own_patterns.checked import Checked
from hcsearch.subjects.case import Case
from hcsearch.subjects.names import Place
from hcsearch.subjects.resolve import resolve
from hcsearch.system.work_steps import Progress


def check(
    what: str | Circuit | Folding | Case,
    scene: Scene | str | None = None,
    *,
    panel: str | None = None,
    flat_pairs: Way | None = None,
    db: Place | None = None,
    progress: Progress | None = None,
    **values: Any,
) -> Checked:
    """Take the foldings of a pattern or a circuit through all stages, as `hcsearch check` does.

    Parameters
    ----------
    what
        A crease pattern FILE.fold (or .cp, .opx, .svg), a model that `save` wrote (.urdf, .xml, .mjcf), a circuit by
        its notation, in any position, order and direction, or by its id, one of its foldings, a file NAME.toml that
        names one folding or a file, or a case.
    scene, panel, flat_pairs, db, **values
        As in `deploy`. Panels have the size that a file gives in a physical unit, unless `panel` sets another, of a
        pattern that is no design as longest edge x thickness.
    progress
        Called with the numbers of foldings, or of stages, that are done and of all, and the stage.

    Returns
    -------
    Checked
        The verdict on each folding; of a file that draws no design of a grid one verdict, with the linkage, its
        mobility and its motion.

    Examples
    --------
    >>> from hcsearch import check
    >>> check("hex:0234550132").funnel["deployed by springs"]
    1
    """
    check_kinds(check, locals())
    case = resolve(what, db, scene=scene, panel=panel, flat_pairs=flat_pairs, values=values, extent="design")
    return case.checked(progress)
