"""Scenes: everything besides the folding on which a verdict depends. SI units."""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass, field, fields, replace
from inspect import cleandoc
from typing import Any

from hcsearch.basics.errors import HcsearchWarning, SceneError
from hcsearch.basics.vocabulary import WAYS, Way
from hcsearch.designs.grid import GRIDS
from hcsearch.designs.panel_sizes import (
    ACROSS_FLATS_PREFIX,
    PanelSize,
    default_panel,
    panel_size_doubt,
    panel_text,
    read_panel,
)
from hcsearch.scenes.values import (
    AMOUNT,
    BOXES,
    ENVELOPE,
    FRACTION,
    JOININGS,
    LAW,
    LENGTH_IN_MM,
    NAME,
    POSITIVE,
    SIZE,
    SMALL_ANGLE,
    SMALL_LENGTH,
    SceneValue,
    ValueKind,
    by_hinge,
    numbers,
    panel_or,
    read_law,
    read_release,
)

SceneVector = tuple[float, float, float]
CraftBox = tuple[float, float, float, float, float, float]
"""A box of the craft's body: its least x, y, z and its length, width and height, m."""

DEFAULT_SCENE_NAME = "default"
"""The scene used where none is named."""
HARDWARE_SECTION = "Hardware as built"
_NAME = re.compile(r"[A-Za-z][\w.+-]{0,39}(?: [\w.+-]+)*", re.ASCII)


def _value(default: Any, unit: str, meaning: str, kind: ValueKind = AMOUNT, **facts: Any) -> Any:
    """Return a field of `Scene` with its row of the table; facts : the rest of `SceneValue`."""
    return field(default=default, metadata={"row": SceneValue(unit, meaning, kind, default, **facts)})


def _read_own(hinge: str, given: Any) -> tuple[tuple[str, float], ...]:
    """Parse the values of a single hinge."""
    for name in dict(given):
        if name not in HINGE_VALUES:
            raise SceneError(f"hinge {hinge} has no {name!r}: it has {', '.join(HINGE_VALUES)}")
    return tuple((name, SCENE_VALUES[name].read(value)) for name, value in dict(given).items())


