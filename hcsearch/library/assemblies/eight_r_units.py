"""Units I, II and III: four 8R elements joined so that given joints merge (thesis 5.2.1, 5.2.3)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from hcsearch.basics.errors import PatternError
from hcsearch.library.assemblies.eight_r import assembly_of_elements, eight_r
from hcsearch.library.assemblies.named_assembly import Assembly, Parameters
from hcsearch.library.assemblies.overlays import CreaseMatch, join_patterns
from hcsearch.shape.pattern import Pattern

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


def _assembly(
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


_BOTH = {
    "panels": 21,
    "hinges": 24,
    "merged_joints": 8,
    "dof": 1,
    "deployment_ratio": "7:1",
    "void_volume_mm3": 0.0,
}
"""Published facts common to units I and II."""

ASSEMBLIES = (
    _assembly(
        "unit-i",
        "section 5.2.1, Fig. 5.4",
        unit_i,
        {**_BOTH, "panels_by_facets": {"1": 14, "2": 7}, "kutzbach": 0},
        {},
    ),
    _assembly(
        "unit-ii",
        "section 5.2.3, Fig. 5.6; appendix",
        unit_ii,
        {**_BOTH, "rank_between": 23, "nullity_folded": 4, "nullity_flat": 4},
        {"singular_values": UNIT_II_SINGULAR_VALUES},
    ),
    _assembly("unit-iii", "not in the thesis: found by the search for units", unit_iii, {}, {}),
)
