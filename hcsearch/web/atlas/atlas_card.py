"""The numbers of an atlas and its data card.

The counts are tables of README.md, and b-files of the On-Line Encyclopedia of Integer Sequences (OEIS): lines of n and
a(n). The card is README.md for people, and datapackage.json, a Data Package of Frictionless Data.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import metadata, version
from pathlib import Path
from typing import Any

from hcsearch.basics.vocabulary import listed
from hcsearch.designs.grid.sequences import Sequence as KnownSequence
from hcsearch.designs.grid.sequences import known_sequences
from hcsearch.store import Database, count_rows, summarize
from hcsearch.store.columns import VIEWS
from hcsearch.store.quantity import Quantity
from hcsearch.web.atlas.atlas_folder import REQUEST_KEY
from hcsearch.web.atlas.atlas_request import AtlasRequest

TABLES = ("designs", "foldings")
"""The views that are written."""
PLACE_COLUMNS = (Quantity("grid", "text", "", "tiling"), Quantity("n", "integer", "", "number of panels"))
"""Columns of both tables after the columns of `table_columns`; the view `foldings` does not have them."""
_LEFT_OUT = (*(quantity.name for quantity in PLACE_COLUMNS), "score")
"""Scores are of a user's own rank."""


def table_columns(view: str) -> tuple[Quantity, ...]:
    """Return the columns of the files of a view, without `PLACE_COLUMNS`."""
    return tuple(quantity for quantity in VIEWS[view] if quantity.name not in _LEFT_OUT)


def table_path(view: str, grid: str, n: int) -> Path:
    """Return the path of the file of a view for one size; names are in the order of the sizes."""
    return Path(view, f"{grid}-{n:03}.parquet")


