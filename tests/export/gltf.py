"""A reader of binary glTF in plain NumPy, to judge the writer by: where nodes are at a time of the animation."""

import json
import struct

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}
KINDS = {5126: "<f4", 5125: "<u4"}


class Scene:
    def __init__(self, content):
        magic, version, length = struct.unpack_from("<4sII", content)
        assert (magic, version, length) == (b"glTF", 2, len(content))
        size, kind = struct.unpack_from("<I4s", content, 12)
        assert kind == b"JSON"
        self.document = json.loads(content[20 : 20 + size])
        rest = content[20 + size :]
        size, kind = struct.unpack_from("<I4s", rest)
        assert kind == b"BIN\0"
        self.binary = rest[8 : 8 + size]
        self.nodes = self.document["nodes"]
        self.tracks = {}
        for animation in self.document.get("animations", ()):
            for channel in animation["channels"]:
                sampler = animation["samplers"][channel["sampler"]]
                assert sampler["interpolation"] == "LINEAR"
                assert channel["target"]["path"] == "rotation"
                self.tracks[channel["target"]["node"]] = (
                    self.table(sampler["input"])[:, 0],
                    self.table(sampler["output"]),
                )

    def table(self, number):
        accessor = self.document["accessors"][number]
        view = self.document["bufferViews"][accessor["bufferView"]]
        values = np.frombuffer(
            self.binary,
            KINDS[accessor["componentType"]],
            offset=view["byteOffset"],
            count=accessor["count"] * WIDTHS[accessor["type"]],
        )
        return values.reshape(accessor["count"], -1).astype(float)

    @property
    def times(self):
        return next(iter(self.tracks.values()))[0]

    def vertices(self, time, below=0):
        """Name of each mesh's node, to its vertices at a time, as seen from the node `below` the scene."""
        places = {}

        def walk(number, pose):
            node = self.nodes[number]
            if number != below:
                own = np.eye(4)
                own[:3, :3] = self._turn(number, time)
                own[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
                pose = pose @ own
            if "mesh" in node:
                parts = [
                    self.table(p["attributes"]["POSITION"]) for p in self.document["meshes"][node["mesh"]]["primitives"]
                ]
                places[node["name"]] = np.concatenate(parts) @ pose[:3, :3].T + pose[:3, 3]
            for child in node.get("children", ()):
                walk(child, pose)

        walk(below, np.eye(4))
        return places

    def _turn(self, number, time):
        if number not in self.tracks:
            return Rotation.from_quat(self.nodes[number].get("rotation", (0.0, 0.0, 0.0, 1.0))).as_matrix()
        times, turns = self.tracks[number]
        return Slerp(times, Rotation.from_quat(turns))(time).as_matrix()
