"""The files of an atlas, made from a database with the results of all its searches.

Designs and foldings are Parquet files, one for each grid and number of panels. Grid and number are columns of the
files: from names of folders (`n=8`) pandas would read them as categories, which do not compare with numbers.
Certificates stand in one archive for each grid and number of panels. A certificate is kept in the folder of work as
soon as it is made, so that an interrupted atlas makes none twice. The page is a report on all designs, which searches
them without a server.
"""

from __future__ import annotations

import csv
import hashlib
import io
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from zipfile import ZIP_DEFLATED, ZipFile

from hcsearch.basics.errors import HcsearchError
from hcsearch.designs.folding import Folding
from hcsearch.motion.certificates.certifying import prove_folding
from hcsearch.scenes import SCENES, panel_of
from hcsearch.search.pipeline import WorkerPool
from hcsearch.store import (
    Database,
    Rows,
    count_rows,
    open_readonly,
    publish_database,
    rows_of_designs,
    select,
    stream,
    write_parquet_rows,
)
from hcsearch.system.outputs import undated_entry, write_output
from hcsearch.system.reading import read_text_file
from hcsearch.system.work_steps import Progress
from hcsearch.web.atlas.atlas_card import (
    DATABASE_FILE,
    LICENCE,
    LICENCE_ADDRESS,
    PLACE_COLUMNS,
    TABLES,
    atlas_counts,
    b_files,
    card_text,
    citation,
    description_text,
    table_columns,
    table_path,
    write_b_files,
)
from hcsearch.web.atlas.atlas_folder import CARD_FILE, CHECKSUM_FILE, DESCRIPTION_FILE, AtlasFolder
from hcsearch.web.atlas.atlas_request import AtlasRequest
from hcsearch.web.report.data import fetch_report_data
from hcsearch.web.report.page_files import render_report

MAX_ATLAS_PAGE_DESIGNS = 200_000
"""Greatest number of designs on the page, which a browser still loads in seconds; the page names the total."""


def atlas_page(database: Database, request: AtlasRequest) -> str:
    """Return the page with the designs of an atlas, best first."""
    data = fetch_report_data(database, "", MAX_ATLAS_PAGE_DESIGNS)
    meta = [(name, value) for name, value in data.meta if name in {"grid", "n", "scene", "hcsearch"}]
    return render_report(
        replace(
            data,
            title=request.title,
            meta=[*meta, ("licence", LICENCE), ("files", "README.md")],
            database_option=f" --db {DATABASE_FILE}",
        )
    )


_PROVED = ("path_proved", "kept_apart", "locked_at_end")
"""Evidence for a status that is a proof."""
_MAX_BYTES = 256 * 2**20


@dataclass(frozen=True)
class ProvedFolding:
    """A folding for which the search has proved a path or a lock.

    design_id : in the atlas. notation : of the folding.
    """

    design_id: int
    notation: str

    @property
    def file_name(self) -> str:
        """Name of the file of its certificate."""
        return f"{self.notation.replace(':', '-')}.json"


def proved_foldings(database: Database, grid: str, n: int) -> list[ProvedFolding]:
    """Return the foldings of one size with a proof, one for each set of congruent ones, by design and crease."""
    designs = select(database, f"grid={grid} n={n} untwisted", columns="id,circuit", sort="id").records()
    ids = [design["id"] for design in designs]
    circuits = {design["id"]: design["circuit"] for design in designs}
    motions = {(row["design_id"], row["crease"]): row for row in rows_of_designs(database, "motions", ids)}
    proved = []
    for folding in rows_of_designs(database, "foldings", ids):
        motion = motions.get((folding["design_id"], folding["crease"]), {})
        has_path = motion.get("flat_pairs") is not None
        if (has_path or folding["known"] in _PROVED) and motion.get("as_crease") is None:
            notation = f"{circuits[folding['design_id']]}:{folding['crease']}"
            proved.append(ProvedFolding(folding["design_id"], notation))
    return proved


def certified(notation: str) -> str:
    """Prove a folding in the scene `default`; return certificate and sentences, or why there are none, as JSON."""
    folding, scene = Folding.from_notation(notation), SCENES["default"]
    panel = panel_of(scene, folding.circuit.grid.name)
    try:
        data, sentences = prove_folding(folding, panel, scene.flat_pairs, scene.margin)
    except HcsearchError as error:
        return json.dumps({"certificate": None, "sentences": [str(error)]})
    return json.dumps({"certificate": data, "sentences": sentences}, separators=(",", ":"))


def make_certificates(proved: Sequence[ProvedFolding], kept: Path, workers: WorkerPool, progress: Progress) -> None:
    """Make the certificates of foldings that are not made yet. kept : the folder for them, which is made."""
    kept.mkdir(exist_ok=True)
    missing = [folding for folding in proved if not (kept / folding.file_name).is_file()]
    done = len(proved) - len(missing)
    progress(done, len(proved), "none made yet" if not done else "made before")
    notations = [folding.notation for folding in missing]
    results = workers.map_ordered(certified, notations, parcel_size=1)
    for count, (folding, (_, text)) in enumerate(zip(missing, results, strict=True), done + 1):
        write_output(kept / folding.file_name, text)
        progress(count, len(proved), folding.notation)


