"""The scene file to start from: every value with its default, its unit and one line."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from hcsearch.designs.panel_sizes import PanelSize, default_panel, panel_text
from hcsearch.scenes.scene import Scene


class _Line(NamedTuple):
    """A value of a scene: its key in files, its unit and meaning, and an example where it is not set by default."""

    key: str
    meaning: str
    example: str = ""


_HEAD = """\
# A scene of hcsearch: all that a verdict depends on besides the folding. Each value below has its default.
# Lines that begin with # are not read: remove the # to set such a value. docs/reference/scenes.md explains them all.
# Numbers are in SI units, but for those whose names end in _mm.

# name = "solar"  # of the scene in a database; that of this file unless given
"""
_TOP = (
    _Line("flat_pairs", "how panels at flat creases are joined: rigid, hinged, merged, either, or a list"),
    _Line("held", "the panel that stands still: bottom (the lowest pair), a number, or free (a floating base)"),
)
_SECTIONS = {
    "Panels": (
        _Line("density", "kg/m^3"),
        _Line("areal_mass", "kg/m^2, which replaces the density", "6.5"),
        _Line("equipment", "kg/m^2 of what is mounted on panels, spread through their thickness"),
    ),
    "Springs and dampers": (
        _Line("spring", "the law of all hinges: free, linear:N m/rad, table:FILE.csv or others"),
        _Line("spring_range", "N m/rad, the softest and the stiffest spring that is tried or tuned", "[0.001, 0.2]"),
        _Line("damping_time", "s, damping over stiffness at each hinge"),
        _Line("damping", "N m s/rad at every hinge, which replaces damping_time", "0.0043"),
        _Line("restitution", "of hinge stops, 0 to 1"),
    ),
    "Loads": (
        _Line("gravity", "m/s^2 along x, y, z; z points up from the flat sheet"),
        _Line("drag", "kg/m^3, density of the air times drag coefficient of panels; 0 in a vacuum"),
        _Line("base_mass", "kg of the floating base, where held is free"),
        _Line("base_inertia", "kg m^2, its moments of inertia"),
    ),
    "Simulation": (
        _Line("start", "share of the folded angles at which the motion starts, at rest"),
        _Line("seconds", "s simulated; from panels and springs unless given", "1.0"),
        _Line("stop_stiffness", "N m/rad of stops, in the formulations penalty and compliant"),
        _Line("stop_damping", "N m s/rad of stops"),
        _Line("cut_stiffness", "N/m of springs that close loops"),
        _Line("cut_damping", "N s/m of springs that close loops"),
    ),
    "Hardware as built": (
        _Line("friction", "N m, Coulomb friction of every hinge"),
        _Line("harness", "N m with which a harness resists at every hinge"),
        _Line("latch_stiffness", "N m/rad of the latch of every hinge at the flat state"),
        _Line("stop_tolerance", "rad, error of the flat stop of every hinge, to each side"),
        _Line("play", "rad, play of every hinge, to each side"),
        _Line("thickness_tolerance", "m, of panels, to each side"),
        _Line("offset_tolerance", "m, of hinge lines, to each side"),
        _Line("root", "the panel at which the flat array is mounted: held, a number, or free for none"),
        _Line("craft", "boxes that panels must not touch: [[x, y, z, length, width, height]], m"),
        _Line("envelope", "the box for the folded array, such as 3U or 100x100x340 in mm; empty for none"),
    ),
}
_OF_ONE_DESIGN = """\
# Of single hinges, by their numbers in pictures: for one design, as in hcsearch deploy 17:4 --scene FILE.toml.
# [springs]
# 7 = "linear:0.2"
# [hinges]
# 7 = { damping = 0.01, friction = 0.02, latch_stiffness = 80.0 }
# [releases]
# 7 = "0.5 s"
# 3 = "hinge 7 at 0.2 rad"
"""
_COMMENT_COLUMN = 34


def scene_template(panel: PanelSize | None = None, grid: str | None = None) -> str:
    """Return the text of a scene file with all values of the scene `default`, as comments where these are not set.

    panel : the size of the panels, m. grid : their grid, whose default size is shown where no panel is given.
    """
    size = "length x width x thickness, mm"
    if panel is None:
        shown = panel_text(default_panel(grid or "hex"))
        panel_line = _written(_Line("panel_mm", size, f'"{shown}"'), None)
    else:
        panel_line = _written(_Line("panel_mm", size), panel_text(panel))
    margin = _Line("margin_mm", "mm by which panels are shrunk for collisions; 0.1 on 50 mm, in proportion", "0.1")
    default = Scene()
    values = {line.key: getattr(default, line.key) for lines in (_TOP, *_SECTIONS.values()) for line in lines}
    values["flat_pairs"] = "either"  # all ways, which are the default
    parts = [_HEAD, panel_line, _written(margin, default.margin)]
    parts += [_written(line, values[line.key]) for line in _TOP]
    parts.append("\n[scene]\n")
    for title, lines in _SECTIONS.items():
        parts.append(f"# {title}\n")
        parts += [_written(line, values[line.key]) for line in lines]
    return "".join([*parts, "\n", _OF_ONE_DESIGN])


def template_keys() -> Iterator[str]:
    """Yield the names of the values in the file, as a Scene has them."""
    yield from ("name", "panel", "margin", "springs", "hinges", "releases")
    for lines in (_TOP, *_SECTIONS.values()):
        yield from (line.key for line in lines)


def _written(line: _Line, value: object) -> str:
    """Return one line of the file, a comment where there is no value."""
    if value is None:
        assignment = f"# {line.key} = {line.example}"
    else:
        text = f'"{value}"' if isinstance(value, str) else str(list(value) if isinstance(value, tuple) else value)
        assignment = f"{line.key} = {text}"
    return f"{assignment:{_COMMENT_COLUMN}}# {line.meaning}\n"
