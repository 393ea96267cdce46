"""Certificates as plain data: what is claimed of an array, and what a checker needs to prove it anew."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from hcsearch.basics.errors import HcsearchError
from hcsearch.motion.certificates.path_checker import Array
from hcsearch.motion.certificates.refining import stretch_data
from hcsearch.motion.collision.plates import plates_of
from hcsearch.motion.locks.boxes import MAX_BOX_ANGLE
from hcsearch.motion.locks.enclosures import Enclosure
from hcsearch.motion.locks.lattice import lattice_frame_of
from hcsearch.motion.planning.stretches import Tube
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import Pattern

CERTIFICATE_FORMAT, CERTIFICATE_VERSION = "hcsearch certificate", 1


def array_data(linkage: Linkage) -> dict[str, Any]:
    """The panels and hinges of a linkage in whole coordinates of its lattice (`lattice.Frame`)."""
    frame, pattern = lattice_frame_of(linkage), linkage.pattern
    facets = [] if frame is None else [frame.points(np.array(facet)) for facet in pattern.facets]
    lattice = [facet.tolist() for facet in facets if facet is not None]
    if frame is None or len(lattice) < len(facets):
        raise HcsearchError("certificates are written for arrays on a tiling: this one is on none")
    return {
        "unit": str(Fraction(frame.unit).limit_denominator(10**15)),
        "root": frame.q,
        "thickness": frame.steps[2],
        "facets": lattice,
        "panels": [list(panel) for panel in pattern.panels],
        "hinges": [
            {
                "facets": _facets(pattern, number),
                "face": hinge.face,
                "closes": bool(hinge.closes),
            }
            for number, hinge in enumerate(pattern.hinges)
        ],
    }


def _facets(pattern: Pattern, hinge: int) -> list[int]:
    """Two facets that share an edge along a hinge, that of its first panel first."""
    one, two = next(pair for pair, crease in pattern.creases.items() if crease.face and pattern.hinge_of(pair) == hinge)
    return [one, two] if pattern.panel_of[one] == pattern.hinges[hinge].first else [two, one]


def lock_claim(linkage: Linkage, enclosure: Enclosure) -> dict[str, Any]:
    """The claim that no motion leaves the boxes of a lock, or, with panels, none without a collision."""
    cuts = [[0.0, MAX_BOX_ANGLE] for _ in range(linkage.n_hinges)]
    lows = np.zeros((len(enclosure.lows), linkage.n_hinges), int)
    highs = np.ones_like(lows)
    for own, hinge in enumerate(linkage.looped.tolist()):
        low, high = enclosure.lows[:, own], enclosure.highs[:, own]
        values = np.unique(np.concatenate([[0.0, MAX_BOX_ANGLE], low, high]))
        cuts[hinge] = values.tolist()
        lows[:, hinge], highs[:, hinge] = np.searchsorted(values, low), np.searchsorted(values, high)
    boxes = {"cuts": cuts, "lows": lows.tolist(), "highs": highs.tolist()}
    claim = {"array": array_data(linkage), "end": enclosure.end, "tried": enclosure.boxes, **boxes}
    if enclosure.margin is None:
        return {"kind": "lock", **claim}
    pairs = plates_of(linkage, enclosure.margin).pairs.tolist()
    return {"kind": "collision", **claim, "margin": repr(enclosure.margin), "pairs_of_facets": pairs}


def path_claim(linkage: Linkage, tubes: Sequence[Tube], margin: float) -> dict[str, Any]:
    """The claim that a path leads from packed to flat with a margin (m), and its stretches.

    `path_checker.NotProvedError` where the checker does not prove a stretch.
    """
    data = array_data(linkage)
    array = Array(data)
    share, closed = float(Fraction(margin) / array.unit / Fraction(array.size)), array.packed
    stretches = []
    for tube in tubes:
        stretch, closed = stretch_data(array, tube, closed, share)
        stretches.append(stretch)
    return {"kind": "path", "array": data, "margin": repr(float(margin)), "stretches": stretches}


def certificate(claims: Sequence[dict[str, Any]], of: str, panel_mm: str) -> dict[str, Any]:
    """A certificate of a folding, with its checksum."""
    data: dict[str, Any] = {
        "format": CERTIFICATE_FORMAT,
        "version": CERTIFICATE_VERSION,
        "of": of,
        "panel_mm": panel_mm,
        "claims": list(claims),
    }
    return {**data, "sha256": checksum(data)}


def checksum(data: dict[str, Any]) -> str:
    """SHA-256 of the data as JSON without spaces, keys in order."""
    return hashlib.sha256(json.dumps(data, sort_keys=True, separators=(",", ":")).encode()).hexdigest()
