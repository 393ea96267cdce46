"""Units I and II: four 8R elements laid together so that given joints merge (thesis 5.2.1, 5.2.3)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from hcsearch.assemblies.assembly import Assembly, Parameters, Reals
from hcsearch.assemblies.eight_r import eight_r, hindrance, skew_symmetric
from hcsearch.assemblies.joining import Match, join
from hcsearch.errors import PatternError
from hcsearch.pattern import Pattern

UNIT_I = ("b1=a7 b2=a8", "d7=a1 d8=a2", "c3=d5 c4=d6 c5=b3 c6=b4")
"""Joints that merge where elements B, D and C come to A, one after another (thesis 5.7)."""

UNIT_II = ("f6=a8 f7=a7 f8=a6", "h1=a1", "g5=f5 g4=h2 g3=h3 g2=h4")
"""Joints that merge where elements F, H and G come to A (thesis 5.25)."""

UNIT_III = ("d1=a7 d2=a8", "c5=d3 c6=d4", "b1=a1 b2=c4 b3=c3 b4=c2")
"""Joints that merge where elements D, C and B come to A in a unit that is not in the thesis (docs/unit_search.md)."""


def unit_i(parameters: Parameters) -> Pattern:
    """Unit I (thesis Fig. 5.4). Loops are the elements A, B, C, D, each from joint 1 to 8; B and D lie turned over."""
    return assemble(eight_r(parameters), UNIT_I)


def unit_ii(parameters: Parameters) -> Pattern:
    """Unit II (thesis Fig. 5.6). Loops are the elements A, F, G, H, each from joint 1 to 8."""
    return assemble(eight_r(parameters), UNIT_II)


def unit_iii(parameters: Parameters) -> Pattern:
    """Unit III, half unit I and half unit II, found by the search for units. Loops are the elements A, B, C, D."""
    return assemble(eight_r(parameters), UNIT_III)


def assemble(element: Pattern, steps: Sequence[str]) -> Pattern:
    """Lay copies of an element onto a first one, `a`, so that joints coincide.

    steps : for each further copy the joints that merge, as in `b1=a7 b2=a8`: its own joint first. Loops of the
        outcome are the copies' loops in the order of their letters.
    """
    pattern, names = element, "a"
    for step in steps:
        letter = step[0]
        pattern = join(pattern, element, matches(pattern, names, element, letter, step))
        names += letter
    loops = tuple(pattern.loops[names.index(letter)] for letter in sorted(names))
    return replace(pattern, loops=loops)


def matches(still: Pattern, names: str, moving: Pattern, letters: str, step: str) -> list[Match]:
    """Creases to coincide, read from a text such as `b1=a7 b2=a8`: joints of the moving pattern, then of the still one.

    names, letters : one letter for each loop of the still and of the moving pattern.
    """
    found = []
    for equation in step.split():
        of, _, on = equation.partition("=")
        try:
            found.append((_crease(still, names, on), _crease(moving, letters, of)))
        except (ValueError, IndexError):
            raise PatternError(
                f"{equation!r} names no joints: write one of {letters}, a number, = and one of {names}, a number"
            ) from None
    return found


def _crease(pattern: Pattern, names: str, joint: str) -> tuple[int, int]:
    loop = pattern.loops[names.index(joint[0])]
    return loop[range(1, len(loop) + 1).index(int(joint[1:]))]


def between_i(parameters: Parameters) -> Reals:
    """Fold angles of unit I half-way along its motion (5.24)."""
    return skew_symmetric(unit_i(parameters), parameters.alpha, math.pi / 2)


def between_ii(parameters: Parameters) -> Reals:
    """Fold angles of unit II half-way along its motion (5.24)."""
    return skew_symmetric(unit_ii(parameters), parameters.alpha, math.pi / 2)


A16 = (
    *(91.6169, 73.9355, 73.3750, 52.2536, 38.9967, 34.6444, 32.5559, 29.3057, 23.5099, 22.4854),
    *(14.7911, 11.0325, 2.19116, 1.74072, 1.60164, 1.52818, 1.34030, 1.22320, 1.17221, 0.27834),
)
"""Singular values of unit II's Jacobian in the folded state, lengths in mm, but for four zeros (thesis A16)."""


def between_iii(parameters: Parameters) -> Reals:
    """Fold angles of unit III half-way along its motion (5.24)."""
    return skew_symmetric(unit_iii(parameters), parameters.alpha, math.pi / 2)


ASSEMBLIES = (
    Assembly(
        name="unit-i",
        title="Unit I, four 8R elements",
        source="section 5.2.1, Fig. 5.4",
        uses=("alpha", "base", "thickness"),
        build=unit_i,
        between=between_i,
        hindrance=hindrance,
        elements=True,
        apart=32,
        published={
            "panels": 21,
            "panels_by_facets": {"1": 14, "2": 7},
            "hinges": 24,
            "merged_joints": 8,
            "kutzbach": 0,
            "dof": 1,
            "deployment_ratio": "7:1",
            "void_volume_mm3": 0.0,
        },
    ),
    Assembly(
        name="unit-ii",
        title="Unit II, four 8R elements",
        source="section 5.2.3, Fig. 5.6; appendix",
        uses=("alpha", "base", "thickness"),
        build=unit_ii,
        between=between_ii,
        hindrance=hindrance,
        elements=True,
        apart=32,
        published={
            "panels": 21,
            "hinges": 24,
            "merged_joints": 8,
            "dof": 1,
            "rank_between": 23,
            "nullity_folded": 4,
            "nullity_flat": 4,
            "deployment_ratio": "7:1",
            "void_volume_mm3": 0.0,
        },
        published_at_defaults={"singular_values": A16},
    ),
    Assembly(
        name="unit-iii",
        title="Unit III, four 8R elements",
        source="not in the thesis: found by the search for units",
        uses=("alpha", "base", "thickness"),
        build=unit_iii,
        between=between_iii,
        hindrance=hindrance,
        elements=True,
        apart=32,
    ),
)
