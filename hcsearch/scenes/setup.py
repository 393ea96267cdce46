"""Setups: scenes evaluated for a linkage, with all values set, including the hardware as built.

Times, lengths and springs that a scene leaves unset are taken from the scene `default` (panels of 50 mm, 6 mm thick,
springs of 0.1 N m/rad), scaled by dimensional analysis: angles follow J phi'' = -k phi, so times are proportional to
the root of J / k, with J the mass of a panel times its edge squared; springs that lift a panel are proportional to its
weight times its edge.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.motion.collision.panel_prisms import REFERENCE_EDGE_LENGTH, margin_of, scale_of
from hcsearch.scenes.laws import Law, law_named, linear_law
from hcsearch.scenes.releases import release_named
from hcsearch.scenes.scene import DEFAULT_SCENE_NAME, HINGE_VALUES, SCENES, CraftBox, Scene, SceneVector
from hcsearch.shape.labels import Labels, labels_of
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.mesh import facet_area

DEFAULT_SCENE_SECONDS = 1.0
"""Simulated time of the scene `default`, s."""
MIN_SPRING_STIFFNESS, MAX_SPRING_STIFFNESS = 0.001, 0.2
"""Bounds of the stiffness of a spring in the scene `default`, N m/rad (thesis 4.5.4)."""
_STANDARD_GRAVITY = 9.81
_PLAIN = SCENES[DEFAULT_SCENE_NAME]
_PLAIN_STIFFNESS = law_named(_PLAIN.spring).mean_stiffness


class HoldDown(NamedTuple):
    """A hinge that cannot open until a time (s), or until another one has opened to an angle (rad); -1 for none."""

    hinge: int
    time: float
    after: int
    angle: float

    def moved(self, images: Sequence[int]) -> HoldDown:
        """Return the hold-down at the images of its hinges."""
        after = images[self.after] if self.after >= 0 else -1
        return HoldDown(images[self.hinge], self.time, after, self.angle)


@dataclass(frozen=True)
class Setup:
    """All numbers besides the linkage on which its motion in a scene depends, by the linkage's panels and hinges.

    name : of the scene, for messages. density : kg/m^3. margin : by how much panels are shrunk on every face when
    collisions are checked, m.
    laws : of all hinges. spring_range : softest and stiffest spring that is tried or tuned, N m/rad.
    damping_time : s, and damping : N m s/rad, of all hinges; each has its damping plus its time times the mean
    stiffness of its law.
    held : the fixed panel, or the one that belongs to the floating base, if the array is `free`. seconds : the
    simulated time. friction, harness, latch_stiffness, stop_tolerance, play : of all hinges. root : the panel at which
    the flat array is mounted; None for a free one. hold_downs : of hinges. The rest is as in `Scene`.
    """

    name: str
    density: float
    margin: float
    laws: tuple[Law, ...]
    spring_range: tuple[float, float]
    damping_time: tuple[float, ...]
    damping: tuple[float, ...]
    gravity: SceneVector
    drag: float
    held: int
    free: bool
    base_mass: float
    base_inertia: SceneVector
    start: float
    restitution: float
    seconds: float
    stop_stiffness: float
    stop_damping: float
    cut_stiffness: float
    cut_damping: float
    friction: tuple[float, ...]
    harness: tuple[float, ...]
    latch_stiffness: tuple[float, ...]
    stop_tolerance: tuple[float, ...]
    play: tuple[float, ...]
    thickness_tolerance: float
    offset_tolerance: float
    root: int | None
    craft: tuple[CraftBox, ...]
    envelope: str
    hold_downs: tuple[HoldDown, ...] = ()

    @cached_property
    def resistance(self) -> tuple[float, ...]:
        """The torque with which each hinge resists, friction and harness together, N m."""
        return tuple(self.weighted_resistance(1.0).tolist())

    def weighted_resistance(self, harness: float) -> Reals:
        """Return the friction of hinges and a factor of their harness together, (n_hinges,), N m."""
        return np.array(self.friction) + harness * np.array(self.harness)

    def damping_of(self, hinge: int, law: Law) -> float:
        """Return the damping of a hinge with a law, N m s/rad."""
        return self.damping[hinge] + self.damping_time[hinge] * law.mean_stiffness

    @property
    def dampings(self) -> tuple[float, ...]:
        """The damping of all hinges with their laws, N m s/rad."""
        return tuple(self.damping_of(hinge, law) for hinge, law in enumerate(self.laws))

    @property
    def law_times(self) -> tuple[float, ...]:
        """The times at which laws begin to act and act in full, s; none where all always act."""
        return tuple(sorted({time for law in self.laws if law.full for time in (law.begin, law.full)}))

    def dampers(self) -> dict[float, list[int]]:
        """Return the hinges of each damping that is given, and not in proportion to springs, by the damping."""
        hinges: dict[float, list[int]] = {}
        for hinge, damping in enumerate(self.damping):
            if damping:
                hinges.setdefault(damping, []).append(hinge)
        return hinges

    def of_congruent(self, linkage: Linkage) -> Setup:
        """Return the setup of the congruent linkage of a linkage, with its panels, hinges and directions.

        The craft is left out, as it stands at the root of the linkage alone.
        """
        congruent = linkage.twin
        if congruent is None:
            return self
        order = np.argsort(congruent.hinges).tolist()
        names = ("laws", "damping_time", *HINGE_VALUES)
        moved: dict[str, Any] = {name: tuple(getattr(self, name)[hinge] for hinge in order) for name in names}
        moved |= {"held": congruent.panels[self.held], "gravity": _turned(linkage, self.gravity), "craft": ()}
        moved["root"] = None if self.root is None else congruent.panels[self.root]
        moved["hold_downs"] = tuple(hold_down.moved(congruent.hinges) for hold_down in self.hold_downs)
        return replace(self, **moved)


def setup_of_scene(scene: Scene | Setup, linkage: Linkage) -> Setup:
    """Evaluate a scene for a linkage; a setup is returned unchanged.

    Density, margin, spring range and seconds follow from the panels where the scene leaves them unset. Seconds are
    never fewer than in the scene `default`; they are rounded to three digits, as springs are. HcsearchError where the
    scene names a panel or a hinge that the linkage does not have.
    """
    if isinstance(scene, Setup):
        return scene
    labels = labels_of(linkage)
    # the congruent linkage gives the values derived from panels, as sums in another order round differently
    standard = linkage if linkage.twin is None else linkage.twin.linkage
    values: dict[str, Any] = {own.name: getattr(scene, own.name) for own in fields(Setup) if hasattr(scene, own.name)}
    at_hinges = {name: _at_hinges(scene, labels, name) for name in HINGE_VALUES}
    dampings = at_hinges["damping"]  # None where hinges have damping_time
    held = linkage.base if scene.held in ("bottom", "free") else labels.panel(scene.held)
    roots = {"free": None, "held": None if scene.held == "free" else held}
    evaluated = {
        "density": scene.density_of(standard.pattern.thickness),
        "margin": float(f"{margin_of(standard):.10g}") if scene.margin is None else scene.margin,
        "laws": _laws(scene, labels),
        "spring_range": scene.spring_range or (MIN_SPRING_STIFFNESS, MAX_SPRING_STIFFNESS),
        "damping_time": tuple(scene.damping_time if damping is None else 0.0 for damping in dampings),
        "damping": tuple(0.0 if damping is None else damping for damping in dampings),
        "held": held,
        "free": scene.held == "free",
        "seconds": scene.seconds or DEFAULT_SCENE_SECONDS,
        "root": roots[scene.root] if scene.root in roots else labels.panel(scene.root),
        "hold_downs": _hold_downs(scene, labels),
    }
    setup = Setup(**values | at_hinges | evaluated)
    seconds, scale = _scales(setup, linkage)
    return replace(
        setup,
        spring_range=scene.spring_range or (_short(MIN_SPRING_STIFFNESS * scale), _short(MAX_SPRING_STIFFNESS * scale)),
        seconds=_natural(setup, seconds) if scene.seconds is None else scene.seconds,
    )


def _at_hinges(scene: Scene, labels: Labels, name: str) -> tuple[Any, ...]:
    """Return a value at all hinges: the scene's, or their own.

    HcsearchError where the scene names a hinge that the linkage does not have, or one hinge by two names with different
    values.
    """
    given: dict[int, float] = {}
    for label, own in scene.hinges:
        hinge, value = labels.hinge(label), dict(own).get(name)
        if value is not None and given.setdefault(hinge, value) != value:
            raise HcsearchError(f"hinge {labels.hinges[hinge]} is given two values of {name}: leave one out")
    return tuple(given.get(hinge, getattr(scene, name)) for hinge in range(len(labels.hinges)))


def _natural(setup: Setup, seconds: float) -> float:
    """Return the simulated time of a setup, s, from the ratio of its times to the times in the scene `default`."""
    last = max((0.0, *(held.time for held in setup.hold_downs), *setup.law_times))
    return _short(DEFAULT_SCENE_SECONDS * seconds + last)


def natural_seconds(setup: Setup, linkage: Linkage) -> float:
    """Return the simulated time of a motion whose scene leaves it unset, s."""
    return _natural(setup, _scales(setup, linkage)[0])


def _scales(setup: Setup, linkage: Linkage) -> tuple[float, float]:
    """Return the ratios of the times and of the springs of a motion to those in the scene `default`."""
    if linkage.twin is not None:
        return _scales(setup.of_congruent(linkage), linkage.twin.linkage)
    length, mass = scale_of(linkage), _mass(linkage, setup.density)
    stiffness = float(np.mean([law.mean_stiffness for law in setup.laws])) if setup.laws else 0.0
    inertia, weight = mass * length**2, mass * length * math.hypot(*setup.gravity) / _STANDARD_GRAVITY
    springs = max(stiffness / _PLAIN_STIFFNESS, weight)
    slowness = max(setup.damping_time, default=0.0)
    if stiffness:
        slowness = max(slowness, max(setup.damping) / stiffness)
    seconds = max(1.0, math.sqrt(inertia / springs) if springs else 1.0, slowness / _PLAIN.damping_time)
    return seconds, _short(springs or inertia)


def scene_of_setup(setup: Setup, scene: Scene, labels: Labels) -> Scene:
    """Convert a setup back to a scene with all values set.

    scene : the scene of the setup. labels : of the linkage. Springs of single hinges are listed unless all have the
    scene's, and dampers where they differ from the scene's.
    """
    single_laws = any(law.text != law_named(scene.spring).text for law in setup.laws)
    laws = zip(labels.hinges, setup.laws, strict=True)
    return replace(
        scene,
        name=setup.name,
        density=setup.density,
        areal_mass=None,
        equipment=0.0,
        margin=setup.margin,
        springs=tuple((hinge, law.text) for hinge, law in laws) if single_laws else (),
        spring_range=setup.spring_range,
        seconds=setup.seconds,
        **_written_dampers(setup, scene, labels),
    )


def _written_dampers(setup: Setup, scene: Scene, labels: Labels) -> dict[str, Any]:
    """Return the values of a scene in which hinges have the dampers of a setup."""
    of_hinges = list(zip(setup.damping_time, setup.damping, strict=True))
    plain = (scene.damping_time, 0.0) if scene.damping is None else (0.0, scene.damping)
    if len(set(of_hinges)) == 1 and of_hinges[0] != plain and 0.0 in of_hinges[0]:
        plain = time, damping = of_hinges[0]
        scene = replace(scene, damping_time=time, damping=None if time else damping)
    own = {hinge: {name: value for name, value in given if name != "damping"} for hinge, given in scene.hinges}
    for hinge, damper, damping in zip(labels.hinges, of_hinges, setup.dampings, strict=True):
        if damper != plain:
            own.setdefault(hinge, {})["damping"] = damping
    hinges = tuple((hinge, tuple(given.items())) for hinge, given in own.items() if given)
    return {"damping_time": scene.damping_time, "damping": scene.damping, "hinges": hinges}


def with_stiffnesses(setup: Setup, stiffnesses: Sequence[float] | Reals) -> Setup:
    """Return a setup with a linear spring at every hinge, N m/rad, in the order of hinges; 0: no spring.

    Damping in proportion to springs changes with them.
    """
    return replace(setup, laws=tuple(linear_law(float(stiffness)) for stiffness in stiffnesses))


def with_dampings(setup: Setup, dampings: Sequence[float] | Reals) -> Setup:
    """Return a setup with other dampings of hinges, N m s/rad, in the order of hinges; NaN keeps the setup's."""
    before = zip(setup.damping_time, setup.damping, dampings, strict=True)
    dampers = [(time, own) if math.isnan(chosen) else (0.0, float(chosen)) for time, own, chosen in before]
    return replace(setup, damping_time=tuple(d[0] for d in dampers), damping=tuple(d[1] for d in dampers))


