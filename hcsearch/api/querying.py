"""Read designs from a database into pandas tables, and rank them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from hcsearch.api.kinds import check_kinds
from hcsearch.basics.errors import QueryError
from hcsearch.basics.simulation_summaries import undecided_sentences
from hcsearch.scenes import DEFAULT_SCENE_NAME
from hcsearch.store import (
    SCENIC,
    Database,
    Rows,
    asks_for,
    check_scene,
    format_rows,
    save_rows,
    simulations_not_decided,
    stream,
    stream_sql,
)
from hcsearch.store.columns import RANKING_CRITERIA
from hcsearch.store.empty_results import empty_result_reason
from hcsearch.store.rows import ResultRow
from hcsearch.subjects.names import Place, reading_database, writing_database
from hcsearch.subjects.stored_scenes import scene_asked_for
from hcsearch.system.terminal import write_notice

if TYPE_CHECKING:
    import pandas as pd

    from hcsearch.search.ranking import RankedDesigns

_DTYPES = {"integer": "Int64", "boolean": "boolean", "real": "Float64", "text": "string"}
"""Nullable pandas dtypes by the kinds of columns."""


@dataclass(frozen=True)
class Query:
    """A query on a view, with the scene and the panels whose verdicts are read; `sql` stands in place of the rest."""

    conditions: str = ""
    view: str = "designs"
    columns: str | Sequence[str] = ""
    sort: str = ""
    limit: int | None = None
    scene: str | None = None
    panel: str | None = None
    sql: str | None = None

    def __post_init__(self) -> None:
        if self.sql is not None and (any((self.conditions, self.columns, self.sort)) or self.limit is not None):
            raise QueryError("a SELECT stands alone: put conditions, columns, order and limit into it")

    def rows(self, database: Database) -> AbstractContextManager[Rows]:
        """The rows, as they are read from a database, which must come from `open_readonly` for SQL."""
        if self.sql is not None:
            scenic = asks_for(self.sql, *SCENIC)
            scene = self._scene(database, scenic)
            if scenic:
                check_scene(database, scene)
            return stream_sql(database, self.sql, scene=scene)
        return stream(
            database,
            self.conditions,
            columns=self.columns,
            sort=self.sort,
            limit=self.limit,
            view=self.view,
            scene=self._scene(database, self.view in SCENIC),
        )

    @contextmanager
    def noticed_rows(self, database: Database, announce: Callable[[str], None] | None = None) -> Iterator[Rows]:
        """The same rows; where there are none, a line on stderr says which ranges the compared columns have.

        announce : callback for sentences on foldings of the selected designs that no simulation decides. SQL has none.
        """
        if self.sql is not None:
            with self.rows(database) as rows:
                yield rows
            return
        count = 0

        def chunks(rows: Rows) -> Iterator[Sequence[ResultRow]]:
            nonlocal count
            for chunk in rows.chunks:
                count += len(chunk)
                yield chunk

        scene = self._scene(database, self.view in SCENIC)  # once, as lines on stderr say which it is
        check_scene(database, scene, self.view)
        with replace(self, scene=scene, panel=None).rows(database) as rows:
            yield replace(rows, chunks=chunks(rows))
        if not count and self.limit != 0:
            reason = empty_result_reason(database, self.conditions, self.view, scene)
            write_notice(reason and f"no design: {reason}")
        if announce is not None:
            for sentence in undecided_sentences(simulations_not_decided(database, self.conditions, scene)):
                announce(sentence)

    def _scene(self, database: Database, scenic: bool) -> str:
        """The scene that is asked for; scenic : whether what is read depends on one, where none is named."""
        named = (self.scene, self.panel)
        if not scenic and all(name is None for name in named):
            return DEFAULT_SCENE_NAME
        return scene_asked_for(database, *named, query=self.conditions)


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

    Parameters
    ----------
    db
        A path, a URL or an open database.
    query
        Conditions such as `n=12 untwisted dof<=6`; by default all rows.
    view
        `designs`, `foldings`, `motions`, `deployments`, `evaluations`, `runs` or `units`.
    columns
        Names of columns, in a list or separated by commas; by default all.
    sort
        The same; `-` before a name sorts in descending order.
    limit
        The greatest number of rows.
    scene, panel
        The scene, and the panels in millimetres, for which results are read.
    sql
        One SELECT, in place of all of these.

    Returns
    -------
    pandas.DataFrame
        The rows, in the order of `sort`.

    Examples
    --------
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

    Parameters
    ----------
    db, query, scene, panel
        As in `read`.
    weights
        Weights of criteria by name, such as `{"dof": 2}`; 1 by default.
    pareto
        Whether only the designs on the Pareto front are returned.
    limit
        The greatest number of rows.
    save
        Whether the scores of all ranked designs are stored in the column `score`.

    Returns
    -------
    pandas.DataFrame
        The designs with their scores, the best first.
    """
    check_kinds(rank, locals())
    if limit is not None and limit < 0:
        raise QueryError(f"the limit {limit} is negative: give a number of rows, or leave it out")
    import pandas as pd  # noqa: PLC0415 - as above

    ranked = rank_in_database(db, query, weights or {}, scene, panel, save=save)
    table = pd.DataFrame(list(ranked.result.rows), columns=list(ranked.result.columns)).astype({"pareto": bool})
    shown = table[table["pareto"]].reset_index(drop=True) if pareto else table
    return shown if limit is None else shown.head(limit)


def rank_in_database(
    db: Place | None, query: str, weights: Mapping[str, float], scene: str | None, panel: str | None, *, save: bool
) -> RankedDesigns:
    """Rank the designs of a database; save : store their scores."""
    from hcsearch.search.ranking import complete_weights, rank_designs, save_ranks  # noqa: PLC0415 - only to rank

    all_weights = complete_weights(weights)
    with writing_database(db, create=False) if save else reading_database(db) as database:
        scene_name = scene_asked_for(database, scene, panel, query=query)
        ranked = rank_designs(database, query, all_weights, scene_name)
        if save:
            save_ranks(database, ranked, scene_name)
    return ranked


def ranking_text(ranked: RankedDesigns, style: str, *, pareto: bool, limit: int | None) -> Iterator[str]:
    """Yield a ranking as pieces of text in a style; in styles for people, column heads contain units."""
    names = ranked.result.columns
    on_front = names.index("pareto")
    rows = [row for row in ranked.result.rows if row[on_front] or not pareto][:limit]
    if style in ("table", "markdown"):
        units = {quantity.name: f" ({quantity.unit})" for quantity in RANKING_CRITERIA if quantity.unit}
        names = tuple(name + units.get(name, "") for name in names)
    return format_rows(Rows(names, (None,) * len(names), iter([rows] if rows else [])), style)


def query_text(selection: Query, db: Place, style: str, announce: Callable[[str], None] | None = None) -> Iterator[str]:
    """Yield the rows that a query selects as pieces of text in a style; announce : as of `Query.noticed_rows`."""
    with reading_database(db) as database, selection.noticed_rows(database, announce) as rows:
        yield from format_rows(rows, style)


def save_query(selection: Query, db: Place, style: str, path: str | Path) -> None:
    """Write the rows that a query selects to a file in a style."""
    with reading_database(db) as database, selection.noticed_rows(database) as rows:
        save_rows(rows, style, Path(path))
