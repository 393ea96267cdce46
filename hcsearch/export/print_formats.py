"""Formats for 3D printers, in millimetres: binary STL (triangles only) and 3MF (an object per panel)."""

from __future__ import annotations

import io
import struct
import zipfile
from collections.abc import Sequence
from xml.etree import ElementTree as Xml

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.export.panel_solids import MILLIMETRES_PER_METRE, PanelSolid, panel_solid_of, placed_vertices
from hcsearch.shape.labels import Labels
from hcsearch.shape.linkage import Linkage

_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def stl_of(
    linkage: Linkage,
    angles: Reals,
    title: str = "",
    panels: Sequence[int] | None = None,
    *,
    scale: float = MILLIMETRES_PER_METRE,
) -> bytes:
    """Return panels (all unless given) at fold angles (n_hinges,), rad, as binary STL.

    scale : units per metre. Coordinates are in single precision, as in all STL files.
    """
    poses = linkage.poses(angles)
    chosen = range(linkage.n_panels) if panels is None else panels
    solids = [panel_solid_of(linkage.pattern, panel) for panel in chosen]
    corners = np.concatenate(
        [placed_vertices(poses[k], solid.vertices)[solid.triangles] for k, solid in zip(chosen, solids, strict=True)]
    )
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    records = np.zeros(len(corners), _RECORD)
    records["normal"] = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    records["corners"] = scale * corners
    # a header that begins with "solid" would be mistaken for the text format
    head = f"hcsearch {title}, {'mm' if scale == MILLIMETRES_PER_METRE else 'm'}".encode("ascii", "replace")[:80].ljust(
        80
    )
    return head + struct.pack("<I", len(records)) + bytes(records.tobytes())


_CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_PACKAGE = "http://schemas.openxmlformats.org/package/2006"
_MODEL = "3D/3dmodel.model"
_DATED = (1980, 1, 1, 0, 0, 0)
"""Fixed date of the archive's members, so that equal exports are equal files."""


def threemf_of(
    linkage: Linkage, labels: Labels, angles: Reals, title: str = "", panels: Sequence[int] | None = None
) -> bytes:
    """Return panels (all unless given) at fold angles (n_hinges,), rad, as 3MF: flat solids with placements."""
    chosen = range(linkage.n_panels) if panels is None else panels
    poses = linkage.poses(angles)
    root = Xml.Element("model", {"unit": "millimeter", "xml:lang": "en", "xmlns": _CORE})
    Xml.SubElement(root, "metadata", name="Title").text = title
    Xml.SubElement(root, "metadata", name="Application").text = "hcsearch"
    resources, build = Xml.SubElement(root, "resources"), Xml.SubElement(root, "build")
    for number, panel in enumerate(chosen, start=1):
        name = f"panel {labels.panels[panel]}"
        element = Xml.SubElement(resources, "object", id=str(number), type="model", name=name)
        _add_mesh(element, panel_solid_of(linkage.pattern, panel))
        # twelve numbers, the 3 x 4 pose column by column: 3MF multiplies row vectors from the left
        pose = poses[panel] * np.array([1.0, 1.0, 1.0, MILLIMETRES_PER_METRE])
        Xml.SubElement(build, "item", objectid=str(number), transform=_text(pose.T.ravel()))
    return _package(Xml.tostring(root, encoding="utf-8", xml_declaration=True))


def _add_mesh(element: Xml.Element, solid: PanelSolid) -> None:
    mesh = Xml.SubElement(element, "mesh")
    vertices, triangles = Xml.SubElement(mesh, "vertices"), Xml.SubElement(mesh, "triangles")
    for x, y, z in (MILLIMETRES_PER_METRE * solid.vertices).tolist():
        Xml.SubElement(vertices, "vertex", x=repr(x), y=repr(y), z=repr(z))
    for a, b, c in solid.triangles.tolist():
        Xml.SubElement(triangles, "triangle", v1=str(a), v2=str(b), v3=str(c))


def _package(model: bytes) -> bytes:
    types = (
        f'<?xml version="1.0" encoding="UTF-8"?><Types xmlns="{_PACKAGE}/content-types">'
        '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
        '<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>'
    )
    relations = (
        f'<?xml version="1.0" encoding="UTF-8"?><Relationships xmlns="{_PACKAGE}/relationships">'
        f'<Relationship Target="/{_MODEL}" Id="rel0" '
        'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>'
    )
    parts = {"[Content_Types].xml": types.encode(), "_rels/.rels": relations.encode(), _MODEL: model}
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as package:
        for name, content in parts.items():
            package.writestr(zipfile.ZipInfo(name, _DATED), content, zipfile.ZIP_DEFLATED)
    return archive.getvalue()


def _text(values: Reals) -> str:
    return " ".join(repr(float(x)) for x in values)
