"""Sheets as SVG, with a group per layer, and as DXF (AutoCAD 2000 and later), in millimetres.

Older versions of Origami Simulator ignore groups and do not close paths, so its profile writes separate line elements.
"""

from __future__ import annotations

import math
from html import escape
from io import StringIO
from itertools import pairwise
from typing import Any

from hcsearch.export.cutting_sheets import LAYER_COLOURS, CuttingSheet, SheetLine
from hcsearch.export.settings import SheetProfile

STROKE_WIDTH = 0.1
"""Line width, mm."""
_LAYER = '\n <g id="{0}" inkscape:groupmode="layer" inkscape:label="{0}">{1}\n </g>'


def svg_of(sheet: CuttingSheet, title: str, profile: SheetProfile) -> str:
    """Return a sheet as SVG; every element has its own colour, since some cutters ignore groups."""
    colours = {layer: colour for layer, (colour, _) in LAYER_COLOURS[profile].items()}
    body = _alone(sheet, colours) if profile == "simulator" else _layers(sheet, colours)
    width, height = _number(sheet.width), _number(sheet.height)
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '
        f'width="{width}mm" height="{height}mm" viewBox="0 0 {width} {height}">'
        f"\n <title>{escape(title)}</title>{body}\n</svg>\n"
    )


def _layers(sheet: CuttingSheet, colours: dict[str, str]) -> str:
    """Return an SVG group for each layer, with a path for each polyline."""
    groups = []
    for layer, lines in sheet.lines.items():
        paths = (f"\n  <path {_look(colours[layer])}{_named(line)} d={_data(line, sheet)}/>" for line in lines)
        groups.append(_LAYER.format(layer, "".join(paths)) if lines else "")
    return "".join(groups)


def _alone(sheet: CuttingSheet, colours: dict[str, str]) -> str:
    """Return a separate SVG line for each segment of a polyline, with the opacity of its fold angle."""
    elements = []
    for layer, lines in sheet.lines.items():
        for line in lines:
            points = [*line.points, *line.points[:1]] if line.closed else line.points
            for (x, y), (to_x, to_y) in pairwise(points):
                ends = f'x1="{_number(x)}" y1="{_number(sheet.height - y)}"'
                ends += f' x2="{_number(to_x)}" y2="{_number(sheet.height - to_y)}"'
                share = "" if line.angle == math.pi else f' stroke-opacity="{line.angle / math.pi:.12g}"'
                elements.append(f"\n <line {_look(colours[layer])}{share} {ends}/>")
    return "".join(elements)


def _look(colour: str) -> str:
    return f'fill="none" stroke="{colour}" stroke-width="{STROKE_WIDTH}"'


def _named(line: SheetLine) -> str:
    return f' data-label="{escape(line.label)}"' if line.label else ""


def _data(line: SheetLine, sheet: CuttingSheet) -> str:
    points = " L ".join(f"{_number(x)} {_number(sheet.height - y)}" for x, y in line.points)
    return f'"M {points}{" Z" if line.closed else ""}"'


def _number(value: float) -> str:
    return f"{value:.5f}".rstrip("0").rstrip(".") if abs(value) > 5e-6 else "0"


SCREEN_RATIO = 4.0 / 3.0
"""Aspect ratio of the narrowest window in which the whole sheet is visible."""


def dxf_of(sheet: CuttingSheet, profile: SheetProfile) -> str:
    """Return a sheet as DXF; lines have the colours of their layers."""
    from ezdxf import units  # noqa: PLC0415 - of an extra
    from ezdxf._options import options  # noqa: PLC0415
    from ezdxf.filemanagement import new  # noqa: PLC0415

    previous = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True  # without time stamps, so that equal exports are equal files
    try:
        return _text(sheet, LAYER_COLOURS[profile], new("R2000"), units.MM)
    finally:
        options.write_fixed_meta_data_for_testing = previous


def _text(sheet: CuttingSheet, colours: dict[str, tuple[str, int]], document: Any, units: int) -> str:
    from ezdxf.bbox import extents  # noqa: PLC0415

    document.units = units
    space = document.modelspace()
    for layer, lines in sheet.lines.items():
        if not lines:
            continue
        document.layers.add(layer, color=colours[layer][1])
        for line in lines:
            space.add_lwpolyline(line.points, close=line.closed, dxfattribs={"layer": layer})
    box = extents(space)
    space.reset_extents(box.extmin, box.extmax)
    low, high = box.extmin.vec2, box.extmax.vec2
    width, height = high - low
    document.set_modelspace_vport(1.1 * max(height, width / SCREEN_RATIO), center=low.lerp(high))
    text = StringIO()
    document.write(text)
    return text.getvalue()
