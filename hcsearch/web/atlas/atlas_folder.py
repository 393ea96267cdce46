"""The folder of an atlas: unfinished work, and finished files with their checksums.

Files are made in a folder of work and moved into place when all are there, the checksums last: a folder with checksums
holds a whole atlas.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from hcsearch.basics.errors import InputFileError, OutputError
from hcsearch.system.outputs import make_folder, write_output
from hcsearch.system.reading import read_text_file
from hcsearch.web.atlas.atlas_request import AtlasRequest

CHECKSUM_FILE = "SHA256SUMS"
DESCRIPTION_FILE = "datapackage.json"
CARD_FILE = "README.md"
REQUEST_KEY = "hcsearch"
"""Key of the request in the description."""
_WORK = "work"
_LOCK = "lock"
_REQUEST_FILE = "request.json"
_CHECKSUM_LINE = re.compile(r"(?P<digest>[0-9a-f]{64})  (?P<name>.+)\n")
_PART_NAME = re.compile(r"\.[0-9a-f]+\.part")
"""Names of files that are being written, see `replacing_file`."""
_DESCRIPTION_BYTES = 64 * 2**20


@dataclass(frozen=True)
class AtlasFolder:
    """A folder that holds an atlas, or the work on one."""

    path: Path

    @property
    def work(self) -> Path:
        """The folder of unfinished work, which is removed at the end."""
        return self.path / _WORK

    @property
    def is_complete(self) -> bool:
        """Whether the folder holds a whole atlas."""
        return (self.path / CHECKSUM_FILE).is_file()

    def checksums(self) -> dict[str, str]:
        """Return the SHA-256 checksum of each file of a whole atlas by its path, without files that others added.

        OutputError if the file of checksums is damaged.
        """
        file = self.path / CHECKSUM_FILE
        text = read_text_file(file, max_bytes=_DESCRIPTION_BYTES)
        lines = [_CHECKSUM_LINE.fullmatch(line) for line in text.splitlines(keepends=True)]
        if not all(lines):
            raise self._damaged(f"{file} has a line that is not a checksum, two spaces and a name")
        return {line["name"]: line["digest"] for line in lines if line}

    def new_draft(self) -> Path:
        """Make an empty folder for the files of the atlas."""
        draft = self.work / "draft"
        shutil.rmtree(draft, ignore_errors=True)
        draft.mkdir()
        return draft

    def publish(self, draft: Path) -> None:
        """Write the checksums of a draft, and move its files into place."""
        names = sorted(path.name for path in draft.iterdir())
        write_output(draft / CHECKSUM_FILE, _checksum_lines(draft))
        for name in [*names, CHECKSUM_FILE]:
            _remove(self.path / name)
            (draft / name).rename(self.path / name)

    def check(self) -> None:
        """Raise OutputError if a file of a whole atlas is missing or changed, or has no checksum."""
        checksums = self.checksums()
        for name, digest in checksums.items():
            file = self.path / name
            if not file.is_file() or _digest(file) != digest:
                raise self._damaged(f"{file} is missing or was changed")
        for name in (DESCRIPTION_FILE, CARD_FILE, *_described_files(self.path / DESCRIPTION_FILE)):
            if name not in checksums:
                raise self._damaged(f"{self.path / CHECKSUM_FILE} has no checksum of {name}")

    def _damaged(self, fault: str) -> OutputError:
        return OutputError(f"{fault}: remove {self.path} and build the atlas anew")


@contextmanager
def open_atlas_folder(path: str | Path, request: AtlasRequest) -> Iterator[AtlasFolder]:
    """Open the folder for an atlas, and remove its work at the end if the atlas is whole.

    A folder `work` beside a whole atlas that is not the work of an atlas is left as it is. OutputError for a folder
    with other contents or of another request, and for one in which another process works.
    """
    folder = AtlasFolder(Path(path))
    _check_contents(folder, request)
    make_folder(folder.path)
    if folder.is_complete:
        folder.check()
        if not _is_own_work(folder.work):
            yield folder
            return
    folder.work.mkdir(exist_ok=True)
    with _locked(folder):
        write_output(folder.work / _REQUEST_FILE, json.dumps(request.record(), indent=1) + "\n")
        yield folder
        if folder.is_complete:  # under the lock, which another process would else take
            _remove_work(folder.work)


@contextmanager
def _locked(folder: AtlasFolder) -> Iterator[None]:
    """Hold the lock of the work in a folder, which the system releases if this process is killed."""
    lock = FileLock(folder.work / _LOCK)
    try:
        lock.acquire(timeout=0)
    except Timeout as error:
        raise OutputError(
            f"another process builds the atlas in {folder.path}: wait for it, or name another folder"
        ) from error
    try:
        yield
    finally:
        lock.release()


def _check_contents(folder: AtlasFolder, request: AtlasRequest) -> None:
    if not folder.path.is_dir() or _is_unused(folder):
        return
    recorded = _recorded_request(folder)
    if recorded is None:
        raise OutputError(f"{folder.path} is not empty and holds no atlas: name another folder")
    asked = request.record()
    if asked != recorded:
        raise OutputError(
            f"{folder.path} holds an atlas of {_difference(recorded, asked)}, not of {_difference(asked, recorded)}: "
            "name another folder, or remove it"
        )
    if not folder.is_complete and os.path.lexists(folder.work) and not _is_own_work(folder.work):
        raise OutputError(f"{folder.work} is not the work of an atlas: move it away, or name another folder")
    if not folder.is_complete:
        for place in (folder.path, folder.work):
            _check_links(place)


def _check_links(place: Path) -> None:
    """Refuse links to folders, whose files would be written, or replaced, elsewhere; OutputError."""
    links = [path for path in place.iterdir() if path.is_symlink() and path.is_dir()] if place.is_dir() else []
    if links:
        raise OutputError(f"{min(links)} is a link to a folder elsewhere: move it away, or name another folder")


def _is_unused(folder: AtlasFolder) -> bool:
    """Return whether a folder is empty but for work whose request was not written yet."""
    names = [path.name for path in folder.path.iterdir()]
    return not names or (names == [_WORK] and _is_unbegun_work(folder.work))


def _is_own_work(work: Path) -> bool:
    """Return whether a path is a folder of work on an atlas, and no link to one."""
    return not work.is_symlink() and (_is_unbegun_work(work) or _request_in(work / _REQUEST_FILE) is not None)


def _is_unbegun_work(work: Path) -> bool:
    """Return whether a path is a folder of work whose request was not written yet, and no link to one."""
    if work.is_symlink() or not work.is_dir():
        return False
    return all(path.name == _LOCK or _PART_NAME.fullmatch(path.name) for path in work.iterdir())


def _remove_work(work: Path) -> None:
    """Remove a folder of work; its request last, so that the next call goes on with a removal that was interrupted."""
    for path in work.iterdir():
        if path.name not in {_REQUEST_FILE, _LOCK}:
            _remove(path)
    shutil.rmtree(work)


def _recorded_request(folder: AtlasFolder) -> dict[str, Any] | None:
    """Return the request of the work or of the atlas in a folder; None for a folder of something else."""
    return _request_in(folder.work / _REQUEST_FILE) or _request_in(folder.path / DESCRIPTION_FILE, REQUEST_KEY)


def _request_in(place: Path, key: str | None = None) -> dict[str, Any] | None:
    """Return the request in a file, or in the entry of a file with this key; None where there is none."""
    if not place.is_file():
        return None
    try:
        data = json.loads(read_text_file(place, max_bytes=_DESCRIPTION_BYTES))
    except (InputFileError, ValueError, RecursionError):
        return None
    found = data.get(key) if key is not None and isinstance(data, dict) else data
    return found if _is_request(found) else None


def _is_request(data: Any) -> bool:
    """Return whether data are a request, of any version of this program."""
    versions = data.get("versions") if isinstance(data, dict) else None
    return isinstance(versions, dict) and "hcsearch" in versions


def _described_files(description: Path) -> list[str]:
    """Return the paths that the description of an atlas names; none where it cannot be read."""
    with suppress(OSError, InputFileError, ValueError, RecursionError, KeyError, TypeError):
        data = json.loads(read_text_file(description, max_bytes=_DESCRIPTION_BYTES))
        return [str(path) for resource in data["resources"] for path in resource["path"]]
    return []


def _difference(record: Mapping[str, Any], other: Mapping[str, Any]) -> str:
    """Return the entries of a request that another one lacks, as text."""
    texts = []
    for key, value in record.items():
        if isinstance(value, dict):
            texts.append(_difference(value, other[key] if isinstance(other.get(key), dict) else {}))
        elif other.get(key) != value:
            texts.append(f"{key} {' '.join(map(str, value)) if isinstance(value, list) else value}")
    return ", ".join(filter(None, texts))


def _checksum_lines(folder: Path) -> str:
    """Return the SHA-256 checksums of all files below a folder, as `sha256sum` prints them, in the order of names."""
    names = sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())
    return "".join(f"{_digest(folder / name, sync=True)}  {name}\n" for name in names)


def _digest(path: Path, *, sync: bool = False) -> str:
    """Return the checksum of a file; sync : whether to wait until it is on the disk."""
    if sync:
        with path.open("rb+") as written:
            os.fsync(written.fileno())
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)
