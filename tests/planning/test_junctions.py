"""Junctions: all flat-folded closed states, against a list of all of them that is tried one by one."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, foldings
from hcsearch.designs.grid import GRIDS
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.kernels.planning.space import new_state_stack, pick_state, place_state
from hcsearch.motion.locks.lattice import whole_end
from hcsearch.motion.planning import simple_moves
from hcsearch.motion.planning.problems import space_of
from hcsearch.motion.planning.simple_moves import clear_junctions, junctions_of
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import Crease, Pattern
from tests.linkages import linkage_named
from tests.planned import joined, open_by
from tests.strategies import words

WAYS = ("rigid", "hinged", "merged")
LISTS = [("hex", 8), ("hex", 10), ("square", 8), ("square", 10), ("rectangle", 8), ("rectangle", 10)]


@st.composite
def linkages(draw):
    """A folding of a small list as a linkage, twisted or not."""
    grid, n = draw(st.sampled_from(LISTS))
    listed = [folding for word in words(grid, n) for folding in foldings(Circuit(GRIDS[grid], word))]
    folding, way = draw(st.sampled_from(listed)), draw(st.sampled_from(WAYS))
    return folding.linkage(default_panel(grid), flat_pairs=way if folding.can_join(way) else "hinged")


def all_stops(linkage):
    """All states with every hinge at a stop."""
    return np.array(list(itertools.product((0.0, math.pi), repeat=linkage.n_hinges)))


def closed_to_rounding(linkage):
    """Those that are closed, by products of matrices."""
    states = all_stops(linkage)
    return states[open_by(linkage, states) < 1e-9].tolist()


@settings(max_examples=25)
@given(linkages())
def test_junctions_are_all_flat_folded_states_that_are_closed_in_whole_numbers(linkage):
    found = junctions_of(linkage)
    assert found.complete
    assert found.states.tolist() == [
        state.tolist() for state in all_stops(linkage) if whole_end(linkage, state) is not None
    ]
    own = {tuple(state) for state in found.states.tolist()}
    assert {tuple(linkage.folded.tolist()), tuple(linkage.flat.tolist())} <= own


def test_junctions_off_the_tilings_are_closed_to_rounding():
    folding = Folding.from_notation("hex:0234550132:4")
    length = 0.05 / 3
    linkage = folding.linkage((length, length, length / math.pi), flat_pairs="hinged")
    found = junctions_of(linkage).states.tolist()
    assert found == closed_to_rounding(linkage)
    assert len(found) == len(junctions_of(joined("hex:0234550132:4", "hinged")).states)


def test_loops_that_share_hinges_are_closed_together():
    """Six squares about two inner vertices; the hinge between these is in both loops."""
    facets = tuple(((x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)) for y in (0.0, 1.0) for x in (0.0, 1.0, 2.0))
    pairs = {(0, 1): "bottom", (1, 2): "bottom", (3, 4): "bottom", (4, 5): "bottom"}
    pairs |= {(0, 3): "bottom", (1, 4): "top", (2, 5): "bottom"}
    linkage = Linkage(Pattern.from_polygons(facets, {pair: Crease(face) for pair, face in pairs.items()}, 0.1))
    assert len(linkage.loops) == 2
    assert junctions_of(linkage).states.tolist() == closed_to_rounding(linkage)


def test_hinges_in_no_loop_turn_freely():
    linkage = linkage_named("thesis-4x4")
    assert {hinge for walk in linkage.loops for hinge, _ in walk} != set(range(linkage.n_hinges))
    assert junctions_of(linkage).states.tolist() == closed_to_rounding(linkage)


@pytest.mark.parametrize(("name", "count"), [("hex:02345500111133355432:8", 813), ("square:0122230323000121:0", 871)])
def test_junctions_of_long_loops(name, count):
    linkage = joined(name, "hinged")
    found = junctions_of(linkage)
    assert found.complete
    assert len(found.states) == count
    assert all(whole_end(linkage, state) is not None for state in found.states[:: count // 20])


def test_a_list_that_is_not_whole_says_so(monkeypatch):
    linkage = joined("hex:0234550132:4", "hinged")
    every = junctions_of(linkage).states.tolist()
    monkeypatch.setattr(simple_moves, "MAX_JUNCTION_COUNT", len(every) - 1)
    some = junctions_of(linkage)
    assert not some.complete
    assert len(some.states) == len(every) - 1
    assert all(state in every for state in some.states.tolist())
    monkeypatch.setattr(simple_moves, "MAX_JUNCTION_LOOP_HINGES", 9)
    none = junctions_of(linkage)
    assert (none.complete, none.states.shape) == (False, (0, 10))


def test_clear_junctions_keep_panels_apart():
    """Beside packed and flat, three of the four junctions of this folding have room for their panels."""
    linkage = joined("hex:0232335050:2", "hinged")
    space = space_of(linkage, 1e-4)
    stack = new_state_stack(space, 1)
    clear = clear_junctions(linkage, space, stack)
    every = junctions_of(linkage).states
    inner = [state for state in every if state.any() and (state != linkage.folded).any()]
    apart = [state.tolist() for state in inner if place_state(space, state, space.min_gap, pick_state(stack, 0))]
    assert clear.tolist() == apart
    assert (len(every), len(clear)) == (6, 3)
