"""Linkages that tests name, and congruence of patterns in its plain form."""

import math

import numpy as np

from hcsearch.basics.errors import PatternError
from hcsearch.designs.folding import Folding
from hcsearch.library.assemblies import ASSEMBLIES
from hcsearch.library.assemblies.overlays import placements
from hcsearch.motion.collision.distances import first_cut
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.mesh import SAME_POINT_SHARE
from hcsearch.shape.pattern import Pattern, overlay


def linkage_named(name: str) -> Linkage:
    """An assembly with its own sizes, or a folding as DESIGN:CREASE."""
    if name in ASSEMBLIES:
        return Linkage(ASSEMBLIES[name].build(ASSEMBLIES[name].defaults))
    return Folding.from_notation(name).linkage()


def congruent(one: Pattern, two: Pattern) -> bool:
    """Whether an isometry takes one pattern to another, with all creases; the sheet may be turned over.

    Patterns that mirror each other are congruent when `two.inverted()` is. `unit_search.rings.congruence_key` does not
    distinguish these, and is what the program compares patterns by.
    """
    sizes = (len(one.facets), len(one.creases)), (len(two.facets), len(two.creases))
    if sizes[0] != sizes[1]:
        return False
    of = next(iter(two.creases))
    tolerance = SAME_POINT_SHARE * one.size
    corners = np.array(one.vertices)
    for on in one.creases:
        if abs(math.dist(*one.segment(on)) - math.dist(*two.segment(of))) > tolerance:
            continue
        for placement in placements(one, two, [(on, of)]):
            images = np.array([placement.image(point) for point in two.vertices])
            if np.linalg.norm(corners[:, None] - images, axis=2).min(axis=0).max() > tolerance:
                continue
            try:
                union = overlay([one, two.placed(placement)])
            except PatternError:
                continue
            if (len(union.facets), len(union.creases)) == sizes[0]:
                return True
    return False


def penetration(linkage, angles):
    """The greatest depth of penetration of panels at one state, in metres; 0 where they only touch."""
    cut = first_cut(linkage, np.asarray(angles, float)[None], 0.0)
    return 0.0 if cut is None else cut.depth
