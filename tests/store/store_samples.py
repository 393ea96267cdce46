"""Batches of made-up designs, small enough to check by hand."""

from __future__ import annotations

import numpy as np
import sqlalchemy

from hcsearch.designs.records import NO_NUMBER, DesignBatch, StageResult, WorkKey
from hcsearch.store import schema

NOT_ALLOWED = r"constraint failed|cannot store|violates \w+[- ]\w* ?constraint"
"""What SQLite and PostgreSQL say of rows that break a constraint."""
WORK = WorkKey("hex", 12, "", "all")
VERSIONS = {"circuits": 1, "foldings": 1, "twist": 1}
RESULTS = [
    StageResult("circuits", 1, 3, 30, 0.5),
    StageResult("foldings", 1, 2, 20, 0.25),
    StageResult("twist", 1, 1, 10, 0.125),
]

# Of three designs: the first has no folding, the second two twisted ones, the third one twisted and one untwisted.
CREASES = [[], [1, 4], [0, 3]]
TWISTS = [[], [1, 2], [1, 0]]


def circuits(start, count):
    """Notations in another order than their numbers, as a real search may give them."""
    return [f"hex:{(start + k) * 7919 % 100003:06d}" for k in range(count)]


def sample(names, until="twist", creases=CREASES, twists=TWISTS):
    """A batch of these circuits; number k has the foldings of CREASES[k % 3]."""
    n_designs = len(names)
    chosen = [creases[k % len(creases)] for k in range(n_designs)]
    turns = [twists[k % len(twists)] for k in range(n_designs)]
    designs = {
        "grid": "hex",
        "n": 12,
        "circuit": list(names),
        "array": [f"hex:array{k // 2}" for k in range(n_designs)],
        "array_symmetry": np.full(n_designs, 12, np.int64),
        "symmetry": np.resize(np.array([1, 2, 6], np.int8), n_designs),
        "n_fixed": np.resize(np.array([12, 6, 2], np.int8), n_designs),
    }
    foldings = {}
    if until in ("foldings", "twist"):
        designs["n_foldings"] = np.array([len(c) for c in chosen], np.int16)
        foldings["row"] = np.repeat(np.arange(n_designs), designs["n_foldings"])
        foldings["crease"] = np.array([c for cs in chosen for c in cs], np.int8)
    if until == "twist":
        foldings["twist"] = np.array([t for ts in turns for t in ts], np.int16)
        designs["n_untwisted"] = np.array([ts.count(0) for ts in turns], np.int16)
        designs["min_twist"] = np.array([min(ts, default=NO_NUMBER) for ts in turns], np.int32)
    return DesignBatch(designs, foldings)


def unit_row(**changes):
    """A unit, as the columns of the view."""
    values = {
        "grid": "triangle",
        "n": 10,
        "circuit": "triangle:0123434501",
        "crease": 1,
        "alpha": None,
        "shape": "",
        "merged": 0,
        "element_dof": 2,
        "copies": 4,
        "placements": "[]",
        "panels": 21,
        "hinges": 24,
        "directions": 3,
        "loops": 4,
        "kutzbach": 0,
        "dof": 1,
        "dof_folded": 4,
        "dof_flat": 4,
        "rank_gap": 1e9,
        "deployment_ratio": 7.0,
        "ways": 1,
        "path": "flat",
        "closure_error": 1e-14,
        "contact": 0,
        "known": "unit-i",
    }
    return values | changes


def evaluation_row(**changes):
    """A check of springs, as the columns of its table."""
    values = {
        "subject": "thesis-4x4",
        "setting": '{"seconds": 1.0}',
        "springs": "0.1 0.2",
        "outcome": "flat",
        "clear": 1,
        "end_time": 0.5,
        "collision_time": None,
        "first_panel": None,
        "second_panel": None,
        "gap": 0.002,
        "speed": 0.0,
        "remaining": 0.25,
        "end_remaining": 0.125,
        "widest": 0.01,
        "drift": 1e-6,
        "opening": None,
        "steps": 100,
        "evaluations": 1000,
        "looks": 500,
    }
    return values | changes


def begin(database, work=WORK):
    """Start a run with nothing special about it."""
    from hcsearch.store import start_run

    return start_run(database, work=work, until="twist", panel=None, arguments={}, versions={})


def record(database, names, prefix="p", until="twist", *, work=WORK, results=RESULTS, **options):
    """Record a sample batch as a run of its own."""
    from hcsearch.store import record_batches

    record_batches(database, begin(database, work), work, [(prefix, sample(names, until, **options), results)])


def as_rows(result, kinds=None, chunk=2):
    """A result as it would come from a database, in chunks."""
    from hcsearch.store import Rows

    chunks = [result.rows[at : at + chunk] for at in range(0, len(result.rows), chunk)]
    return Rows(result.columns, kinds or (None,) * len(result.columns), iter(chunks))


CLOCKS = {"started", "finished", "stage_times", "seconds"}


def everything(database):
    """All rows of all tables, ids included, but for what a clock says."""
    tables = {}
    for name, table in schema.metadata.tables.items():
        columns = [column for column in table.c if column.name not in CLOCKS]
        with database.reading() as connection:
            rows = connection.execute(sqlalchemy.select(*columns).order_by(*table.primary_key)).all()
        tables[name] = [tuple(row) for row in rows]
    return tables


def contents(database):
    """Everything about designs and foldings, without the ids, in an order of its own."""
    from hcsearch.store import find_design, select

    rows = [find_design(database, circuit) for (circuit,) in select(database, columns="circuit").rows]
    for row in rows:
        row["foldings"] = [{**folding, "design_id": 0} for folding in row["foldings"]]
    return sorted(({**row, "id": 0} for row in rows), key=lambda row: row["circuit"])
