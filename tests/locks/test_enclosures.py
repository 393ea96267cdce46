"""Kinematic locks: expansions, empty boxes and floods, against naive twins, proved paths and known locks."""

import math
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hcsearch.designs.folding import Folding, foldings
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.kernels.enclosure.contraction import close_within_box, contract_box, new_contraction
from hcsearch.kernels.enclosure.expansion import (
    EQUATIONS_PER_LOOP,
    bound_third_order,
    cut_loops,
    expand_closure,
    new_expansion,
    write_first_order,
)
from hcsearch.kernels.enclosure.flooding import (
    COUNT_BOXES,
    COUNT_HEAD,
    COUNT_TAIL,
    FACE_BOX_LIMITS,
    FLOOD_ENCLOSED,
    FLOOD_GOING,
    new_flood,
    spread_flood,
)
from hcsearch.kernels.enclosure.refutation import (
    BOX_CLOSED,
    BOX_EMPTY,
    BOX_UNFINISHED,
    continue_refutation,
    new_refutation,
    start_refutation,
)
from hcsearch.kernels.enclosure.wandering import MAX_WALK_STEP, random_walk
from hcsearch.library.unit_search.elements import untwisted_foldings_of
from hcsearch.motion.collision.panel_prisms import margin_of, plates_of
from hcsearch.motion.locks import enclosures, floods
from hcsearch.motion.locks.enclosures import Enclosure, enclose_ends, rings_of
from hcsearch.motion.locks.end_locks import lock_at
from hcsearch.motion.locks.floods import expected_cube_counts, flood_grid
from hcsearch.motion.planning.planner import Planner
from hcsearch.motion.searching import Budget
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import Crease, Pattern
from tests.locks.refuting import refute_box
from tests.naive import around_the_loop
from tests.planned import SAMPLES, joined, open_by, planned, walks_of
from tests.strategies import writings

MERGED = joined("square:012233230011:4", "merged")
"""Two loops."""
LINKAGES = {name: joined(name, way) for name, (way, _) in SAMPLES.items()} | {"merged": MERGED}
LOCKED = [
    ("hex:0223335500:4", "hinged"),
    ("hex:0232335050:2", "hinged"),
    ("hex:0232435051:0", "hinged"),
    ("hex:0233534001:3", "hinged"),
    ("hex:0234535012:4", "hinged"),
    ("hex:0233555022:3", "rigid"),
    ("hex:0233350401:0", "rigid"),
    ("square:0112223300:4", "hinged"),
    ("square:0122323001:0", "rigid"),
]
"""Foldings that a referee's own program proved locked."""


def equations(linkage, angles, about, cuts):
    """The 12 equations of each loop at some angles, with the middle panel turned back from its place at others."""
    values = []
    lines = linkage.directions, linkage.points / linkage.pattern.size
    for loop, (first, last) in zip(linkage.loops, cuts, strict=True):
        there, back = loop[first:last], [(hinge, -sign) for hinge, sign in (loop[last:] + loop[:first])[::-1]]
        poses = [around_the_loop(*lines, walk, state) for state in (angles, about) for walk in (there, back)]
        # the point of the middle panel half-way between its hinges, in the flat state
        middle = 0.5 * (lines[1][loop[last - 1][0]] + lines[1][loop[last % len(loop)][0]])
        turned = (poses[0][:3, :3] - poses[1][:3, :3]) @ poses[2][:3, :3].T
        place = [pose[:3, :3] @ middle + pose[:3, 3] for pose in poses[:2]]
        values += [*turned.ravel(), *(place[0] - place[1])]
    return np.array(values)


def second_order(expansion, d):
    """What an expansion gives at an offset from the middle."""
    values = expansion.values + expansion.slopes @ d
    filled = slice(0, int(expansion.bend_count[0]))
    for (i, j), owner, bend in zip(
        expansion.pairs[filled], expansion.bend_loops[filled], expansion.bends[filled], strict=True
    ):
        values[EQUATIONS_PER_LOOP * owner : EQUATIONS_PER_LOOP * (owner + 1)] += bend * d[i] * d[j]
    return values