def with_resistance(setup: Setup, torque: float) -> Setup:
    """Return a setup in which each hinge resists with a torque of friction, N m, and no harness does."""
    none = (0.0,) * len(setup.laws)
    return replace(setup, friction=(torque,) * len(none), harness=none)


def _laws(scene: Scene, labels: Labels) -> tuple[Law, ...]:
    """Parse the laws of all hinges; HcsearchError where two names of one hinge have different laws."""
    laws: dict[int, str] = {}
    for name, law in scene.springs:
        hinge = labels.hinge(name)
        if laws.setdefault(hinge, law) != law:
            raise HcsearchError(f"hinge {labels.hinges[hinge]} is given two springs: leave one out")
    return tuple(law_named(laws.get(hinge, scene.spring)) for hinge in range(len(labels.hinges)))


def _hold_downs(scene: Scene, labels: Labels) -> tuple[HoldDown, ...]:
    """Return the hold-downs of all hinges; HcsearchError where a hinge has two, or waits for itself."""
    hold_downs: dict[int, HoldDown] = {}
    for name, text in scene.releases:
        release, hinge = release_named(text), labels.hinge(name)
        after = labels.hinge(release.hinge) if release.hinge else -1
        if hinge in hold_downs or after == hinge:
            what = "waits for itself: name another" if after == hinge else "is given two releases: leave one out"
            raise HcsearchError(f"hinge {labels.hinges[hinge]} {what}")
        hold_downs[hinge] = HoldDown(hinge, release.time, after, release.angle)
    return tuple(hold_downs[hinge] for hinge in sorted(hold_downs))


def _turned(linkage: Linkage, gravity: SceneVector) -> SceneVector:
    """Return gravity in the axes of the congruent linkage."""
    assert linkage.twin is not None
    x, y, z = (float(part) for part in linkage.twin.turn @ np.array(gravity))
    return (x, y, z)


def _mass(linkage: Linkage, density: float) -> float:
    """Return the mean mass of a facet over the mass of a regular panel of `default` with as many corners."""
    facets = linkage.pattern.facets
    corners = len(facets[0])
    regular = 0.25 * corners * REFERENCE_EDGE_LENGTH**2 / math.tan(math.pi / corners)
    mean = sum(map(facet_area, facets)) / len(facets)
    return (density * mean * linkage.pattern.thickness) / (_PLAIN.density * regular * default_panel("square")[2])


def _short(value: float) -> float:
    return float(f"{value:.3g}")
