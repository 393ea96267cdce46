"""The data of a page for its script as JSON: columns of designs and foldings, and grids to draw them on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import DESIGN_STATUSES
from hcsearch.cases.names import deployment_scene_name
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.grid import GRIDS, Grid
from hcsearch.designs.grid.step_names import digit_steps
from hcsearch.shape.drawing import DRAWING_SIDE_UNITS, DRAWING_SIDES
from hcsearch.store.columns import FOLDING_QUANTITIES, Quantity
from hcsearch.web.report.data import ReportData, ViewRow
from hcsearch.web.report.reasons import best_deployment, status_reason, verdict_of_row

PackedColumn = list[object] | dict[str, object]
"""A column in compact form, with repeated values stored once."""

FOLDING_COLUMNS = tuple(
    q for q in FOLDING_QUANTITIES if q.name not in ("design_id", "opposite", "untwisted", "deployable")
)


def page_data(data: ReportData) -> dict[str, Any]:
    """Return the data that the script of a page draws, for JSON.

    Foldings are in the order of their designs; `design` is the index of a folding's design, `best` the crease drawn
    first.
    """
    rows = [(k, row) for k, design in enumerate(data.designs) for row in data.foldings.get(design_id_of(design), ())]
    keys = [(design_id_of(data.designs[k]), int(str(row["crease"]))) for k, row in rows]
    deployments = [data.deployments.get(key, ()) for key in keys]
    best = [drawn_crease(data, design) for design in data.designs]
    reasons = [
        status_reason(row, data.motions.get(key), rows_of_folding)
        for (_, row), key, rows_of_folding in zip(rows, keys, deployments, strict=True)
    ]
    foldings: dict[str, list[Any]] = {
        "design": [k for k, _ in rows],
        **{q.name: [row.get(q.name) for _, row in rows] for q in FOLDING_COLUMNS},
        "scene": [
            None
            if (best_ := best_deployment(rows_of_folding)) is None
            else deployment_scene_name(best_, verdict_of_row(row, rows_of_folding))
            for (_, row), rows_of_folding in zip(rows, deployments, strict=True)
        ],
        "why": [reason or None for reason in reasons],
    }
    return {
        "total": data.total,
        "scene": data.scene,
        "where": data.database_option,
        "pages": data.page_address,
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
    """Return the crease of the folding that represents a design; None without foldings.

    It is the best one in the database; before any stage has compared them, the first untwisted one.
    """
    foldings = data.foldings.get(design_id_of(design), ())
    creases = [int(str(row["crease"])) for row in foldings]
    best = data.best.get(design_id_of(design))
    if best in creases:
        return best
    untwisted = [crease for crease, row in zip(creases, foldings, strict=True) if row.get("untwisted")]
    return min(untwisted or creases, default=None)


def describe_quantity(quantity: Quantity) -> dict[str, object]:
    """Return name, unit, meaning and ordered words of a quantity for a page."""
    return {
        "name": quantity.name,
        "label": quantity.title,
        "kind": quantity.kind,
        "unit": quantity.unit,
        "note": quantity.note,
        "words": list(quantity.words),
    }


def pack_column(values: Sequence[object]) -> PackedColumn:
    """Return a column in compact form for JSON; `unpack` of table.js restores the values.

    `{"all": value}` for equal values, `{"words": [...], "at": [...]}` for few distinct texts, else the values.
    """
    kinds = list(dict.fromkeys(values))
    if len(kinds) <= 1:
        return {"all": kinds[0] if kinds else None}
    if all(value is None or isinstance(value, str) for value in kinds) and 2 * len(kinds) < len(values):
        index_of = {value: index for index, value in enumerate(kinds)}
        return {"words": kinds, "at": [index_of[value] for value in values]}
    return list(values)


def design_id_of(design: ViewRow) -> int:
    """Return the id in a row of `designs`."""
    return int(str(design.get("id", 0)))


def _grid(grid: Grid) -> dict[str, Any]:
    """Return the drawing data of a grid.

    unit : Cartesian coordinates of the lattice points (1, 0) and (0, 1). places, corners, leaving : of the cell of each
    kind at home, corners relative to its place. side : units of pictures to the first side. digits : for each frame,
    the step and the next frame of each digit of a notation; frames : the first frame of each kind.
    """
    homes = [(0, 0, kind) for kind in range(grid.kinds)]
    centres = [grid.position(grid.point(home)) for home in homes]
    digits, frames = digit_steps(grid)
    return {
        "steps": grid.steps,
        "kinds": [kind for kind, _ in grid.step_kinds],
        "unit": [grid.position((1, 0)), grid.position((0, 1))],
        "places": [grid.point(home) for home in homes],
        "corners": [
            [(x - cx, y - cy) for x, y in grid.corners(home)] for home, (cx, cy) in zip(homes, centres, strict=True)
        ],
        "leaving": grid.leaving,
        "digits": digits,
        "frames": frames,
        "rectangular": grid.is_rectangular,
        "small": grid.name == "triangle",
        "side": DRAWING_SIDES.get(grid.name, DRAWING_SIDE_UNITS),
    }


def _is_readable(notation: str) -> bool:
    try:
        Circuit.from_notation(notation)
    except HcsearchError:
        return False
    return True
