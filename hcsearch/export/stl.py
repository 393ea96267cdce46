"""Binary STL: triangles of all panels in one state, or of one panel, in millimetres."""

from __future__ import annotations

import struct
from collections.abc import Sequence

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.export.panel_solids import MILLIMETRES, placed, solid_of
from hcsearch.shape.linkage import Linkage

_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def stl_of(
    linkage: Linkage,
    angles: Reals,
    title: str = "",
    panels: Sequence[int] | None = None,
    *,
    scale: float = MILLIMETRES,
) -> bytes:
    """Panels (all unless given) at fold angles (n_hinges,), rad.

    scale : units to a metre. Numbers are of single precision, as STL has them.
    """
    poses = linkage.poses(angles)
    wanted = range(linkage.n_panels) if panels is None else panels
    solids = [solid_of(linkage.pattern, panel) for panel in wanted]
    corners = np.concatenate(
        [placed(poses[k], solid.vertices)[solid.triangles] for k, solid in zip(wanted, solids, strict=True)]
    )
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    records = np.zeros(len(corners), _RECORD)
    records["normal"] = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    records["corners"] = scale * corners
    # a head that begins with "solid" would be taken for the text format
    head = f"hcsearch {title}, {'mm' if scale == MILLIMETRES else 'm'}".encode("ascii", "replace")[:80].ljust(80)
    return head + struct.pack("<I", len(records)) + bytes(records.tobytes())
