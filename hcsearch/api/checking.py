"""Take a pattern or a circuit of the user through every stage."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from hcsearch.api.kinds import check_kinds
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import Way
from hcsearch.cases.case import Case
from hcsearch.cases.databases import Place
from hcsearch.cases.names import design_named
from hcsearch.cases.resolve import resolve_scene
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, folding_of, split_crease
from hcsearch.scenes import Scene
from hcsearch.search.own_patterns.fold_reading import read_fold
from hcsearch.search.own_patterns.recognition import drawn_panel_size, recognise_design
from hcsearch.search.own_patterns.single_circuits import CheckedCircuit, check_circuit
from hcsearch.system.terminal import write_notice

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
) -> CheckedCircuit:
    """Take the foldings of a pattern or a circuit through all stages, as `hcsearch check` does.

    Parameters
    ----------
    what
        A crease pattern FILE.fold, a circuit by its notation, in any position, order and direction, or by its id, one
        of its foldings, or a case.
    scene, panel, flat_pairs, db, **values
        As in `deploy`. Panels have the size that a file gives in a physical unit, unless `panel` sets another.
    progress
        Called with the numbers of foldings that are done and of all, and the stage.

    Returns
    -------
    CheckedCircuit
        The pattern, the circuit, and the verdict on each folding.

    Examples
    --------
    >>> from hcsearch import check
    >>> check("hex:0234550132").funnel["deployable by springs"]
    1
    """
    check_kinds(check, locals())
    if isinstance(what, Case):
        circuit, creases = _of_case(what)
    elif isinstance(what, str) and what.lower().endswith(".fold"):
        circuit, creases, drawn = _of_file(what)
        panel = drawn if panel is None else panel
    else:
        circuit, creases = _of_name(what, db)
    chosen: Scene | str | None = what.scene if isinstance(what, Case) else scene
    in_scene = resolve_scene(circuit.grid.name, db, scene=chosen, panel=panel, flat_pairs=flat_pairs, values=values)
    return check_circuit(circuit, in_scene, creases, *(() if progress is None else (progress,)))


def _of_case(case: Case) -> tuple[Circuit, list[int] | None]:
    if case.folding is None:
        raise HcsearchError(f"{case.title} is no circuit: name one, such as hex:0234435011, or a file .fold")
    folding = Folding.from_notation(case.folding.notation)
    return folding.circuit, [folding.crease]


def _of_file(path: str) -> tuple[Circuit, list[int] | None, str | None]:
    """The circuit of a FOLD file, the creases of the foldings that are drawn, and the size of its panels."""
    drawing = read_fold(path)
    for remark in drawing.remarks:
        write_notice(f"{path}: {remark}")
    design = recognise_design(drawing)
    return design.circuit, list(design.creases) if design.has_assignments else None, drawn_panel_size(design, drawing)


def _of_name(what: str | Circuit | Folding, db: Place | None) -> tuple[Circuit, list[int] | None]:
    if isinstance(what, Circuit):
        return what, None
    name = what.notation if isinstance(what, Folding) else what
    if not name[:1].isdigit() and ":" not in name:
        raise HcsearchError(f"{name!r} is no circuit: name a file .fold, or a notation such as hex:0234435011")
    text, crease = split_crease(name)
    circuit, _ = design_named(text, db)
    return circuit, None if crease is None else [folding_of(circuit, crease).crease]
