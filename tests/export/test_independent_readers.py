"""Exports opened by independent readers of their formats: the dependency group `readers`, and npm for glTF."""

import io
import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

from hcsearch.export.glb import glb_of
from hcsearch.export.panel_solids import panel_solid_of, placed_vertices
from hcsearch.export.print_formats import stl_of, threemf_of
from hcsearch.export.step import step_of
from hcsearch.springs.dynamics.panels import panel_bodies
from tests.export.cases import NAMES, case, replay, volumes

pytestmark = pytest.mark.extra

VALIDATOR = "gltf-validator@2.0.0-dev.3.10"
SCRIPT = """
const validator = require('gltf-validator'), fs = require('fs');
validator.validateBytes(new Uint8Array(fs.readFileSync(process.argv[1])), {maxIssues: 0})
    .then(report => console.log(JSON.stringify(report)));
"""


@pytest.fixture(scope="session")
def node_folder(tmp_path_factory):
    """A folder with the Khronos validator."""
    folder = tmp_path_factory.mktemp("node")
    words = ["npm", "install", "--no-audit", "--no-fund", "--silent", "--prefix", str(folder), VALIDATOR]
    subprocess.run(words, check=True, capture_output=True, timeout=120)
    return folder


def motion_of(name):
    linkage, _ = case(name)
    shares = np.linspace(1.0, 0.0, 12)[:, None] ** np.linspace(0.5, 2.0, linkage.n_hinges)
    return replay(name, shares * linkage.folded)


@pytest.mark.parametrize("name", NAMES)
def test_khronos_validator_finds_nothing_wrong(name, node_folder, tmp_path):
    path = tmp_path / "a.glb"
    path.write_bytes(glb_of(motion_of(name)))
    surroundings = os.environ | {"NODE_PATH": str(Path(node_folder) / "node_modules")}
    done = subprocess.run(
        ["node", "-e", SCRIPT, str(path)], env=surroundings, capture_output=True, check=True, timeout=60
    )
    report = json.loads(done.stdout)
    issues = report["issues"]
    assert [issues[kind] for kind in ("numErrors", "numWarnings", "numInfos", "numHints")] == [0, 0, 0, 0], issues
    assert report["info"]["animationCount"] == 1
    assert report["info"]["drawCallCount"] >= case(name)[0].n_panels


@pytest.mark.parametrize("name", NAMES)
def test_trimesh_reads_the_first_state_of_glb_with_the_panels_in_place(name):
    import trimesh

    motion = motion_of(name)
    linkage, labels = case(name)
    scene = trimesh.load(io.BytesIO(glb_of(motion)), file_type="glb")
    poses = linkage.poses(motion.angles[0])
    for panel, label in enumerate(labels.panels):
        corners = [
            trimesh.transform_points(scene.geometry[geometry].vertices, pose)
            for pose, geometry in (
                scene.graph[node] for node in scene.graph.nodes_geometry if is_of(scene, node, label)
            )
        ]
        vertices = np.concatenate(corners)[:, [0, 2, 1]] * [1.0, -1.0, 1.0]  # y is upwards there
        solid = panel_solid_of(linkage.pattern, panel)
        expected = placed_vertices(poses[panel], solid.vertices)
        apart = np.linalg.norm(vertices[:, None] - expected, axis=2)
        assert max(apart.min(axis=1).max(), apart.min(axis=0)[solid.wall[:, 0]].max()) < 1e-6


def is_of(scene, node, label):
    """Whether a node is that of a panel, or below it where a mesh has several materials."""
    while node != scene.graph.base_frame:
        if node == f"panel {label}":
            return True
        node = scene.graph.transforms.parents.get(node, scene.graph.base_frame)
    return False


