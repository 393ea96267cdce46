"""URDF: the tree of links of a cut-open array, and beside it what closes its loops, as URDF has no loops.

Beside the file are `.closure.json`, with the pairs of links that are one panel, the frames that coincide, and the
springs and the start that URDF has no words for, and a mesh of each panel (`.panel_3.stl`), in metres. SI units.
"""

from __future__ import annotations

import json
import math
from typing import Any
from xml.etree import ElementTree as Xml

from hcsearch.export.cut_trees import CutTree, TreeLink, cut_tree, numbers_text
from hcsearch.export.print_formats import stl_of
from hcsearch.scenes import Scene
from hcsearch.scenes.setup import Setup
from hcsearch.shape.labels import Labels
from hcsearch.shape.linkage import Linkage

UNLIMITED_EFFORT = 1e6
"""Greatest effort and rate of a joint (N m, rad/s), which URDF wants: ours have none."""


def urdf_of(linkage: Linkage, labels: Labels, scene: Scene | Setup, title: str, stem: str) -> dict[str, str | bytes]:
    """Files by what follows the stem of their names."""
    tree = cut_tree(linkage, labels, scene)
    files: dict[str, str | bytes] = {".urdf": _tree(tree, title, stem), ".closure.json": closure_json(tree, title)}
    for link in tree.links:
        if link.whole:
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
        if link.whole:
            for kind in ("visual", "collision"):
                shape = Xml.SubElement(element, kind)
                Xml.SubElement(shape, "origin", xyz=numbers_text(-link.frame), rpy="0 0 0")
                Xml.SubElement(Xml.SubElement(shape, "geometry"), "mesh", filename=f"{stem}{_mesh(link)}")
    for link in tree.links[1:]:
        _add_joint(root, tree, link)
    Xml.indent(root)
    return '<?xml version="1.0"?>\n' + Xml.tostring(root, encoding="unicode") + "\n"


def _add_joint(root: Xml.Element, tree: CutTree, link: TreeLink) -> None:
    joined = link.joined
    assert joined is not None
    above = tree.links[joined.above]
    joint = Xml.SubElement(root, "joint", name=joined.name, type="revolute")
    Xml.SubElement(joint, "parent", link=above.name)
    Xml.SubElement(joint, "child", link=link.name)
    Xml.SubElement(joint, "origin", xyz=numbers_text(link.frame - above.frame), rpy="0 0 0")
    Xml.SubElement(joint, "axis", xyz=numbers_text(joined.axis))
    limits = {
        "lower": "0.0",
        "upper": repr(math.pi),
        "effort": repr(UNLIMITED_EFFORT),
        "velocity": repr(UNLIMITED_EFFORT),
    }
    Xml.SubElement(joint, "limit", limits)
    Xml.SubElement(joint, "dynamics", damping=repr(float(joined.drive.damping)), friction="0.0")


def closure_json(tree: CutTree, title: str) -> str:
    """What the tree lacks, as JSON: closures, springs, start, gravity and what is held.

    Frames are translations (m) in the frames of their links, which have the axes of the flat state: where both links
    are one panel, the two frames coincide, not turned against each other.
    """
    links = tree.links
    facts: dict[str, Any] = {
        "design": title,
        "base": links[0].name,
        "base_floats": tree.floats,
        "gravity_m_s2": _listed(tree.setup.gravity),
        "closures": [
            {
                "name": closure.name,
                "panel": links[closure.second].name.partition("_part")[0],
                "first": {
                    "link": links[closure.first].name,
                    "xyz_m": _listed(closure.point - links[closure.first].frame),
                },
                "second": {
                    "link": links[closure.second].name,
                    "xyz_m": _listed(closure.point - links[closure.second].frame),
                },
                "closes": "all six directions",
            }
            for closure in tree.closures
        ],
        "joints": {link.joined.name: _joint_facts(tree, link) for link in links if link.joined is not None},
    }
    return json.dumps(facts, indent=2, allow_nan=False) + "\n"


def _joint_facts(tree: CutTree, link: TreeLink) -> dict[str, Any]:
    """Spring (as of `dynamics.laws`, N m by rad, towards angle 0), damper and start of the joint of a link."""
    joined = link.joined
    assert joined is not None
    return {
        "law": joined.drive.law.text,
        "damping_N_m_s_rad": float(joined.drive.damping),
        "start_rad": float(tree.start[joined.hinge]),
    }


def _mesh(link: TreeLink) -> str:
    return f".{link.name}.stl"


def _listed(values: Any) -> list[float]:
    return [float(x) for x in values]
