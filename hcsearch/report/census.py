"""Designs counted by their number of foldings and their least twist."""

from __future__ import annotations

from hcsearch.report.data import ReportData

Census = tuple[list[str], list[tuple[int | None, list[int]]]]
"""Names of columns, and rows: a number of foldings, and the designs in each column."""


def census_table(data: ReportData) -> Census | None:
    """Count designs by number of foldings (rows) and smallest twist (columns); None before foldings are known."""
    cells = [(foldings, twist, count) for foldings, twist, count in data.census if foldings is not None]
    if not cells:
        return None
    twists = sorted({twist for _, twist, _ in cells if twist is not None})
    columns = [f"least twist {twist}" for twist in twists]
    names = [_column(foldings, twist) for foldings, twist, _ in cells]
    columns += [name for name in ("twist not known", "no folding") if name in names]
    counts: dict[tuple[int, str], int] = {}
    for (foldings, _, count), name in zip(cells, names, strict=True):
        counts[foldings, name] = counts.get((foldings, name), 0) + count
    rows = sorted({foldings for foldings, _, _ in cells})
    return columns, [(row, [counts.get((row, name), 0) for name in columns]) for row in rows]


def _column(foldings: int, twist: int | None) -> str:
    """The column of the census that designs are counted in."""
    if twist is not None:
        return f"least twist {twist}"
    return "twist not known" if foldings else "no folding"
