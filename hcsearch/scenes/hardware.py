"""The hardware of a scene as built, evaluated for a linkage: values of hinges, tolerances, the root and the craft."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.scenes.scene import CraftBox, Scene
from hcsearch.shape.labels import labels_of
from hcsearch.shape.linkage import Linkage


@dataclass(frozen=True, eq=False)
class Hardware(ByValue):
    """Values of a scene's hardware by the hinges of a linkage, (n_hinges,) each, and of the array.

    friction, harness : torques that resist, N m. latch_stiffness : N m/rad. stop_tolerance, play : rad, to each side.
    thickness_tolerance, offset_tolerance : m, to each side. root : the panel at which the flat array is mounted; None
    for a free one. craft : boxes of the craft in the axes of the flat sheet, whose origin is the centre of the bottom
    face of the root (of the held panel if the array is free), m. envelope : a name or lengths in mm; may be empty.
    """

    friction: Reals
    harness: Reals
    latch_stiffness: Reals
    stop_tolerance: Reals
    play: Reals
    thickness_tolerance: float
    offset_tolerance: float
    root: int | None
    craft: tuple[CraftBox, ...]
    envelope: str

    @property
    def resistance(self) -> Reals:
        """The torque with which each hinge resists, N m."""
        return self.friction + self.harness

    def of_congruent(self, linkage: Linkage) -> Hardware:
        """Return the hardware of the congruent linkage of a linkage; its craft is left out."""
        congruent = linkage.twin
        if congruent is None:
            return self
        order = np.argsort(congruent.hinges)
        names = ("friction", "harness", "latch_stiffness", "stop_tolerance", "play")
        root = None if self.root is None else congruent.panels[self.root]
        return replace(self, root=root, craft=(), **{name: getattr(self, name)[order] for name in names})


def hinge_values(scene: Scene, linkage: Linkage, name: str) -> Reals:
    """Return a value of `values.HARDWARE_VALUES` at each hinge of a linkage, shape (n_hinges,); errors as below."""
    values = np.full(linkage.n_hinges, float(getattr(scene, name)))
    for hinge, value in own_hinge_values(scene, linkage, name).items():
        values[hinge] = value
    return values


def own_hinge_values(scene: Scene, linkage: Linkage, name: str) -> dict[int, float]:
    """Return a value of `values.HINGE_VALUES` at the hinges of a linkage that have one of their own.

    HcsearchError where the scene names a hinge that the linkage does not have, or one hinge by two names with different
    values.
    """
    if not scene.hinges:
        return {}
    labels = labels_of(linkage)
    given: dict[int, float] = {}
    for label, own in scene.hinges:
        hinge = labels.hinge(label)
        value = dict(own).get(name)
        if value is not None and given.setdefault(hinge, value) != value:
            raise HcsearchError(f"hinge {labels.hinges[hinge]} is given two values of {name}: leave one out")
    return given


def hardware_of(scene: Scene, linkage: Linkage, held: int) -> Hardware:
    """Evaluate the hardware of a scene for a linkage; held : its held panel, as of the setup."""
    on = scene.held if scene.root == "held" else scene.root
    root = None if on == "free" else held if scene.root == "held" else labels_of(linkage).panel(scene.root)
    return Hardware(
        hinge_values(scene, linkage, "friction"),
        hinge_values(scene, linkage, "harness"),
        hinge_values(scene, linkage, "latch_stiffness"),
        hinge_values(scene, linkage, "stop_tolerance"),
        hinge_values(scene, linkage, "play"),
        scene.thickness_tolerance,
        scene.offset_tolerance,
        root,
        scene.craft,
        scene.envelope,
    )
