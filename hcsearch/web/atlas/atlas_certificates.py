"""Certificates of the foldings of an atlas, one archive for each grid and number of panels.

A certificate is kept in the folder of work as soon as it is made, so that an interrupted atlas makes none twice.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from zipfile import ZIP_DEFLATED, ZipFile

from hcsearch.basics.errors import HcsearchError
from hcsearch.designs.folding import Folding
from hcsearch.motion.certificates.certifying import prove_folding
from hcsearch.scenes import SCENES, panel_of
from hcsearch.search.pipeline import WorkerPool
from hcsearch.store import Database, rows_of_designs, select
from hcsearch.system.archives import undated_entry
from hcsearch.system.outputs import write_output
from hcsearch.system.reading import read_text_file
from hcsearch.system.work_steps import Progress

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