@dataclass(frozen=True, repr=False)
class Scene:
    """All data besides the folding on which a verdict depends: panels, springs, gravity and the start.

    A field is a row of the table of values. The last ones, from `friction` on, describe the hardware as built.
    """

    name: str = _value(
        DEFAULT_SCENE_NAME, "", "the name in a database; that of the file unless given", NAME, example="solar"
    )
    panel: PanelSize | None = _value(
        None,
        "m",
        "the length, width and thickness of panels",
        SIZE,
        unset="50x50x6, of rectangles 50x40x6, of assemblies their own",
    )
    margin: float | None = _value(
        None,
        "m",
        "by how much panels are shrunk on every face for collisions",
        LENGTH_IN_MM,
        unset="0.1 mm on 50 mm, in proportion to the longest edge",
        example=1e-4,
    )
    flat_pairs: tuple[Way, ...] = _value(
        WAYS,
        "",
        "how panels at flat creases are joined: rigid, hinged, merged, either, or a list in the order of trial",
        JOININGS,
        more="Where they are merged, the two panels of each mirror pair are one, too. `either` means all three.",
    )
    held: str = _value(
        "bottom",
        "",
        "the panel that is held fixed: a number, bottom (the lowest pair), or free (a floating base)",
        panel_or("bottom", "free"),
        option=("loads", "PANEL|free"),
        unset="the lowest pair, of assemblies panel 0",
    )
    density: float = _value(547.0, "kg/m^3", "the density of panels", POSITIVE, section="Panels")
    areal_mass: float | None = _value(
        None, "kg/m^2", "the mass of panels per area, which replaces the density", POSITIVE, example=6.5
    )
    spring: str = _value(
        "linear:0.1",
        "",
        "the law of every spring, such as linear:0.1 (N m/rad)",
        LAW,
        section="Springs and dampers",
        more="docs/reference/scenes.md lists the laws. The points of a table take the place of its file.",
        option=("springs", "LAW"),
    )
    springs: tuple[tuple[str, str], ...] = _value(
        (),
        "",
        "the laws of single hinges, by their numbers in pictures",
        by_hinge(
            read_law, "write { 3 = 'linear:0.2' }, a law for each hinge", "law, such as (('7', 'linear:0.2'),)", dict
        ),
        example={"7": "linear:0.2"},
    )
    spring_range: tuple[float, float] | None = _value(
        None,
        "N m/rad",
        "the softest and the stiffest spring that is tried or tuned",
        numbers(2, "give the softest and the stiffest, N m/rad, such as 0.001,0.2", 0.0, rising=True),
        unset="bounds derived from springs and weight",
        example=(0.001, 0.2),
    )
    damping_time: float = _value(0.043, "s", "the damping of each hinge over its stiffness")
    damping: float | None = _value(
        None,
        "N m s/rad",
        "the damping of every hinge, which replaces damping_time",
        by_hinge=True,
        option=("springs", "C"),
        unset="0.043 s x stiffness",
        example=0.0043,
    )
    gravity: SceneVector = _value(
        (0.0, 0.0, 0.0),
        "m/s^2",
        "gravity along x, y and z, which points up from the flat sheet",
        numbers(3, "give x,y,z in m/s^2, such as 0,0,-9.81"),
        section="Loads",
        unset="none",
        option=("loads", "X,Y,Z"),
    )
    drag: float = _value(
        0.0,
        "kg/m^3",
        "the density of the air times the drag coefficient of panels",
    )
    base_mass: float = _value(0.0, "kg", "the mass of the floating base, where held is free")
    base_inertia: SceneVector = _value(
        (0.0, 0.0, 0.0),
        "kg m^2",
        "the moments of inertia of that base about the centre of the panel",
        numbers(3, "give three moments of inertia, kg m^2, such as 0.0067,0.0067,0.0067", 0.0),
    )
    start: float = _value(
        0.999,
        "",
        "the share of the folded angles at which the motion starts, at rest",
        FRACTION,
        section="Simulation",
        option=("springs", "SHARE"),
    )
    restitution: float = _value(0.0, "", "the restitution of hinge stops, 0 to 1", FRACTION, option=("springs", "E"))
    seconds: float | None = _value(
        None,
        "s",
        "how long the motion is simulated",
        POSITIVE,
        option=("time", "S"),
        unset="1 s, longer for large panels and soft springs",
        example=1.0,
    )
    stop_stiffness: float = _value(1e6, "N m/rad", "the stiffness of stops, in the formulations penalty and compliant")
    stop_damping: float = _value(1.0, "N m s/rad", "the damping of these stops")
    cut_stiffness: float = _value(1e8, "N/m", "the stiffness of springs that close loops, in these formulations")
    cut_damping: float = _value(10.0, "N s/m", "the damping of these springs")
    friction: float = _value(
        0.0,
        "N m",
        "the Coulomb friction of every hinge",
        by_hinge=True,
        section=HARDWARE_SECTION,
        more="It holds hinges at rest and brakes those that turn.",
        option=("loads", "T"),
    )
    harness: float = _value(0.0, "N m", "the torque with which a harness resists at every hinge", by_hinge=True)
    latch_stiffness: float = _value(
        0.0, "N m/rad", "the stiffness of the latch of every hinge at the flat state", by_hinge=True
    )
    stop_tolerance: float = _value(
        0.0, "rad", "the error of the flat stop of every hinge, to each side", SMALL_ANGLE, by_hinge=True
    )
    play: float = _value(0.0, "rad", "the play of every hinge, to each side", SMALL_ANGLE, by_hinge=True)
    hinges: tuple[tuple[str, tuple[tuple[str, float], ...]], ...] = _value(
        (),
        "",
        "dampers and hardware of single hinges, by their numbers in pictures",
        by_hinge(
            _read_own,
            "write { 3 = { friction = 0.02 } }, the values of each hinge",
            "values, such as (('7', (('friction', 0.02),)),)",
            lambda hinges: {hinge: dict(own) for hinge, own in hinges},
        ),
        example={"7": {"damping": 0.01, "friction": 0.02, "latch_stiffness": 80.0}},
    )
    releases: tuple[tuple[str, str], ...] = _value(
        (),
        "",
        "when hold-downs release their hinges, by their numbers in pictures; until then these cannot open",
        by_hinge(
            read_release,
            "write { 3 = '0.5 s' }, or { 3 = 'hinge 7 at 0.2 rad' }, a release for each hinge",
            "release, such as (('7', '0.5 s'),)",
            dict,
        ),
        example={"7": "0.5 s", "3": "hinge 7 at 0.2 rad"},
    )
    thickness_tolerance: float = _value(0.0, "m", "the tolerance of panels' thickness, to each side", SMALL_LENGTH)
    offset_tolerance: float = _value(0.0, "m", "the tolerance of hinge lines' places, to each side", SMALL_LENGTH)
    equipment: float = _value(
        0.0, "kg/m^2", "the mass per area of what is mounted on panels, spread through their thickness"
    )
    root: str = _value(
        "held",
        "",
        "the panel at which the flat array is mounted: held, a number, or free for none",
        panel_or("held", "free"),
    )
    craft: tuple[CraftBox, ...] = _value(
        (),
        "m",
        "boxes that panels must not touch: [[x, y, z, length, width, height]]",
        BOXES,
        more="Their axes are those of the flat sheet, from the centre of the bottom face of the root.",
    )
    envelope: str = _value(
        "", "", "the box for the folded array, such as 3U or 100x100x340 in mm; empty for none", ENVELOPE
    )

    def __post_init__(self) -> None:
        for name in self.changed():
            object.__setattr__(self, name, SCENE_VALUES[name].checked(getattr(self, name)))

    def changed(self) -> list[str]:
        """Return the names of the values that differ from the scene `default`."""
        return [name for name, value in SCENE_VALUES.items() if getattr(self, name) != value.default]

    def __repr__(self) -> str:
        return f"Scene({', '.join(f'{name}={getattr(self, name)!r}' for name in self.changed())})"

    def density_of(self, thickness: float) -> float:
        """Return the density of panels of a thickness (m) with what is mounted on them, kg/m^3."""
        bare = self.density if self.areal_mass is None else self.areal_mass / thickness
        return bare + self.equipment / thickness if self.equipment else bare


