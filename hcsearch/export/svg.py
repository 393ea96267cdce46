"""Sheets as SVG in millimetres, a layer a group, which Inkscape shows as layers."""

from __future__ import annotations

from html import escape

from hcsearch.export.exported import Exported
from hcsearch.export.settings import Settings
from hcsearch.export.sheets import COLOURS, Line, sheet_of

STROKE = 0.1
"""Width of lines, mm."""


def write(exported: Exported, settings: Settings) -> str:
    """The sheet; every element has its own colour, as some cutters heed no groups."""
    sheet, colours = sheet_of(exported, settings), COLOURS[settings.profile]
    groups = []
    for layer, lines in sheet.lines.items():
        if not lines:
            continue
        look = f'fill="none" stroke="{colours[layer][0]}" stroke-width="{STROKE}"'
        paths = "".join(f"\n  <path {look}{_named(line)} d={_data(line, sheet.height)}/>" for line in lines)
        groups.append(f'\n <g id="{layer}" inkscape:groupmode="layer" inkscape:label="{layer}">{paths}\n </g>')
    width, height = _number(sheet.width), _number(sheet.height)
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '
        f'width="{width}mm" height="{height}mm" viewBox="0 0 {width} {height}">'
        f"\n <title>{escape(exported.name)}</title>{''.join(groups)}\n</svg>\n"
    )


def _named(line: Line) -> str:
    return f' data-label="{escape(line.label)}"' if line.label else ""


def _data(line: Line, height: float) -> str:
    points = " L ".join(f"{_number(x)} {_number(height - y)}" for x, y in line.points)
    return f'"M {points}{" Z" if line.closed else ""}"'


def _number(value: float) -> str:
    return f"{value:.5f}".rstrip("0").rstrip(".") if abs(value) > 5e-6 else "0"
