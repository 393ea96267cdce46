"""Read designs from a database into pandas tables, and rank them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING

from hcsearch.api.kinds import check_kinds
from hcsearch.basics.errors import QueryError
from hcsearch.cases.names import Place, reading_database, writing_database
from hcsearch.cases.selections import Query
from hcsearch.cases.stored_scenes import scene_asked_for
from hcsearch.search.ranking import RankedDesigns, complete_weights, rank_designs, save_ranks
from hcsearch.store import Database

if TYPE_CHECKING:
    import pandas as pd

_DTYPES = {"integer": "Int64", "boolean": "boolean", "real": "Float64", "text": "string"}
"""Nullable pandas dtypes by the kinds of columns."""


def read(
    db: Place | None = None,
    query: str = "",
    *,
    view: str = "designs",
    columns: str | Sequence[str] = "",
    sort: str | Sequence[str] = "",
    limit: int | None = None,
    scene: str | None = None,
    panel: str | None = None,
    sql: str | None = None,
) -> pd.DataFrame:
    """Read the rows of a view that satisfy a query into a pandas table, as `hcsearch query` prints them.

    db : a path, a URL or an open database. query : conditions such as `n=12 untwisted dof<=6`; by default all rows.
    view : `designs`, `foldings`, `motions`, `deployments`, `evaluations`, `runs` or `units`.
    columns : names of columns, in a list or separated by commas; by default all. sort : the same; `-` before a name
    sorts in descending order. limit : the greatest number of rows.
    scene, panel : the scene, and the panels in millimetres, for which results are read.
    sql : one SELECT, in place of all of these.

    >>> from hcsearch import enumerate_into, read
    >>> _ = enumerate_into("designs.sqlite", grid="hex", n=8, until="twist")
    >>> read("designs.sqlite", "two_stack", columns="circuit,n_foldings,min_twist", sort="min_twist")
            circuit  n_foldings  min_twist
    0  hex:02234400           1          0
    1  hex:02334051           2          1
    """
    import pandas as pd  # noqa: PLC0415 - only for tables

    check_kinds(read, locals())
    order = sort if isinstance(sort, str) else ",".join(sort)
    query_arguments = Query(query, view, columns, order, limit, scene, panel, sql)
    with reading_database(db) as database, query_arguments.rows(database) as rows:
        table = pd.DataFrame([row for chunk in rows.chunks for row in chunk], columns=list(rows.columns))
        return table.astype({name: _DTYPES[kind] for name, kind in zip(rows.columns, rows.kinds, strict=True) if kind})


def rank(
    db: Place | None = None,
    query: str = "",
    *,
    weights: Mapping[str, float] | None = None,
    scene: str | None = None,
    panel: str | None = None,
    pareto: bool = False,
    limit: int | None = None,
    save: bool = False,
) -> pd.DataFrame:
    """Rank the designs that a query selects by a weighted score, best first, as `hcsearch rank` does.

    Designs known not to deploy are left out.

    db, query, scene, panel : as in `read`.
    weights : weights of criteria by name, such as `{"dof": 2}`; 1 by default.
    pareto : whether only the designs on the Pareto front are returned. limit : the greatest number of rows.
    save : whether the scores of all ranked designs are stored in the column `score`.
    """
    check_kinds(rank, locals())
    if limit is not None and limit < 0:
        raise QueryError(f"the limit {limit} is negative: give a number of rows, or leave it out")
    import pandas as pd  # noqa: PLC0415 - as above

    with open_existing(db, to_write=save) as database:
        ranked = rank_in_database(database, query, weights or {}, scene, panel, save=save)
    table = pd.DataFrame(list(ranked.result.rows), columns=list(ranked.result.columns)).astype({"pareto": bool})
    shown = table[table["pareto"]].reset_index(drop=True) if pareto else table
    return shown if limit is None else shown.head(limit)


def open_existing(db: Place | None, *, to_write: bool) -> AbstractContextManager[Database]:
    """Open an existing database for writing or read-only."""
    return writing_database(db, create=False) if to_write else reading_database(db)


def rank_in_database(
    database: Database,
    query: str,
    weights: Mapping[str, float],
    scene: str | None,
    panel: str | None,
    *,
    save: bool,
) -> RankedDesigns:
    """Rank the designs of an open database; save : store their scores."""
    all_weights = complete_weights(weights)
    scene_name = scene_asked_for(database, scene, panel, query=query)
    ranked = rank_designs(database, query, all_weights, scene_name)
    if save:
        save_ranks(database, ranked, scene_name)
    return ranked
