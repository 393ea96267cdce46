"""Sequences of the On-Line Encyclopedia of Integer Sequences (OEIS) that count circuits."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from functools import cache
from pathlib import Path


@dataclass(frozen=True)
class Sequence:
    """A sequence of the OEIS.

    number : its number, such as A036418. grid : the name of the grid. array : the arrays that it counts on, as
    specifications with letters for sizes; '' for all arrays of n cells. counts : `circuits`, or `classes` of these.
    term : the count as a term of the sequence. lattice : the graph of cells, as it is known to mathematicians.
    offset, leading : for sequences of all arrays, the first index, and the terms for less than three cells, with
    spaces; both are texts.
    """

    number: str
    grid: str
    array: str
    counts: str
    term: str
    lattice: str
    offset: str
    leading: str


@cache
def known_sequences() -> tuple[Sequence, ...]:
    """Return the sequences in `sequences.csv`, in its order."""
    with Path(__file__).with_name("sequences.csv").open(encoding="utf-8", newline="") as lines:
        return tuple(Sequence(**row) for row in csv.DictReader(lines))


def polygon_sequence(grid: str, counts: str) -> str | None:
    """Return the number of the sequence that counts circuits, or classes, of all arrays of n cells; None if unknown."""
    return next((s.number for s in known_sequences() if (s.grid, s.array, s.counts) == (grid, "", counts)), None)
