"""What one run of a bench measured: tables for the terminal, files for a folder."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from hcsearch_bench.run.machine import Machine
from hcsearch_bench.run.tables import Table, save


@dataclass(frozen=True)
class Report(ABC):
    """All that one run of a bench measured, on a machine.

    page : name of the Markdown file; heading : begins with a title `# ...`. data : folder of CSV files, below that of
        the page.
    """

    machine: Machine

    page: ClassVar[str]
    heading: ClassVar[str]
    data: ClassVar[str] = "."

    @property
    @abstractmethod
    def tables(self) -> Sequence[Table]:
        """What is shown and saved, in order."""

    def draw(self, folder: Path) -> None:  # noqa: B027 - most have pictures, and some have none
        """Write pictures into a folder, and what else is no table."""

    def save(self, folder: Path) -> None:
        """Write the tables, the machine and the pictures into a folder."""
        save(self.tables, self.machine, folder, self.page, self.heading, data=self.data)
        self.draw(folder)
