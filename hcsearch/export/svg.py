"""Sheets as SVG in millimetres, a layer a group, which Inkscape shows as layers.

Older versions of Origami Simulator read no groups and do not close paths: for it, all lines stand alone.
"""

from __future__ import annotations

from html import escape
from itertools import pairwise

from hcsearch.export.cutting_sheets import COLOURS, Line, Sheet
from hcsearch.export.exported import Profile

STROKE = 0.1
"""Width of lines, mm."""
_LAYER = '\n <g id="{0}" inkscape:groupmode="layer" inkscape:label="{0}">{1}\n </g>'


def svg_of(sheet: Sheet, title: str, profile: Profile) -> str:
    """The sheet; every element has its own colour, as some cutters heed no groups."""
    colours = {layer: colour for layer, (colour, _) in COLOURS[profile].items()}
    body = _alone(sheet, colours) if profile == "simulator" else _layers(sheet, colours)
    width, height = _number(sheet.width), _number(sheet.height)
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '
        f'width="{width}mm" height="{height}mm" viewBox="0 0 {width} {height}">'
        f"\n <title>{escape(title)}</title>{body}\n</svg>\n"
    )


def _layers(sheet: Sheet, colours: dict[str, str]) -> str:
    """A group for each layer, with a path for each polyline."""
    groups = []
    for layer, lines in sheet.lines.items():
        paths = (f"\n  <path {_look(colours[layer])}{_named(line)} d={_data(line, sheet)}/>" for line in lines)
        groups.append(_LAYER.format(layer, "".join(paths)) if lines else "")
    return "".join(groups)


def _alone(sheet: Sheet, colours: dict[str, str]) -> str:
    """An element for each piece of a polyline."""
    elements = []
    for layer, lines in sheet.lines.items():
        for line in lines:
            points = [*line.points, *line.points[:1]] if line.closed else line.points
            for (x, y), (to_x, to_y) in pairwise(points):
                ends = f'x1="{_number(x)}" y1="{_number(sheet.height - y)}"'
                ends += f' x2="{_number(to_x)}" y2="{_number(sheet.height - to_y)}"'
                elements.append(f"\n <line {_look(colours[layer])} {ends}/>")
    return "".join(elements)


def _look(colour: str) -> str:
    return f'fill="none" stroke="{colour}" stroke-width="{STROKE}"'


def _named(line: Line) -> str:
    return f' data-label="{escape(line.label)}"' if line.label else ""


def _data(line: Line, sheet: Sheet) -> str:
    points = " L ".join(f"{_number(x)} {_number(sheet.height - y)}" for x, y in line.points)
    return f'"M {points}{" Z" if line.closed else ""}"'


def _number(value: float) -> str:
    return f"{value:.5f}".rstrip("0").rstrip(".") if abs(value) > 5e-6 else "0"
