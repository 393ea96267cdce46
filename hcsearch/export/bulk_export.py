"""Bulk export: a file for each design of a query."""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from dataclasses import dataclass, replace
from hashlib import sha256
from typing import Any

from hcsearch import store
from hcsearch.basics.errors import DatabaseError, HcsearchError, OutputError
from hcsearch.basics.vocabulary import ReplaySource
from hcsearch.designs.folding import foldings
from hcsearch.export.bulk_targets import BulkTarget, IndexRow
from hcsearch.export.export_files import export_contents, export_subject, exported_case
from hcsearch.export.formats import ExportFormat
from hcsearch.export.settings import ExportSettings
from hcsearch.subjects.case import Case
from hcsearch.subjects.names import stored_circuit
from hcsearch.system.machine import __version__
from hcsearch.system.work_steps import Progress


@dataclass(frozen=True)
class SavedDesigns:
    """What a bulk export wrote.

    Parameters
    ----------
    path
        The folder, the archive or the file.
    written, kept
        Numbers of designs or foldings written now, and kept from an earlier export of the same inputs.
    left_out
        Number of designs left out.
    reason
        Why the first of these was left out.
    faulty
        Number of those written now whose motions have faults, such as a collision.
    """

    path: str
    written: int
    kept: int
    left_out: int
    reason: str
    faulty: int

    @property
    def sentence(self) -> str:
        """The numbers in words."""
        parts = [f"{self.written:,} written"]
        parts += [f"{self.kept:,} kept"] if self.kept else []
        parts += [f"{self.left_out:,} designs left out ({self.reason})"] if self.left_out else []
        parts += [f"motions of {self.faulty:,} collide, are not certified or do not end flat"] if self.faulty else []
        return "; ".join(parts)


@dataclass(frozen=True)
class BulkRequest:
    """What is written of each design: a format with its settings, a motion, and arguments of `resolve` by name."""

    export_format: ExportFormat
    settings: ExportSettings
    motion: ReplaySource | None
    named: dict[str, Any]

    def names(self, database: store.Database, number: int, scene: str) -> list[str]:
        """Return the names of what is written of a design: the design itself, or its foldings where none is the best.

        scene : whose verdicts tell which folding is the best.
        """
        if self.export_format.subject == "array" or store.best_creases(database, [number], scene):
            return [str(number)]
        circuit = stored_circuit(database, *store.find_circuit(database, str(number)))
        return [f"{number}:{folding.crease}" for folding in foldings(circuit)] or [str(number)]

    def export(self, database: store.Database, number: int, name: str, target: BulkTarget) -> _Outcome:
        """Write the files of a design, named by its number or as NUMBER:CREASE, to a target, unless it holds them."""
        case = export_subject(name, self.export_format, self.motion, database, **self.named)
        settings = replace(self.settings, stem=case.stem(number))
        digest = self._digest(case)
        row = IndexRow(f"{settings.stem}{self.export_format.endings[0]}", number, case.title, "", digest)
        if target.holds(row):
            return _Outcome(kept=True)
        exported = exported_case(case, self.export_format, self.motion, settings.state)
        contents = export_contents(exported, self.export_format, settings)
        files = {f"{settings.stem}{ending}": content for ending, content in contents.items()}
        target.add(replace(row, note=exported.sentence), files)
        return _Outcome(faulty=exported.replay is not None and bool(exported.replay.faults))

    def _digest(self, case: Case) -> str:
        """Return a digest of all that the files of a case depend on."""
        parts = [__version__, self.export_format.name, repr(self.settings), str(self.motion), *case.dependencies]
        return sha256("\n".join(parts).encode()).hexdigest()[:16]


@dataclass(frozen=True)
class _Outcome:
    """Whether the files of a design were kept, and whether its motion has faults."""

    kept: bool = False
    faulty: bool = False


def designs_of_query(database: store.Database, query: str, scene: str) -> Sequence[int]:
    """Return the ids of the designs of a query, in their order: eight bytes each, so that no read stays open."""
    with store.stream(database, query, columns="id", scene=scene) as rows:
        return array("q", (number for chunk in rows.chunks for (number,) in chunk))


def export_designs(
    database: store.Database,
    ids: Sequence[int],
    request: BulkRequest,
    target: BulkTarget,
    path: str,
    scene: str,
    progress: Progress | None = None,
) -> SavedDesigns:
    """Write the files of designs one after the other to a target at a path; scene : name of the stored one.

    A design that cannot be exported, such as one without a folding, is left out. HcsearchError if all are.
    """
    written = kept = left_out = faulty = 0
    reason = ""
    for done, number in enumerate(ids):
        if progress is not None:
            progress(done, len(ids), f"design {number}")
        try:
            outcomes = [
                request.export(database, number, name, target) for name in request.names(database, number, scene)
            ]
        except (DatabaseError, OutputError):  # further designs would meet it, too
            raise
        except HcsearchError as error:
            left_out += 1
            reason = reason or f"design {number}: {error}"
            target.add(IndexRow("", number, "", str(error), ""), {})
            continue
        for outcome in outcomes:
            written, kept, faulty = written + (not outcome.kept), kept + outcome.kept, faulty + outcome.faulty
    if left_out == len(ids):
        raise HcsearchError(f"none of {left_out:,} designs can be exported; {reason}")
    return SavedDesigns(path, written, kept, left_out, reason, faulty)
