"""The SQL views that users query, `designs` to `evaluations`, with the columns of `columns.py`.

Plain SQL that SQLite and PostgreSQL both read. NULL where a stage has not run, booleans as 0 or 1.
"""

from __future__ import annotations

from hcsearch.store.columns import VIEWS

# A folding with twist never deploys, and a design without an untwisted folding neither: known before any later stage.
_DESIGNS = {
    "orbit_size": "d.array_symmetry / d.symmetry",
    "two_stack": "CASE WHEN d.n_foldings > 0 THEN 1 WHEN d.n_foldings = 0 THEN 0 END",
    "untwisted": "CASE WHEN d.n_untwisted > 0 THEN 1 WHEN d.n_untwisted = 0 THEN 0 END",
    "deployable": """CASE
        WHEN d.n_foldings = 0 OR (d.n_foldings > 0 AND d.n_untwisted = 0) THEN 0
        WHEN d.status IN ('no_folding', 'twisted', 'locked') THEN 0
        WHEN d.status = 'deploys' THEN 1
    END""",
    "status": """CASE
        WHEN d.n_foldings = 0 THEN 'no_folding'
        WHEN d.n_foldings > 0 AND d.n_untwisted = 0 THEN 'twisted'
        ELSE d.status
    END""",
    # Two stacks of n/2 panels on two cells; every crease but the two flat ones has a hinge in the scene `default`.
    "deployment_ratio": "CASE WHEN d.n_untwisted > 0 THEN d.n / 2 END",
    "hinges": "CASE WHEN d.n_untwisted > 0 THEN d.n - 2 END",
}
_FOLDINGS = {
    "untwisted": "CASE WHEN f.twist = 0 THEN 1 WHEN f.twist > 0 THEN 0 END",
    "status": "CASE WHEN f.twist > 0 THEN 'twisted' ELSE f.status END",
    "deployable": """CASE
        WHEN f.twist > 0 OR f.status IN ('twisted', 'locked') THEN 0
        WHEN f.status = 'deploys' THEN 1
    END""",
}
_BEST_FOLDING = ("kutzbach", "dof", "merged_panels", "kutzbach_merged", "dof_merged")
_BEST_DEPLOYING = ("min_clearance", "deploy_time")

# Where a column of a view is more than the column of that name in its table.
_EXPRESSIONS = {
    "designs": _DESIGNS
    | {name: f'f."{name}"' for name in _BEST_FOLDING}
    | {name: f'g."{name}"' for name in _BEST_DEPLOYING},
    "foldings": _FOLDINGS,
    "deployments": {},
    "runs": {},
    "units": {},
    "evaluations": {"clearance": 'e."gap" * 1000.0'},
}

# The joins of `designs` find one row each at most, so SQLite leaves out those of which no column is asked for.
_SOURCES = {
    "designs": (
        "d",
        """design AS d
LEFT JOIN folding AS f ON f.design_id = d.id AND f.crease = d.best_crease
LEFT JOIN folding AS g ON g.design_id = d.id AND g.crease = (
    SELECT e.crease FROM folding AS e WHERE e.design_id = d.id AND e.twist = 0 AND e.status = 'deploys'
    ORDER BY e.dof IS NULL, e.dof, e.crease LIMIT 1
)""",
    ),
    "foldings": ("f", "folding AS f"),
    "deployments": ("p", "deployment AS p"),
    "runs": ("r", "run AS r"),
    "units": ("u", "unit AS u"),
    "evaluations": ("e", "evaluation AS e"),
}


def create_view(view: str) -> str:
    """Return the CREATE VIEW statement of a view."""
    alias, source = _SOURCES[view]
    # Quoted, because `array` is a reserved word of PostgreSQL.
    columns = {quantity.name: f'{alias}."{quantity.name}"' for quantity in VIEWS[view]} | _EXPRESSIONS[view]
    lines = ",\n".join(f'    {expression} AS "{name}"' for name, expression in columns.items())
    return f"CREATE VIEW {view} AS SELECT\n{lines}\nFROM {source}"
