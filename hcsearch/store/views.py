"""The SQL views that users query, `designs` to `evaluations`, with the columns of `columns.py`.

They are plain SQL for SQLite and PostgreSQL, with NULL where a stage has not run, and booleans as 0 or 1. The views
show the scene `default`; the same SELECT with another name shows any other scene.
"""

from __future__ import annotations

import re

from hcsearch.scenes import DEFAULT_SCENE_NAME
from hcsearch.store.columns import FLIGHT_QUANTITIES, VIEWS

# A folding with twist never deploys, nor does a design without an untwisted folding: this is known before later stages.
# A verdict in a scene has precedence over the status from enumeration.
_DESIGN, _FOLDING = "coalesce(o.status, d.status)", "coalesce(v.status, f.status)"


def _known(verdict: str, status: str, twist: str) -> str:
    """Return SQL for the evidence of a folding's status: a word of `vocabulary.STATUS_EVIDENCE`, or NULL."""
    return f"""CASE
        WHEN {twist} > 0 THEN 'twist'
        WHEN {verdict} = 'deploys' THEN 'deployment'
        WHEN {verdict} = 'movable' THEN 'path_proved'
        WHEN {status} = 'locked' AND m.lock_pairs IS NOT NULL THEN 'kept_apart'
        WHEN {status} = 'locked' THEN 'locked_at_end'
        WHEN m.states > 0 THEN 'path_met'
        WHEN m.states = 0 THEN 'no_path_met'
    END"""


def _error(column: str, alias: str, crease: str) -> str:
    """Return SQL for an error of the one deployment of a folding that has become flat, certified clear, or NULL."""
    return (
        f"(SELECT p.{column} FROM deployment AS p WHERE p.design_id = {alias} AND p.crease = {crease} "
        "AND p.base = :scene AND p.status = 'deploys')"
    )


# Each join of `designs` finds at most one row, so SQLite omits joins of which no column is selected; a join condition
# on a column of another join would keep that one.
_BEST = "(SELECT b.best_crease FROM outcome AS b WHERE b.design_id = d.id AND b.scene = :scene)"
_ERRORS = ("error_angle", "error_time")
_DESIGNS = {
    "orbit_size": "d.array_symmetry / d.symmetry",
    "two_stack": "CASE WHEN d.n_foldings > 0 THEN 1 WHEN d.n_foldings = 0 THEN 0 END",
    "untwisted": "CASE WHEN d.n_untwisted > 0 THEN 1 WHEN d.n_untwisted = 0 THEN 0 END",
    "deployable": f"""CASE
        WHEN d.n_foldings = 0 OR (d.n_foldings > 0 AND d.n_untwisted = 0) THEN 0
        WHEN {_DESIGN} IN ('no_folding', 'twisted', 'locked') THEN 0
        WHEN o.status IN ('deploys', 'movable') THEN 1
    END""",
    "status": f"""CASE
        WHEN d.n_foldings = 0 THEN 'no_folding'
        WHEN d.n_foldings > 0 AND d.n_untwisted = 0 THEN 'twisted'
        ELSE {_DESIGN}
    END""",
    "score": "s.score",
    # Two stacks of n/2 panels cover two cells; every crease but the two flat ones has a hinge in the scene `default`.
    "deployment_ratio": "CASE WHEN d.n_untwisted > 0 THEN d.n / 2 END",
    "hinges": "CASE WHEN d.n_untwisted > 0 THEN d.n - 2 END",
}
_FOLDINGS = {
    "untwisted": "CASE WHEN f.twist = 0 THEN 1 WHEN f.twist > 0 THEN 0 END",
    "status": f"CASE WHEN f.twist > 0 THEN 'twisted' ELSE {_FOLDING} END",
    "deployable": f"""CASE
        WHEN f.twist > 0 OR {_FOLDING} IN ('twisted', 'locked') THEN 0
        WHEN v.status IN ('deploys', 'movable') THEN 1
    END""",
    "min_clearance": "v.min_clearance",
    "deploy_time": "v.deploy_time",
    "needed_margin": "v.needed_margin",
    "least_gap": "v.least_gap",
    "flat_pairs": "m.flat_pairs",
    "known": _known("v.status", _FOLDING, "f.twist"),
    "critical_margin": "m.critical_margin",
    "unmet_margin": "m.unmet_margin",
}
_BEST_FOLDING = ("kutzbach", "dof", "merged_panels", "kutzbach_merged", "dof_merged")
_OF_VERDICT = ("min_clearance", "deploy_time", "needed_margin", "least_gap")

_OF_FLIGHT = {quantity.name: f'g."{quantity.name}"' for quantity in FLIGHT_QUANTITIES}

# Columns of views that are not simply the column of that name in the table.
_EXPRESSIONS = {
    "designs": _DESIGNS
    | {name: f'f."{name}"' for name in _BEST_FOLDING}
    | {name: f'v."{name}"' for name in _OF_VERDICT}
    | {name: f'm."{name}"' for name in ("flat_pairs", "critical_margin", "unmet_margin")}
    | {name: _error(name, "d.id", _BEST) for name in _ERRORS}
    | _OF_FLIGHT
    | {"known": _known("o.status", _DESIGN, "CASE WHEN d.n_foldings > 0 AND d.n_untwisted = 0 THEN 1 END")},
    "foldings": _FOLDINGS | {name: _error(name, "f.design_id", "f.crease") for name in _ERRORS} | _OF_FLIGHT,
    "motions": {},
    "deployments": {},
    "runs": {},
    "units": {},
    "evaluations": {"clearance": 'e."gap" * 1000.0'},
}

_SOURCES = {
    "designs": (
        "d",
        f"""design AS d
LEFT JOIN outcome AS o ON o.design_id = d.id AND o.scene = :scene
LEFT JOIN folding AS f ON f.design_id = d.id AND f.crease = coalesce({_BEST}, d.best_crease)
LEFT JOIN verdict AS v ON v.design_id = d.id AND v.scene = :scene AND v.crease = {_BEST}
LEFT JOIN motion AS m ON m.design_id = d.id AND m.scene = :scene AND m.crease = {_BEST}
LEFT JOIN flight AS g ON g.design_id = d.id AND g.scene = :scene AND g.crease = {_BEST}
LEFT JOIN score AS s ON s.design_id = d.id AND s.scene = :scene""",
    ),
    "foldings": (
        "f",
        """folding AS f
LEFT JOIN verdict AS v ON v.design_id = f.design_id AND v.crease = f.crease AND v.scene = :scene
LEFT JOIN motion AS m ON m.design_id = f.design_id AND m.crease = f.crease AND m.scene = :scene
LEFT JOIN flight AS g ON g.design_id = f.design_id AND g.crease = f.crease AND g.scene = :scene""",
    ),
    "motions": ("m", "motion AS m"),
    "deployments": ("p", "deployment AS p"),
    "runs": ("r", "run AS r"),
    "units": ("u", "unit AS u"),
    "evaluations": ("e", "evaluation AS e"),
}


SCENIC = tuple(view for view, (_, source) in _SOURCES.items() if ":scene" in source)
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
    alias, source = _SOURCES[view]
    # Quoted, because `array` is a reserved word of PostgreSQL.
    columns = {quantity.name: f'{alias}."{quantity.name}"' for quantity in VIEWS[view]} | _EXPRESSIONS[view]
    lines = ",\n".join(f'    {expression} AS "{name}"' for name, expression in columns.items())
    return f"SELECT\n{lines}\nFROM {source}".replace(":scene", sql_literal(scene))


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
