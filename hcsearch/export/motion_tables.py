"""A motion as a table: where, the fold angle of each hinge, the least gap and the panels that are nearest."""

from __future__ import annotations

from io import BytesIO
from typing import TYPE_CHECKING

from hcsearch.cases.replay import Replay
from hcsearch.motion.collision.distances import nearest_panels

if TYPE_CHECKING:
    import pandas as pd


def csv_of(motion: Replay) -> str:
    """Return comma-separated numbers in full digits under a line of names."""
    return motion_table_of(motion).to_csv(index=False, lineterminator="\n")


def parquet_of(motion: Replay) -> bytes:
    """Return the same table as a Parquet file."""
    buffer = BytesIO()
    motion_table_of(motion).to_parquet(buffer, index=False)
    return buffer.getvalue()


def motion_table_of(motion: Replay) -> pd.DataFrame:
    """Return the states of a motion.

    Columns: `time_s`, or `path_share` from packed 0 to flat 1; `angle_LABEL_rad` of each hinge; `gap_mm` of the nearest
    panels that neither a hinge joins nor touch, below 0 where they overlap; `nearest`, these two by their labels;
    `touching`, the number of pairs that touch.
    """
    import pandas as pd  # noqa: PLC0415 - only here

    labels = motion.labels
    columns = {"time_s" if motion.axis == "time" else "path_share": motion.at}
    columns |= {f"angle_{name}_rad": motion.angles[:, k] for k, name in enumerate(labels.hinges)}
    near = nearest_panels(motion.linkage, motion.angles)
    names = [None if one < 0 else f"{labels.panels[one]} {labels.panels[two]}" for one, two in near.pairs.tolist()]
    return pd.DataFrame({**columns, "gap_mm": 1e3 * near.gaps, "nearest": names, "touching": near.touching})
