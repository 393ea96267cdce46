"""The page docs/gallery.md: the pictures in tables, each above its sentence, its outcome and its command."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from html import unescape
from pathlib import Path

from hcsearch_bench.gallery.shown import SECTIONS, Section, ShownPicture

GALLERY_FOLDER = "gallery"
"""The folder of the pictures, beside the page."""
_COLUMNS = 3
_HEAD = """\
# Gallery

Each picture moves from the packed towards the flat state and back. Below it stand what the program found and the
command that makes the picture, or that prints the design where nothing moves. Mountain hinges are red, valley hinges
blue. The pictures are SVG files without scripts; where a reader asks for reduced motion, they stand still.

`make gallery` makes this page and its pictures.
"""


def gallery_page(folder: Path) -> str:
    """Return the page; folder : of the pictures, whose titles state the outcomes."""
    return "\n".join([_HEAD, *("\n".join(_section(section, folder)) for section in SECTIONS)])


def _section(section: Section, folder: Path) -> Iterator[str]:
    yield f"## {section.heading}\n"
    yield f"{section.text}\n"
    for first in range(0, len(section.pictures), _COLUMNS):
        yield from _table(section.pictures[first : first + _COLUMNS], folder)
        yield ""


def _table(row: Sequence[ShownPicture], folder: Path) -> Iterator[str]:
    cells = [
        [f"**{shown.title}**" for shown in row],
        [f"![{shown.title}]({GALLERY_FOLDER}/{shown.file})" for shown in row],
        [_caption(shown, folder) for shown in row],
    ]
    for number, line in enumerate(cells):
        yield f"| {' | '.join(line)} |"
        if number == 0:
            yield f"|{'---|' * len(row)}"


def _caption(shown: ShownPicture, folder: Path) -> str:
    parts = [shown.sentence, _outcome(folder / shown.file) if shown.is_exported else "", f"`{shown.whole_command}`"]
    return "<br>".join(part for part in parts if part)


def _outcome(picture: Path) -> str:
    """What the program says of the motion: the title of its picture, without the name."""
    found = re.search("<title>[^,]*, (.*?)</title>", picture.read_text(encoding="utf-8"))
    assert found, picture
    text = unescape(found.group(1)).replace("'", "`")
    return f"{text[0].upper()}{text[1:]}."
