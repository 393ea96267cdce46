"""Bills of materials as text: tables for people, Markdown, CSV and JSON."""

from __future__ import annotations

import json
from typing import Any

from hcsearch.basics.errors import HcsearchError
from hcsearch.export.bill_items import BillOfMaterials
from hcsearch.scenes.laws import rounded_law_text
from hcsearch.system.terminal import short_number

BILL_STYLES = {".csv": "csv", ".md": "markdown", ".txt": "text", ".json": "json"}
"""Styles of bills by the ending of their files."""
_UNITS = {
    "_mm2": " (mm²)",
    "_mm": " (mm)",
    "_g": " (g)",
    "_N_m_s_per_rad": " (N m s/rad)",
    "_N_m_per_rad": " (N m/rad)",
    "_N_m": " (N m)",
    "_rad": " (rad)",
}


def bill_text(bill: BillOfMaterials, style: str) -> str:
    """Return a bill of materials as `text`, `markdown`, `csv` (one table) or `json`; HcsearchError for other styles."""
    if style == "csv":
        return str(bill.table().to_csv(index=False, lineterminator="\n"))
    if style == "json":
        facts = {"title": bill.title, "scene": bill.scene, "mass_g": 1e3 * bill.mass}
        items = {section.kind: list(section.rows) for section in bill.sections}
        return json.dumps(facts | items, indent=1) + "\n"
    if style not in ("text", "markdown"):
        raise HcsearchError(f"a bill of materials has no style {style!r}: choose text, markdown, csv or json")
    from tabulate import tabulate  # noqa: PLC0415 - only these two styles need it

    is_text = style == "text"
    parts = [f"{bill_summary(bill)}\n" if is_text else f"# Bill of materials\n\n{bill_summary(bill)}\n"]
    for section in bill.sections:
        columns, cells = section_cells(section.rows)
        right = [isinstance(value, int | float) for value in section.rows[0].values()]
        table = tabulate(
            cells,
            headers=columns,
            tablefmt="simple" if is_text else "pipe",
            disable_numparse=True,
            colalign=["right" if number else "left" for number in right],
        )
        parts.append(f"{section.kind if is_text else f'## {section.kind.capitalize()}'}\n\n{table}\n")
    return "\n".join(parts)


def bill_summary(bill: BillOfMaterials) -> str:
    """Return the totals of a bill in a sentence."""
    panels, hinges = (sum(len(item.names) for item in items) for items in (bill.panels, bill.hinges))
    return (
        f"{bill.title}, scene {bill.scene}: {panels:,} panels of {short_number(1e3 * bill.mass)} g together, "
        f"{hinges:,} hinges of {short_number(1e3 * bill.hinge_length)} mm together"
    )


def section_cells(rows: tuple[dict[str, Any], ...]) -> tuple[list[str], list[list[str]]]:
    """Return the column heads, with units, and the cells of a section as texts, numbers rounded to four digits."""
    return [_head(name) for name in rows[0]], [[_cell(*item) for item in row.items()] for row in rows]


def _head(name: str) -> str:
    """Return the name of a column in words: `length_mm` is `length (mm)`."""
    suffix = next((suffix for suffix in _UNITS if name.endswith(suffix)), "")
    return name.removesuffix(suffix).replace("_", " ") + _UNITS.get(suffix, "")


def _cell(name: str, value: Any) -> str:
    if name == "law":
        return rounded_law_text(value)
    return short_number(value) if isinstance(value, float) else str(value)
