"""The data of a page for its script as JSON: columns of designs and foldings, and grids to draw them on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import DESIGN_STATUSES
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.grid import GRIDS, Grid
from hcsearch.designs.grid.step_names import reading_frames
from hcsearch.scenes.envelopes import envelope_catalogue
from hcsearch.shape.drawing import drawn_size, shortest_side
from hcsearch.store.columns import FOLDING_QUANTITIES
from hcsearch.store.quantity import Quantity
from hcsearch.subjects.names import deployment_scene_name
from hcsearch.web.report.data import ReportData, ViewRow
from hcsearch.web.report.reasons import best_deployment, status_reason, verdict_of_row

PackedColumn = list[object] | dict[str, object]
"""A column in compact form, with repeated values stored once."""

FOLDING_COLUMNS = tuple(
    q for q in FOLDING_QUANTITIES if q.name not in ("design_id", "opposite", "untwisted", "deployable")
)

CARD_HEADS = ("id", "circuit", "array", "status")
"""Columns of a design that its card always shows."""
CARD_COLUMNS = (*("symmetry", "n_foldings", "dof", "deploy_time", "score"),)
"""Columns that a card shows below these, unless others are chosen. Its sentence has the one number on clearance."""


def page_data(data: ReportData) -> dict[str, Any]:
    """Return the data that the script of a page draws, for JSON.

    Foldings are in the order of their designs; `design` is the index of a folding's design, `best` the crease drawn
    first.
    """
    rows = [(k, row) for k, design in enumerate(data.designs) for row in data.foldings.get(design_id_of(design), ())]
    keys = [(design_id_of(data.designs[k]), int(str(row["crease"]))) for k, row in rows]
    deployments = [data.deployments.get(key, ()) for key in keys]
    best = [drawn_crease(data, design) for design in data.designs]
    names = {str(design.get("circuit", "")).partition(":")[0] for design in data.designs}
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
        "grids": {name: grid_data(grid) for name, grid in GRIDS.items() if name in names},
        "statuses": list(DESIGN_STATUSES),
        "envelopes": envelope_catalogue(),
        "card_heads": list(CARD_HEADS),
        "card_columns": list(CARD_COLUMNS),
        "quantities": [describe_quantity(quantity) for quantity in data.columns],
        "folding_quantities": [describe_quantity(quantity) for quantity in FOLDING_COLUMNS],
        "count": len(data.designs),
        "folding_count": len(rows),
        "designs": {q.name: pack_column([design.get(q.name) for design in data.designs]) for q in data.columns},
        "readable": pack_column([_is_readable(str(design.get("circuit", ""))) for design in data.designs]),
        "best": pack_column(best),
        "first": first_design(data),
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


def first_design(data: ReportData) -> int:
    """Return the index of the design that plays when the page opens: the first whose drawn folding has a motion.

    The first design where none has.
    """
    for index, design in enumerate(data.designs if data.players else ()):
        if (design_id_of(design), drawn_crease(data, design)) in data.players:
            return index
    return 0


def describe_quantity(quantity: Quantity) -> dict[str, object]:
    """Return name, unit, meaning, better direction and ordered words of a quantity for a page."""
    return {
        "name": quantity.name,
        "label": quantity.title,
        "kind": quantity.kind,
        "unit": quantity.unit,
        "better": quantity.better,
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


def grid_data(grid: Grid) -> dict[str, Any]:
    """Return the drawing data of a grid, in corner units: `Grid.corner_scale` to a lattice point.

    steps : kind of the panel that is left, and the vector. corners : of each kind, relative to its lattice point.
    axes : coordinates of the two unit vectors for panels whose shortest side is 1. size : length and width by default,
    null where panels have one shape. digits, after, first : `ReadingFrames`.
    """
    frames, scale = reading_frames(grid), grid.corner_scale
    shortest = scale * shortest_side(grid.corners((0, 0, 0)))
    corners = []
    for kind in range(grid.kinds):
        x, y = grid.point((0, 0, kind))
        corners.append([(cx - scale * x, cy - scale * y) for cx, cy in grid.lattice_corners((0, 0, kind))])
    return {
        "steps": [(kind, scale * x, scale * y) for (kind, _), (x, y) in zip(grid.step_kinds, grid.steps, strict=True)],
        "corners": corners,
        "axes": [[value / shortest for value in grid.position(unit)] for unit in ((1, 0), (0, 1))],
        "size": drawn_size(grid) if grid.is_rectangular else None,
        "digits": frames.steps,
        "after": frames.after,
        "first": frames.first,
    }


def _is_readable(notation: str) -> bool:
    try:
        Circuit.from_notation(notation)
    except HcsearchError:
        return False
    return True
