"""What the tests of solid and simulator formats export: panels of one facet and of several, loops and a chain."""

from hcsearch.designs.folding import Folding
from hcsearch.scenes import SCENES, panel_of
from hcsearch.shape.labels import labels_of
from hcsearch.shape.mesh import facet_area
from hcsearch.subjects.replay_sources import replay_of_path
from tests.linkages import linkage_named

PARTS = (
    "rhombus:23121320:1",
    "kite:12020103:2",
    "right45:12121212:0",
    "right30:20201210:3",
    "obtuse:121212121212:0",
)
"""A design of each grid whose panels are parts of regular ones."""
NAMES = (
    "hex:0234550132:4",
    "square:01222300:1",
    "triangle:012343454545012121:2",
    "rectangle:012233300121:5",
    *PARTS,
    "thesis-4x4",
    "unit-ii",
    "module-iii",
)
"""A design of each grid, and assemblies."""


def case(name):
    """The linkage of a name, with the names of its panels and hinges."""
    linkage = linkage_named(name)
    return linkage, labels_of(linkage)


def merged():
    """A folding whose mirror pairs are one, an open chain."""
    folding = Folding.from_notation("square:012222230000:1")
    linkage = folding.linkage(panel_of(SCENES["default"], "square"), flat_pairs="merged")
    return linkage, labels_of(linkage)


def volumes(linkage):
    """Area times thickness of each panel, m^3."""
    pattern = linkage.pattern
    return [sum(facet_area(pattern.facets[k]) for k in facets) * pattern.thickness for facets in pattern.panels]


def replay(name, states):
    """A motion through some states, whether its loops are closed or not."""
    linkage, _ = case(name)
    return replay_of_path(linkage, states, name, margin=None)
