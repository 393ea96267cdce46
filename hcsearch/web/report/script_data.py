"""The data of a page for its script: columns of designs and foldings, grids to draw them on, in one JSON text."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import DESIGN_STATUSES
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.grid import GRIDS, Grid
from hcsearch.store.columns import FOLDING_QUANTITIES, Quantity
from hcsearch.web.report.data import ReportData, ViewRow
from hcsearch.web.report.reasons import best_deployment, deployment_scene_name, status_reason, verdict_of_row

PackedColumn = list[object] | dict[str, object]
"""A column in little text: what is the same everywhere once, words that repeat once each."""

FOLDING_COLUMNS = tuple(
    q for q in FOLDING_QUANTITIES if q.name not in ("design_id", "opposite", "untwisted", "deployable")
)


def page_data(data: ReportData) -> dict[str, Any]:
    """Everything that the script of a page draws, as JSON takes it.

    Foldings are in the order of their designs; `design` is the place of the one each belongs to, `best` the crease that
    is drawn first.
    """
    rows = [(k, row) for k, design in enumerate(data.designs) for row in data.foldings.get(design_id_of(design), ())]
    keys = [(design_id_of(data.designs[k]), int(str(row["crease"]))) for k, row in rows]
    tried = [data.tried.get(key, ()) for key in keys]
    best = [drawn_crease(data, design) for design in data.designs]
    reasons = [
        status_reason(row, data.motions.get(key), own) for (_, row), key, own in zip(rows, keys, tried, strict=True)
    ]
    foldings: dict[str, list[Any]] = {
        "design": [k for k, _ in rows],
        **{q.name: [row.get(q.name) for _, row in rows] for q in FOLDING_COLUMNS},
        "scene": [
            None if (best_ := best_deployment(own)) is None else deployment_scene_name(best_, verdict_of_row(row, own))
            for (_, row), own in zip(rows, tried, strict=True)
        ],
        "why": [reason or None for reason in reasons],
    }
    return {
        "total": data.total,
        "scene": data.scene,
        "where": data.where,
        "pages": data.pages,
        "size": data.size,
        "grids": {name: _grid(grid) for name, grid in GRIDS.items()},
        "statuses": list(DESIGN_STATUSES),
        "quantities": [describe_quantity(quantity) for quantity in data.columns],
        "folding_quantities": [describe_quantity(quantity) for quantity in FOLDING_COLUMNS],
        "count": len(data.designs),
        "folding_count": len(rows),
        "designs": {q.name: pack_column([design.get(q.name) for design in data.designs]) for q in data.columns},
        "readable": pack_column([_is_readable(str(design.get("circuit", ""))) for design in data.designs]),
        "best": pack_column(best),
        "foldings": {name: pack_column(values) for name, values in foldings.items()},
        "players": [data.players.get(key) for key in keys] if data.players else [],
    }


def drawn_crease(data: ReportData, design: ViewRow) -> int | None:
    """The crease of the folding that stands for a design; None without foldings.

    It is the one that the database names. Before any stage has compared them, it is the first untwisted one.
    """
    foldings = data.foldings.get(design_id_of(design), ())
    creases = [int(str(row["crease"])) for row in foldings]
    best = data.best.get(design_id_of(design))
    if best in creases:
        return best
    untwisted = [crease for crease, row in zip(creases, foldings, strict=True) if row.get("untwisted")]
    return min(untwisted or creases, default=None)


def describe_quantity(quantity: Quantity) -> dict[str, object]:
    """Name, unit and meaning of a quantity for a page, and the words by which its values compare."""
    return {
        "name": quantity.name,
        "label": quantity.title,
        "kind": quantity.kind,
        "unit": quantity.unit,
        "note": quantity.note,
        "words": list(quantity.words),
    }


def pack_column(values: Sequence[object]) -> PackedColumn:
    """A column as JSON takes it; `unpack` of table.js gives the values back.

    `{"all": value}` where all are alike, `{"words": [...], "at": [...]}` where few texts repeat, else the values.
    """
    kinds = list(dict.fromkeys(values))
    if len(kinds) <= 1:
        return {"all": kinds[0] if kinds else None}
    if all(value is None or isinstance(value, str) for value in kinds) and 2 * len(kinds) < len(values):
        places = {value: place for place, value in enumerate(kinds)}
        return {"words": kinds, "at": [places[value] for value in values]}
    return list(values)


def design_id_of(design: ViewRow) -> int:
    """The id of a design's row."""
    return int(str(design.get("id", 0)))


def _grid(grid: Grid) -> dict[str, Any]:
    """What drawing takes of a grid; corners about the centre, for each parity of triangles."""
    starts: Sequence[range] = (
        [range(d, grid.directions, 2) for d in (0, 1)] if grid.is_triangle else [range(grid.directions)]
    )
    return {
        "directions": grid.directions,
        "steps": grid.steps,
        "triangle": grid.is_triangle,
        "faces": [list(faces) for faces in starts],
        "corners": [grid.corners_from_centre(list(faces)) for faces in starts],
        "regular": grid.directions != 4,
    }


def _is_readable(notation: str) -> bool:
    try:
        Circuit.from_notation(notation)
    except HcsearchError:
        return False
    return True
