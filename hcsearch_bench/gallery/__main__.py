"""Write docs/gallery.md and its pictures: `python -m hcsearch_bench.gallery docs`."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

from hcsearch.cli import hcsearch
from hcsearch_bench.gallery.compression import compress_picture
from hcsearch_bench.gallery.drawings import drawings
from hcsearch_bench.gallery.page import GALLERY_FOLDER, gallery_page
from hcsearch_bench.gallery.screenshots import write_screenshots
from hcsearch_bench.gallery.shown import OTHER_PICTURES, SECTIONS, ShownPicture


def write_gallery(docs: Path) -> None:
    """Write the page and all pictures into the folder of the documentation."""
    folder = docs / GALLERY_FOLDER
    folder.mkdir(exist_ok=True)
    for name, text in drawings():
        (folder / name).write_text(text, encoding="utf-8")
    for shown in [*(picture for section in SECTIONS for picture in section.pictures), *OTHER_PICTURES]:
        if shown.is_exported:
            export_picture(shown, folder)
    write_screenshots(folder, docs / "howto")
    (docs / "gallery.md").write_text(gallery_page(folder), encoding="utf-8")


def export_picture(shown: ShownPicture, folder: Path) -> None:
    """Run the command of a picture, with its file in a folder."""
    words = shlex.split(shown.command)[1:]
    written = folder / shown.written
    hcsearch.main([*words, shown.option, str(written)], standalone_mode=False)
    if shown.written != shown.file:
        compress_picture(written, folder / shown.file, lossless=True)
        written.unlink()


if __name__ == "__main__":
    write_gallery(Path(sys.argv[1]))