def pack_certificates(proved: Sequence[ProvedFolding], kept: Path, path: Path) -> int:
    """Write the certificates of foldings to an archive with an index, and return their number."""
    path.parent.mkdir(parents=True, exist_ok=True)
    index = io.StringIO()
    rows = csv.writer(index, lineterminator="\n")
    rows.writerow(["file", "id", "folding", "proves"])
    count = 0
    with ZipFile(path, "w", ZIP_DEFLATED) as archive:
        for folding, text, sentence in _read(proved, kept):
            rows.writerow([folding.file_name if text else "", folding.design_id, folding.notation, sentence])
            if text is not None:
                archive.writestr(undated_entry(folding.file_name), text)
                count += 1
        archive.writestr(undated_entry("index.csv"), index.getvalue())
    return count


def _read(proved: Sequence[ProvedFolding], kept: Path) -> Iterator[tuple[ProvedFolding, str | None, str]]:
    """Yield each folding with its certificate as JSON, None without one, and what it proves or why there is none."""
    for folding in proved:
        made = json.loads(read_text_file(kept / folding.file_name, max_bytes=_MAX_BYTES))
        data = made["certificate"]
        text = None if data is None else json.dumps(data, separators=(",", ":")) + "\n"
        yield folding, text, "; ".join(made["sentences"])


def write_tables(database: Database, folder: Path, request: AtlasRequest, notes: dict[str, str]) -> list[Path]:
    """Write the files of all sizes that have designs, in the order of sizes; return their paths in the folder.

    notes : metadata of each file.
    """
    written = []
    for grid, n in request.sizes:
        size = f"grid={grid} n={n}"
        bounds = [select(database, size, columns="id", sort=sort, limit=1).rows for sort in ("id", "-id")]
        if not bounds[0]:
            continue
        # the designs of one size are numbered one after the other
        ((first,),), ((last,),) = bounds
        for view, query in zip(TABLES, (size, f"design_id>={first} design_id<={last}"), strict=True):
            path = table_path(view, grid, n)
            (folder / view).mkdir(exist_ok=True)
            _write_table(database, view, query, (grid, n), folder / path, notes)
            written.append(path)
    return written


def _write_table(
    database: Database, view: str, query: str, size: tuple[str, int], path: Path, notes: dict[str, str]
) -> None:
    columns = (*table_columns(view), *PLACE_COLUMNS)
    described = {quantity.name: {"description": quantity.meaning, "unit": quantity.unit} for quantity in columns}
    with stream(database, query, view=view, columns=[quantity.name for quantity in table_columns(view)]) as rows:
        kinds = (*rows.kinds, *(quantity.kind for quantity in PLACE_COLUMNS))
        placed = ([(*row, *size) for row in chunk] for chunk in rows.chunks)
        write_parquet_rows(Rows(tuple(described), kinds, placed), path, described, notes)


_PAGE_FILE = "index.html"


@dataclass(frozen=True)
class Atlas:
    """A finished atlas.

    Parameters
    ----------
    path
        Its folder.
    designs, foldings, files
        Their numbers.
    size
        Size of all files, bytes.
    checksum
        SHA-256 of the file of checksums, which is equal for equal atlases.
    """

    path: Path
    designs: int
    foldings: int
    files: int
    size: int
    checksum: str


def write_atlas(
    folder: AtlasFolder, source: Path, request: AtlasRequest, workers: WorkerPool, progress: Progress
) -> None:
    """Make all files of an atlas and move them into its folder.

    source : the database with the results, which no other program writes.
    """
    draft = folder.new_draft()
    publish_database(source, draft / DATABASE_FILE, request.sizes)
    with open_readonly(draft / DATABASE_FILE) as database:
        count, archives = _write_archives(database, folder, draft, request, workers, progress)
        notes = {"title": request.title, "license": LICENCE_ADDRESS, "citation": citation(request)}
        tables = write_tables(database, draft, request, notes | {"hcsearch": version("hcsearch")})
        counts = atlas_counts(database, request)
        made = list(b_files(counts, request))
        write_b_files(made, draft / "bfiles")
        write_output(draft / _PAGE_FILE, atlas_page(database, request))
    write_output(draft / CARD_FILE, card_text(request, counts, made, count))
    others = {
        "database": [DATABASE_FILE],
        "certificates": archives,
        "bfiles": [f"bfiles/{one.name}" for one in made],
        "page": [_PAGE_FILE],
    }
    write_output(draft / DESCRIPTION_FILE, description_text(request, tables, others))
    folder.publish(draft)


def _write_archives(
    database: Database,
    folder: AtlasFolder,
    draft: Path,
    request: AtlasRequest,
    workers: WorkerPool,
    progress: Progress,
) -> tuple[int | None, list[str]]:
    """Write the archives of certificates; return the number of certificates and the paths, None before the proofs."""
    if not request.has_run("motion"):
        return None, []
    of_sizes = {size: proved_foldings(database, *size) for size in request.sizes}
    kept = folder.work / "certificates"
    make_certificates([one for proved in of_sizes.values() for one in proved], kept, workers, progress)
    count, paths = 0, []
    for (grid, n), proved in of_sizes.items():
        if proved:
            paths.append(f"certificates/grid={grid}/n={n}.zip")
            count += pack_certificates(proved, kept, draft / paths[-1])
    return count, paths


def atlas_in(folder: AtlasFolder) -> Atlas:
    """Return the numbers of a finished atlas."""
    files = [folder.path / name for name in (*folder.checksums(), CHECKSUM_FILE)]
    with open_readonly(folder.path / DATABASE_FILE) as database:
        designs, foldings = (count_rows(database, view=view, most=2**62) for view in ("designs", "foldings"))
    checksum = hashlib.sha256((folder.path / CHECKSUM_FILE).read_bytes()).hexdigest()
    size = sum(path.stat().st_size for path in files)
    return Atlas(folder.path, designs, foldings, len(files), size, checksum)
