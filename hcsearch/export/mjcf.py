"""MJCF, the format of MuJoCo: a scene with its springs, dampers, stops, gravity and start, loops closed by welds.

Loops are cut through panels whose parts are welded to each other, so that every hinge is a joint. SI units; joints are
fold angles, 0 flat. MuJoCo's constraints are soft: how far it then moves beside us is in docs/howto/export_solids.md.
"""

from __future__ import annotations

import math
from xml.etree import ElementTree as Xml

import numpy as np

from hcsearch.basics.errors import HcsearchError
from hcsearch.export.cut_trees import CutTree, TreeLink, cut_tree, linear_law_of, numbers_text
from hcsearch.motion.collision.panel_prisms import check_margin, prisms_of
from hcsearch.scenes import Scene
from hcsearch.scenes.setup import Setup, natural_seconds, setup_of_scene
from hcsearch.shape.labels import Labels
from hcsearch.shape.linkage import Linkage

STEPS_PER_NATURAL_TIME = 50_000
"""In the natural time of a scene; a step is 0.02 ms for panels of 50 mm, which the stiff welds ask for."""
MAX_DAMPED_RATE_SHARE = 1.0
"""Share of a panel's rate that its damper may take in a step of the Runge-Kutta method, which is unstable above 2.8."""
MIN_INERTIA = 1e-14
"""The least principal moment of inertia that MuJoCo reads, kg m^2."""
MAX_ACCELERATION = 1e10
"""The greatest acceleration that MuJoCo goes on with, rad/s^2."""
MAX_IMPEDANCE = 0.9999
"""The greatest impedance that MuJoCo has: constraints then give way least."""
SOLVER_ITERATIONS, SOLVER_TOLERANCE = 50, 1e-12
"""Of its solver, which needs few steps as nothing but welds and stops are constraints."""
_COLOURS = ("0.86 0.83 0.73 1", "0.62 0.65 0.71 1")


def mjcf_of(
    linkage: Linkage,
    labels: Labels,
    scene: Scene | Setup,
    title: str = "",
    *,
    contact: bool = False,
    timestep: float | None = None,
) -> str:
    """A linkage in a scene as a model of MuJoCo, whose keyframes are the start and the flat state.

    contact : whether panels collide, shrunk by the scene's margin as in our own check; neighbours at a hinge never do,
    as its stops keep them apart. timestep : s, by `STEPS_PER_NATURAL_TIME` unless given. HcsearchError where a law is
    not linear, and for panels that are too small for MuJoCo.
    """
    setup = setup_of_scene(scene, linkage)
    tree = cut_tree(linkage, labels, setup)
    _check_size(tree)
    timestep = timestep or natural_seconds(setup, linkage) / STEPS_PER_NATURAL_TIME
    root = Xml.Element("mujoco", model=title or "array")
    Xml.SubElement(root, "compiler", angle="radian", autolimits="true", inertiafromgeom="false")
    Xml.SubElement(
        root,
        "option",
        timestep=numbers_text(timestep),
        integrator=_integrator(tree, timestep),
        gravity=numbers_text(tree.setup.gravity),
        iterations=str(SOLVER_ITERATIONS),
        tolerance=numbers_text(SOLVER_TOLERANCE),
    )
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
    """Refuse panels too small for MuJoCo: by their own moments of inertia, and by what springs do with them alone."""
    for link in tree.links:
        least = float(np.linalg.eigvalsh(link.body.inertia)[0])
        if least < MIN_INERTIA:
            raise HcsearchError(
                f"{link.name} has a moment of inertia of {least:.2g} kg m^2, and MuJoCo reads none below "
                f"{MIN_INERTIA:g}: give larger panels with --panel"
            )
        if link.joined is None:
            continue
        stiffness, moment = linear_law_of(link.joined.drive.law, link.joined.name)
        most = abs(stiffness * tree.start[link.joined.hinge] + moment) / _inertia_at_hinge(link)
        if most > MAX_ACCELERATION:
            raise HcsearchError(
                f"the spring of {link.joined.name} turns {link.name} alone at {most:.2g} rad/s^2, and MuJoCo stops "
                f"above {MAX_ACCELERATION:g}: give larger panels with --panel, or a scene with softer springs"
            )


def _inertia_at_hinge(link: TreeLink) -> float:
    """The moment of inertia of a link about its hinge, kg m^2."""
    assert link.joined is not None
    return float(link.joined.axis @ link.body.about(link.frame) @ link.joined.axis)


def _integrator(tree: CutTree, timestep: float) -> str:
    """The most accurate integrator that is stable: dampers stop light panels within a step."""
    rates = [link.joined.drive.damping / _inertia_at_hinge(link) for link in tree.links if link.joined is not None]
    return "RK4" if max(rates, default=0.0) * timestep <= MAX_DAMPED_RATE_SHARE else "implicitfast"


