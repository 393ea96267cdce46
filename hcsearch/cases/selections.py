"""The rows that a query selects: in the words of `hcsearch query`, or by one SELECT in place of all of them."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass

from hcsearch.basics.errors import QueryError
from hcsearch.cases.stored_scenes import scene_asked_for
from hcsearch.scenes import DEFAULT_SCENE_NAME
from hcsearch.store import (
    SCENIC,
    Database,
    Rows,
    asks_for,
    check_scene,
    stream,
    stream_sql,
)


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

    def _scene(self, database: Database, scenic: bool) -> str:
        """The scene that is asked for; scenic : whether what is read depends on one, where none is named."""
        named = (self.scene, self.panel)
        if not scenic and all(name is None for name in named):
            return DEFAULT_SCENE_NAME
        return scene_asked_for(database, *named, query=self.conditions)
