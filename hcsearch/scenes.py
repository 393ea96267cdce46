"""Scenes: what a verdict on a folding depends on, beside the folding itself. SI units."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

PanelSize = tuple[float, float, float]
Vector = tuple[float, float, float]
Held = int | Literal["bottom", "free"]


@dataclass(frozen=True)
class Scene:
    """Material, springs, stops, gravity, what is held, and the start of a deployment.

    density : kg/m^3. spring : moment-angle law of every hinge, in the notation of laws; springs : of single hinges.
    damping_time : damping over stiffness of each hinge, s (proportional damping, thesis 4.4); damping : N m s/rad at
        every hinge in its place, where it is given.
    gravity : m/s^2, in axes of the flat state; the drawing is seen from +z.
    held : the panel that stands still (`bottom` the first, the lowest pair of a folding), or `free`: that panel belongs
        to a floating base of base_mass (kg) and base_inertia (kg m^2) about its centre, which is the panel's.
    start : share of the folded angles at which it starts, projected onto closure and at rest.
    restitution : of hinge stops, 0 to 1. seconds : how long it is simulated.
    stop_stiffness, stop_damping, cut_stiffness, cut_damping : of stops, and of the springs that close loops, in the
        penalty (thesis Table 4.3) and the compliant formulation: N m/rad, N m s/rad, N/m, Ns/m.
    """

    name: str = "default"
    density: float = 547.0
    spring: str = "linear:0.1"
    springs: tuple[tuple[int, str], ...] = ()
    damping_time: float = 0.043
    damping: float | None = None
    gravity: Vector = (0.0, 0.0, 0.0)
    held: Held = "bottom"
    base_mass: float = 0.0
    base_inertia: Vector = (0.0, 0.0, 0.0)
    start: float = 0.999
    restitution: float = 0.0
    seconds: float = 1.0
    stop_stiffness: float = 1e6
    stop_damping: float = 1.0
    cut_stiffness: float = 1e8
    cut_damping: float = 10.0


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
sheet: the text does not tell its direction; the array hangs from its held panel, see docs/tuning.md. `satellite`: on a
floating cube of 4 kg and 0.1 m, a CubeSat of 3 units."""


def default_panel(grid: str) -> PanelSize:
    """Length, width and thickness of a panel in the scene `default`, in metres."""
    return (0.050, 0.040 if grid == "rectangle" else 0.050, 0.006)
