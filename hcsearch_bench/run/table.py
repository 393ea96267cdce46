"""Tables of a bench: shown on the terminal and in Markdown, saved as CSV and JSON."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hcsearch.system.outputs import make_folder, write_output
from hcsearch_bench.run.machine import Machine

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Table:
    """Rows of one kind (frozen dataclasses), with what a reader must know about them.

    name : also of its CSV file. hidden : columns that are saved but not shown. columns : attributes of a row that are
        saved, in order; all its fields unless given.
    """

    name: str
    title: str
    about: str
    rows: Sequence[Any]
    hidden: tuple[str, ...] = ()
    columns: tuple[str, ...] = ()

    def records(self) -> list[dict[str, Any]]:
        """The rows as plain dictionaries."""
        if not self.columns:
            return [asdict(row) for row in self.rows]
        return [{name: getattr(row, name) for name in self.columns} for row in self.rows]


@dataclass(frozen=True)
class Goal:
    """A goal, its limits, and the number that was measured; None where there is none. note : on the number."""

    goal: str
    measured: float | None
    at_least: float | None = None
    at_most: float | None = None
    note: str = ""

    @property
    def met(self) -> str:
        """`yes`, `no` or `not measured`."""
        if self.measured is None:
            return "not measured"
        enough = self.at_least is None or self.measured >= self.at_least
        return "yes" if enough and (self.at_most is None or self.measured <= self.at_most) else "no"


def frame(table: Table) -> pd.DataFrame:
    """The table as a data frame, numbers as they were measured; exact integers of any size."""
    import pandas as pd

    return pd.DataFrame(table.records(), dtype=object)


def shown(table: Table) -> pd.DataFrame:
    """The table as it is shown: three figures, a dash for what there is not."""
    return frame(table).drop(columns=list(table.hidden)).map(_shown)


def _shown(value: Any) -> str:
    if value is None:
        return "-"
    if isinstance(value, float):
        if math.isnan(value):
            return "-"
        return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.3g}"
    return f"{value:,}" if isinstance(value, int) else str(value)


def text(table: Table) -> str:
    """The table for a terminal."""
    lines = shown(table).to_string(index=False)
    return f"{table.title}\n{table.about}\n\n{lines}\n"


def markdown(table: Table) -> str:
    """The table as a section of Markdown."""
    data = shown(table)
    right = ["left" if table.rows and _is_text(table, name) else "right" for name in data.columns]
    body = data.to_markdown(index=False, disable_numparse=True, colalign=right)
    return f"## {table.title}\n\n{table.about}\n\n{body}\n"


def _is_text(table: Table, column: str) -> bool:
    return any(isinstance(getattr(row, column), str) for row in table.rows)


def save(tables: Sequence[Table], machine: Machine, folder: Path, name: str, heading: str, *, data: str = ".") -> None:
    """Write tables into NAME.md of a folder, and `machine.json` and a CSV file each into the folder `data` below it.

    heading : begins with a title `# ...`; what NAME.md has under other titles stays as it is.
    """
    below = folder / data
    for place in (folder, below):
        make_folder(place)
    write_output(below / "machine.json", json.dumps(asdict(machine), indent=1) + "\n")
    for table in tables:
        write_output(below / f"{table.name}.csv", frame(table).to_csv(index=False))
    sections = "\n".join(map(markdown, tables))
    _put(folder / f"{name}.md", f"{heading}\n\n{machine}\n\n{sections}")


def _put(page: Path, part: str) -> None:
    """Write a part into a page, in the place of the one with the same title or after all others."""
    old = page.read_text(encoding="utf-8") if page.exists() else ""
    parts = {text.partition("\n")[0]: text.rstrip() for text in re.split("^(?=# )", old, flags=re.MULTILINE) if text}
    parts[part.partition("\n")[0]] = part.rstrip()
    write_output(page, "\n\n".join(parts.values()) + "\n")


def save_json(tables: Sequence[Table], machine: Machine, path: Path) -> None:
    """Write machine and tables into one JSON file."""
    data = {"machine": asdict(machine)} | {table.name: table.records() for table in tables}
    write_output(path, json.dumps(data, indent=1) + "\n")
