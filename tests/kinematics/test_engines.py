"""Poses, screws and degrees of freedom against Pinocchio and MuJoCo, which have kinematics of their own."""

import math
from functools import cache
from xml.etree import ElementTree as Xml

import networkx as nx
import numpy as np
import pytest
from scipy.linalg import null_space

from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import fold, foldings
from hcsearch.designs.grid import GRIDS, parse_array
from hcsearch.designs.twisting import twist
from hcsearch.motion.kinematics.closing import close_linkage
from hcsearch.motion.kinematics.dh import dh_closure_jacobian
from hcsearch.motion.kinematics.numerical_rank import rank_at
from hcsearch.search.enumeration import ArraySearch, PolygonSearch
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import MOUNTAIN_CREASE, VALLEY_CREASE, Pattern

pytestmark = pytest.mark.extra

SEARCHES = {
    "hex 10": PolygonSearch(GRIDS["hex"], 10),
    "hex 12": PolygonSearch(GRIDS["hex"], 12),
    "square 12": PolygonSearch(GRIDS["square"], 12),
    "triangle 14": PolygonSearch(GRIDS["triangle"], 14),
    "rectangle 4x4": ArraySearch(parse_array(GRIDS["rectangle"], "4x4")),
}
SIZES = {"hex": (0.05, 0.05, 0.004), "square": (0.05, 0.05, 0.01), "triangle": (0.06, 0.06, 0.005)}
SIZES["rectangle"] = (0.07, 0.04, 0.006)
FEW = 4  # foldings of a search, with and without twist


@cache
def designs(name):
    """Linkages of a few foldings, spread over the list of a search, the two flat pairs hinged."""
    search = SEARCHES[name]
    circuits = [
        Circuit(search.grid, tuple(batch.words[row].tolist()))
        for batch in search.batches()
        for row in sorted(set(fold(batch).row.tolist()))
    ]
    chosen = []
    for twisted in (False, True):
        kind = [f for circuit in circuits for f in foldings(circuit) if bool(twist(f)) is twisted]
        chosen += kind[:: max(1, math.ceil(len(kind) / FEW))]
    return [Linkage(f.pattern(SIZES[search.grid.name], flat_pairs="hinged")) for f in chosen]


def vertices(columns, rows):
    """Rectangles about interior vertices, a loop of four hinges around each, like an egg box."""
    facets, creases = [], {}
    for j in range(rows):
        for i in range(columns):
            x, y = (0.05 * i, 0.05 * (i + 1)), (0.03 * j, 0.03 * (j + 1))
            facets.append(((x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])))
            k = columns * j + i
            if i:
                creases[k - 1, k] = VALLEY_CREASE
            if j:
                creases[k - columns, k] = MOUNTAIN_CREASE if i % 2 else VALLEY_CREASE
    return Linkage(Pattern.from_polygons(tuple(facets), creases, 0.004))


# Every engine gets the flat state as a tree of bodies: for each hinge one joint, from a body to a new one. Where a
# hinge closes a loop, the new body is a copy of a panel that is there already, and has to move as that one does.


def tree(linkage):
    """(body, parent, hinge, sense) from the base on, in depth-first order, and pairs of a panel and its copy."""
    graph = nx.Graph((hinge.first, hinge.second) for hinge in linkage.pattern.hinges)
    in_tree = {frozenset(edge) for edge in nx.bfs_edges(graph, linkage.base)}
    children, pairs = {}, []
    for k, hinge in enumerate(linkage.pattern.hinges):
        ends = (hinge.first, hinge.second)
        if frozenset(ends) in in_tree:
            in_tree.remove(frozenset(ends))  # a second hinge between them closes a loop
            far = nx.shortest_path_length(graph, linkage.base, ends[0]) > nx.shortest_path_length(
                graph, linkage.base, ends[1]
            )
            near, body, sense = (ends[1], ends[0], -1) if far else (*ends, 1)
        else:
            near, body, sense = ends[0], f"copy{k}", 1
            pairs.append((ends[1], body))
        children.setdefault(near, []).append((body, near, k, sense))
    branches, waiting = [], [*reversed(children[linkage.base])]
    while waiting:
        branches.append(waiting.pop())
        waiting += reversed(children.get(branches[-1][0], []))
    return branches, pairs


