"""The 8R element, made of ten isosceles triangles (thesis 5.1), and units I to III of four such elements (thesis 5.2).

The slit runs from V1 at the origin to V2 at (d, 0), d the equal side. Going round V1 from the slit, the sectors are
gamma, gamma, alpha, alpha, alpha, alpha: P3, the two triangles of the parallelogram P4, P5, P6, P7. The other
half is this one turned by pi about the slit's middle (P_i to P_{i+4}). Joint i lies between panels P_{i-1} and P_i, as
in Fig. 5.3; of the thesis's labels only these agree with (5.3), (5.7) and (5.25).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.basics.errors import PatternError
from hcsearch.library.assemblies.named_assembly import Assembly, Parameters
from hcsearch.library.assemblies.overlays import CreaseMatch, join_patterns
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
    angles = np.cumsum(sectors).tolist()
    ends = [(r * math.cos(angle), r * math.sin(angle)) for r, angle in zip(lengths, angles, strict=True)]

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


def joint_parts(pattern: Pattern) -> WholeNumbers | None:
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

    first : dihedral angle phi_1 (rad). Its sign is the sign of -cos(2 alpha) at every phi_1 between 0 and pi.
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


UNIT_I_JOINTS = ("b1=a7 b2=a8", "d7=a1 d8=a2", "c3=d5 c4=d6 c5=b3 c6=b4")
"""Joints that merge when elements B, D and C are added to A in turn (thesis 5.7)."""

UNIT_II_JOINTS = ("f6=a8 f7=a7 f8=a6", "h1=a1", "g5=f5 g4=h2 g3=h3 g2=h4")
"""Joints that merge when elements F, H and G are added to A in turn (thesis 5.25)."""

UNIT_III_JOINTS = ("d1=a7 d2=a8", "c5=d3 c6=d4", "b1=a1 b2=c4 b3=c3 b4=c2")
"""Joints that merge when D, C and B are added to A, in a unit not in the thesis (docs/explanation/unit_search.md)."""


def unit_i(parameters: Parameters) -> Pattern:
    """Return unit I (thesis Fig. 5.4). Loops are elements A, B, C, D, each from joint 1 to 8; B, D are turned over."""
    return assemble_unit(eight_r(parameters), UNIT_I_JOINTS)


def unit_ii(parameters: Parameters) -> Pattern:
    """Return unit II (thesis Fig. 5.6). Loops are the elements A, F, G, H, each from joint 1 to 8."""
    return assemble_unit(eight_r(parameters), UNIT_II_JOINTS)


def unit_iii(parameters: Parameters) -> Pattern:
    """Return unit III, half unit I and half unit II, a result of the unit search. Loops are elements A, B, C, D."""
    return assemble_unit(eight_r(parameters), UNIT_III_JOINTS)


def assemble_unit(element: Pattern, steps: Sequence[str]) -> Pattern:
    """Add copies of an element to a first one, `a`, so that given joints coincide.

    steps : for each further copy the joints that merge, as in `b1=a7 b2=a8`: its own joint first. Loops of the result
        are the copies' loops in the order of their letters.
    """
    pattern, names = element, "a"
    for step in steps:
        letter = step[0]
        pattern = join_patterns(pattern, element, read_crease_matches(pattern, names, element, letter, step))
        names += letter
    loops = tuple(pattern.loops[names.index(letter)] for letter in sorted(names))
    return replace(pattern, loops=loops)


def read_crease_matches(fixed: Pattern, names: str, moving: Pattern, letters: str, step: str) -> list[CreaseMatch]:
    """Parse pairs of creases that coincide, such as `b1=a7 b2=a8`: joints of the moving, then of the fixed pattern.

    names, letters : one letter for each loop of the fixed and of the moving pattern.
    """
    pairs = []
    for equation in step.split():
        own_joint, _, fixed_joint = equation.partition("=")
        try:
            pairs.append((_crease(fixed, names, fixed_joint), _crease(moving, letters, own_joint)))
        except (ValueError, IndexError):
            raise PatternError(
                f"{equation!r} names no joints: write one of {letters}, a number, = and one of {names}, a number"
            ) from None
    return pairs


def _crease(pattern: Pattern, names: str, joint: str) -> tuple[int, int]:
    loop = pattern.loops[names.index(joint[0])]
    return loop[range(1, len(loop) + 1).index(int(joint[1:]))]


UNIT_II_SINGULAR_VALUES = (
    *(91.6169, 73.9355, 73.3750, 52.2536, 38.9967, 34.6444, 32.5559, 29.3057, 23.5099, 22.4854),
    *(14.7911, 11.0325, 2.19116, 1.74072, 1.60164, 1.52818, 1.34030, 1.22320, 1.17221, 0.27834),
)
"""Nonzero singular values of unit II's Jacobian in the folded state, lengths in mm (thesis A16)."""


def _unit(
    name: str,
    source: str,
    build: Callable[[Parameters], Pattern],
    published: Mapping[str, object],
    published_at_defaults: Mapping[str, object],
) -> Assembly:
    """Return the entry of a unit of four 8R elements, which have 32 joints when separate."""
    return assembly_of_elements(
        name,
        f"Unit {name.removeprefix('unit-').upper()}, four 8R elements",
        source,
        build,
        separate_hinge_count=32,
        published=published,
        published_at_defaults=published_at_defaults,
    )


_BOTH = {"panels": 21, "hinges": 24, "merged_joints": 8, "dof": 1, "deployment_ratio": "7:1", "void_volume_mm3": 0.0}
"""Published facts common to units I and II."""


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
    _unit(
        "unit-i",
        "section 5.2.1, Fig. 5.4",
        unit_i,
        {**_BOTH, "panels_by_facets": {"1": 14, "2": 7}, "kutzbach": 0},
        {},
    ),
    _unit(
        "unit-ii",
        "section 5.2.3, Fig. 5.6; appendix",
        unit_ii,
        {**_BOTH, "rank_between": 23, "nullity_folded": 4, "nullity_flat": 4},
        {"singular_values": UNIT_II_SINGULAR_VALUES},
    ),
    _unit("unit-iii", "not in the thesis: found by the search for units", unit_iii, {}, {}),
)
