"""The table of a motion as a Parquet file."""

from __future__ import annotations

from io import BytesIO

from hcsearch.export.exported import Exported
from hcsearch.export.settings import Settings
from hcsearch.export.tables.motion_tables import table_of


def write(exported: Exported, settings: Settings) -> bytes:
    """The table that `csv` has."""
    del settings
    buffer = BytesIO()
    table_of(exported).to_parquet(buffer, index=False)
    return buffer.getvalue()
