"""List the parts of foldings and assemblies."""

from __future__ import annotations

from typing import Any

from hcsearch.api.kinds import check_kinds
from hcsearch.basics.vocabulary import Way
from hcsearch.export.bill_items import BillOfMaterials, bill_of_case
from hcsearch.scenes import Scene
from hcsearch.subjects.case import Case, CaseSubject
from hcsearch.subjects.names import Place
from hcsearch.subjects.resolve import resolve
from hcsearch.system.terminal import write_notice


def bill_of_materials(
    what: CaseSubject | Case,
    scene: Scene | str | None = None,
    *,
    panel: str | None = None,
    flat_pairs: Way | None = None,
    db: Place | None = None,
    **values: Any,
) -> BillOfMaterials:
    """List the panels, hinges, springs, latches and drives of a folding or an assembly, alike ones together.

    Parameters
    ----------
    what, scene, panel, flat_pairs, db, **values
        As in `deploy`; a file `NAME.toml` with a table [drive] has drives.

    Returns
    -------
    BillOfMaterials
        The parts; alike ones are one item.

    Examples
    --------
    >>> from hcsearch import bill_of_materials
    >>> bill = bill_of_materials("hex:0234550132:4", flat_pairs="hinged")
    >>> [(item.fold, len(item.names)) for item in bill.hinges]
    [('valley', 4), ('mountain', 4), ('flat', 1), ('flat', 1)]
    """
    check_kinds(bill_of_materials, locals())
    case = resolve(what, db, scene=scene, panel=panel, flat_pairs=flat_pairs, values=values)
    write_notice(case.sentence)
    return bill_of_case(case)