def _table() -> dict[str, SceneValue]:
    """Return the rows of all values by name, each in the section of the one before it unless it begins another."""
    rows, section = {}, ""
    for value in fields(Scene):
        row: SceneValue = value.metadata["row"]
        section = row.section or section
        rows[value.name] = replace(row, name=value.name, section=section)
    return rows


SCENE_VALUES = _table()
"""All values of a scene, in the order of files and of the reference."""
HINGE_VALUES = tuple(name for name, value in SCENE_VALUES.items() if value.by_hinge)
"""Values that single hinges may have of their own."""
HARDWARE_VALUES = tuple(name for name, value in SCENE_VALUES.items() if value.section == HARDWARE_SECTION)
"""Values of the hardware as built."""
Scene.__doc__ = "\n".join(
    [
        *(cleandoc(Scene.__doc__ or ""), "", "Parameters", "----------"),
        *(f"{name}\n    {value.paragraph(value.unit)}" for name, value in SCENE_VALUES.items()),
        *("", "Raises", "------", "SceneError\n    For invalid values."),
    ]
)

SCENES = {
    scene.name: scene
    for scene in (
        Scene(),
        Scene("earth", gravity=(0.0, 0.0, -9.81)),
        Scene("thesis", gravity=(0.0, 9.81, 0.0)),
        Scene("satellite", held="free", base_mass=4.0, base_inertia=(0.0067, 0.0067, 0.0067)),
    )
}
"""`default`: no gravity. `earth`: gravity normal to the level sheet. `thesis`: Tables 4.1 and 4.3, with gravity in the
plane of the sheet: the text does not give its direction; the array hangs from its held panel, see
docs/explanation/tuning.md. `satellite`: on a floating cube of 4 kg and 0.1 m, a CubeSat of 3 units."""


