"""Closed states and what is known of them: closing, gaps, contacts, steps, chords and trees against plain twins."""

import math

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from scipy.optimize import nnls

from hcsearch.kernels.planning.closed_states import (
    close_state,
    keep_closed,
    largest_closure_residual,
    new_closing,
    remove_span,
    write_closure_basis,
)
from hcsearch.kernels.planning.sliding import (
    MIN_CONDITION_NORM,
    SPARE_GAP_SHARE,
    _allow,
    _ascend,
    condition_change,
    move_panels,
    near_contacts,
    near_stops,
    slide,
    write_condition_row,
)
from hcsearch.kernels.planning.space import (
    link_states,
    new_space_work,
    new_state_stack,
    pick_state,
    place_state,
    separated,
)
from hcsearch.kernels.planning.tree_search import (
    MAX_STATES_PER_CELL,
    add_state,
    cell_slot,
    keep_new_states,
    nearest_state,
    new_tree,
)
from hcsearch.motion.collision.distances import proximal_distances
from hcsearch.motion.planning.problems import loops_of, space_of
from tests import planned as samples
from tests.planned import SAMPLES, planned

MARGIN = 1e-5
states = st.tuples(st.sampled_from(sorted(SAMPLES)), st.floats(0.02, 0.98), st.integers(0, 2**32))


def state_of(drawn):
    """A sample, a state of its path, and a generator."""
    name, share, seed = drawn
    sample = planned(name)
    path = sample.states
    return sample, path[int(share * (len(path) - 1))].copy(), np.random.default_rng(seed)


def solids_at(linkage, angles, prisms):
    poses = linkage.poses(angles)
    solids = []
    for f, panel in enumerate(prisms.panels):
        corners = prisms.vertices[f, : prisms.counts[f, 0]]
        solids.append(corners @ poses[panel, :, :3].T + poses[panel, :, 3])
    return solids


@settings(max_examples=25)
@given(states, st.floats(1e-6, 0.1))
@example(("square:012123230301:1", 0.71875, 0), 1e-6)
def test_closing_ends_at_a_closed_state_within_the_stops(drawn, far):
    sample, state, rng = state_of(drawn)
    loops = loops_of(sample.linkage)
    work = new_closing(loops)
    moved = np.clip(state + far * rng.uniform(-1, 1, len(state)), 0, math.pi)
    closed = moved.copy()
    if not close_state(loops, closed, 1e-11, 0.0, 40, work):
        assert far > 1e-3
        return
    assert samples.open_by(sample.linkage, closed) < 1e-10
    assert closed.min() >= 0
    assert closed.max() <= math.pi
    # nearest to first order, no further than the closed state it was moved from, unless stops leave the loops nearly
    # singular there: to second order then
    off = np.linalg.norm(state - moved)
    free = (state > 1e-6) & (state < math.pi - 1e-6)
    values = np.linalg.svd(sample.linkage.closure(state)[1][:, free], compute_uv=False)
    firm = off <= 0.1 * min(values[values > 1e-9], default=0.0)
    assert np.linalg.norm(closed - moved) <= (3 * off if firm else max(3 * off, math.sqrt(off))) + 1e-9


@settings(max_examples=25)
@given(states)
def test_rates_that_are_kept_closed_open_no_loop_and_turn_no_stopped_hinge(drawn):
    sample, state, rng = state_of(drawn)
    loops = loops_of(sample.linkage)
    work = new_closing(loops)
    rates = rng.normal(size=(1, len(state)))
    keep_closed(loops, state, rates, 0, work)
    _, jacobian = sample.linkage.closure(state)
    assert np.abs(jacobian @ rates[0]).max() < 1e-8
    stopped = (state < 1e-9) | (state > math.pi - 1e-9)
    assert (rates[0, stopped] == 0).all()


@settings(max_examples=25)
@given(st.integers(1, 9), st.integers(1, 12), st.integers(1, 9), st.integers(0, 2**32))
def test_spans(rows, columns, rank, seed):
    rng = np.random.default_rng(seed)
    rank = min(rank, rows, columns)
    jacobian = rng.normal(size=(rows, rank)) @ rng.normal(size=(rank, columns))
    work = new_closing(loops_of(planned("hex:0234550132:4").linkage))
    work = work._replace(jacobian=jacobian, basis=np.zeros((rows, columns)))
    count = write_closure_basis(work, 1e-9)
    assert count == rank
    basis = work.basis[:count]
    np.testing.assert_allclose(basis @ basis.T, np.eye(count), atol=1e-12)
    np.testing.assert_allclose(jacobian @ basis.T @ basis, jacobian, atol=1e-8)


