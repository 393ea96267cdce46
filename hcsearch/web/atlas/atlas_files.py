"""The files of an atlas, made from a database with the results of all its searches."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

from hcsearch.search.pipeline import WorkerPool
from hcsearch.store import Database, count_rows, open_readonly, publish_database
from hcsearch.system.outputs import write_output
from hcsearch.system.work_steps import Progress
from hcsearch.web.atlas.atlas_card import DATABASE_FILE, LICENCE_ADDRESS, card_text, citation, description_text
from hcsearch.web.atlas.atlas_certificates import make_certificates, pack_certificates, proved_foldings
from hcsearch.web.atlas.atlas_counts import atlas_counts, b_files, write_b_files
from hcsearch.web.atlas.atlas_folder import CARD_FILE, CHECKSUM_FILE, DESCRIPTION_FILE, AtlasFolder
from hcsearch.web.atlas.atlas_page import atlas_page
from hcsearch.web.atlas.atlas_request import AtlasRequest
from hcsearch.web.atlas.atlas_tables import write_tables

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
