"""The circuit of ten isosceles triangles, and the 8R element derived from it (thesis 5.1).

The slit runs from V1 at the origin to V2 at (d, 0), d the equal side. Going round V1 from the slit, the sectors are
gamma, gamma, alpha, alpha, alpha, alpha: P3, the two triangles of the parallelogram P4, P5, P6, P7. The other
half is this one turned by pi about the slit's middle (P_i to P_{i+4}). Joint i lies between panels P_{i-1} and P_i, as
in Fig. 5.3; of the thesis's labels only these agree with (5.3), (5.7) and (5.25).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import PatternError
from hcsearch.library.assemblies.named_assembly import Assembly, Parameters
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.mesh import Facet, PlanePoint
from hcsearch.shape.pattern import RIGID_CREASE, Crease, FacetPair, PanelFace, Pattern

SLIT_FACETS = (2, 7)
"""Facets of P3 and P7, on both sides of the slit."""

_JOINTS: tuple[FacetPair, ...] = ((0, 9), (0, 1), (1, 2), (2, 3), (4, 5), (5, 6), (6, 7), (7, 8))
_FACES: tuple[PanelFace, ...] = ("top", "bottom", "top", "bottom", "bottom", "top", "bottom", "top")
# faces alternate along the ten triangles, flat creases of P4 and P8 included, so that a_45 = a_81 = 0
_FLAT: tuple[tuple[FacetPair, PanelFace], ...] = (((3, 4), "top"), ((8, 9), "bottom"))


def ten_triangles(parameters: Parameters) -> Pattern:
    """Return the circuit of ten triangles with a hinge at every crease of the circuit (thesis Fig. 5.1a).

    Facets are in the order of the circuit: P1, P2, P3, the two of P4, P5, P6, P7, the two of P8.
    """
    joints = [(pair, Crease(face)) for pair, face in zip(_JOINTS, _FACES, strict=True)]
    flat = [(pair, Crease(face, closes=False)) for pair, face in _FLAT]
    ring = [*(pair for pair, _ in joints[1:4]), (3, 4), *_JOINTS[4:], (8, 9), (0, 9)]
    return Pattern.from_polygons(_triangles(parameters), dict(joints + flat), parameters.thickness, (tuple(ring),))


def eight_r(parameters: Parameters) -> Pattern:
    """Return the 8R element, with rigid creases in both outer layers (thesis Fig. 5.1b); its loop is joints 1 to 8."""
    creases = {pair: Crease(face) for pair, face in zip(_JOINTS, _FACES, strict=True)}
    creases |= {pair: RIGID_CREASE for pair, _ in _FLAT}
    return Pattern.from_polygons(_triangles(parameters), creases, parameters.thickness, (_JOINTS,))


def _triangles(parameters: Parameters) -> tuple[Facet, ...]:
    """Return the corners of the ten triangles, in metres."""
    alpha, base = parameters.alpha, parameters.base
    side, gamma = equal_side(alpha, base), math.pi - 2 * alpha
    lengths = (side, side, side, base, side, base)
    sectors = (0.0, gamma, gamma, alpha, alpha, alpha)
    ends = [
        (length * math.cos(angle), length * math.sin(angle))
        for length, angle in zip(lengths, np.cumsum(sectors).tolist(), strict=True)
    ]

    def turned(point: PlanePoint) -> PlanePoint:
        return (side - point[0], -point[1])

    half: list[Facet] = [((0.0, 0.0), a, b) for a, b in pairwise(ends)]
    other: list[Facet] = [(turned(a), turned(b), turned(c)) for a, b, c in half]
    return (other[3], other[4], *half, *other[:3])


def equal_side(alpha: float, base: float) -> float:
    """Return the length d of the equal sides of an isosceles triangle with base angle alpha (rad)."""
    return base / (2 * math.cos(alpha))


def second_angle(alpha: float, first: float) -> float:
    """Return the dihedral angle phi_2 for phi_1 on the skew-symmetric path, cos(alpha) tan(phi_2/2) = tan(phi_1/2).

    Thesis (5.24); rad, exact at both ends 0 and pi.
    """
    return 2 * math.atan2(math.sin(first / 2), math.cos(alpha) * math.cos(first / 2))


def skew_symmetric_angles(pattern: Pattern, alpha: float, first: float) -> Reals:
    """Return fold angles (n_hinges,) on the skew-symmetric path (5.24) of a pattern whose loops are 8R elements.

    first : dihedral angle phi_1 (rad) of joints 1, 3, 5, 7 in every element; 0 folded, pi flat.
    """
    parts = joint_parts(pattern)
    if parts is None:
        raise PatternError("the elements of this pattern cannot fold alike: a hinge is a base in one, a leg in another")
    angles = np.array([first, second_angle(alpha, first)])
    fold: Reals = math.pi - angles[parts]
    return fold


def joint_parts(pattern: Pattern) -> NDArray[np.int64] | None:
    """Return for each hinge 0 if it is an odd joint (1, 3, 5, 7) of its elements, 1 if even; None if they disagree."""
    parts = np.full(len(pattern.hinges), -1)
    for loop in pattern.loops:
        for k, pair in enumerate(loop):
            hinge = pattern.hinge_of(pair)
            if parts[hinge] == 1 - k % 2:
                return None
            parts[hinge] = k % 2
    return parts if parts.min() >= 0 else None


def slit_distance(alpha: float, thickness: float, first: float) -> float:
    """Return the slit distance p on the skew-symmetric path (thesis 5.27), m: negative where P3 and P7 interfere.

    first : dihedral angle phi_1 (rad). The sign is that of -cos(2 alpha) at every phi_1 between 0 and pi.
    """
    c, s = math.cos(alpha), math.sin(alpha)
    numerator = 4 * math.cos(first / 2) * math.sin(first / 2) * c * (2 * c * c - 1)
    return thickness * numerator / (s * s + math.cos(first) * s * s - 2)


def measured_slit(element: Pattern, angles: Reals) -> float:
    """Measure the distance of the side walls of P3 and P7 at the slit from the panels' poses, in metres.

    It is measured along the outward normal of P3's wall, so it is negative where the panels interfere (thesis 5.3.1).
    """
    third, seventh = (solid for k, solid in enumerate(Linkage(element).solids(angles)) if k in SLIT_FACETS)
    along, up = third[0, 1] - third[0, 0], third[1, 0] - third[0, 0]
    outward = np.cross(along, up)  # P3 lies on the left of its edge from V1 to V2
    # P7's wall runs back from V2 to V1, the first two corners of its facet
    return float((seventh[0, 0] - third[0, 1]) @ outward / np.linalg.norm(outward))


def assembly_hindrance(parameters: Parameters) -> str | None:
    """Return why panels of 8R elements cannot move without interference, or None (thesis 5.3.1)."""
    if parameters.alpha >= math.pi / 4 - 1e-12:
        return None
    return (
        f"panels P3 and P7 of each element cut through each other at a base angle of "
        f"{math.degrees(parameters.alpha):g} degrees: give one from 45 up"
    )


def half_way_angles(build: Callable[[Parameters], Pattern]) -> Callable[[Parameters], Reals]:
    """Return a function of parameters that gives the fold angles half-way along the skew-symmetric path (5.24)."""
    return lambda parameters: skew_symmetric_angles(build(parameters), parameters.alpha, math.pi / 2)


_USES = ("alpha", "base", "thickness")


def assembly_of_elements(
    name: str, title: str, source: str, build: Callable[[Parameters], Pattern], **facts: Any
) -> Assembly:
    """Return an assembly of 8R elements with its half-way state and hindrance; facts : other fields of `Assembly`."""
    between = half_way_angles(build)
    return Assembly(name, title, source, _USES, build, between, assembly_hindrance, has_element_loops=True, **facts)


ASSEMBLIES = (
    Assembly(
        "ten-triangles",
        "Circuit of ten isosceles triangles",
        "section 5.1.1, Fig. 5.1(a)",
        _USES,
        ten_triangles,
        hindrance=assembly_hindrance,
        published={"panels": 10, "hinges": 10, "kutzbach": 4},
    ),
    assembly_of_elements(
        "element-8r",
        "8R element",
        "section 5.1, Figs. 5.1(b) to 5.3",
        eight_r,
        published={"panels": 8, "hinges": 8, "kutzbach": 2, "dof": 2},
    ),
)
