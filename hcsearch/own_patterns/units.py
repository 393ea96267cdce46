"""Units of length of drawings, by the names that programs give them."""

from __future__ import annotations

_METRES = {
    "in": (0.0254, ("inch", "inches", '"')),
    "ft": (0.3048, ("foot", "feet")),
    "pt": (0.0254 / 72, ("point", "points")),
    "m": (1.0, ("metre", "metres", "meter", "meters")),
    "cm": (0.01, ("centimetre", "centimetres", "centimeter", "centimeters")),
    "mm": (1e-3, ("millimetre", "millimetres", "millimeter", "millimeters")),
    "um": (1e-6, ("µm", "μm", "micron", "microns", "micrometre", "micrometres", "micrometer", "micrometers")),
    "nm": (1e-9, ("nanometre", "nanometres", "nanometer", "nanometers")),
}
_NAMES = {name: metres for unit, (metres, others) in _METRES.items() for name in (unit, *others)}
_NONE = ("", "unit", "units")


def metres_of(unit: object) -> tuple[float | None, str | None]:
    """Metres to a unit, None where it is no physical one; and what a user should know of a name that is none."""
    if unit is None:
        return None, None
    name = unit.strip().rstrip(".").lower() if isinstance(unit, str) else None
    if name in _NONE:
        return None, None
    if name is not None and name in _NAMES:
        return _NAMES[name], None
    known = ", ".join(_METRES)
    return None, f"frame_unit {unit!r} is no unit of length: sizes are not taken from the file; write {known}"