@settings(max_examples=12)
@given(states)
def test_gaps_of_a_placed_state_are_those_of_its_prisms(drawn):
    sample, angles, _ = state_of(drawn)
    linkage = sample.linkage
    space = space_of(linkage, MARGIN)
    state = pick_state(new_state_stack(space, 1), 0)
    assert place_state(space, angles, -math.inf, state)
    solids = solids_at(linkage, angles, space.prisms)
    exact = proximal_distances(linkage, angles[None])
    whole = {tuple(pair): gap for pair, gap in zip(exact.pairs.tolist(), exact.gaps[:, 0], strict=True)}
    least = {}
    for (f, g), gap, way in zip(space.pairs.tolist(), state.gaps, state.gap_directions, strict=True):
        assert np.linalg.norm(way) == pytest.approx(1)
        apart = (solids[g] @ way).min() - (solids[f] @ way).max()
        if gap <= space.measured_distance:
            assert apart == pytest.approx(gap, abs=1e-12)  # the direction of a gap shows all of it
        else:
            assert min(np.linalg.norm(a - b) for a in solids[f] for b in solids[g]) >= gap - 1e-12
        between = tuple(sorted((int(space.prisms.panels[f]), int(space.prisms.panels[g]))))
        least[between] = min(least.get(between, math.inf), gap)
    for between, gap in least.items():
        if gap <= space.measured_distance:  # corners of shrunk prisms are off by no more than this
            assert whole[between] - 1e-12 <= gap or whole[between] <= 0
            assert gap <= whole[between] + 8 * MARGIN
    assert not place_state(space, angles, state.gaps.min() + 1e-9, pick_state(new_state_stack(space, 1), 0))


@settings(max_examples=12)
@given(states, st.integers(0, 10**6))
def test_conditions_of_contact_are_derivatives_of_heights_of_corners(drawn, number):
    sample, angles, _ = state_of(drawn)
    linkage = sample.linkage
    space = space_of(linkage, MARGIN)
    p = number % len(space.pairs)
    space = space._replace(pairs=space.pairs[p : p + 1].copy(), measured_distance=math.inf)
    state, work = pick_state(new_state_stack(space, 1), 0), new_space_work(space)
    place_state(space, angles, -math.inf, state)
    count = near_contacts(space, state, 1e-2, 0, work)
    if state.gaps[0] > 1e-2:
        assert count == 0
        return
    f, g = space.pairs[0]
    expected = []
    for own, other, way in ((f, g, state.gap_directions[0]), (g, f, -state.gap_directions[0])):
        fixed = linkage.poses(angles)[space.prisms.panels[own], :, :3].T @ way

        def heights(angles, own=own, other=other, fixed=fixed):
            turned = linkage.poses(angles)[space.prisms.panels[own], :, :3] @ fixed
            solids = solids_at(linkage, angles, space.prisms)
            return solids[other] @ turned, (solids[own] @ turned)

        below = heights(angles)[1].argmax()
        slopes = []
        for e in np.eye(len(angles)):
            up, down = heights(angles + 1e-5 * e), heights(angles - 1e-5 * e)
            slopes.append(((up[0] - up[1][below]) - (down[0] - down[1][below])) / 2e-5)
        corners, under = heights(angles)
        expected.append((np.array(slopes).T, corners - under.max()))
    for k in range(count):
        write_condition_row(space, k, work.rows, k, work)
    rows, bounds = work.rows[:count], work.conditions.bounds[:count]
    agree = []
    for slopes, gaps in expected:
        near = gaps <= state.gaps[0] + 1e-2
        agree.append(
            near.sum() == count
            and np.allclose(rows, slopes[near], atol=1e-8)
            and np.allclose(bounds, SPARE_GAP_SHARE * (space.step_gap - gaps[near]), atol=1e-12)
        )
    assert any(agree)


