"""A scene for simulators: a tree of links, with loops cut through panels, and the welds that close them.

Every hinge remains a joint of the tree, with its spring, damper and stops. Where a loop closes, a panel is cut into
parts of equal mass that are welded to each other (`dynamics.panels`). The frame of a link lies at the middle of its
parent hinge, with the axes of the flat state, so all fold angles are 0 in the flat state.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.scenes import Scene
from hcsearch.scenes.laws import Law
from hcsearch.scenes.setup import Setup, setup_of_scene
from hcsearch.shape.labels import Labels
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.compiled_scene import OMISSIONS, compile_scene
from hcsearch.springs.dynamics.body_trees import Body
from hcsearch.springs.dynamics.panels import panel_bodies
from hcsearch.springs.dynamics.system import JointDrive


@dataclass(frozen=True, eq=False)
class LinkJoint(ByValue):
    """The hinge that joins a link to its parent.

    parent : number of the parent link. axis : unit vector, about which the link turns by the fold angle.
    """

    name: str
    hinge: int
    parent: int
    axis: Reals
    drive: JointDrive


@dataclass(frozen=True, eq=False)
class TreeLink(ByValue):
    """A panel, or a part of a panel that is cut.

    has_shape : whether the link carries the panel's shape, as its first part does. frame : origin of its frame in the
    flat state, m. body : mass properties there. joint : joint to the parent; None of the base.
    """

    name: str
    panel: int
    has_shape: bool
    frame: Reals
    body: Body
    joint: LinkJoint | None


@dataclass(frozen=True, eq=False)
class LoopClosure(ByValue):
    """A weld of two parts of a panel: their links' numbers, and a common point in the flat state, m."""

    name: str
    first: int
    second: int
    point: Reals


@dataclass(frozen=True, eq=False)
class CutTree(ByValue):
    """The links, the base first and each after its parent, and the closures of the loops.

    has_free_base : whether the base is free, with the scene's floating body as part of it; else it is held.
    start : (n_hinges,), fold angles at which the scene starts, rad.
    """

    linkage: Linkage
    setup: Setup
    links: tuple[TreeLink, ...]
    closures: tuple[LoopClosure, ...]
    has_free_base: bool
    start: Reals


def cut_tree(linkage: Linkage, labels: Labels, scene: Scene | Setup) -> CutTree:
    """Cut the loops of a linkage in a scene open; HcsearchError as of `compile_scene`."""
    setup = setup_of_scene(scene, linkage)
    # link frames are those of this linkage, not of its twin
    compiled = compile_scene(replace(linkage, twin=None), setup, keep=frozenset(OMISSIONS))
    system, held = compiled.system, setup.held
    shift = int(np.count_nonzero(~compiled.hinged))
    base = system.bodies[shift - 1] if shift else panel_bodies(linkage, setup.density)[held]
    links = [TreeLink(_panel(labels, held), held, True, np.zeros(3), base, None)]
    hinge_of = {int(joint): hinge for hinge, joint in enumerate(compiled.joint_of)}
    parts = {held: 1}
    for i in range(shift, system.n_joints):
        joint, hinge = system.joints[i], hinge_of[i]
        parent = max(0, joint.parent - shift + 1)
        ends = linkage.pattern.hinges[hinge]
        panel = ends.second if ends.first == links[parent].panel else ends.first
        parts[panel] = parts.get(panel, 0) + 1
        name = _panel(labels, panel) + ("" if parts[panel] == 1 else f"_part{parts[panel]}")
        joined = LinkJoint(f"hinge_{labels.hinges[hinge]}", hinge, parent, joint.axis, system.drives[i])
        links.append(TreeLink(name, panel, parts[panel] == 1, joint.point, system.bodies[i], joined))
    places = [(max(0, weld.first - shift + 1), weld.second - shift + 1, weld.point) for weld in system.welds]
    closures = tuple(LoopClosure(f"closure_{k}", *parts) for k, parts in enumerate(places))
    start = compiled.start[compiled.joint_of]
    return CutTree(linkage, setup, tuple(links), closures, bool(shift), start)


def linear_law_of(law: Law, name: str) -> tuple[float, float]:
    """Return stiffness (N m/rad) and moment at angle 0 (N m) of a linear law; HcsearchError for other laws.

    name : of the hinge, for messages.
    """
    pieces = law.straight.cubics
    if law.full:
        raise HcsearchError(f"{name} has the law {law.text}, and MuJoCo's springs always act: write a .urdf instead")
    if law.bent is not None or len(pieces) > 1 or any(pieces[0][2:]):
        raise HcsearchError(
            f"{name} has the law {law.text or 'of a table'}, and MuJoCo's springs are linear: give it one, such as "
            f"linear:{law.mean_stiffness:.3g}, which has its mean stiffness"
        )
    moment, stiffness, *_ = pieces[0]
    return stiffness, moment - stiffness * law.straight.breaks[0]


def numbers_text(values: Any) -> str:
    """Format numbers for XML attributes, in full precision."""
    return " ".join(repr(float(x) + 0.0) for x in np.atleast_1d(values))  # no -0.0


def _panel(labels: Labels, panel: int) -> str:
    return f"panel_{labels.panels[panel]}"
