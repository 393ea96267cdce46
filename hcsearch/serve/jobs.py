"""What a request may have computed, in a process of its own: the page of a design, and files of exports."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from hcsearch.export.formats import FORMATS
from hcsearch.export.reading import exported_named
from hcsearch.export.writing import settings_of
from hcsearch.scenes import DEFAULT
from hcsearch.subjects.reading import Request


@dataclass(frozen=True)
class Made:
    """A file: its name, and what is in it."""

    name: str
    content: bytes


def export_file(
    db: str, subject: str, stem: str, name: str, scene: str, motion: Any, settings: Mapping[str, Any]
) -> Made:
    """An export of a design or folding, named by notation; of several files, an archive. stem : of its name."""
    wanted = FORMATS[name]
    chosen = replace(settings_of(wanted, settings), stem=stem)
    request = Request(subject, db, scene=None if scene == DEFAULT else scene)
    content = wanted.write(exported_named(request, wanted, motion, chosen.state), chosen)
    if not isinstance(content, Mapping):
        return Made(stem + wanted.endings[0], _bytes(content))
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as packed:
        for ending, text in content.items():
            packed.writestr(zipfile.ZipInfo(stem + ending), _bytes(text))
    return Made(f"{stem}{wanted.endings[0]}.zip", archive.getvalue())


def _bytes(content: str | bytes) -> bytes:
    return content.encode() if isinstance(content, str) else content
