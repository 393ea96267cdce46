"""Tessellations of units I and II that share panels (thesis 5.4), and the search for all placements of two patterns.

The thesis draws its tessellations and states areas, footprints and numbers of merged joints; the placements here are
results of the search that agree with these numbers (docs/explanation/assemblies.md). They are stored as joints that
merge, so they hold for every base angle, while the thesis has equilateral triangles.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from hcsearch.basics.errors import PatternError
from hcsearch.library.assemblies.eight_r import (
    assembly_of_elements,
    joint_parts,
    read_crease_matches,
    skew_symmetric_angles,
    unit_i,
    unit_ii,
)
from hcsearch.library.assemblies.named_assembly import Assembly, Parameters
from hcsearch.library.assemblies.overlays import CreaseMatch, join_patterns, neighbouring_facets
from hcsearch.library.assemblies.packages import Package, folded_package
from hcsearch.shape.isometries import Isometry
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import Pattern

_UNITS: dict[str, tuple[Callable[[Parameters], Pattern], str]] = {"I": (unit_i, "abcd"), "II": (unit_ii, "afgh")}


@dataclass(frozen=True)
class TilingStep:
    """A unit added to the first one; joints : pairs that merge, its own joint first (`a1=c1`)."""

    kind: str
    joints: str
    inverted: bool = False


@dataclass(frozen=True)
class Laying:
    """A placement of a pattern on another one whose union folds and moves as the elements do.

    merged : the creases that coincide.
    union : the tessellation; its loops are the elements of both, each once.
    """

    placement: Isometry
    merged: tuple[CreaseMatch, ...]
    union: Pattern
    package: Package

    @property
    def areas(self) -> Mapping[int, int]:
        """Number of panels by their number of triangles."""
        sizes = [len(panel) for panel in self.union.panels]
        return {size: sizes.count(size) for size in sorted(set(sizes))}


def tessellate(parameters: Parameters, first: str, *steps: TilingStep) -> Pattern:
    """Add units to a first one; loops are the elements, each once, the first unit's first."""
    build, names = _UNITS[first]
    pattern = build(parameters)
    for step in steps:
        build, letters = _UNITS[step.kind]
        moving = build(parameters).inverted() if step.inverted else build(parameters)
        merging = [read_crease_matches(pattern, names, moving, letters, text) for text in step.joints.split()]
        pattern = _once(join_patterns(pattern, moving, [*chain.from_iterable(merging)]))
    return pattern


def possible_layings(fixed: Pattern, moving: Pattern, alpha: float) -> Iterator[Laying]:
    """Yield all placements of a pattern of 8R elements on another one that merge hinges and remain mobile.

    Unions are excluded where panels or creases contradict each other, elements cannot move alike along (5.24), or
    panels overlap in the folded state.
    """
    for placement, merged, joined in neighbouring_facets(fixed, moving):
        union = _once(joined)
        if joint_parts(union) is None:
            continue
        residual, _ = Linkage(union).closure(skew_symmetric_angles(union, alpha, math.pi / 3))
        if np.abs(residual).max() > 1e-9:
            continue
        try:
            folded = folded_package(union)
        except PatternError:
            continue
        if folded.overlap_volume == 0.0:
            yield Laying(placement, tuple(merged), union, folded)


def _once(pattern: Pattern) -> Pattern:
    """Remove duplicate loops, which may begin at different joints where whole elements merge."""
    loops = {frozenset(loop): loop for loop in reversed(pattern.loops)}
    return replace(pattern, loops=tuple(loop for loop in pattern.loops if loops[frozenset(loop)] is loop))


def _assembly(
    name: str,
    figure: str,
    title: str,
    first: str,
    steps: tuple[TilingStep, ...],
    published: Mapping[str, object],
    *notes: str,
) -> Assembly:
    """Return an entry of the table of tessellations."""

    def build(parameters: Parameters) -> Pattern:
        return tessellate(parameters, first, *steps)

    return assembly_of_elements(
        name,
        title,
        f"section 5.4, Fig. {figure}",
        build,
        separate_hinge_count=24 * (1 + len(steps)),
        published={"dof": 1, **published},
        defaults=Parameters(alpha=math.pi / 3),
        notes=("every base angle will do; the thesis has equilateral triangles", *notes),
    )


ASSEMBLIES = (
    _assembly(
        "fig-5.10a",
        "5.10(a)",
        "Two units I, four joints merged",
        "I",
        (TilingStep("I", "a3=b5 a4=b6 d1=c7 d2=c8"),),
        {"merged_joints": 4},
        "a choice: fig-5.10a-other fits the thesis's words as well",
    ),
    _assembly(
        "fig-5.10a-other",
        "5.10(a)",
        "Two units I, four joints merged, the other way",
        "I",
        (TilingStep("I", "a5=d3 a6=d4 b7=c1 b8=c2"),),
        {"merged_joints": 4},
        "a choice: fig-5.10a fits the thesis's words as well",
    ),
    _assembly(
        "fig-5.10b",
        "5.10(b)",
        "Two units I, eight joints merged",
        "I",
        (TilingStep("I", "a1=c1 a2=c2 a3=c3 a4=c4 a5=b3 a6=b4 a7=c7 a8=c8"),),
        {"merged_joints": 8, "panels_by_facets": {"1": 24, "2": 10}, "deployment_ratio": "11:1"},
        "the only way of this area",
    ),
    _assembly(
        "fig-5.11a",
        "5.11(a)",
        "Two units II, three joints merged",
        "II",
        (TilingStep("II", "a4=g6 a3=g7 a2=g8", inverted=True),),
        {"merged_joints": 3},
        "a choice: fig-5.11a-other fits the thesis's words as well; this one folds smaller",
    ),
    _assembly(
        "fig-5.11a-other",
        "5.11(a)",
        "Two units II, three joints merged, the other way",
        "II",
        (TilingStep("II", "f4=h6 f3=h7 f2=h8", inverted=True),),
        {"merged_joints": 3},
        "a choice: fig-5.11a fits the thesis's words as well",
    ),
    _assembly(
        "fig-5.11b",
        "5.11(b)",
        "Two units II, fifteen joints merged",
        "II",
        (TilingStep("II", "a1=f5 a2=a8 a3=a7 a4=a6 a5=f1 a6=f2 a7=f3 a8=f4", inverted=True),),
        {"merged_joints": 14, "panels_by_facets": {"1": 18, "2": 10}, "deployment_ratio": "38:5"},
        "the only way of this area and footprint merges 15 joints; none merges 14",
    ),
    _assembly(
        "fig-5.12",
        "5.12(a)",
        "A unit II between two units I",
        "II",
        (
            TilingStep("I", "a7=f1 a8=f2 b3=f3 b4=f4 b5=f5 b6=a8 b7=a7 b8=a6"),
            TilingStep("I", "a1=h7 a2=h8 c3=h5 c4=h6 d1=a1 d2=g4 d3=g3 d4=g2"),
        ),
        {},
        "a choice: each unit I merges eight joints, the most that fold; the thesis gives no numbers",
    ),
)
