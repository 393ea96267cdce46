"""MJCF, the format of MuJoCo: a scene with its springs, dampers, friction, stops, gravity and start.

Loops are cut through panels, whose parts are welded to each other, so that every hinge is a joint. SI units; joint
coordinates are fold angles, 0 flat. MuJoCo's constraints are soft: docs/howto/export_solids.md compares its motion with
ours.
"""

from __future__ import annotations

import math
from xml.etree import ElementTree as Xml

import numpy as np

from hcsearch.basics.errors import HcsearchError
from hcsearch.export.cut_trees import CutTree, TreeLink, cut_tree, linear_law_of, numbers_text
from hcsearch.export.scene_values import check_model_values, scene_notes
from hcsearch.motion.collision.panel_prisms import check_margin, prisms_of
from hcsearch.scenes import Scene
from hcsearch.scenes.setup import natural_seconds
from hcsearch.shape.labels import Labels
from hcsearch.shape.linkage import Linkage

STEPS_PER_NATURAL_TIME = 50_000
"""Steps in the natural time of a scene; 0.02 ms each for panels of 50 mm, as required by the stiff welds."""
MAX_DAMPED_RATE_SHARE = 1.0
"""Limit of damping times step over inertia for the Runge-Kutta method, which is unstable above 2.8."""
MIN_INERTIA = 1e-14
"""The least principal moment of inertia that MuJoCo accepts, kg m^2."""
MAX_ACCELERATION = 1e10
"""The acceleration above which MuJoCo stops, rad/s^2."""
MAX_IMPEDANCE = 0.9999
"""The greatest impedance of MuJoCo, which makes constraints as stiff as possible."""
STOP_DAMPING_RATIO = 5.0
"""Damping of stops over the critical one, at which they would throw hinges back with 0.16 of their speed, whatever the
step; these do so with 0.01, as near to a restitution of 0 as stops allow that settle within some steps."""
SOLVER_ITERATIONS, SOLVER_TOLERANCE = 50, 1e-12
"""Iterations and tolerance of its solver, which converges fast since only welds and stops are constraints."""
_COLOURS = ("0.86 0.83 0.73 1", "0.62 0.65 0.71 1")


def mjcf_of(
    linkage: Linkage,
    labels: Labels,
    scene: Scene,
    title: str = "",
    *,
    contact: bool = False,
    timestep: float | None = None,
) -> str:
    """Return a linkage in a scene as a model of MuJoCo, with the start, the packed and the flat state as keyframes.

    contact : whether panels collide, shrunk by the scene's margin as in our own check; neighbours at a hinge never do,
    since its stops keep them apart. timestep : s, by `STEPS_PER_NATURAL_TIME` unless given. HcsearchError where a law
    is not linear, for values of the scene that a model cannot hold, and for panels that are too small for MuJoCo.
    """
    check_model_values(scene)
    tree = cut_tree(linkage, labels, scene)
    _check_size(tree)
    timestep = timestep or natural_seconds(tree.setup, linkage) / STEPS_PER_NATURAL_TIME
    root = Xml.Element("mujoco", model=title or "array")
    Xml.SubElement(root, "compiler", angle="radian", autolimits="true", inertiafromgeom="false")
    stepping = {"timestep": numbers_text(timestep), "integrator": _integrator(tree, timestep)}
    solver = {"iterations": str(SOLVER_ITERATIONS), "tolerance": numbers_text(SOLVER_TOLERANCE)}
    Xml.SubElement(root, "option", stepping | {"gravity": numbers_text(tree.setup.gravity)} | solver)
    _add_notes(root, scene)
    _add_defaults(root, timestep, contact)
    _add_meshes(root, tree)
    actuators = Xml.Element("actuator")
    _add_bodies(Xml.SubElement(root, "worldbody"), tree, actuators)
    _add_constraints(root, tree)
    if len(actuators):
        root.append(actuators)
    _add_keys(root, tree)
    Xml.indent(root)
    return Xml.tostring(root, encoding="unicode") + "\n"


