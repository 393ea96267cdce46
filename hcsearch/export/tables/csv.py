"""The table of a motion as comma-separated values."""

from __future__ import annotations

from hcsearch.export.exported import Exported
from hcsearch.export.settings import Settings
from hcsearch.export.tables.motion_tables import table_of


def write(exported: Exported, settings: Settings) -> str:
    """Lines of numbers in full digits under a line of names."""
    del settings
    return table_of(exported).to_csv(index=False, lineterminator="\n")