def in_pinocchio(linkage, angles):
    """Poses of the bodies (4 x 4) and their spatial Jacobians (rotation, velocity at the origin), by body."""
    import pinocchio as pin

    bodies, _ = tree(linkage)
    model, joint_of, point_of = pin.Model(), {linkage.base: 0}, {linkage.base: np.zeros(3)}
    for body, parent, k, sense in bodies:
        joint_of[body] = model.addJoint(
            joint_of[parent],
            pin.JointModelRevoluteUnaligned(sense * linkage.directions[k]),
            pin.SE3(np.eye(3), linkage.points[k] - point_of[parent]),
            f"joint{k}",
        )
        point_of[body] = linkage.points[k]
    columns, q = np.zeros(len(bodies), int), np.zeros(model.nq)
    for body, _, k, _ in bodies:
        joint = model.joints[joint_of[body]]
        columns[k] = joint.idx_v
        q[joint.idx_q] = angles[k]
    data = model.createData()
    pin.computeJointJacobians(model, data, q)
    poses = {linkage.base: np.eye(4)}
    jacobians = {linkage.base: np.zeros((6, len(bodies)))}
    for body, *_ in bodies:
        placed = data.oMi[joint_of[body]]
        poses[body] = (placed * pin.SE3(np.eye(3), -point_of[body])).homogeneous
        jacobian = pin.getJointJacobian(model, data, joint_of[body], pin.ReferenceFrame.WORLD)
        jacobians[body] = np.vstack([jacobian[3:], jacobian[:3]])[:, columns]
    return poses, jacobians


def in_mujoco(linkage, angles):
    """The same."""
    import mujoco

    bodies, _ = tree(linkage)
    root = Xml.Element("mujoco")
    Xml.SubElement(root, "compiler", angle="radian")
    elements = {linkage.base: Xml.SubElement(root, "worldbody")}

    def text(vector):
        return " ".join(repr(float(x)) for x in vector)

    for body, parent, k, sense in bodies:
        elements[body] = Xml.SubElement(elements[parent], "body", name=str(body))
        Xml.SubElement(elements[body], "inertial", pos="0 0 0", mass="1", diaginertia="1 1 1")
        line = {"axis": text(sense * linkage.directions[k]), "pos": text(linkage.points[k])}
        Xml.SubElement(elements[body], "joint", name=f"joint{k}", type="hinge", **line)
    model = mujoco.MjModel.from_xml_string(Xml.tostring(root, encoding="unicode"))
    data = mujoco.MjData(model)
    columns = [model.joint(f"joint{k}").dofadr[0] for k in range(len(bodies))]
    data.qpos[columns] = angles  # hinges only: positions and velocities have the same addresses
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    poses = {linkage.base: np.eye(4)}
    jacobians = {linkage.base: np.zeros((6, len(bodies)))}
    for body, *_ in bodies:
        number = model.body(str(body)).id
        poses[body] = np.eye(4)
        poses[body][:3, :3], poses[body][:3, 3] = data.xmat[number].reshape(3, 3), data.xpos[number]
        velocity, rotation = np.zeros((2, 3, model.nv))
        mujoco.mj_jac(model, data, velocity, rotation, np.zeros(3), number)
        jacobians[body] = np.vstack([rotation, velocity])[:, columns]
    return poses, jacobians


def row_space(matrix, rank):
    """The projector onto it."""
    rows = np.linalg.svd(matrix)[2][:rank]
    return rows.T @ rows


def compare(linkage, angles, engine):
    """Everything at a closed state: where panels are, that copies lie on them, and how they may move."""
    _, pairs = tree(linkage)
    poses, jacobians = engine(linkage, angles)
    for panel, expected in enumerate(linkage.poses(angles)):
        assert poses[panel][:3] == pytest.approx(expected, abs=1e-11)
    for panel, copy in pairs:
        assert poses[panel] == pytest.approx(poses[copy], abs=1e-10)
    theirs = np.vstack([jacobians[copy] - jacobians[panel] for panel, copy in pairs])
    theirs.reshape(len(pairs), 6, -1)[:, 3:] /= linkage.pattern.size
    mine = rank_at(linkage, angles)
    values = np.linalg.svd(theirs, compute_uv=False)
    # no singular value of theirs lies between these two
    assert [np.count_nonzero(values > least) for least in (1e-7, 1e-10)] == [mine.rank, mine.rank]
    assert mine.nullity == null_space(theirs, rcond=1e-9).shape[1]
    for ours in (linkage.closure(angles)[1], dh_closure_jacobian(linkage, angles)):
        assert row_space(ours, mine.rank) == pytest.approx(row_space(theirs, mine.rank), abs=1e-9)


def opened(linkage, seed):
    """A closed state about 0.3 rad from the folded one, on its open side."""
    change = np.random.default_rng(seed).uniform(0, 0.3, linkage.n_hinges)
    closed = close_linkage(linkage, linkage.folded - np.where(linkage.folded > 0, change, 0))
    assert closed.closed
    return closed.angles


ENGINES = [in_pinocchio, in_mujoco]


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("name", SEARCHES)
def test_foldings_move_as_in(engine, name):
    for seed, linkage in enumerate(designs(name)):
        for angles in (linkage.folded, linkage.flat, opened(linkage, seed)):
            compare(linkage, angles, engine)


def test_there_are_at_least_twenty_of_them():
    assert sum(len(designs(name)) for name in SEARCHES) >= 20


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("size", [(2, 2), (3, 2), (3, 3)])
def test_loops_that_share_hinges_move_as_in(engine, size):
    linkage = vertices(*size)
    assert len(linkage.loops) == (size[0] - 1) * (size[1] - 1)
    compare(linkage, linkage.flat, engine)
