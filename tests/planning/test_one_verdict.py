"""One verdict a folding: however its circuit is written, and whatever the size of its panels."""

import pytest

from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import foldings
from hcsearch.designs.grid import GRIDS
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.designs.twisting import twist
from hcsearch.motion.planning.motion_search import plan_motion
from tests.strategies import words, writings

LISTS = [("hex", 10), ("square", 8), ("square", 10), ("square", 12), ("rectangle", 8), ("rectangle", 10)]
LISTS += [("triangle", 14), ("triangle", 18), ("hex", 8)]
SCALED = (
    "hex:0234550132:4",
    "square:012233230011:4",
    "square:01222300:0",
    "rectangle:0122333011:1",
    "hex:0234435011:3",
)
SCALED += ("square:0112223300:4", "triangle:012343454505012321:3")


@pytest.mark.parametrize(("grid", "n"), LISTS)
def test_every_writing_of_a_folding_is_searched_in_one_position(grid, n):
    """A search begins with `likeness`, and is the same from there on: so verdicts are equal."""
    size, count = default_panel(grid), 0
    for word in words(grid, n):
        circuit = Circuit(GRIDS[grid], word)
        known = searched(circuit, size)
        assert all(folding.likeness(size) is None for folding in known)
        for writing in writings(circuit):
            assert searched(writing, size) == known
            count += len(known)
    assert count


def searched(circuit, size):
    """The foldings that are searched in place of the untwisted ones of a circuit."""
    own = [folding for folding in foldings(circuit) if not twist(folding)]
    likes = [(folding.likeness(size), folding) for folding in own]
    return sorted((folding if like is None else like.folding for like, folding in likes), key=lambda own: own.crease)


@pytest.mark.parametrize("name", SCALED)
def test_verdicts_do_not_hang_on_the_size_of_panels(name):
    grid = name.split(":")[0]
    folding = next(one for one in foldings(Circuit.from_notation(name.rpartition(":")[0])) if one.notation == name)
    panel = default_panel(grid)
    known = plan_motion(folding, panel, ("rigid", "hinged"), budget=1)
    for scale in (1e-3, 7.0):
        size = tuple(scale * length for length in panel)
        found = plan_motion(folding, size, ("rigid", "hinged"), budget=1)
        assert found.way == known.way
        assert (found.margin is None) == (known.margin is None)
        if known.margin is not None:
            assert found.margin == pytest.approx(scale * known.margin, rel=1e-9)
