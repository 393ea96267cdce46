"""Pictures as WebP, which takes a third of the bytes of PNG."""

from __future__ import annotations

from pathlib import Path

from PIL import Image

_QUALITY = 55
"""Of the lossy compression of screenshots: text stays sharp, and each has less than 80 kB."""


def compress_picture(picture: Path, file: Path, *, lossless: bool) -> None:
    """Write a picture as a file .webp, without loss or as a screenshot."""
    with Image.open(picture) as opened:
        opened.convert("RGB").save(file, lossless=lossless, quality=100 if lossless else _QUALITY, method=6)