def panel_of(scene: Scene, grid: str) -> PanelSize:
    """Return the size of the panels of a design in a scene, m; SceneError where its grid has no such panels."""
    panel = scene.panel or default_panel(grid)
    if panel[0] != panel[1] and not GRIDS[grid].is_rectangular:
        one, other = "one side", ", or --panel 'across WIDTHxTHICKNESS'"
        if GRIDS[grid].given_edge:
            one, other = "one given length", f", where SIDE is the {GRIDS[grid].given_edge}"
        raise SceneError(
            f"panels of the {grid} grid have {one}: write --panel SIDExTHICKNESS in mm, such as 50x6{other}"
        )
    return panel


def check_verdicts(scene: Scene, grid: str, n: int) -> None:
    """Refuse a scene in which foldings of n panels of a grid cannot be tried."""
    panel = panel_of(scene, grid)
    if not GRIDS[grid].stretched and panel[0] != panel[1]:
        raise SceneError(
            "designs of squares count as one when they are turned, so that panels are square: use the grid rectangle"
        )
    if scene.springs or scene.hinges or scene.releases:
        what = "springs" if scene.springs else "values" if scene.hinges else "hold-downs"
        raise SceneError(
            f"the scene {scene.name} has {what} of single hinges, which are those of one design: leave them out, or "
            "use hcsearch deploy"
        )
    if " from " in scene.spring:
        raise SceneError(
            f"the scene {scene.name} has springs that act from a time on, which hcsearch deploy simulates: leave it out"
        )
    if scene.held == "free":
        raise SceneError(f"the scene {scene.name} holds no panel: hold one for verdicts, such as held = 'bottom'")
    if scene.held != "bottom" and not (scene.held.isdigit() and int(scene.held) < n):
        raise SceneError(f"panel {scene.held} is not in all foldings of {n} panels: hold 'bottom', or 0 to {n - 1}")
    if scene.root not in ("held", "free") and not (scene.root.isdigit() and int(scene.root) < n):
        raise SceneError(
            f"panel {scene.root} is not in all foldings of {n} panels: root may be 'held', or 0 to {n - 1}"
        )


def with_panel(scene: Scene, panel: PanelSize, grid: str) -> Scene:
    """Return a scene with other panels, named after them, or the scene itself where it has these panels already."""
    if panel == panel_of(scene, grid):
        return scene
    changed = replace(scene, panel=panel, name=joined_name(scene.name, panel_text(panel)))
    panel_of(changed, grid)
    return changed


def with_size(scene: Scene, panel: str | None, grid: str) -> Scene:
    """Return a scene with the panels described by a text; HcsearchWarning for doubtful sizes."""
    sized = scene if panel is None else with_panel(scene, read_panel(panel, grid), grid)
    if sized.panel is not None:
        warn_of_panel_size(sized.panel, panel, grid)
    return sized


def warn_of_panel_size(panel: PanelSize, text: str | None = None, grid: str | None = None) -> None:
    """Issue a HcsearchWarning for doubtful panel sizes; text : the size as given by the user, for a grid."""
    doubt = panel_size_doubt(panel, grid, across=text is not None and text.startswith(ACROSS_FLATS_PREFIX))
    if doubt is not None:
        warnings.warn(doubt, HcsearchWarning, stacklevel=3)


def joined_name(base: str, *parts: str) -> str:
    """Join the name of a base scene, left out for `default`, with the names of its changes."""
    return (
        ", ".join(part for part in (base if base != DEFAULT_SCENE_NAME else "", *parts) if part) or DEFAULT_SCENE_NAME
    )


def check_scene_name(name: str) -> str:
    """Return the name of a scene; SceneError where it could not be written on a command line."""
    if not _NAME.fullmatch(name):
        raise SceneError(f"{name[:60]!r} is no name of a scene: write letters, digits, - and _, such as solar")
    return name
