"""The SQL views that users query, `designs` to `evaluations`, with the columns of `columns.py`.

The views show the scene `default`; the same SELECT with another name shows any other scene.
"""

from __future__ import annotations

import re

from hcsearch.scenes import DEFAULT_SCENE_NAME
from hcsearch.store.columns import BEST_CREASE, VIEWS, table_of

_ALIASES = {"design": "d", "folding": "f", "outcome": "o", "verdict": "v", "motion": "m", "flight": "g", "score": "s"}
_ALIASES |= {"deployment": "p", "run": "r", "unit": "u", "evaluation": "e"}

# Each join of `designs` finds at most one row, so SQLite omits joins without a selected column; a join condition on a
# column of another join would keep that one.
_SOURCES = {view: f"{view.removesuffix('s')} AS {_ALIASES[view.removesuffix('s')]}" for view in VIEWS}
_SOURCES["designs"] += f"""
LEFT JOIN outcome AS o ON o.design_id = d.id AND o.scene = :scene
LEFT JOIN folding AS f ON f.design_id = d.id AND f.crease = coalesce({BEST_CREASE}, d.best_crease)
LEFT JOIN verdict AS v ON v.design_id = d.id AND v.scene = :scene AND v.crease = {BEST_CREASE}
LEFT JOIN motion AS m ON m.design_id = d.id AND m.scene = :scene AND m.crease = {BEST_CREASE}
LEFT JOIN flight AS g ON g.design_id = d.id AND g.scene = :scene AND g.crease = {BEST_CREASE}
LEFT JOIN score AS s ON s.design_id = d.id AND s.scene = :scene"""
_SOURCES["foldings"] += """
LEFT JOIN verdict AS v ON v.design_id = f.design_id AND v.crease = f.crease AND v.scene = :scene
LEFT JOIN motion AS m ON m.design_id = f.design_id AND m.crease = f.crease AND m.scene = :scene
LEFT JOIN flight AS g ON g.design_id = f.design_id AND g.crease = f.crease AND g.scene = :scene"""

SCENIC = tuple(view for view, source in _SOURCES.items() if ":scene" in source)
"""Views that depend on the scene."""


_SELECT = re.compile(
    r"(?:\s|--[^\n]*(?:\n|$)|/\*.*?\*/)*(?:(?P<with>WITH\s+)(?P<recursive>RECURSIVE\s+)?|(?=SELECT\b|VALUES\b|\())",
    re.IGNORECASE | re.DOTALL,
)
"""The beginning of a SELECT statement, after comments."""


def create_view(view: str) -> str:
    """Return the CREATE VIEW statement of a view."""
    return f"CREATE VIEW {view} AS {select_view_in(view, DEFAULT_SCENE_NAME)}"


def select_view_in(view: str, scene: str) -> str:
    """Return the SELECT of a view in a scene."""
    # Quoted, because `array` is a reserved word of PostgreSQL.
    columns = {one.name: one.sql or f'{_ALIASES[table_of(view, one)]}."{one.name}"' for one in VIEWS[view]}
    lines = ",\n".join(f'    {expression} AS "{name}"' for name, expression in columns.items())
    return f"SELECT\n{lines}\nFROM {_SOURCES[view]}".replace(":scene", sql_literal(scene))


def sql_in_scene(sql: str, scene: str) -> str:
    """Return a SELECT whose views show a scene, by common table expressions of their names before its own.

    Other statements, such as EXPLAIN, are returned unchanged.
    """
    match = _SELECT.match(sql)
    if match is None:
        return sql
    views = ",\n".join(f"{view} AS ({select_view_in(view, scene)})" for view in SCENIC if asks_for(sql, view))
    if not views:
        return sql
    body = sql[match.end() :]
    return f"WITH {views}\n{sql}" if match["with"] is None else f"WITH {match['recursive'] or ''} {views},\n{body}"


def asks_for(sql: str, *views: str) -> bool:
    """Return whether a statement may read one of some views: it contains its name as a word."""
    return any(re.search(rf"\b{view}\b", sql, re.IGNORECASE) for view in views)


def sql_literal(text: str) -> str:
    """Return a text as an SQL string literal."""
    return "'" + text.replace("'", "''") + "'"
