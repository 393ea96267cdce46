"""What one run of a bench measured: tables for the terminal, files for a folder."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from hcsearch_bench.run.machine import Machine
from hcsearch_bench.run.tables import Table, save

Say = Callable[[str], None]
"""Called with the name of each step of a bench when it begins."""


@dataclass(frozen=True)
class BenchReport(ABC):
    """All that one run of a bench measured, on a machine.

    page : name of the Markdown file. heading : its beginning, a title `# ...`; `# Bench: PAGE` unless given. data :
        folder of CSV files, below that of the page.
    """

    machine: Machine

    page: ClassVar[str]
    heading: ClassVar[str] = ""
    data: ClassVar[str] = "."

    @property
    @abstractmethod
    def tables(self) -> Sequence[Table]:
        """What is shown and saved, in order."""

    def draw(self, folder: Path) -> None:  # noqa: B027 - most have pictures, and some have none
        """Write pictures into a folder, and what else is no table."""

    def save(self, folder: Path) -> None:
        """Write the tables, the machine and the pictures into a folder."""
        heading = self.heading or f"# Bench: {self.page}"
        save(self.tables, self.machine, folder, self.page, heading, data=self.data)
        self.draw(folder)