def box_about(state, rng, width):
    """A box within the stops that holds a state, one side of it of no width."""
    part = rng.random(len(state)) * width
    low, high = np.clip(state - part, 0.0, math.pi), np.clip(state + width - part, 0.0, math.pi)
    side = rng.integers(len(state))
    low[side] = high[side] = state[side]
    return low, high


def close(rings, state, work):
    """Move a state to a closed one within the stops; what is left of the equations there."""
    low, high = np.zeros(len(state)), np.full(len(state), math.pi)
    return close_within_box(rings, low, high, state, work.contraction.expansion, work.newton)


def close_fully(rings, state, work):
    """A closed state near one, with hinges that nearly are at a stop at it; what is left of the equations there.

    A state with a residual of 1e-9 is none where the box has no width along a hinge that ought to be at its stop.
    """
    low, high = np.zeros(len(state)), np.full(len(state), math.pi)
    for stop in (low, high):
        at_stop = np.abs(state - stop) < 1e-6
        state[at_stop] = stop[at_stop]
    free, own = (low < state) & (state < high), work.contraction.expansion
    for _ in range(6):
        write_first_order(rings, state, own)
        state[free] -= np.linalg.lstsq(own.slopes[:, free], own.values, rcond=1e-9)[0]
        np.clip(state, low, high, out=state)
    write_first_order(rings, state, own)
    return np.linalg.norm(own.values)


def assert_kept(rings, closed, box, work):
    """A box that is contracted still holds a closed state."""
    low, high = box
    assert contract_box(rings, low, high, work)
    assert (low <= closed + 2e-6).all()
    assert (closed <= high + 2e-6).all()


@given(st.sampled_from(sorted(LINKAGES)), st.floats(0.001, 0.5), st.integers(0, 2**32 - 1))
def test_an_expansion_is_that_of_the_loops_but_for_its_rests(name, width, seed):
    linkage, rng = LINKAGES[name], np.random.default_rng(seed)
    rings, hinges = rings_of(linkage)
    assert hinges.tolist() == list(range(linkage.n_hinges))
    middle = math.pi * rng.random(len(hinges))
    radii = width * rng.random(len(hinges)) ** 3
    expansion = new_expansion(rings)
    cut_loops(rings, radii, int(rng.integers(5)), expansion.cuts)
    expand_closure(rings, middle, radii, expansion)
    cuts = expansion.cuts.tolist()
    assert expansion.values == pytest.approx(equations(linkage, middle, middle, cuts), abs=1e-12)
    for scale in (1.0, rng.random()):
        d = scale * radii * rng.choice([-1.0, 1.0], len(hinges))
        rest = equations(linkage, middle + d, middle, cuts) - second_order(expansion, d)
        for loop in range(len(cuts)):
            own = rest[EQUATIONS_PER_LOOP * loop : EQUATIONS_PER_LOOP * (loop + 1)]
            values = np.linalg.svd(own[:9].reshape(3, 3), compute_uv=False)
            assert values[0] <= expansion.third_order_bounds[loop, 0] + 1e-12
            assert np.linalg.norm(own[9:]) <= expansion.third_order_bounds[loop, 1] + 1e-12
            for mix in rng.normal(size=(5, 9)):
                # a sum of matrices of rank 2, with singular values of 1 at most
                most = math.sqrt(2.0) * np.linalg.norm(mix) * expansion.third_order_bounds[loop, 0]
                assert abs(mix @ own[:9]) <= most + 1e-12
        for mix in rng.normal(size=(5, len(rest))):
            assert abs(mix @ rest) <= bound_third_order(radii, rings.hinges, expansion, mix[:, None].copy()) + 1e-12


