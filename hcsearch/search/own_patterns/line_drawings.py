"""Crease patterns as lists of lines: the files `.cp` of Orihime, Oriedita and other editors, and `.opx` of ORIPA.

Sources: `.cp` is a line `type x1 y1 x2 y2` for each crease, with the types of Orihime; `.opx` is the output of Java's
`XMLEncoder` for ORIPA's class `OriLineProxy`, without values that are 0. In both, y points down, and lines need neither
end nor cross at common points.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple
from xml.etree import ElementTree as Xml

from hcsearch.basics.errors import InputFileError
from hcsearch.search.own_patterns.fold_reading import PatternDrawing, drawing_of_data
from hcsearch.search.own_patterns.fold_values import MAX_COORDINATE, MAX_FOLD_ENTRIES, is_finite_number
from hcsearch.shape.mesh import PlanePoint
from hcsearch.system.reading import read_text_file

MAX_LINE_FILE_BYTES = 8 * 2**20
LINE_LETTERS = {1: "B", 2: "M", 3: "V"}
"""The assignments of the types of lines of both formats. All other types are auxiliary lines, which do not fold."""
_AUXILIARY = "J"
_DOCTYPE = re.compile(r"<!DOCTYPE[^][<>]*>")
"""A document type that only names itself."""


class CreaseLine(NamedTuple):
    """A line of a drawing: its assignment, its ends with y up, and the fold angle (degrees) that is stated."""

    letter: str
    start: PlanePoint
    end: PlanePoint
    angle: float | None = None


def read_cp(path: str) -> PatternDrawing:
    """Read a file `.cp`; InputFileError as in `read_text_file`, and where it holds no flat pattern."""
    lines = []
    for number, text in enumerate(read_text_file(path, max_bytes=MAX_LINE_FILE_BYTES).splitlines(), 1):
        words = text.split()
        if not words:
            continue
        values = list(map(_number, words))
        if len(words) != 5 or not re.fullmatch("[0-9]{1,2}", words[0]) or None in values:
            raise InputFileError(
                f"{path}: line {number}: {text.strip()!r:.60} is no line of a file .cp: write type x1 y1 x2 y2, with "
                "the types 1 (border), 2 (mountain), 3 (valley) and 4 (auxiliary)"
            )
        _, x1, y1, x2, y2 = (value or 0.0 for value in values)
        lines.append(CreaseLine(LINE_LETTERS.get(int(words[0]), _AUXILIARY), (x1, -y1), (x2, -y2)))
    return drawing_of_lines(lines, path, left_out=_left_out(lines))


def read_opx(path: str) -> PatternDrawing:
    """Read a file `.opx`; InputFileError as in `read_xml`, and where it holds no flat pattern."""
    lines = []
    for number, line in enumerate(read_xml(path).iterfind(".//object[@class='oripa.OriLineProxy']")):
        values = dict.fromkeys(("type", "x0", "y0", "x1", "y1"), 0.0)
        for part in line.iterfind("void[@property]"):
            name, value = part.get("property", ""), _number(part.findtext("*", "").strip())
            if name in values and value is None:
                raise InputFileError(
                    f"{path} is no sound file of ORIPA: {name} of line {number} is no number below {MAX_COORDINATE:g}; "
                    "save it anew, or export it as FOLD"
                )
            values[name] = value or 0.0
        letter = LINE_LETTERS.get(int(values["type"]), _AUXILIARY)
        lines.append(CreaseLine(letter, (values["x0"], -values["y0"]), (values["x1"], -values["y1"])))
    return drawing_of_lines(lines, path, left_out=_left_out(lines))


def _left_out(lines: Sequence[CreaseLine]) -> str:
    """Return a clause on auxiliary lines; empty without any."""
    has_any = any(line.letter == _AUXILIARY for line in lines)
    return "left out are auxiliary lines, of other types than 1, 2 and 3" if has_any else ""


def drawing_of_lines(
    lines: Sequence[CreaseLine], path: str, unit: str | None = None, left_out: str = ""
) -> PatternDrawing:
    """Return the drawing that lines make; unit : of length, as in FOLD files. left_out : a clause, a remark or empty.

    InputFileError for no flat pattern, with this clause.
    """
    if not lines:
        raise InputFileError(f"{path} is no crease pattern: it has no line; draw one, or export it as FOLD")
    if 2 * len(lines) > MAX_FOLD_ENTRIES:
        raise InputFileError(f"{path} has {len(lines):,} lines: take at most {MAX_FOLD_ENTRIES // 2:,}")
    data = {
        "vertices_coords": [list(point) for line in lines for point in (line.start, line.end)],
        "edges_vertices": [[2 * k, 2 * k + 1] for k in range(len(lines))],
        "edges_assignment": [line.letter for line in lines],
        "edges_foldAngle": [line.angle for line in lines],
        "frame_unit": unit,
    }
    try:
        drawing = drawing_of_data(data, path)
    except InputFileError as error:
        raise InputFileError("; ".join(filter(None, (str(error), left_out)))) from None
    return replace(drawing, remarks=(*filter(None, [left_out]), *drawing.remarks))


def read_xml(path: str) -> Xml.Element:
    """Return the root of a drawing in XML.

    InputFileError as in `read_text_file`, for a file that is no XML, and for one whose document type declares entities,
    which may expand to any size.
    """
    text = _DOCTYPE.sub("", read_text_file(path, max_bytes=MAX_LINE_FILE_BYTES), count=1)
    if "<!DOCTYPE" in text:
        raise InputFileError(f"{path} declares entities in its document type (DOCTYPE): export it without them")
    try:
        return Xml.fromstring(text)
    except (Xml.ParseError, ValueError) as error:  # a declared encoding may be unknown
        raise InputFileError(f"{path} is no XML: {error}; save it anew, or export it as FOLD") from None


def _number(text: str) -> float | None:
    """Return the number of a text; None for other texts, and beyond `MAX_COORDINATE`."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if is_finite_number(value) else None
