"""Exports written to files."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any

from hcsearch.errors import HcsearchError
from hcsearch.export.exported import Exported
from hcsearch.export.formats import FORMATS, Content, Format, format_of
from hcsearch.export.reading import exported_named
from hcsearch.export.settings import NAMES, Settings
from hcsearch.folding import Folding
from hcsearch.replays.sources import By
from hcsearch.subjects.requests import Request
from hcsearch.system.outputs import check_output, replacing
from hcsearch.system.terminal import say


def export(
    subject: str | Folding | Request,
    path: str | Path,
    format: str | None = None,  # noqa: A002 - as the command's option
    *,
    motion: By | None = None,
    db: str = "hcsearch.sqlite",
    **settings: Any,
) -> list[Path]:
    """Write a design, folding or assembly to a file, and return the paths of what was written.

    subject : a folding, or what `hcsearch export` takes: DESIGN[:CREASE], an assembly, a file .toml. format : by its
    name; by the file's ending unless given. motion : `path` or `springs`, where one is exported. settings : `Settings`.
    Errors: HcsearchError for settings that the format does not take, and for wrong input; OutputError.
    """
    wanted = format_of(str(path), format)
    chosen = settings_of(wanted, settings)
    check_output(path)
    wanted.check_installed()
    folding = subject if isinstance(subject, Folding) else None
    request = subject if isinstance(subject, Request) else Request(str(subject), db, folding=folding)
    return write_export(path, wanted, exported_named(request, wanted, motion, chosen.state), chosen)


def settings_of(wanted: Format, given: Mapping[str, Any]) -> Settings:
    """The settings of an export; HcsearchError for those that the format does not heed."""
    for name in given:
        if name not in NAMES:
            raise HcsearchError(f"exports have no setting {name!r}: they have {', '.join(sorted(NAMES))}")
        if name not in wanted.takes:
            option = "--" + name.removesuffix("_mm").removesuffix("_s").replace("_", "-")
            others = ", ".join(other.name for other in FORMATS.values() if name in other.takes)
            raise HcsearchError(
                f"{wanted.name} takes no {option}: leave it out, or choose {others or 'another format'}"
            )
    return Settings(**given)


def write_export(path: str | Path, wanted: Format, exported: Exported, settings: Settings) -> list[Path]:
    """Write what a format makes, all of its files or none, and say on stderr what users should know of it."""
    content = wanted.write(exported, replace(settings, stem=Path(path).stem))
    files: Mapping[str, Content] = content if isinstance(content, Mapping) else {Path(path).suffix: content}
    paths = [Path(path), *(Path(path).with_suffix(ending) for ending in list(files)[1:])]
    with ExitStack() as stack:
        for place, text in zip(paths, files.values(), strict=True):
            part = stack.enter_context(replacing(place))
            part.write_bytes(text.encode() if isinstance(text, str) else text)
    say(exported.sentence)
    return paths
