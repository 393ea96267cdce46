"""Files of a drive: its course as a table, or a scene with the drive, which `hcsearch deploy` takes."""

from __future__ import annotations

from hcsearch.scenes.scene_file import file_text
from hcsearch.scenes.setup import written
from hcsearch.shape.labels import labels_of
from hcsearch.springs.deployment.driving import drives_text
from hcsearch.springs.drive.driving import Drive
from hcsearch.springs.drive.facts import table
from hcsearch.system.outputs import write_output, write_table

TABLES = (".csv", ".parquet")
"""Endings of files that the course is written to."""
SCENES = (".toml",)


def save(drive: Drive, path: str) -> None:
    """Write the course (.csv, .parquet) or a scene with the drive (.toml)."""
    if path.endswith(SCENES):
        labels = labels_of(drive.linkage)
        scene = written(drive.setup, drive.scene, labels)
        text = file_text({"design": drive.folding.notation}, "constrained", scene)
        write_output(path, f"{text}\n{drives_text(drive.drives, labels)}")
    else:
        write_table(path, table(drive), TABLES)
