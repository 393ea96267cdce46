"""Tables of a motion: for each state the fold angles, the least gap, and the nearest panels."""

from __future__ import annotations

from io import BytesIO
from typing import TYPE_CHECKING

from hcsearch.cases.replay import Replay
from hcsearch.motion.collision.distances import nearest_panels

if TYPE_CHECKING:
    import pandas as pd


def csv_of(motion: Replay) -> str:
    """Return the table of a motion as CSV text, in full precision, with a line of column names."""
    return motion_table_of(motion).to_csv(index=False, lineterminator="\n")


def parquet_of(motion: Replay) -> bytes:
    """Return the table of a motion as a Parquet file."""
    buffer = BytesIO()
    motion_table_of(motion).to_parquet(buffer, index=False)
    return buffer.getvalue()


def motion_table_of(motion: Replay) -> pd.DataFrame:
    """Return the table of a motion, one row per state.

    Columns: `time_s`, or `path_share` from packed 0 to flat 1; `angle_LABEL_rad` of each hinge; `gap_mm` of the nearest
    panels among pairs that share no hinge and do not touch, negative for an overlap; `nearest`, the labels of these
    two; `touching`, the number of pairs that touch.
    """
    import pandas as pd  # noqa: PLC0415 - only here

    labels = motion.labels
    columns = {"time_s" if motion.axis == "time" else "path_share": motion.at}
    columns |= {f"angle_{name}_rad": motion.angles[:, k] for k, name in enumerate(labels.hinges)}
    near = nearest_panels(motion.linkage, motion.angles)
    names = [None if i < 0 else f"{labels.panels[i]} {labels.panels[j]}" for i, j in near.pairs.tolist()]
    return pd.DataFrame({**columns, "gap_mm": 1e3 * near.gaps, "nearest": names, "touching": near.touching})