@settings(max_examples=20)
@given(states, st.integers(0, 10**6))
def test_what_a_step_opens_is_the_row_of_a_condition_times_the_step(drawn, number):
    sample, angles, _ = state_of(drawn)
    space = space_of(sample.linkage, MARGIN)
    state, work = pick_state(new_state_stack(space, 1), 0), new_space_work(space)
    place_state(space, angles, -math.inf, state)
    stops = near_stops(state, 1.0, work)
    assert stops == (angles < 1).sum() + (angles > math.pi - 1).sum()
    count = near_contacts(space, state, 1e-2, stops, work)
    step = np.random.default_rng(number).normal(size=len(angles))
    move_panels(space, step, work)
    for k in range(count):
        write_condition_row(space, k, work.rows, 0, work)
        assert condition_change(step, k, work) == pytest.approx(work.rows[0] @ step, abs=1e-12)
        if k < stops:
            reached = (angles + work.rows[0] * work.conditions.bounds[k])[work.rows[0] != 0]
            assert reached == pytest.approx(0.0 if work.rows[0].max() > 0 else math.pi)


@settings(max_examples=30)
@given(st.integers(2, 8), st.integers(1, 6), st.integers(0, 2**32))
def test_a_step_is_the_nearest_that_its_conditions_allow(m, count, seed):
    rng = np.random.default_rng(seed)
    count = min(count, m)
    rows = rng.normal(size=(count, m)) + np.eye(count, m) * 2
    rows /= np.linalg.norm(rows, axis=1)[:, None]
    # conditions that are nearly opposite take more rounds than a step has
    assume(np.linalg.svd(rows, compute_uv=False)[-1] > 0.2)
    bounds, wanted = rng.normal(size=count), rng.normal(size=m)
    work = new_space_work(space_of(planned("hex:0234550132:4").linkage, MARGIN))
    work = work._replace(rows=rows, bounds=bounds, forces=np.zeros(count), step=np.zeros(m))
    work.allowed_steps[1, :m] = wanted
    _ascend(count, work)
    # the dual: least |rows^T forces - d|, forces >= 0, for any d with rows d = bounds - rows wanted
    off = np.linalg.lstsq(rows, bounds - rows @ wanted, rcond=None)[0]
    forces, _ = nnls(rows.T, off)
    np.testing.assert_allclose(work.step, wanted + rows.T @ forces, atol=0.02 * (1 + np.linalg.norm(wanted)))
    assert (work.forces >= 0).all()


@settings(max_examples=25)
@given(states, st.floats(1e-3, 0.1))
def test_a_step_keeps_loops_closed_and_all_stops_and_contacts(drawn, longest):
    sample, angles, rng = state_of(drawn)
    space = space_of(sample.linkage, MARGIN)
    state, work = pick_state(new_state_stack(space, 1), 0), new_space_work(space)
    place_state(space, angles, -math.inf, state)
    largest_closure_residual(space.loops, angles, work.closing)
    rank = write_closure_basis(work.closing, 1e-7)
    wanted = rng.normal(size=(1, len(angles)))
    remove_span(work.closing.basis, rank, wanted, 0)
    wanted *= longest / np.abs(wanted).max()
    work.step[:] = work.allowed_steps[1] = wanted[0]
    _allow(space, state, longest, rank, work)
    step = work.step.copy()
    assert np.abs(sample.linkage.closure(angles)[1] @ step).max() < 1e-12
    count = near_contacts(space, state, longest * space.lever, near_stops(state, 2 * longest, work), work)
    for k in range(count):
        row = np.zeros((1, len(angles)))
        write_condition_row(space, k, row, 0, work)
        opened = row[0] @ step
        remove_span(work.closing.basis, rank, row, 0)
        # what no closed step changes is no condition; others hold but for a share of the step (at most 1.5 % of 400)
        if np.linalg.norm(row) > MIN_CONDITION_NORM:
            short = work.conditions.bounds[k] - opened
            assert short < 0.05 * np.linalg.norm(row) * np.linalg.norm(wanted)


@settings(max_examples=15)
@given(states, st.floats(1e-3, 0.1))
def test_a_slide_leads_to_a_closed_state_with_panels_apart(drawn, longest):
    sample, angles, rng = state_of(drawn)
    space = space_of(sample.linkage, MARGIN)
    stack, work = new_state_stack(space, 2), new_space_work(space)
    here, there = pick_state(stack, 0), pick_state(stack, 1)
    assume(place_state(space, angles, space.min_gap, here))
    work.wanted_step[:] = rng.normal(size=len(angles))
    far = slide(space, here, longest, 1e-7, work, there)
    assume(far > 0)
    assert far == pytest.approx(np.abs(there.angles - angles).max())
    assert far <= 2 * longest
    assert samples.open_by(sample.linkage, there.angles) < 1e-8
    assert there.gaps.min() >= space.min_gap
    assert there.angles.min() >= 0
    assert there.angles.max() <= math.pi
    assert separated(space, here, there)


