"""The counts of an atlas, as b-files of the On-Line Encyclopedia of Integer Sequences (OEIS): lines of n and a(n)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from hcsearch.designs.grid.sequences import Sequence, known_sequences
from hcsearch.store import Database, count_rows, summarize
from hcsearch.web.atlas.atlas_request import AtlasRequest


@dataclass(frozen=True)
class CountedQuantity:
    """A number that is counted for each grid and number of panels.

    name : in file names. stage : which counts it. meaning : for readers.
    """

    name: str
    stage: str
    meaning: str


COUNTED = (
    CountedQuantity("circuits", "circuits", "circuits up to translation"),
    CountedQuantity("classes", "circuits", "circuits up to rotation, reflection and translation: designs"),
    CountedQuantity("arrays", "circuits", "arrays that have a circuit, up to congruence"),
    CountedQuantity("two_stack", "foldings", "designs with a two-stack folding"),
    CountedQuantity("untwisted", "twist", "designs with an untwisted folding"),
    CountedQuantity(
        "deployable", "deployment", "designs proved to open, by springs or motors: status deploys or movable"
    ),
    CountedQuantity("deploys", "deployment", "designs that springs alone open"),
    CountedQuantity(
        "undecided", "deployment", "designs of which neither is proved, that they open or that they are locked"
    ),
)
"""The quantities, in the order of stages."""
_TERMS: dict[str, Callable[[int, int], tuple[int, int] | None]] = {
    "a(n)": lambda n, count: (n, count),
    "a(n/2)": lambda n, count: None if n % 2 else (n // 2, count),
    "a(n) 3 / 2n": lambda n, count: (n, 2 * n * count // 3),
}
"""Index and term of a sequence for a count, by the text in `sequences.csv`; None where it has no term."""

SizeCounts = Mapping[str, int]
"""The counts of one size, by name of the quantity."""


def atlas_counts(database: Database, request: AtlasRequest) -> dict[tuple[str, int], SizeCounts]:
    """Return the counts of all sizes; those of stages that have not run are left out."""
    return {(grid, n): _counts_of_size(database, request, grid, n) for grid, n in request.sizes}


def _counts_of_size(database: Database, request: AtlasRequest, grid: str, n: int) -> SizeCounts:
    size = f"grid={grid} n={n}"
    counts = summarize(database, size)
    values = {
        "circuits": counts.fixed,
        "classes": counts.circuits,
        "arrays": counts.arrays,
        "two_stack": counts.two_stack,
        "untwisted": counts.untwisted,
        "deployable": counts.movable,
        "deploys": counts.deploys,
    }
    known = {quantity.name: values.get(quantity.name) or 0 for quantity in COUNTED if request.has_run(quantity.stage)}
    if "undecided" in known:
        known["undecided"] = count_rows(database, f"{size} status=undecided", most=counts.circuits)
    return known


@dataclass(frozen=True)
class BFile:
    """A b-file. name : of the file. title : what it counts. text : its lines."""

    name: str
    title: str
    text: str


def b_files(counts: Mapping[tuple[str, int], SizeCounts], request: AtlasRequest) -> Iterator[BFile]:
    """Yield the b-files of all grids: under the number of the sequence where the OEIS has one, each number once."""
    written = set()
    for grid in request.grids:
        for quantity in COUNTED:
            if not request.has_run(quantity.stage):
                continue
            values = {n: sizes[quantity.name] for (name, n), sizes in counts.items() if name == grid}
            made = _b_file(grid, quantity, values)
            if made.name not in written:
                yield made
            written.add(made.name)


def _b_file(grid: str, quantity: CountedQuantity, values: Mapping[int, int]) -> BFile:
    sequence = _sequence_of(grid, quantity.name)
    title = f"{quantity.meaning}, grid {grid}"
    if sequence is None:
        return BFile(f"{grid}-{quantity.name}.txt", title, _lines(title, dict(values)))
    terms = dict(enumerate(map(int, sequence.leading.split()), int(sequence.offset)))
    terms |= dict(filter(None, (_TERMS[sequence.term](n, count) for n, count in values.items())))
    name = f"b{sequence.number.removeprefix('A')}.txt"
    return BFile(name, f"{sequence.number}: {title}", _lines(f"{sequence.number}: {title}", terms))


def _sequence_of(grid: str, counts: str) -> Sequence | None:
    return next((s for s in known_sequences() if (s.grid, s.array, s.counts) == (grid, "", counts)), None)


def _lines(title: str, terms: Mapping[int, int]) -> str:
    return f"# {title}\n" + "".join(f"{index} {terms[index]}\n" for index in sorted(terms))


def write_b_files(made: list[BFile], folder: Path) -> None:
    """Write b-files to a folder, which is made."""
    folder.mkdir()
    for one in made:
        (folder / one.name).write_text(one.text, encoding="ascii")