def test_loops_are_cut_where_their_halves_are_most_alike_and_then_in_order():
    rings, hinges = rings_of(LINKAGES["hex:0234550132:4"])
    cuts, rng = np.zeros((1, 2), np.int64), np.random.default_rng(4)
    m = len(hinges)
    for _ in range(50):
        radii = rng.random(m) ** 4
        own = radii[rings.hinges]
        ways = sorted((abs(2.0 * own[i:j].sum() - own.sum()), i, j) for i in range(m) for j in range(i, m))
        for turn, (uneven, _, _) in enumerate(ways[:4]):
            cut_loops(rings, radii, turn, cuts)
            first, last = cuts[0]
            assert abs(2.0 * own[first:last].sum() - own.sum()) == pytest.approx(uneven)
    cut_loops(rings, np.ones(m), 0, cuts)
    even = {tuple(cuts[0])}
    for turn in (1, 2):
        cut_loops(rings, np.ones(m), turn, cuts)
        even.add(tuple(cuts[0]))
    assert len(even) == 3


@pytest.mark.parametrize("name", sorted(SAMPLES))
def test_no_box_that_holds_a_closed_state_is_empty(name):
    sample, rng = planned(name), np.random.default_rng(1)
    rings, hinges = rings_of(sample.linkage)
    work, states, tested = new_refutation(rings), sample.proof.motion.angles[:, hinges], 0
    for _ in range(2000):
        state = np.clip(states[rng.integers(len(states))], 0.0, math.pi)
        close(rings, state, work)
        if close_fully(rings, state, work) > 1e-13:
            continue
        low, high = box_about(state, rng, 10.0 ** rng.uniform(-4, 0))
        assert refute_box(rings, low.copy(), high.copy(), 50, work)[0] != BOX_EMPTY
        tested += 1
    assert tested > 1900, tested


