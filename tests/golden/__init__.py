"""Published numbers, by the beginning of a table's name."""

import csv
import json
from pathlib import Path
from typing import Any

_TABLES = json.loads(Path(__file__).with_name("published_counts.json").read_text(encoding="utf-8"))["tables"]


def table(name: str) -> dict[str, Any]:
    (found,) = [entry for entry in _TABLES if entry["name"].startswith(name)]
    return found


def values(name: str, step: int = 1) -> dict[int, int]:
    """Value by index; `step` 2 where the index counts pairs of panels."""
    entry = table(name)
    return {step * (entry["offset"] + k): value for k, value in enumerate(entry["values"])}


# Counts of two-stack and untwisted designs, computed on 2026-11-21 by a program independent of this one.
# (grid, n): (fixed, free, two-stack, untwisted)
FOLDABLE = {
    ("hex", 6): (15, 4, 1, 1),
    ("hex", 8): (123, 16, 2, 1),
    ("hex", 10): (1212, 120, 32, 25),
    ("hex", 12): (13265, 1175, 239, 88),
    ("square", 8): (7, 3, 1, 1),
    ("square", 10): (28, 6, 6, 5),
    ("square", 12): (124, 25, 20, 13),
    ("triangle", 10): (3, 1, 1, 1),
    ("triangle", 14): (12, 3, 2, 2),
    ("triangle", 16): (18, 2, 2, 0),
    ("triangle", 18): (65, 12, 10, 10),
}
# (grid, n): (fixed, free, two-stack, untwisted, foldings, untwisted foldings), as the header of the table says.
_LINES = Path(__file__).with_name("tilings.csv").read_text(encoding="utf-8").splitlines()
TILINGS = {
    (tiling, int(n)): tuple(map(int, numbers))
    for tiling, n, *numbers in list(csv.reader(line for line in _LINES if not line.startswith("#")))[1:]
}
# square array: (circuits, classes, two-stack, untwisted)
FOLDABLE_ARRAYS = {"4x4": (6, 2, 2, 2), "6x4": (37, 15, 15, 15), "6x5": (154, 44, 43, 43)}