def _check_size(tree: CutTree) -> None:
    """Refuse panels too small for MuJoCo, by their moments of inertia and the accelerations that springs give them."""
    for link in tree.links:
        smallest_moment = float(np.linalg.eigvalsh(link.body.inertia)[0])
        if smallest_moment < MIN_INERTIA:
            raise HcsearchError(
                f"{link.name} has a moment of inertia of {smallest_moment:.2g} kg m^2, and MuJoCo reads none below "
                f"{MIN_INERTIA:g}: give larger panels with --panel"
            )
        if link.joint is None:
            continue
        stiffness, moment = linear_law_of(link.joint.drive.law, link.joint.name)
        acceleration = abs(stiffness * tree.start[link.joint.hinge] + moment) / _inertia_at_hinge(link)
        if acceleration > MAX_ACCELERATION:
            raise HcsearchError(
                f"the spring of {link.joint.name} turns {link.name} alone at {acceleration:.2g} rad/s^2, and MuJoCo "
                f"stops above {MAX_ACCELERATION:g}: give larger panels with --panel, or a scene with softer springs"
            )


def _inertia_at_hinge(link: TreeLink) -> float:
    """Return the moment of inertia of a link about its hinge, kg m^2."""
    assert link.joint is not None
    return float(link.joint.axis @ link.body.about(link.frame) @ link.joint.axis)


def _integrator(tree: CutTree, timestep: float) -> str:
    """Return the most accurate stable integrator: implicit where a damper stops a light panel within a step."""
    rates = [link.joint.drive.damping / _inertia_at_hinge(link) for link in tree.links if link.joint is not None]
    return "RK4" if max(rates, default=0.0) * timestep <= MAX_DAMPED_RATE_SHARE else "implicitfast"


def _add_notes(root: Xml.Element, scene: Scene) -> None:
    """Add the values of the scene that no motion depends on as custom data, which MuJoCo keeps with the model."""
    custom = Xml.SubElement(root, "custom")
    for name, value in scene_notes(scene).items():
        if isinstance(value, str):
            Xml.SubElement(custom, "text", name=name, data=value)
        else:
            Xml.SubElement(custom, "numeric", name=name, data=numbers_text(value))


def _add_defaults(root: Xml.Element, timestep: float, contact: bool) -> None:
    """Add defaults, with constraints that settle within two steps, the fastest stable rate, and plastic stops."""
    default = Xml.SubElement(root, "default")
    impedance = (MAX_IMPEDANCE, MAX_IMPEDANCE, 1e-3, 0.5, 2.0)
    soft = {"solref": numbers_text((2.0 * timestep, 1.0)), "solimp": numbers_text(impedance)}
    Xml.SubElement(default, "equality", soft)
    limits = {f"{name}{of}": text for name, text in soft.items() for of in ("limit", "friction")}
    limits["solreflimit"] = numbers_text((2.0 * timestep, STOP_DAMPING_RATIO))
    Xml.SubElement(default, "joint", limits, range=numbers_text((0.0, math.pi)))
    kind = "1" if contact else "0"
    Xml.SubElement(default, "geom", type="mesh", contype=kind, conaffinity=kind)


def _add_meshes(root: Xml.Element, tree: CutTree) -> None:
    """Add a convex mesh for each facet, shrunk by the margin as in our own collision check."""
    asset = Xml.SubElement(root, "asset")
    check_margin(tree.linkage, tree.setup.margin)
    prisms = prisms_of(tree.linkage, tree.setup.margin)
    for link in tree.links:
        for facet in tree.linkage.pattern.panels[link.panel] if link.has_shape else ():
            corners = prisms.vertices[facet, : prisms.counts[facet, 0]] - link.frame
            Xml.SubElement(asset, "mesh", name=_mesh(link, facet), vertex=numbers_text(corners.ravel()))