@settings(max_examples=12)
@given(states, st.floats(0, 0.98))
def test_pairs_are_separated_where_one_fixed_direction_does(drawn, to):
    sample, angles, _ = state_of(drawn)
    linkage = sample.linkage
    other = sample.states[int(to * (len(sample.states) - 1))]
    space = space_of(linkage, MARGIN)
    stack = new_state_stack(space, 2)
    one, two = pick_state(stack, 0), pick_state(stack, 1)
    place_state(space, angles, -math.inf, one)
    place_state(space, other, -math.inf, two)
    both = []
    for (f, g), first, second in zip(space.pairs.tolist(), one.gap_directions, two.gap_directions, strict=True):
        gaps = []
        for way, here in ((first, angles), (second, other)):
            for fixed in (f, g):
                own = linkage.poses(here)[space.prisms.panels[fixed], :, :3].T @ way
                least = math.inf
                for at in (angles, other):
                    turned = linkage.poses(at)[space.prisms.panels[fixed], :, :3] @ own
                    solids = solids_at(linkage, at, space.prisms)
                    least = min(least, (solids[g] @ turned).min() - (solids[f] @ turned).max())
                gaps.append(least)
        both.append(max(gaps))
    moved = space.lever * np.abs(angles - other).max()
    far = one.gaps + two.gaps > moved
    expected = (np.array(both) >= space.parting_gap) | far
    if np.abs(np.array(both)[~far] - space.parting_gap).min(initial=1) > 1e-12:
        assert separated(space, one, two) == expected.all()


@settings(max_examples=12)
@given(states, st.integers(1, 4))
def test_links_are_lines_of_closed_states(drawn, steps):
    sample, angles, _ = state_of(drawn)
    path = sample.states
    other = path[min(int(drawn[1] * (len(path) - 1)) + steps, len(path) - 1)]
    space = space_of(sample.linkage, MARGIN)
    between = np.zeros((200, len(angles)))
    count = link_states(space, angles, other, 0.02, 8, new_state_stack(space, 12), new_space_work(space), between)
    assume(count >= 0)
    line = np.array([angles, *between[:count], other])
    assert np.abs(np.diff(line, axis=0)).max() <= 0.02
    for state in between[:count]:
        assert samples.open_by(sample.linkage, state) < 1e-8


def test_the_nearest_state_of_a_tree():
    rng = np.random.default_rng(5)
    tree = new_tree(200, rng.normal(size=4))
    for _ in range(150):
        add_state(tree, int(rng.integers(tree.size[0])), rng.normal(size=4))
    for _ in range(50):
        target, beyond = rng.normal(size=4), rng.choice([-1.0, 0.5, 2.0, 1e9])
        squares = ((tree.angles[: tree.size[0]] - target) ** 2).sum(axis=1)
        squares[squares <= beyond] = math.inf
        node, least = nearest_state(tree, target, beyond)
        if beyond > 1e8:
            assert (node, least) == (-1, math.inf)
        else:
            assert node == squares.argmin()
            assert least == pytest.approx(squares.min())


def test_a_tree_keeps_few_states_of_a_cell_and_none_beyond_its_room():
    tree = new_tree(20, np.zeros(3))
    for k in range(MAX_STATES_PER_CELL + 3):
        add_state(tree, 0, np.full(3, 1e-3 * k))
    assert keep_new_states(tree, 1)
    assert tree.size[0] == 1 + MAX_STATES_PER_CELL  # two of this cell, the rest of the line is cut off
    add_state(tree, 0, np.full(3, 2e-3))
    assert not keep_new_states(tree, 1 + MAX_STATES_PER_CELL)
    assert tree.size[0] == 1 + MAX_STATES_PER_CELL
    while add_state(tree, 0, np.ones(3)) >= 0:
        pass
    assert tree.size[0] == 20
    assert cell_slot(tree, 18) == cell_slot(tree, 19) != cell_slot(tree, 0)


def test_how_far_loops_are_open():
    for name in SAMPLES:
        linkage = planned(name).linkage
        loops, rng = loops_of(linkage), np.random.default_rng(2)
        work = new_closing(loops)
        assert largest_closure_residual(loops, linkage.folded, work) < 1e-14
        angles = linkage.folded + 1e-3 * rng.normal(size=linkage.n_hinges)
        residual, jacobian = linkage.closure(angles)
        assert largest_closure_residual(loops, angles, work) == np.abs(residual).max()
        assert (work.jacobian == jacobian).all()