@pytest.mark.parametrize("name", NAMES)
def test_trimesh_reads_stl_and_3mf_as_watertight_panels_of_their_volumes(name):
    import trimesh

    linkage, labels = case(name)
    expected = volumes(linkage)
    whole = trimesh.load(io.BytesIO(stl_of(linkage, linkage.folded, name)), file_type="stl")
    assert 1e-9 * whole.volume == pytest.approx(sum(expected), rel=1e-6)
    one = trimesh.load(io.BytesIO(stl_of(linkage, linkage.folded, name, (1,))), file_type="stl")
    assert one.is_watertight
    assert 1e-9 * one.volume == pytest.approx(expected[1], rel=1e-6)
    scene = trimesh.load(io.BytesIO(threemf_of(linkage, labels, linkage.folded, name)), file_type="3mf")
    assert scene.units == "millimeter"
    assert set(scene.geometry) == {f"panel {panel}" for panel in labels.panels}
    for volume, label in zip(expected, labels.panels, strict=True):
        mesh = scene.geometry[f"panel {label}"]
        assert mesh.is_watertight
        assert 1e-9 * mesh.volume == pytest.approx(volume, rel=1e-9)
    corners = np.concatenate([solid.reshape(-1, 3) for solid in linkage.solids(linkage.folded)])
    assert 1e-3 * scene.bounds == pytest.approx(np.array([corners.min(axis=0), corners.max(axis=0)]), abs=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_open_cascade_reads_step_as_valid_solids_named_and_placed_by_panel(name, tmp_path):
    linkage, labels = case(name)
    path = tmp_path / "a.step"
    path.write_text(step_of(linkage, labels, linkage.folded, name))
    parts = parts_in_step(path)
    assert set(parts) == {f"panel {panel}" for panel in labels.panels}
    poses = linkage.poses(linkage.folded)
    for panel, (label, volume) in enumerate(zip(labels.panels, volumes(linkage), strict=True)):
        valid, own, centre = parts[f"panel {label}"]
        assert valid
        assert 1e-9 * own == pytest.approx(volume, rel=1e-9)
        expected = placed_vertices(poses[panel], panel_bodies(linkage, 1.0)[panel].centre[None])[0]
        assert 1e-3 * np.array(centre) == pytest.approx(expected, abs=1e-9)


def test_open_cascade_reads_one_panel_as_one_part(tmp_path):
    linkage, labels = case("hex:0234550132:4")
    path = tmp_path / "a.step"
    path.write_text(step_of(linkage, labels, linkage.flat, "one", (3,)))
    assert list(parts_in_step(path)) == [f"panel {labels.panels[3]}"]


def parts_in_step(path):
    """Name of each part to whether it is valid, its volume (mm^3) and its centre (mm) where the assembly places it."""
    from OCP.BRepCheck import BRepCheck_Analyzer
    from OCP.BRepGProp import BRepGProp
    from OCP.collections import Sequence_TDF_Label
    from OCP.GProp import GProp_GProps
    from OCP.IFSelect import IFSelect_ReturnStatus
    from OCP.STEPCAFControl import STEPCAFControl_Reader
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDataStd import TDataStd_Name
    from OCP.TDF import TDF_Label
    from OCP.TDocStd import TDocStd_Document
    from OCP.XCAFDoc import XCAFDoc_DocumentTool, XCAFDoc_ShapeTool

    reader = STEPCAFControl_Reader()
    reader.SetNameMode(True)
    document = TDocStd_Document(TCollection_ExtendedString("XmlOcaf"))
    assert reader.ReadFile(str(path)) == IFSelect_ReturnStatus.IFSelect_RetDone
    assert reader.Transfer(document)
    tool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    roots = Sequence_TDF_Label()
    tool.GetFreeShapes(roots)
    assert roots.Length() == 1
    labels = Sequence_TDF_Label()
    if XCAFDoc_ShapeTool.IsAssembly_s(roots.Value(1)):
        XCAFDoc_ShapeTool.GetComponents_s(roots.Value(1), labels)
    else:
        labels.Append(roots.Value(1))
    parts = {}
    for k in range(1, labels.Length() + 1):
        own = labels.Value(k)
        shape = XCAFDoc_ShapeTool.GetShape_s(own)
        referred = TDF_Label()
        part = referred if XCAFDoc_ShapeTool.GetReferredShape_s(own, referred) else own
        name = TDataStd_Name()
        assert part.FindAttribute(TDataStd_Name.GetID_s(), name)
        properties = GProp_GProps()
        BRepGProp.VolumeProperties_s(shape, properties)
        centre = properties.CentreOfMass()
        title = name.Get().ToExtString()
        parts[title] = (BRepCheck_Analyzer(shape).IsValid(), properties.Mass(), (centre.X(), centre.Y(), centre.Z()))
    return parts
