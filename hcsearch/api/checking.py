"""Take a pattern or a circuit of the user through every stage."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from hcsearch.api.kinds import check_kinds
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import Way
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, folding_of, split_crease
from hcsearch.scenes import Scene
from hcsearch.search.own_patterns.checked_patterns import CheckedPattern, check_pattern
from hcsearch.search.own_patterns.single_circuits import CheckedCircuit, check_circuit
from hcsearch.subjects.case import Case
from hcsearch.subjects.databases import Place
from hcsearch.subjects.names import design_named
from hcsearch.subjects.pattern_files import DrawnPattern, is_pattern_file, read_pattern_file, refuse_other_file
from hcsearch.subjects.resolve import resolve, resolve_pattern, resolve_scene

CheckProgress = Callable[[int, int, str], None]


def check(
    what: str | Circuit | Folding | Case,
    scene: Scene | str | None = None,
    *,
    panel: str | None = None,
    flat_pairs: Way | None = None,
    db: Place | None = None,
    progress: CheckProgress | None = None,
    **values: Any,
) -> CheckedCircuit | CheckedPattern:
    """Take the foldings of a pattern or a circuit through all stages, as `hcsearch check` does.

    Parameters
    ----------
    what
        A crease pattern FILE.fold (or .cp, .opx, .svg), a model that `save` wrote (.urdf, .xml, .mjcf), a circuit by
        its notation, in any position, order and direction, or by its id, one of its foldings, a file NAME.toml that
        names one folding or a file, or a case.
    scene, panel, flat_pairs, db, **values
        As in `deploy`. Panels have the size that a file gives in a physical unit, unless `panel` sets another, of a
        CheckedPattern as longest edge x thickness.
    progress
        Called with the numbers of foldings, or of stages, that are done and of all, and the stage.

    Returns
    -------
    CheckedCircuit or CheckedPattern
        The pattern, the circuit, and the verdict on each folding; of a file that draws no design of a grid, the
        linkage, its mobility and its motion.

    Examples
    --------
    >>> from hcsearch import check
    >>> check("hex:0234550132").funnel["deployed by springs"]
    1
    """
    check_kinds(check, locals())
    reporting = () if progress is None else (progress,)
    if isinstance(what, str) and what.endswith(".toml"):
        what = resolve(what, db, scene=scene, panel=panel, flat_pairs=flat_pairs, values=values)
        what.check_moved()
        scene, panel, flat_pairs, values = None, None, None, {}
    if isinstance(what, Case) and isinstance(what.what, DrawnPattern):
        return check_pattern(what.title, what.what.packed, what.scene, *reporting)
    if isinstance(what, Case):
        circuit, creases = _of_case(what)
    elif isinstance(what, str) and is_pattern_file(what):
        drawn = read_pattern_file(what, panel)
        if isinstance(drawn, DrawnPattern):
            case = resolve_pattern(drawn, db, scene=scene, flat_pairs=flat_pairs, values=values)
            return check_pattern(what, drawn.packed, case.scene, *reporting)
        circuit, panel = drawn.design.circuit, drawn.panel
        creases = list(drawn.design.creases) if drawn.design.has_assignments else None
    else:
        circuit, creases = _of_name(what, db)
    chosen: Scene | str | None = what.scene if isinstance(what, Case) else scene
    in_scene = resolve_scene(circuit.grid.name, db, scene=chosen, panel=panel, flat_pairs=flat_pairs, values=values)
    return check_circuit(circuit, in_scene, creases, *reporting)


def _of_case(case: Case) -> tuple[Circuit, list[int] | None]:
    if case.folding is None:
        raise HcsearchError(f"{case.title} is no circuit: name one, such as hex:0234435011, or a file .fold")
    folding = Folding.from_notation(case.folding.notation)
    return folding.circuit, [folding.crease]


def _of_name(what: str | Circuit | Folding, db: Place | None) -> tuple[Circuit, list[int] | None]:
    if isinstance(what, Circuit):
        return what, None
    name = what.notation if isinstance(what, Folding) else what
    refuse_other_file(name)
    if not name[:1].isdigit() and ":" not in name:
        raise HcsearchError(f"{name!r} is no circuit: name a file .fold, or a notation such as hex:0234435011")
    text, crease = split_crease(name)
    circuit, _ = design_named(text, db)
    return circuit, None if crease is None else [folding_of(circuit, crease).crease]
