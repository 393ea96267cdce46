"""Triangles of STL files, binary or text, of bounded size."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import InputFileError
from hcsearch.search.own_patterns.fold_values import MAX_COORDINATE
from hcsearch.system.reading import read_binary_file

_HEAD_BYTES = 84
"""The title and the number of triangles of a binary file."""
_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
"""A triangle of a binary file."""
_FACET = re.compile(
    rb"facet\s+normal(?:\s+\S+){3}\s+outer\s+loop((?:\s+vertex(?:\s+\S+){3}){3})\s+endloop\s+endfacet\s*"
)
_CORNERS = re.compile(rb"vertex\s+(\S+)\s+(\S+)\s+(\S+)")


def read_stl(path: Path, max_bytes: int) -> Reals:
    """Return the corners of the triangles of an STL file, (k, 3, 3), in its unit.

    InputFileError as in `read_binary_file`, for a file without triangles, a file that is cut off, and coordinates that
    are not below `MAX_COORDINATE`.
    """
    content = read_binary_file(path, "the mesh", max_bytes)
    count = int.from_bytes(content[_HEAD_BYTES - 4 : _HEAD_BYTES], "little")
    whole = _HEAD_BYTES + count * _RECORD.itemsize
    # the titles of some binary files begin like text
    if len(content) != whole and content.lstrip().startswith(b"solid"):
        corners = _text_corners(content, path)
    elif len(content) < _HEAD_BYTES or len(content) != whole:
        raise _no_mesh(path, f"it has {len(content):,} bytes where its head promises {whole:,}")
    else:
        corners = np.frombuffer(content[_HEAD_BYTES:], _RECORD)["corners"].astype(float)
    if not len(corners):
        raise _no_mesh(path, "it has no triangle")
    if not (np.abs(corners) < MAX_COORDINATE).all():  # never of NaN
        raise _no_mesh(path, f"a corner has a coordinate that is no number below {MAX_COORDINATE:g}")
    return corners


def _text_corners(content: bytes, path: Path) -> Reals:
    """Return the corners of a text file."""
    body = content.partition(b"facet")
    facets, place = [], 0
    text = body[1] + body[2]
    while match := _FACET.match(text, place):
        facets.append(match[1])
        place = match.end()
    if not text[place:].startswith(b"endsolid"):
        raise _no_mesh(path, f"its text breaks off after {len(facets):,} triangles")
    try:
        numbers = [[float(number) for number in corner] for facet in facets for corner in _CORNERS.findall(facet)]
    except ValueError:
        raise _no_mesh(path, "a corner has a coordinate that is no number") from None
    return np.array(numbers).reshape(-1, 3, 3)


def _no_mesh(path: Path, why: str) -> InputFileError:
    return InputFileError(f"{path} is no sound STL file: {why}; export it anew")