def _add_defaults(root: Xml.Element, timestep: float, contact: bool) -> None:
    """Constraints settle within two steps, the fastest that is stable."""
    default = Xml.SubElement(root, "default")
    soft = {
        "solref": numbers_text((2.0 * timestep, 1.0)),
        "solimp": numbers_text((MAX_IMPEDANCE, MAX_IMPEDANCE, 1e-3, 0.5, 2.0)),
    }
    Xml.SubElement(default, "equality", soft)
    limits = {f"{name}limit": text for name, text in soft.items()}
    Xml.SubElement(default, "joint", limits, range=numbers_text((0.0, math.pi)))
    kind = "1" if contact else "0"
    Xml.SubElement(default, "geom", type="mesh", contype=kind, conaffinity=kind)


def _add_meshes(root: Xml.Element, tree: CutTree) -> None:
    """A convex mesh for each facet, less the margin by which our own check shrinks panels."""
    asset = Xml.SubElement(root, "asset")
    check_margin(tree.linkage, tree.setup.margin)
    prisms = prisms_of(tree.linkage, tree.setup.margin)
    for link in tree.links:
        for facet in tree.linkage.pattern.panels[link.panel] if link.whole else ():
            corners = prisms.vertices[facet, : prisms.counts[facet, 0]] - link.frame
            Xml.SubElement(asset, "mesh", name=_mesh(link, facet), vertex=numbers_text(corners.ravel()))


def _add_bodies(world: Xml.Element, tree: CutTree, actuators: Xml.Element) -> None:
    elements: list[Xml.Element] = []
    for link in tree.links:
        joined = link.joined
        above = tree.links[joined.above].frame if joined else np.zeros(3)
        element = Xml.SubElement(
            elements[joined.above] if joined else world, "body", name=link.name, pos=numbers_text(link.frame - above)
        )
        elements.append(element)
        if joined:
            _add_joint(element, link, actuators)
        elif tree.floats:
            Xml.SubElement(element, "freejoint", name="base")
        inertia = link.body.inertia
        parts = (inertia[0, 0], inertia[1, 1], inertia[2, 2], inertia[0, 1], inertia[0, 2], inertia[1, 2])
        centre = link.body.centre - link.frame
        Xml.SubElement(
            element,
            "inertial",
            pos=numbers_text(centre),
            mass=numbers_text(link.body.mass),
            fullinertia=numbers_text(parts),
        )
        for facet in tree.linkage.pattern.panels[link.panel] if link.whole else ():
            Xml.SubElement(element, "geom", mesh=_mesh(link, facet), rgba=_COLOURS[link.panel % 2])


def _add_joint(element: Xml.Element, link: TreeLink, actuators: Xml.Element) -> None:
    """A hinge: moment = stiffness (angle - springref) + damping rate; a moment without stiffness by an actuator."""
    joined = link.joined
    assert joined is not None
    stiffness, moment = linear_law_of(joined.drive.law, joined.name)
    values = {"name": joined.name, "type": "hinge", "axis": numbers_text(joined.axis)}
    values |= {"stiffness": numbers_text(stiffness), "damping": numbers_text(joined.drive.damping)}
    if moment and stiffness:
        values["springref"] = numbers_text(-moment / stiffness)
    elif moment:
        bias = {"biastype": "affine", "gainprm": "0", "biasprm": numbers_text((-moment, 0.0, 0.0))}
        Xml.SubElement(actuators, "general", bias, name=f"{joined.name}_moment", joint=joined.name)
    Xml.SubElement(element, "joint", values)


def _add_constraints(root: Xml.Element, tree: CutTree) -> None:
    contact, equality = Xml.SubElement(root, "contact"), Xml.SubElement(root, "equality")
    names = {link.panel: link.name for link in tree.links if link.whole}
    for one, two in sorted({(hinge.first, hinge.second) for hinge in tree.linkage.pattern.hinges}):
        Xml.SubElement(contact, "exclude", body1=names[one], body2=names[two])
    for closure in tree.closures:
        first, second = tree.links[closure.first], tree.links[closure.second]
        Xml.SubElement(
            equality,
            "weld",
            name=closure.name,
            body1=first.name,
            body2=second.name,
            # in the frame of the second body; unless a pose is given, they are welded as they are in the flat state
            anchor=numbers_text(closure.point - second.frame),
        )


def _add_keys(root: Xml.Element, tree: CutTree) -> None:
    """The states at which the scene starts and ends; MuJoCo numbers its joints by going down the tree."""
    base = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0) if tree.floats else ()
    hinges = _downwards(tree)
    keyframe = Xml.SubElement(root, "keyframe")
    for name, angles in (("start", tree.start), ("flat", tree.linkage.flat)):
        Xml.SubElement(keyframe, "key", name=name, qpos=numbers_text((*base, *angles[hinges])))


def _downwards(tree: CutTree) -> list[int]:
    """Hinges in the order of a walk down the tree: those below a link come right after its own."""
    below: list[list[tuple[int, int]]] = [[] for _ in tree.links]
    for k, link in enumerate(tree.links):
        if link.joined is not None:
            below[link.joined.above].append((k, link.joined.hinge))
    hinges, waiting = [], below[0][::-1]
    while waiting:
        k, hinge = waiting.pop()
        hinges.append(hinge)
        waiting += below[k][::-1]
    return hinges


def _mesh(link: TreeLink, facet: int) -> str:
    return f"{link.name}_facet{facet}"
