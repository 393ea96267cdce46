"""Replays that tests of the player share, and a plain twin of how its script places panels."""

import base64
import struct
from functools import cache

import numpy as np
from hypothesis import strategies as st

from hcsearch.basics.vocabulary import WAYS
from hcsearch.designs.folding import Folding, foldings
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.shape.labels import labels_of
from hcsearch.shape.linkage import Linkage
from hcsearch.subjects.replay import Replay
from hcsearch.subjects.replay_sources import replay_of_path
from hcsearch.subjects.resolve import resolve
from tests.planned import planned
from tests.strategies import circuits


@cache
def replay_of(name: str) -> Replay:
    """The deployment of an assembly, or the planned path of a sample of `tests.planned`."""
    if ":" in name:
        path = planned(name)
        return replay_of_path(path.linkage, path.states, name, margin=1e-5)
    return resolve(name, "none.sqlite").replay("springs")[0]


@st.composite
def random_replays(draw) -> tuple[Folding, Replay]:
    """A folding with its flat pairs joined in some way, at random fold angles; closed or not is all one here."""
    circuit = draw(circuits(even=True).filter(lambda one: bool(foldings(one))))
    folding = draw(st.sampled_from(foldings(circuit)))
    linkage = draw(st.sampled_from(linkages_of(folding)))
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    k = draw(st.integers(2, 6))
    return folding, Replay(
        linkage=linkage,
        labels=labels_of(linkage),
        axis=draw(st.sampled_from(["time", "path"])),
        at=np.cumsum(random.uniform(1e-6, 1.0, k)),
        angles=random.uniform(-1.0, 1.0, (k, linkage.n_hinges)) * draw(st.sampled_from([0.1, np.pi, 6.0])),
        certified=((0.1, 0.2),),
        collision=draw(st.sampled_from([None, (0.15, (0, 1))])),
        margin=1e-4,
        error=1e-3,
        title="a <title> & more",
        source="a test",
    )


def twin_poses(payload: dict, at: float) -> np.ndarray:
    """Poses of the panels in mm, (n_panels, 4, 4), from the plain data alone."""
    n, places = len(payload["hinges"]), payload["at"]
    data = base64.b64decode(payload["angles"])
    steps = struct.unpack(f"<{len(data) // 2}h", data)
    angles = [np.interp(at, places, [payload["scale"] * x for x in steps[h::n]]) for h in range(n)]
    poses = np.tile(np.eye(4), (len(payload["order"]), 1, 1))
    for panel in payload["order"]:
        parent, hinge = payload["parents"][panel], payload["via"][panel]
        if parent >= 0:
            turned = turn(payload, hinge, payload["signs"][panel] * angles[hinge])
            poses[panel] = poses[parent] @ turned
    return poses


def turn(payload: dict, hinge: int, angle: float) -> np.ndarray:
    """The rotation about a hinge line: Rodrigues' formula, line taken to the origin and back."""
    x, y, to_x, to_y, top, *_ = payload["hinges"][hinge]
    start = payload["unit"] * np.array([x, y, payload["thickness"] * top])
    axis = (-1.0 if top else 1.0) * np.array([to_x - x, to_y - y, 0.0])
    u, v, w = axis / np.linalg.norm(axis)
    cross = np.array([[0.0, -w, v], [w, 0.0, -u], [-v, u, 0.0]])
    pose = np.eye(4)
    pose[:3, :3] += np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
    pose[:3, 3] = start - pose[:3, :3] @ start
    return pose


def linkages_of(folding: Folding) -> list[Linkage]:
    """The folding with its flat pairs joined in every way."""
    panel = default_panel(folding.circuit.grid.name)
    return [folding.linkage(panel, flat_pairs=way) for way in WAYS if folding.can_join(way)]
