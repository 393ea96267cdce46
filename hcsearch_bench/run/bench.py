"""What a bench is: what it measures, and what is shown and saved of that."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from hcsearch_bench.run.machine import Machine, this_machine
from hcsearch_bench.run.table import Table, save

Results = TypeVar("Results")
Say = Callable[[str], None]
"""Called with the name of each step of a bench when it begins."""


@dataclass(frozen=True)
class Limit:
    """The greatest time for one thing that a bench runs, s: as usual, and with `--quick`; `--limit` names another."""

    what: str
    usual: float
    quick: float


@dataclass(frozen=True)
class Bench(Generic[Results]):
    """One bench, and its command `hcsearch bench NAME`.

    summary : the help of the command. example : of a call.
    measure : `quick`, `say`, and the options that the bench has -> all that one run measured.
    tables : of that, what is shown and saved, in order. draw : writes its pictures, and what else is no table, into a
        folder.
    peers : packages whose versions are noted with the machine.
    repeats, limit, server : whether the command has `--repeats`, `--limit` and `--postgresql`, which `measure` gets as
        `repeats`, `limit` and `postgresql`.
    page : name of the Markdown file; `name` unless given. heading : its beginning, a title `# ...`; `# Bench: PAGE`
        unless given. data : folder of CSV files, below that of the page.
    """

    name: str
    summary: str
    example: str
    measure: Callable[..., Results]
    tables: Callable[[Results], Sequence[Table]]
    draw: Callable[[Results, Path], None] = lambda _results, _folder: None
    peers: tuple[str, ...] = ()
    repeats: bool = False
    limit: Limit | None = None
    server: bool = False
    page: str = ""
    heading: str = ""
    data: str = "."

    def run(
        self,
        *,
        quick: bool = False,
        say: Say = print,
        repeats: int = 3,
        limit: float | None = None,
        postgresql: str | None = None,
    ) -> BenchReport[Results]:
        """Measure on this machine.

        quick : small sizes, once each. repeats : runs of which medians are taken. limit : s, for what `self.limit`
        names. postgresql : URL of a server on which databases may be made and dropped.
        """
        options: dict[str, Any] = {}
        if self.repeats:
            options["repeats"] = 1 if quick else repeats
        if self.limit is not None:
            options["limit"] = limit or (self.limit.quick if quick else self.limit.usual)
        if self.server:
            options["postgresql"] = postgresql
        machine = this_machine(self.peers)
        return BenchReport(self, machine, self.measure(quick=quick, say=say, **options))


@dataclass(frozen=True)
class BenchReport(Generic[Results]):
    """What one run of a bench measured, and on which machine."""

    bench: Bench[Results]
    machine: Machine
    results: Results

    @property
    def tables(self) -> Sequence[Table]:
        """What is shown and saved, in order."""
        return self.bench.tables(self.results)

    def save(self, folder: Path) -> None:
        """Write the tables, the machine and the pictures into a folder."""
        page = self.bench.page or self.bench.name
        heading = self.bench.heading or f"# Bench: {page}"
        save(self.tables, self.machine, folder, page, heading, data=self.bench.data)
        self.bench.draw(self.results, folder)
