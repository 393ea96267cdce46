"""Scenes: everything besides the folding on which a verdict depends. SI units."""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass, fields, replace

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

SceneVector = tuple[float, float, float]
CraftBox = tuple[float, float, float, float, float, float]
"""A box of the craft's body: its least x, y, z and its length, width and height, m."""

DEFAULT_SCENE_NAME = "default"
"""The scene used where none is named."""
_NAME = re.compile(r"[A-Za-z][\w.+-]{0,39}(?: [\w.+-]+)*", re.ASCII)


@dataclass(frozen=True, repr=False)
class Scene:
    """All data besides the folding on which a verdict depends: panels, springs, gravity and the start.

    The last values, from `friction` on, are those of the hardware as built. All are 0 or none unless given.

    Parameters
    ----------
    name
        The name under which a database keeps the verdicts.
    panel
        Length, width and thickness in m; None for 50 x 50 x 6 mm (rectangles 50 x 40 x 6 mm), and for assemblies, which
        have their own sizes.
    density
        The density of panels, kg/m^3.
    areal_mass
        Their mass per area, kg/m^2, which replaces the density.
    flat_pairs
        The joints of the two panels at each flat crease, tried one after the other until one opens: `rigid`, `hinged`,
        or `merged`, where the two panels of each mirror pair are one, too. A single one may be given as a text;
        `either` means all three.
    margin
        By how much panels are shrunk on every face when collisions are checked, m; None for 0.1 mm on 50 mm, in
        proportion to the longest edge.
    spring
        The law of all hinges, such as `linear:0.1` (N m/rad); docs/reference/scenes.md lists the laws. The points of a
        table in a file take the place of its name.
    springs
        Laws of single hinges by their numbers in pictures, as pairs, such as `(("7", "linear:0.2"),)`.
    spring_range
        The softest and the stiffest spring that is tried or tuned, N m/rad; None for bounds derived from springs and
        weight.
    damping_time
        Damping over stiffness at each hinge, s.
    damping
        The damping at every hinge, N m s/rad, which replaces damping_time.
    gravity
        The acceleration of gravity, a vector in m/s^2; z points up from the flat sheet, whose drawing is seen from
        above.
    drag
        The drag of panels in air: its density times the drag coefficient, kg/m^3, such as 1.2 x 1.2 = 1.44; 0 in a
        vacuum.
    held
        The fixed panel, by its number in pictures, or `bottom` for the lowest pair. With `free` the first panel belongs
        to a floating base.
    base_mass
        The mass of that base, kg.
    base_inertia
        Its moments of inertia about the panel's centre, kg m^2.
    start
        The share of the folded angles at which the motion starts, at rest.
    restitution
        The coefficient of restitution of hinge stops, 0 to 1.
    seconds
        The simulated time; None for a time derived from panels and springs.
    stop_stiffness, stop_damping, cut_stiffness, cut_damping
        Stops, and springs that close loops, in the formulations `penalty` and `compliant`: N m/rad, N m s/rad, N/m, N
        s/m.
    friction, harness
        The torque with which Coulomb friction and a harness resist at every hinge, N m.
    latch_stiffness
        The stiffness of the latch of every hinge at the flat state, N m/rad.
    stop_tolerance
        The error of the flat stop of every hinge, to each side, rad.
    play
        The play of every hinge, to each side, rad.
    hinges
        Values of single hinges that replace these five or the damping, by their numbers in pictures, such as `(("7",
        (("damping", 0.01), ("friction", 0.02))),)`.
    releases
        When hold-downs release their hinges, by their numbers in pictures, such as `(("7", "0.5 s"), ("3", "hinge 7 at
        0.2 rad"))`; until then these hinges cannot open.
    thickness_tolerance
        The tolerance of the thickness of panels, to each side, m.
    offset_tolerance
        The tolerance of the place of hinge lines, to each side, m.
    equipment
        The mass per area of what is mounted on panels, kg/m^2; it is spread through their thickness.
    root
        The panel at which the flat array is mounted, `held` for the held one, or `free` for none.
    craft
        Boxes of the craft's body, which panels must not touch, in the axes of the flat sheet. Their origin is the
        centre of the root panel's bottom face.
    envelope
        The box into which the folded array must go, such as `3U` or `100x100x340` in mm; empty for none.

    Raises
    ------
    SceneError
        For invalid values.
    """

    name: str = DEFAULT_SCENE_NAME
    panel: PanelSize | None = None
    density: float = 547.0
    areal_mass: float | None = None
    flat_pairs: tuple[Way, ...] = WAYS
    margin: float | None = None
    spring: str = "linear:0.1"
    springs: tuple[tuple[str, str], ...] = ()
    spring_range: tuple[float, float] | None = None
    damping_time: float = 0.043
    damping: float | None = None
    gravity: SceneVector = (0.0, 0.0, 0.0)
    drag: float = 0.0
    held: str = "bottom"
    base_mass: float = 0.0
    base_inertia: SceneVector = (0.0, 0.0, 0.0)
    start: float = 0.999
    restitution: float = 0.0
    seconds: float | None = None
    stop_stiffness: float = 1e6
    stop_damping: float = 1.0
    cut_stiffness: float = 1e8
    cut_damping: float = 10.0
    friction: float = 0.0
    harness: float = 0.0
    latch_stiffness: float = 0.0
    stop_tolerance: float = 0.0
    play: float = 0.0
    hinges: tuple[tuple[str, tuple[tuple[str, float], ...]], ...] = ()
    releases: tuple[tuple[str, str], ...] = ()
    thickness_tolerance: float = 0.0
    offset_tolerance: float = 0.0
    equipment: float = 0.0
    root: str = "held"
    craft: tuple[CraftBox, ...] = ()
    envelope: str = ""

    def __post_init__(self) -> None:
        changed = {
            value_field.name for value_field in fields(self) if getattr(self, value_field.name) != value_field.default
        }
        if changed - {"name"} or not isinstance(self.name, str):
            from hcsearch.scenes.values import checked_scene_values  # noqa: PLC0415 - the command line needs the names of scenes alone

            for name, value in checked_scene_values({name: getattr(self, name) for name in changed}).items():
                object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        changed = [
            value_field.name for value_field in fields(self) if getattr(self, value_field.name) != value_field.default
        ]
        return f"Scene({', '.join(f'{name}={getattr(self, name)!r}' for name in changed)})"

    def density_of(self, thickness: float) -> float:
        """Return the density of panels of a thickness (m) with what is mounted on them, kg/m^3."""
        bare = self.density if self.areal_mass is None else self.areal_mass / thickness
        return bare + self.equipment / thickness if self.equipment else bare


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