def _add_bodies(world: Xml.Element, tree: CutTree, actuators: Xml.Element) -> None:
    elements: list[Xml.Element] = []
    for link in tree.links:
        joint = link.joint
        parent_frame = tree.links[joint.parent].frame if joint else np.zeros(3)
        parent, place = elements[joint.parent] if joint else world, numbers_text(link.frame - parent_frame)
        element = Xml.SubElement(parent, "body", name=link.name, pos=place)
        elements.append(element)
        if joint:
            _add_joint(element, link, actuators)
        elif tree.has_free_base:
            Xml.SubElement(element, "freejoint", name="base")
        inertia = link.body.inertia
        parts = (inertia[0, 0], inertia[1, 1], inertia[2, 2], inertia[0, 1], inertia[0, 2], inertia[1, 2])
        centre, mass = numbers_text(link.body.centre - link.frame), numbers_text(link.body.mass)
        Xml.SubElement(element, "inertial", pos=centre, mass=mass, fullinertia=numbers_text(parts))
        for facet in tree.linkage.pattern.panels[link.panel] if link.has_shape else ():
            Xml.SubElement(element, "geom", mesh=_mesh(link, facet), rgba=_COLOURS[link.panel % 2])


def _add_joint(element: Xml.Element, link: TreeLink, actuators: Xml.Element) -> None:
    """Add a hinge: moment = stiffness (angle - springref) + damping rate; a constant moment is an actuator.

    Its friction is that of the scene together with the torque of the harness, which resists in the same way.
    """
    joint = link.joint
    assert joint is not None
    stiffness, moment = linear_law_of(joint.drive.law, joint.name)
    values = {"name": joint.name, "type": "hinge", "axis": numbers_text(joint.axis)}
    values |= {"stiffness": numbers_text(stiffness), "damping": numbers_text(joint.drive.damping)}
    values["frictionloss"] = numbers_text(joint.drive.friction)
    if moment and stiffness:
        values["springref"] = numbers_text(-moment / stiffness)
    elif moment:
        bias = {"biastype": "affine", "gainprm": "0", "biasprm": numbers_text((-moment, 0.0, 0.0))}
        Xml.SubElement(actuators, "general", bias, name=f"{joint.name}_moment", joint=joint.name)
    Xml.SubElement(element, "joint", values)


def _add_constraints(root: Xml.Element, tree: CutTree) -> None:
    contact, equality = Xml.SubElement(root, "contact"), Xml.SubElement(root, "equality")
    names = {link.panel: link.name for link in tree.links if link.has_shape}
    for first_panel, second_panel in sorted({(hinge.first, hinge.second) for hinge in tree.linkage.pattern.hinges}):
        Xml.SubElement(contact, "exclude", body1=names[first_panel], body2=names[second_panel])
    for closure in tree.closures:
        first, second = tree.links[closure.first], tree.links[closure.second]
        Xml.SubElement(
            equality,
            "weld",
            name=closure.name,
            body1=first.name,
            body2=second.name,
            # in the frame of the second body; without a pose, they are welded as they lie in the flat state
            anchor=numbers_text(closure.point - second.frame),
        )


def _add_keys(root: Xml.Element, tree: CutTree) -> None:
    """Add the start, the packed and the flat state as keyframes, in MuJoCo's depth-first order of joints."""
    base = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0) if tree.has_free_base else ()
    hinges = _downwards(tree)
    keyframe = Xml.SubElement(root, "keyframe")
    linkage = tree.linkage
    for name, angles in (("start", tree.start), ("packed", linkage.folded), ("flat", linkage.flat)):
        Xml.SubElement(keyframe, "key", name=name, qpos=numbers_text((*base, *angles[hinges])))


def _downwards(tree: CutTree) -> list[int]:
    """Return the hinges in depth-first order of the tree: those below a link directly follow its own."""
    children: list[list[tuple[int, int]]] = [[] for _ in tree.links]
    for k, link in enumerate(tree.links):
        if link.joint is not None:
            children[link.joint.parent].append((k, link.joint.hinge))
    hinges, waiting = [], children[0][::-1]
    while waiting:
        k, hinge = waiting.pop()
        hinges.append(hinge)
        waiting += children[k][::-1]
    return hinges


def _mesh(link: TreeLink, facet: int) -> str:
    return f"{link.name}_facet{facet}"