@dataclass(frozen=True)
class CountedQuantity:
    """A number that is counted for each grid and number of panels.

    name : in file names. stage : the one that counts it. meaning : for readers.
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
    """Return the counts of all sizes; counts of stages that have not run are left out."""
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


def _sequence_of(grid: str, counts: str) -> KnownSequence | None:
    return next((s for s in known_sequences() if (s.grid, s.array, s.counts) == (grid, "", counts)), None)


def _lines(title: str, terms: Mapping[int, int]) -> str:
    return f"# {title}\n" + "".join(f"{index} {terms[index]}\n" for index in sorted(terms))


def write_b_files(made: list[BFile], folder: Path) -> None:
    """Write b-files to a folder, which is made."""
    folder.mkdir()
    for one in made:
        (folder / one.name).write_text(one.text, encoding="ascii")


DATABASE_FILE = "atlas.sqlite"
LICENCE = "CC BY 4.0"
LICENCE_ADDRESS = "https://creativecommons.org/licenses/by/4.0/"
_TYPES = {"integer": "integer", "boolean": "integer", "real": "number", "text": "string"}
"""Types of Data Packages; booleans are stored as 0 and 1."""


def citation(request: AtlasRequest) -> str:
    """Return how to cite the atlas."""
    return f"{metadata('hcsearch')['Author']}: {request.title}, made by hcsearch {version('hcsearch')}"


def card_text(
    request: AtlasRequest, counts: Mapping[tuple[str, int], SizeCounts], made: Sequence[BFile], certificates: int | None
) -> str:
    """Return README.md. certificates : their number; None if the stages that give proofs have not run."""
    parts = [
        f"# {request.title}",
        "Flat arrays of equal thick panels that fold into two stacks. A design is a closed walk through all panels of "
        "an array (a Hamiltonian circuit), up to rotation and reflection. This atlas holds every design with "
        f"{request.sizes[0][1]} to {request.n} panels on {listed(request.grids, 'and')}, taken through the stages of "
        f"the program hcsearch up to `{request.until}`. Verdicts are those of the scene `default`.",
        _files(made, certificates),
        "## Counts\n\nWhere designs are undecided, the numbers of those that open are lower bounds.\n\n"
        + _count_table(request, counts),
        *(f"## Columns of {view}\n\n" + _column_table((*PLACE_COLUMNS, *table_columns(view))) for view in TABLES),
        f"## Licence and citation\n\nThe data are published under {LICENCE}, {LICENCE_ADDRESS}. Please cite:\n\n"
        f"> {citation(request)}\n\nThe SHA-256 checksum of the file "
        "`SHA256SUMS` names exactly these files.",
        "## Versions\n\nThe same versions give the same bytes on the same kind of processor; elsewhere, last digits of "
        "measured quantities may differ.\n\n" + _version_table(request),
    ]
    return "\n\n".join(parts) + "\n"


def _files(made: Sequence[BFile], certificates: int | None) -> str:
    rows = [
        ("`index.html`", "a page that searches and draws the designs; open it in a browser, without a server"),
        *(
            (f"`{view}/GRID-N.parquet`", f"{view}; pandas, Arrow and DuckDB read the folder as one table")
            for view in TABLES
        ),
        (
            f"`{DATABASE_FILE}`",
            "an SQLite database with the views `designs`, `foldings`, `motions` and `deployments`; "
            "`hcsearch query --db` takes it",
        ),
    ]
    if certificates is not None:
        rows.append(
            (
                "`certificates/grid=GRID/n=N.zip`",
                f"{certificates:,} certificates of paths and locks, with an index; `hcsearch verify` checks one. "
                "Congruent foldings of a design share one",
            )
        )
    rows += [
        ("`bfiles/`", "counts in the form of the OEIS, `n a(n)`, as listed below"),
        ("`datapackage.json`", "this description for machines (Data Package)"),
        ("`SHA256SUMS`", "checksums; `sha256sum --check SHA256SUMS` checks them"),
    ]
    listed = "\n".join(f"- `{one.name}`: {one.title}" for one in made)
    return f"## Files\n\n{_markdown(('file', 'content'), rows)}\n\nCounts of designs:\n\n{listed}"


def _count_table(request: AtlasRequest, counts: Mapping[tuple[str, int], SizeCounts]) -> str:
    names = [quantity.name for quantity in COUNTED if request.has_run(quantity.stage)]
    rows = [
        (grid, str(n), *(f"{sizes[name]:,}" for name in names))
        for (grid, n), sizes in counts.items()
        if sizes["classes"]
    ]
    return _markdown(("grid", "n", *(name.replace("_", "-") for name in names)), rows)


def _column_table(columns: Sequence[Quantity]) -> str:
    return _markdown(
        ("column", "type", "unit", "meaning"), [(f"`{q.name}`", q.kind, q.unit, q.meaning) for q in columns]
    )


def _version_table(request: AtlasRequest) -> str:
    return _markdown(("of", "version"), list(request.record()["versions"].items()))


def _markdown(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *([cell.replace("|", "\\|") for cell in row] for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def description_text(request: AtlasRequest, tables: Sequence[Path], others: Mapping[str, Sequence[str]]) -> str:
    """Return datapackage.json.

    tables : paths of the Parquet files. others : paths of the other files, by the name of their kind.
    """
    resources: list[dict[str, Any]] = [
        {
            "name": view,
            "path": [path.as_posix() for path in tables if path.parts[0] == view],
            "format": "parquet",
            "schema": {"fields": [_field(quantity) for quantity in (*table_columns(view), *PLACE_COLUMNS)]},
        }
        for view in TABLES
    ]
    resources += [{"name": name, "path": list(paths)} for name, paths in others.items()]
    description = {
        "name": "hcsearch-atlas",
        "title": request.title,
        "description": citation(request),
        "licenses": [{"name": "CC-BY-4.0", "path": LICENCE_ADDRESS}],
        "resources": [resource for resource in resources if resource["path"]],
        REQUEST_KEY: request.record(),
    }
    return json.dumps(description, indent=1) + "\n"


def _field(quantity: Quantity) -> dict[str, str]:
    field = {"name": quantity.name, "type": _TYPES[quantity.kind], "description": quantity.meaning}
    return field | ({"unit": quantity.unit} if quantity.unit else {})
