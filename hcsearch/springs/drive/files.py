"""Files of a drive: its course as a table, or a scene with the drive, which `hcsearch deploy` takes."""

from __future__ import annotations

from hcsearch.scenes.scene_file import scene_file_text
from hcsearch.scenes.setup import scene_of_setup
from hcsearch.shape.labels import labels_of
from hcsearch.springs.deployment.driving import drives_text
from hcsearch.springs.drive.driving import Drive
from hcsearch.springs.drive.facts import drive_table
from hcsearch.system.outputs import write_output, write_table

DRIVE_TABLE_SUFFIXES = (".csv", ".parquet")
"""Endings of files that the course is written to."""
DRIVE_SCENE_SUFFIXES = (".toml",)


def save_drive(drive: Drive, path: str) -> None:
    """Write the course (.csv, .parquet) or a scene with the drive (.toml)."""
    if path.endswith(DRIVE_SCENE_SUFFIXES):
        labels = labels_of(drive.linkage)
        scene = scene_of_setup(drive.setup, drive.scene, labels)
        text = scene_file_text({"design": drive.folding.notation}, "constrained", scene)
        write_output(path, f"{text}\n{drives_text(drive.drives, labels)}")
    else:
        write_table(path, drive_table(drive), DRIVE_TABLE_SUFFIXES)