@pytest.mark.parametrize("name", sorted(SAMPLES))
def test_contraction_keeps_closed_states(name):
    sample, rng = planned(name), np.random.default_rng(2)
    rings, hinges = rings_of(sample.linkage)
    refutation, work = new_refutation(rings), new_contraction(rings)
    for state in sample.states[:: max(1, len(sample.states) // 40)][:, hinges]:
        closed = np.clip(state, 0.0, math.pi)
        close(rings, closed, refutation)
        assert_kept(rings, closed, box_about(closed, rng, 10.0 ** rng.uniform(-2, -0.5)), work)


def test_contraction_keeps_closed_states_of_several_loops():
    rng, tested = np.random.default_rng(5), 0
    rings, hinges = rings_of(MERGED)
    refutation, work, n = new_refutation(rings), new_contraction(rings), len(hinges)
    for _ in range(300):
        closed = math.pi * rng.random(n)
        if close(rings, closed, refutation) > 1e-7:
            continue
        assert_kept(rings, closed, box_about(closed, rng, 10.0 ** rng.uniform(-2, -0.5)), work)
        tested += 1
    assert tested > 50


def test_a_fine_flood_proves_what_a_coarse_one_does_not(monkeypatch):
    linkage = joined("hex:0233435001:3", "hinged")
    plates, cuts = plates_of(linkage, 1e-4), ((0.15, 0.6, 1.2), floods.FLOOD_GRID_ANGLES[0])
    known = enclose_ends(linkage, 10_000, plates)
    monkeypatch.setattr(enclosures, "WALK_SCHEDULE", ())
    monkeypatch.setattr(floods, "FLOOD_GRID_ANGLES", cuts[:1])
    wide = enclose_ends(linkage, 300_000, plates)
    assert not wide.proved
    assert not wide.unfinished
    monkeypatch.setattr(floods, "FLOOD_GRID_ANGLES", cuts)
    both = enclose_ends(linkage, 300_000, plates)
    assert (both.end, both.cubes, both.faces) == (known.end, known.cubes, known.faces)
    assert both.boxes > known.boxes


def test_regions_are_laid_where_floods_come_to_the_other_end(monkeypatch):
    linkage = joined("hex:0223445511:4", "hinged")
    monkeypatch.setattr(floods, "FLOOD_GRID_ANGLES", ((1.5,),))
    before = enclose_ends(linkage, 10_000)
    assert not before.proved
    assert before.unfinished
    assert enclose_ends(linkage, 100_000).end == "packed"


@pytest.mark.parametrize("name", ["hex:0234451512:0", "hex:0223435501:2", "hex:0233534001:0"])
def test_a_walk_comes_to_some_of_the_cubes_that_are_taken_in(name, monkeypatch):
    monkeypatch.setattr(enclosures, "WALK_SCHEDULE", ())
    linkage = joined(name, "hinged")
    rings, hinges = rings_of(linkage)
    enclosure = enclose_ends(linkage, 400_000)
    end = linkage.folded if enclosure.end == "packed" else linkage.flat
    coarse, fine = expected_cube_counts(random_walk(rings, end[hinges], 10_000, 1, new_refutation(rings)))
    assert 0.1 * enclosure.cubes < coarse < enclosure.cubes
    assert coarse < fine


def test_a_flood_whose_expected_boxes_grow_is_expected_to_grow_on(monkeypatch):
    linkage = joined("hex:0233534001:0", "hinged")
    rings, hinges = rings_of(linkage)
    flood = floods.floods_from(rings, (linkage.folded[hinges], linkage.flat[hinges]), lambda: new_refutation(rings))[0]
    assert flood.boxes_expected == math.inf
    monkeypatch.setattr(floods, "SETTLED_FLOOD_BOXES", 4_000)
    flood.run(Budget(5_000))
    flood.cubes_expected = float(flood.cubes)
    flood.run(Budget(10_000))
    assert flood.progress_at_doubling[0] == 5_000
    naive = (
        3.0 * 10_000 * max(flood.cubes, flood.cubes**2 / (3.0 * flood.cubes_expected)) / flood.flood.counts[COUNT_HEAD]
    )
    before = flood.boxes_expected
    assert before >= naive
    # half the cubes by then, and as many faces left as now: the number has not grown
    flood.progress_at_doubling = 5_000, flood.cubes, flood.flood.counts[COUNT_HEAD] // 2
    assert flood.boxes_expected == pytest.approx(naive, rel=0.1)
    # all faces of as many cubes were tested by then: with twice the boxes it has doubled, and never ends
    flood.progress_at_doubling = 5_000, flood.cubes, flood.flood.counts[COUNT_HEAD]
    assert flood.boxes_expected == pytest.approx(naive * naive / 10_000)
    monkeypatch.setattr(floods, "SETTLED_FLOOD_BOXES", 6_000)
    assert flood.boxes_expected == pytest.approx(naive)


def test_a_walk_passes_closed_states_from_one_to_the_next():
    linkage = joined("square:012233230011:4", "merged")
    rings, hinges = rings_of(linkage)
    states = random_walk(rings, linkage.folded[hinges], 3000, 5, new_refutation(rings))
    assert len(states) > 1000
    assert states.min() >= 0.0
    assert states.max() <= math.pi
    angles = np.tile(linkage.folded, (len(states), 1))
    angles[:, hinges] = states
    assert open_by(linkage, angles).max() < 1e-6
    gaps = np.abs(states[1:, None] - states[None]).max(axis=2)
    assert (
        gaps.min(axis=1, where=np.tri(len(gaps), len(states), dtype=bool), initial=9.0) <= 1.5 * MAX_WALK_STEP
    ).all()


def test_a_box_is_empty_where_newton_reaches_no_closed_state():
    linkage, rng = joined("hex:0223335500:4", "hinged"), np.random.default_rng(3)
    rings, hinges = rings_of(linkage)
    work, verdicts = new_refutation(rings), []
    for _ in range(300):
        low = rng.integers(0, 8, len(hinges)) * math.pi / 8
        high = low + math.pi / 8
        verdict, _ = refute_box(rings, low.copy(), high.copy(), 300, work)
        verdicts.append(verdict)
        for _ in range(10 if verdict == BOX_EMPTY else 0):
            state = low + rng.random(len(low)) * (high - low)
            assert close_within_box(rings, low, high, state, work.contraction.expansion, work.newton) > 1e-4
    assert verdicts.count(BOX_EMPTY) > 100


def test_a_flood_takes_in_what_a_naive_one_does():
    linkage = joined("hex:0232335050:2", "rigid")
    rings, hinges = rings_of(linkage)
    work, start, goal = new_refutation(rings), linkage.folded[hinges], linkage.flat[hinges]
    grid = flood_grid(0)
    flood = new_flood(start, goal, grid, 1000)
    assert spread_flood(rings, flood, 10**9, work) == FLOOD_ENCLOSED
    first = tuple(int(np.sum(angle >= grid)) - 1 for angle in start)
    taken, waiting = {first}, [first]
    while waiting:
        cube = waiting.pop()
        for side, step in product(range(len(cube)), (-1, 1)):
            beyond = (*cube[:side], cube[side] + step, *cube[side + 1 :])
            if beyond in taken or not 0 <= beyond[side] < len(grid) - 1:
                continue
            low, high = grid[list(cube)], grid[[k + 1 for k in cube]]
            low[side] = high[side] = high[side] if step > 0 else low[side]
            if refute_box(rings, low, high, FACE_BOX_LIMITS[-1], work)[0] != BOX_EMPTY:
                taken.add(beyond)
                waiting.append(beyond)
    # the order of cubes decides from which state Newton's method begins, but not which faces are empty
    assert {tuple(cube) for cube in flood.cubes[: flood.counts[COUNT_TAIL]].tolist()} == taken


@pytest.mark.parametrize("boxes", [1, 7, 400])
def test_a_flood_comes_to_the_same_however_often_it_stops(boxes):
    linkage = joined("hex:0223335500:4", "hinged")
    rings, hinges = rings_of(linkage)
    one, two = (new_flood(linkage.folded[hinges], linkage.flat[hinges], flood_grid(0), 1000) for _ in range(2))
    assert spread_flood(rings, one, 10**9, new_refutation(rings)) == FLOOD_ENCLOSED
    work, state = new_refutation(rings), FLOOD_GOING
    while state == FLOOD_GOING:
        state = spread_flood(rings, two, two.counts[COUNT_BOXES] + boxes, work)
    assert state == FLOOD_ENCLOSED
    np.testing.assert_array_equal(one.counts, two.counts)
    np.testing.assert_array_equal(one.cubes, two.cubes)


@pytest.mark.parametrize(("name", "way"), LOCKED)
def test_foldings_that_are_known_to_be_locked_are_enclosed(name, way):
    linkage = joined(name, way)
    enclosure = enclose_ends(linkage, 400_000)
    # a region is proved by six boxes with six faces where it is around the flat end of the first squares
    assert enclosure.faces >= enclosure.cubes == len(enclosure.lows) > 0
    assert not enclosure.unfinished
    hinges = linkage.looped
    for end, state in (("packed", linkage.folded[hinges]), ("flat", linkage.flat[hinges])):
        within = ((enclosure.lows <= state) & (state <= enclosure.highs)).all(axis=1)
        assert within.any() == (enclosure.end == end)


@pytest.mark.parametrize(("name", "way"), LOCKED)
def test_a_lock_is_left_by_no_search_from_any_position_at_any_thickness(name, way):
    folding = Folding.from_notation(name)
    side = default_panel(folding.circuit.grid.name)[0]
    for thickness in (0.04 * side, 0.12 * side, 0.4 * side):
        panel = (side, side, thickness)
        assert enclose_ends(folding.linkage(panel, flat_pairs=way), 400_000).proved
        written = [own for writing in writings(folding.circuit) for own in foldings(writing)]
        positions = [own for own in written if like(own, folding, panel)]
        assert len(positions) >= 4
        for own in positions[:: len(positions) // 4][:4]:
            linkage = own.linkage(panel, flat_pairs=way)
            assert Planner(linkage, margin_of(linkage), collide=False).plan(Budget(150)).states is None


def like(own, folding, panel):
    """Whether a folding is congruent to another."""
    one, two = (given if (known := given.likeness(panel)) is None else known.folding for given in (own, folding))
    return one == two


@pytest.mark.parametrize("name", sorted(SAMPLES))
def test_what_moves_is_not_enclosed(name):
    assert not enclose_ends(planned(name).linkage, 20_000).proved


@pytest.mark.parametrize("boxes", [1, 100, 10_000])
def test_a_flood_stops_where_its_boxes_end(boxes):
    enclosure = enclose_ends(joined("hex:0234451512:0", "hinged"), boxes)
    assert not enclosure.proved
    assert enclosure.unfinished
    assert enclosure.boxes <= boxes


def test_a_proof_does_not_hang_on_how_many_boxes_are_allowed():
    linkage = joined("hex:0234535012:4", "hinged")
    assert enclose_ends(linkage, 200_000) == enclose_ends(linkage, 500_000)


def test_a_chain_without_a_loop_is_never_locked():
    facets = tuple(
        tuple((x + dx, y) for x, y in ((0.0, 0.0), (0.05, 0.0), (0.05, 0.05), (0.0, 0.05))) for dx in (0.0, 0.05)
    )
    chain = Linkage(Pattern.from_polygons(facets, {(0, 1): Crease("top")}, 0.006))
    assert enclose_ends(chain, 1000) == Enclosure(None, 0, 0, 0, unfinished=False)


@pytest.mark.parametrize(
    ("thickness", "missed"),
    [
        # residuals of a millionth count as closed, which panels a hundredth of their edge thick may come to
        (0.0005, {"hex:0233555022:1"}),
        (0.006, set()),
        (0.025, set()),
    ],
)
def test_what_is_locked_at_an_end_is_enclosed(thickness, missed):
    left, count = set(), 0
    for folding in untwisted_foldings_of("hex", 10):
        linkage = Linkage(folding.pattern((0.05, 0.05, thickness)))
        if any(lock_at(linkage, angles).locked for angles in (linkage.folded, linkage.flat)):
            enclosure, count = enclose_ends(linkage, 200_000), count + 1
            if not enclosure.proved:
                left.add(folding.notation)
    assert count == 14
    assert left <= missed


def test_a_search_that_is_interrupted_comes_to_the_same():
    rings, walks = walks_of(joined("hex:0233350401:0", "hinged"), 5_000)
    low, high = walks[0].min(axis=0), np.full(rings.hinge_count, math.pi)
    side = int(np.argmax(low))
    high[side] = low[side] = low[side] - 0.1
    whole, parts = new_refutation(rings), new_refutation(rings)
    verdict, boxes = refute_box(rings, low, high, 10**6, whole)
    assert verdict == BOX_EMPTY
    start_refutation(rings, low, high, parts)
    calls = 0
    while (own := continue_refutation(rings, int(parts.counts[1]) + 1000, parts)) == BOX_UNFINISHED:
        calls += 1
    assert (own, parts.counts[1]) == (verdict, boxes)
    assert calls > 3


def test_closed_states_are_reached_within_a_box():
    sample = planned("hex:0234550132:4")
    rings, hinges = rings_of(sample.linkage)
    work = new_refutation(rings)
    state = sample.states[len(sample.states) // 2][hinges]
    low, high = np.clip(state - 0.2, 0.0, math.pi), np.clip(state + 0.2, 0.0, math.pi)
    own = low + 0.5 * (high - low)
    assert close_within_box(rings, low, high, own, work.contraction.expansion, work.newton) < 1e-6
    assert np.abs(equations(sample.linkage, own, own, [(0, len(own) // 2)])).max() < 1e-6
    assert refute_box(rings, low, high, 100, work)[0] == BOX_CLOSED
