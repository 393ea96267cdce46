"""Sheets as DXF in millimetres, a polyline each on its layer, as AutoCAD 2000 and later read it."""

from __future__ import annotations

from io import StringIO
from typing import Any

from hcsearch.export.cutting_sheets import COLOURS, Sheet
from hcsearch.export.exported import Profile

SCREEN = 4.0 / 3.0
"""Width over height of the narrowest window in which the whole sheet is in view."""


def dxf_of(sheet: Sheet, profile: Profile) -> str:
    """The sheet; lines have the colours of their layers."""
    from ezdxf import units  # noqa: PLC0415 - of an extra
    from ezdxf._options import options  # noqa: PLC0415
    from ezdxf.filemanagement import new  # noqa: PLC0415

    stamped = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True  # no times: two files of one design are equal
    try:
        return _text(sheet, COLOURS[profile], new("R2000"), units.MM)
    finally:
        options.write_fixed_meta_data_for_testing = stamped


def _text(sheet: Sheet, colours: dict[str, tuple[str, int]], document: Any, units: int) -> str:
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
    document.set_modelspace_vport(1.1 * max(height, width / SCREEN), center=low.lerp(high))
    text = StringIO()
    document.write(text)
    return text.getvalue()
