"""URDF: the tree of links of a cut-open array, and a second file with the loop closures, which URDF cannot express.

The second file, `.closure.json`, lists the pairs of links that are one panel with their coincident frames, the springs,
the start, and all values of the scene. Each panel has a mesh (`.panel_3.stl`), in metres. SI units.
"""

from __future__ import annotations

import json
import math
from typing import Any
from xml.etree import ElementTree as Xml

from hcsearch.basics.array_values import Reals
from hcsearch.export.cut_trees import CutTree, TreeLink, cut_tree, numbers_text
from hcsearch.export.print_formats import stl_of
from hcsearch.export.scene_values import stated_values
from hcsearch.scenes import Scene
from hcsearch.scenes.scene import HARDWARE_VALUES, HINGE_VALUES
from hcsearch.shape.labels import Labels
from hcsearch.shape.linkage import Linkage

UNLIMITED_EFFORT = 1e6
"""Limits of effort and velocity of a joint (N m, rad/s), which URDF requires, set beyond reach."""


def urdf_of(linkage: Linkage, labels: Labels, scene: Scene, title: str, stem: str) -> dict[str, str | bytes]:
    """Return the contents of the files, by what follows the stem of their names; the URDF file first."""
    tree = cut_tree(linkage, labels, scene)
    files: dict[str, str | bytes] = {
        ".urdf": _tree(tree, title, stem),
        ".closure.json": closure_json(tree, scene, title),
    }
    for link in tree.links:
        if link.has_shape:
            files[_mesh(link)] = stl_of(linkage, linkage.flat, link.name, (link.panel,), scale=1.0)
    return files


def _tree(tree: CutTree, title: str, stem: str) -> str:
    root = Xml.Element("robot", name=title or "array")
    for link in tree.links:
        element = Xml.SubElement(root, "link", name=link.name)
        inertial = Xml.SubElement(element, "inertial")
        Xml.SubElement(inertial, "origin", xyz=numbers_text(link.body.centre - link.frame), rpy="0 0 0")
        Xml.SubElement(inertial, "mass", value=repr(float(link.body.mass)))
        moments = {
            f"i{'xyz'[i]}{'xyz'[j]}": repr(float(link.body.inertia[i, j])) for i in range(3) for j in range(i, 3)
        }
        Xml.SubElement(inertial, "inertia", moments)
        if link.has_shape:
            for kind in ("visual", "collision"):
                shape = Xml.SubElement(element, kind)
                Xml.SubElement(shape, "origin", xyz=numbers_text(-link.frame), rpy="0 0 0")
                Xml.SubElement(Xml.SubElement(shape, "geometry"), "mesh", filename=f"{stem}{_mesh(link)}")
    for link in tree.links[1:]:
        _add_joint(root, tree, link)
    Xml.indent(root)
    return '<?xml version="1.0"?>\n' + Xml.tostring(root, encoding="unicode") + "\n"


def _add_joint(root: Xml.Element, tree: CutTree, link: TreeLink) -> None:
    joint = link.joint
    assert joint is not None
    parent = tree.links[joint.parent]
    element = Xml.SubElement(root, "joint", name=joint.name, type="revolute")
    Xml.SubElement(element, "parent", link=parent.name)
    Xml.SubElement(element, "child", link=link.name)
    Xml.SubElement(element, "origin", xyz=numbers_text(link.frame - parent.frame), rpy="0 0 0")
    Xml.SubElement(element, "axis", xyz=numbers_text(joint.axis))
    unlimited = repr(UNLIMITED_EFFORT)
    Xml.SubElement(element, "limit", lower="0.0", upper=repr(math.pi), effort=unlimited, velocity=unlimited)
    drive = joint.drive
    Xml.SubElement(element, "dynamics", damping=repr(float(drive.damping)), friction=repr(float(drive.friction)))


def closure_json(tree: CutTree, scene: Scene, title: str) -> str:
    """Return as JSON what URDF cannot express: closures, springs, start, whether the base floats, and the whole scene.

    Frames are given by translations (m) in the frames of their links, which have the axes of the flat state: the two
    frames of a closure coincide without a relative rotation.
    """
    links = tree.links
    hardware = {name: getattr(tree.setup, name) for name in HINGE_VALUES if name in HARDWARE_VALUES}
    facts: dict[str, Any] = {
        "design": title,
        "base": links[0].name,
        "base_floats": tree.has_free_base,
        "gravity_m_s2": _listed(tree.setup.gravity),
        "closures": [
            {
                "name": closure.name,
                "panel": links[closure.second].name.partition("_part")[0],
                "first": _end_facts(links[closure.first], closure.point),
                "second": _end_facts(links[closure.second], closure.point),
                "closes": "all six directions",
            }
            for closure in tree.closures
        ],
        "joints": {
            link.joint.name: _joint_facts(tree, link)
            | {"hardware": {name: values[link.joint.hinge] for name, values in hardware.items()}}
            for link in links
            if link.joint is not None
        },
        "scene": stated_values(scene),
    }
    return json.dumps(facts, indent=2, allow_nan=False) + "\n"


def _end_facts(link: TreeLink, point: Reals) -> dict[str, Any]:
    return {"link": link.name, "xyz_m": _listed(point - link.frame)}


def _joint_facts(tree: CutTree, link: TreeLink) -> dict[str, Any]:
    """Spring law (as of `dynamics.laws`: N m by rad, towards angle 0), damping, start and packed angle of a joint."""
    joint = link.joint
    assert joint is not None
    return {
        "law": joint.drive.law.text,
        "damping_N_m_s_rad": float(joint.drive.damping),
        "start_rad": float(tree.start[joint.hinge]),
        "packed_rad": float(tree.linkage.folded[joint.hinge]),
    }


def _mesh(link: TreeLink) -> str:
    return f".{link.name}.stl"


def _listed(values: Any) -> list[float]:
    return [float(x) for x in values]
