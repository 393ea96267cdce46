"""Scenes: what a verdict on a folding depends on, beside the folding. SI units; millimetres in texts of panels."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, fields, replace
from typing import Literal

from hcsearch.errors import SceneError

PanelSize = tuple[float, float, float]
Vector = tuple[float, float, float]
Held = int | str
"""`bottom`, `free`, the name of a panel, or its number in a linkage."""
FlatPairs = Literal["rigid", "hinged", "either"]
Merge = bool | Literal["either"]

DEFAULT = "default"
SMALLEST, LARGEST = 1e-6, 1e4
"""Lengths of panels, m."""
SMALL_SIDE, LARGE_SIDE = 0.005, 20.0
"""Sides below or above which a size was probably meant in another unit, m."""
THICKEST = 0.2
"""Greatest thickness that is likely to be meant, m."""
_NUMBER = r"\d+(?:\.\d+)?(?:[eE][+-]?\d+)?"
_PANEL = re.compile(rf"({_NUMBER})x({_NUMBER})(?:x({_NUMBER}))?", re.ASCII)
_NAME = re.compile(r"[A-Za-z][\w.+-]{0,39}(?: [\w.+-]+)*", re.ASCII)
_ACROSS = {"square": 1.0, "hex": math.sqrt(3.0), "triangle": 0.5 * math.sqrt(3.0)}
"""Distance across flats (of a triangle its height) over the side."""


@dataclass(frozen=True, repr=False)
class Scene:
    """All that a verdict on a folding depends on beside the folding: panels, springs, gravity, and the start.

    name : the name under which a database keeps the verdicts.
    panel : length, width and thickness in m; None for 50 x 50 x 6 mm (rectangles 50 x 40 x 6 mm), and for assemblies,
    which have their own sizes.
    density : the density of panels, kg/m^3. areal_mass : their mass per area, kg/m^2, which replaces the density.
    flat_pairs : how the two panels at each flat crease are joined, `rigid` or `hinged`; `either` tries both.
    merge : whether the two panels of each mirror pair are one; `either` tries both.
    margin : by how much panels are shrunk on every face when collisions are checked, m; None for 0.1 mm on 50 mm, in
    proportion to the longest edge.
    spring : the law of all hinges, such as `linear:0.1` (N m/rad); docs/reference/scenes.md lists the laws.
    springs : laws of single hinges as pairs, such as `(("7", "linear:0.2"),)`. A text is the number shown in pictures,
    an integer the place of the hinge in the linkage.
    spring_range : the softest and the stiffest spring that is tried or tuned, N m/rad; None for bounds that follow from
    springs and weight.
    damping_time : damping over stiffness at each hinge, s. damping : the damping at every hinge, N m s/rad, which
    replaces damping_time.
    gravity : its vector in m/s^2; z points up from the flat sheet, whose drawing is seen from above.
    held : the panel that stands still: `bottom` for the lowest pair, a text for the number shown in pictures, or an
    integer for the place of a panel in the linkage. With `free` the first panel belongs to a floating base.
    base_mass : the mass of that base, kg. base_inertia : its moments of inertia about the panel's centre, kg m^2.
    start : the share of the folded angles at which the motion starts, at rest.
    restitution : the coefficient of restitution of hinge stops, 0 to 1.
    seconds : how long the motion is simulated; None for a time that follows from panels and springs.
    stop_stiffness, stop_damping, cut_stiffness, cut_damping : stops, and springs that close loops, in the formulations
    `penalty` and `compliant`: N m/rad, N m s/rad, N/m, N s/m.
    """

    name: str = DEFAULT
    panel: PanelSize | None = None
    density: float = 547.0
    areal_mass: float | None = None
    flat_pairs: FlatPairs = "either"
    merge: Merge = "either"
    margin: float | None = None
    spring: str = "linear:0.1"
    springs: tuple[tuple[int | str, str], ...] = ()
    spring_range: tuple[float, float] | None = None
    damping_time: float = 0.043
    damping: float | None = None
    gravity: Vector = (0.0, 0.0, 0.0)
    held: Held = "bottom"
    base_mass: float = 0.0
    base_inertia: Vector = (0.0, 0.0, 0.0)
    start: float = 0.999
    restitution: float = 0.0
    seconds: float | None = None
    stop_stiffness: float = 1e6
    stop_damping: float = 1.0
    cut_stiffness: float = 1e8
    cut_damping: float = 10.0

    def __repr__(self) -> str:
        changed = [own.name for own in fields(self) if getattr(self, own.name) != own.default]
        return f"Scene({', '.join(f'{name}={getattr(self, name)!r}' for name in changed)})"

    def density_of(self, thickness: float) -> float:
        """The density of panels with this thickness (m), kg/m^3."""
        return self.density if self.areal_mass is None else self.areal_mass / thickness


SCENES = {
    scene.name: scene
    for scene in (
        Scene(),
        Scene("earth", gravity=(0.0, 0.0, -9.81)),
        Scene("thesis", gravity=(0.0, 9.81, 0.0)),
        Scene("satellite", held="free", base_mass=4.0, base_inertia=(0.0067, 0.0067, 0.0067)),
    )
}
"""`default`: no gravity. `earth`: the sheet lies level. `thesis`: Tables 4.1 and 4.3, with gravity in the plane of the
sheet: the text does not give its direction; the array hangs from its held panel, see docs/explanation/tuning.md.
`satellite`: on a floating cube of 4 kg and 0.1 m, a CubeSat of 3 units."""


def default_panel(grid: str) -> PanelSize:
    """Length, width and thickness of a panel in the scene `default`, in metres."""
    return (0.050, 0.040 if grid == "rectangle" else 0.050, 0.006)


def panel_of(scene: Scene, grid: str) -> PanelSize:
    """Size of the panels of a design in a scene, m; SceneError where its grid has no such panels."""
    panel = scene.panel or default_panel(grid)
    if panel[0] != panel[1] and grid not in {"square", "rectangle"}:
        raise SceneError(
            f"panels of the {grid} grid have one side: write --panel SIDExTHICKNESS in mm, such as 50x6, "
            "or --across WIDTHxTHICKNESS"
        )
    return panel


def check_verdicts(scene: Scene, grid: str, n: int) -> None:
    """Refuse a scene that the foldings of n panels of a grid cannot be tried in."""
    panel = panel_of(scene, grid)
    if grid == "square" and panel[0] != panel[1]:
        raise SceneError(
            "designs of squares count as one when they are turned, so that panels are square: use the grid rectangle"
        )
    if scene.springs:
        raise SceneError(
            f"the scene {scene.name} has springs of single hinges, which are those of one design: leave them out, or "
            "use hcsearch deploy"
        )
    if scene.held == "free":
        raise SceneError(f"the scene {scene.name} holds no panel: hold one for verdicts, such as held = 'bottom'")
    if isinstance(scene.held, int) and scene.held >= n // 2:
        raise SceneError(f"panel {scene.held} is not in all foldings of {n} panels: hold 'bottom', or a lower number")
    if isinstance(scene.held, str) and scene.held != "bottom" and not (scene.held.isdigit() and int(scene.held) < n):
        raise SceneError(f"panel {scene.held} is not in all foldings of {n} panels: hold 'bottom', or 0 to {n - 1}")


def with_panel(scene: Scene, panel: PanelSize, grid: str) -> Scene:
    """The scene with other panels; its name says which, unless they are those that it has."""
    if panel == panel_of(scene, grid):
        return scene
    changed = replace(scene, panel=panel, name=joined_name(scene.name, panel_text(panel)))
    panel_of(changed, grid)
    return changed


def joined_name(base: str, *parts: str) -> str:
    """The name of a scene that differs from another one; what it shares with `default` goes without saying."""
    return ", ".join(part for part in (base if base != DEFAULT else "", *parts) if part) or DEFAULT


def read_panel(text: str, grid: str | None = None) -> PanelSize:
    """The size of a panel (m) in millimetres: length x width x thickness, or side x thickness.

    For hexagons and triangles length and width are the side. grid : whose panel it is, where that is known; panels of
    `rectangle` have three sizes.
    """
    match = _PANEL.fullmatch(text)
    if match is None:
        raise SceneError(
            f"{text!r} is no panel: write length x width x thickness in mm, such as 50x40x6, or side x "
            "thickness, such as 50x6"
        )
    sizes = [float(f"{float(part):.10g}") * 1e-3 for part in match.groups() if part is not None]
    if len(sizes) == 2 and grid == "rectangle":
        likely = "50x40x6" if _faults((sizes[0], sizes[1], 0.006)) else f"{match[1]}x{match[2]}x6"
        raise SceneError(
            f"{text!r} is no rectangle, which has a length, a width and a thickness: write three numbers in mm, such "
            f"as {likely}"
        )
    length, width, thickness = sizes if len(sizes) == 3 else (sizes[0], *sizes)
    if not all(SMALLEST <= size <= LARGEST for size in sizes):
        raise SceneError(
            f"{text!r} is no panel: write length x width x thickness, from {1e3 * SMALLEST:g} to "
            f"{1e3 * LARGEST:g} mm, such as 50x40x6"
        )
    return (length, width, thickness)


def read_across(text: str, grid: str) -> PanelSize:
    """The size of a panel (m) of a width across flats (of a triangle its height) and a thickness, in millimetres."""
    match = _PANEL.fullmatch(text)
    if match is None or match[3] is not None:
        raise SceneError(f"{text!r} is no width across flats: write width x thickness in mm, such as 1000x20")
    if grid not in _ACROSS:
        raise SceneError(f"panels of the {grid} grid have no width across flats: write --panel 50x40x6")
    return read_panel(f"{float(match[1]) / _ACROSS[grid]:.10g}x{match[2]}")


def doubt_of(panel: PanelSize, across: str | None = None) -> str | None:
    """A sentence on sizes that are probably not meant, with the likely ones; None where there is no doubt.

    Doubtful are sides of less than 5 mm, as of a size in metres, of more than 20 m, and panels thicker than half their
    shortest side, as of sizes in another order. across : the grid of panels whose width across flats was given.
    """
    factor = 1.0 if across is None else _ACROSS[across]
    faults = _faults(panel)
    if not faults:
        return None
    given = (factor * panel[0], factor * panel[1], panel[2])
    sizes = f"{_brief(given)} mm" + ("" if across is None else " across flats")
    likely = _likely(given, factor)
    if likely is not None:
        meant = f"; did you mean {_brief(likely)}?"
    elif given[0] == given[1] and across is None and panel[2] > 0.5 * panel[0]:
        meant = f"; a thickness is missing where both are sides, as in {_brief(given)}x6"
    else:
        meant = ""
    order = "sizes are in mm, sides first, then the thickness"
    return f"panels of {sizes} have {' and '.join(faults)}: {order}{meant}"


def _faults(panel: PanelSize) -> list[str]:
    """What is doubtful of the sizes of a panel, in words."""
    length, width, thickness = panel
    shortest, longest = min(length, width), max(length, width)
    faults = [f"a side of less than {1e3 * SMALL_SIDE:g} mm"] if shortest < SMALL_SIDE else []
    faults += [f"a side of more than {LARGE_SIDE:g} m"] if longest > LARGE_SIDE else []
    return faults + (["a thickness of more than half their side"] if thickness > 0.5 * shortest else [])


def _likely(panel: PanelSize, factor: float) -> PanelSize | None:
    """What doubtful sizes probably mean: the same in another order or unit, if those are in no doubt.

    factor : by which they are larger than the sides of the panel.
    """
    length, width, thickness = panel
    side, turned = min(length, width), [length, width, thickness]
    if thickness > side:
        turned = [thickness, thickness, side] if length == width else sorted(panel, reverse=True)
    for scale in (1.0, 1e3, 1e-3):  # millimetres, metres, or millimetres that Python took for metres
        first, second, last = (scale * size for size in turned)
        if last <= THICKEST and not _faults((first / factor, second / factor, last)):
            return (first, second, last)
    return None


def _brief(panel: PanelSize) -> str:
    """Side x thickness, or length x width x thickness, in millimetres, for people."""
    sizes = panel[1:] if panel[0] == panel[1] else panel
    return "x".join(f"{float(f'{1e3 * size:.4g}'):.10g}" for size in sizes)


def panel_text(panel: PanelSize) -> str:
    """Length x width x thickness in millimetres; `read_panel` reads it."""
    return "x".join(f"{1e3 * size:.10g}" for size in panel)


def is_panel(text: str) -> bool:
    """Whether a text is the size of a panel."""
    return _PANEL.fullmatch(text) is not None


def check_name(name: str) -> str:
    """The name of a scene; SceneError where it could not be written on a command line."""
    if not _NAME.fullmatch(name):
        raise SceneError(f"{name[:60]!r} is no name of a scene: write letters, digits, - and _, such as solar")
    return name
