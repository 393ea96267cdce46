"""Sheets as DXF in millimetres, a polyline each on its layer, as AutoCAD 2000 and later read it."""

from __future__ import annotations

from io import StringIO

from hcsearch.export.exported import Exported
from hcsearch.export.settings import Settings
from hcsearch.export.sheets.layouts import COLOURS, sheet_of


def write(exported: Exported, settings: Settings) -> str:
    """The sheet; lines have the colours of their layers."""
    from ezdxf import units  # noqa: PLC0415 - of an extra
    from ezdxf.filemanagement import new  # noqa: PLC0415

    sheet, colours = sheet_of(exported, settings), COLOURS[settings.profile]
    document = new("R2000")
    document.units = units.MM
    space = document.modelspace()
    for layer, lines in sheet.lines.items():
        if not lines:
            continue
        document.layers.add(layer, color=colours[layer][1])
        for line in lines:
            space.add_lwpolyline(line.points, close=line.closed, dxfattribs={"layer": layer})
    text = StringIO()
    document.write(text)
    return text.getvalue()
