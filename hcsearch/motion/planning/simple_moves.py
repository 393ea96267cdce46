"""Simple moves of a linkage, and its junctions: the flat-folded states between which simple moves lead.

A flat-folded state has every hinge at a stop, and all loops closed. In a simple move two hinges on one line turn, and
the panels between them turn as one body; or 4, 6 or 8 on one line do, as many of them either way; or four parallel
hinges, a plane linkage of one degree of freedom. All others stay at their stops. Each moving hinge goes from stop to
stop. States of such a path are computed exactly or by Newton's method in the plane, and `path_proofs` proves each move
as a stretch.

Packed and flat are two of the junctions. There are few, 2 to 24 in all for 10 and 12 panels on a tiling. Motions branch
at junctions, and the junctions in a component of the closed states distinguish it from others.

A loop is closed if the half turns along its first half and, backwards, along its second half end in the same place: so
the products of both halves are listed and matched (Horowitz and Sahni, https://doi.org/10.1145/321812.321823), 2^(k/2)
of each for k hinges. On a tiling half turns map a lattice to itself (docs/explanation/theory.md, 25): two products are
equal, or differ by at least a step of the lattice, which is far above rounding. So the list is exact there.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from hcsearch.basics.array_values import ByValue, Flags, Reals, WholeNumbers
from hcsearch.kernels.collision.gaps import deepest_overlap
from hcsearch.kernels.planning.space import Space, StateStack, pick_state, place_state
from hcsearch.motion.collision.panel_prisms import kept_apart, prisms_of, solid_pairs
from hcsearch.motion.locks.lattice import whole_end
from hcsearch.motion.planning.problems import turns_equally
from hcsearch.motion.searching import Budget, SteppedSearch
from hcsearch.shape.linkage import Linkage, Walk

MAX_MOVE_STATES = 400
"""Greatest number of flat-folded states that are visited."""
MOVE_STEP_TURN = 0.1
"""Turn of the fastest hinge between two states of a move (rad)."""
MOVE_CLOSURE_TOLERANCE = 1e-9
"""Greatest closure residual of closed states, and greatest difference of equal lines."""
MAX_MOVE_CANDIDATES = 20000
"""Greatest number of sets of hinges that are tried: a large array has too many."""
MIN_LEAVING_RATE = 1e-6
"""Least rate, relative to the rate of all hinges, at which a hinge leaves its stop; slower ones stay there."""
COLLINEAR_HINGE_COUNTS = (2, 4, 6, 8)
"""Numbers of hinges on one line that turn together."""


class SimpleMoves(SteppedSearch[Reals | None]):
    """The path of fewest simple moves of a linkage with loops, with panels shrunk by a margin (m) on every face.

    The result is its states, (k, n_hinges), from packed to flat, or None; efforts are flat-folded states.
    """

    def __init__(self, linkage: Linkage, margin: float) -> None:
        self.linkage, self.candidates_left = linkage, MAX_MOVE_CANDIDATES
        self.prisms = prisms_of(linkage, margin)
        pairs = solid_pairs(linkage, prisms_of(linkage), kept_apart(linkage))
        self.pairs = np.ascontiguousarray(pairs.prisms)
        packed = linkage.folded.astype(float)
        self.arrivals: dict[bytes, tuple[bytes, Reals] | None] = {_key(packed): None}
        self.waiting = deque([packed])

    @property
    def efforts(self) -> int:
        """Flat-folded states that were reached."""
        return len(self.arrivals)

    @property
    def done(self) -> bool:
        """Whether flat is reached, or no move leads on."""
        return not self.waiting or _key(self.linkage.flat) in self.arrivals

    def step(self, budget: Budget) -> None:
        """Reach the states to which moves lead from one."""
        state = self.waiting.popleft()
        for move in self._moves(state):
            self.arrivals[_key(move[-1])] = (_key(state), move)
            self.waiting.append(move[-1])

    @property
    def result(self) -> Reals | None:
        """The states of the path; None without one."""
        moves: list[Reals] = []
        arrival = self.arrivals.get(_key(self.linkage.flat))
        while arrival is not None:
            moves.append(arrival[1])
            arrival = self.arrivals[arrival[0]]
        return np.concatenate([self.linkage.folded[None], *(move[1:] for move in moves[::-1])]) if moves else None

    def _moves(self, state: Reals) -> Iterator[Reals]:
        """Yield the states of each simple move from a flat-folded state to one that is not reached."""
        _, jacobian = self.linkage.closure(state)
        leaving = jacobian * np.where(state > 1.0, -1.0, 1.0)
        whole = whole_end(self.linkage, state)
        if whole is None:
            return
        for hinges in _candidates(leaving):
            if self.candidates_left <= 0:
                return
            self.candidates_left -= 1
            end = state.copy()
            end[hinges] = math.pi - end[hinges]
            if _key(end) in self.arrivals or np.abs(self.linkage.closure(end)[0]).max() > MOVE_CLOSURE_TOLERANCE:
                continue
            rates = None
            if not turns_equally(whole, end != state):
                rates = _rates(leaving[:, hinges])
                if rates is None:
                    continue
            move = self._along(state, end, hinges, rates)
            if move is not None and self._apart(move):
                yield move

    def _along(self, state: Reals, end: Reals, hinges: list[int], rates: Reals | None) -> Reals | None:
        """Return the closed states of a move; None where some hinge turns back, or does not reach its stop.

        rates : of the hinges as they leave their stops, or None where all turn by the same angle.
        """
        if rates is None:
            return state + np.linspace(0.0, 1.0, math.ceil(math.pi / MOVE_STEP_TURN) + 1)[:, None] * (end - state)
        sense = np.sign(end - state)[hinges]
        current, direction, states = state.copy(), rates / rates.max() * sense, [state]
        for _ in range(math.ceil(4.0 * math.pi / MOVE_STEP_TURN)):
            before = current.copy()
            current[hinges] += MOVE_STEP_TURN * direction / np.abs(direction).max()
            left = (end - current)[hinges]
            if np.abs(left).max() < 1.5 * MOVE_STEP_TURN or (sense * left).min() < 0.0:
                near = np.abs(before - end)[hinges].max() < 3.0 * MOVE_STEP_TURN
                return np.array([*states, end]) if near else None
            for _ in range(20):
                residual, jacobian = self.linkage.closure(current)
                if np.abs(residual).max() < 1e-13:
                    break
                current[hinges] -= np.linalg.lstsq(jacobian[:, hinges], residual, rcond=1e-9)[0]
            direction = (current - before)[hinges]
            opening = np.abs(self.linkage.closure(current)[0]).max()
            if opening > MOVE_CLOSURE_TOLERANCE or (sense * direction).min() <= 0.0:
                return None
            states.append(current.copy())
        return None

    def _apart(self, states: Reals) -> bool:
        """Whether the shrunk panels keep apart in all states."""
        return not deepest_overlap(self.linkage.chain, self.prisms, self.pairs, np.ascontiguousarray(states))


def _key(state: Reals) -> bytes:
    """A key of a flat-folded state: which hinges are closed."""
    return (state > 1.0).tobytes()


def _candidates(leaving: Reals) -> Iterator[list[int]]:
    """Yield the hinges of possible simple moves, small sets first.

    leaving : (n_rows, n_hinges), screws in the sense in which hinges leave their stops.
    """
    parallel = _equal_columns(leaving, [k for k in range(len(leaving)) if k % 6 < 3])
    lines = [line for group in parallel for line in _lines(leaving, group)]
    for count in COLLINEAR_HINGE_COUNTS:
        for ahead, back in lines:
            for ahead_set in combinations(ahead, count // 2):
                for back_set in combinations(back, count // 2):
                    yield sorted([*ahead_set, *back_set])
        if count == 2:
            for group in parallel:
                yield from map(list, combinations(group, 4))


def _rates(leaving: Reals) -> Reals | None:
    """The rates at which four parallel hinges leave their stops; None where they are not unique, or one is too slow.

    leaving : (n_rows, 4), their screws in the sense in which they do.
    """
    if leaving.shape[1] != 4:
        return None
    _, values, right_vectors = np.linalg.svd(leaving)
    rates: Reals = right_vectors[3] * (1.0 if right_vectors[3].sum() > 0.0 else -1.0)
    return rates if int((values > MOVE_CLOSURE_TOLERANCE).sum()) == 3 and rates.min() > MIN_LEAVING_RATE else None


def _equal_columns(leaving: Reals, rows: list[int]) -> list[list[int]]:
    """Group hinges whose screws have the same entries in some rows, up to the sense."""
    groups: list[list[int]] = []
    for h in range(leaving.shape[1]):
        for group in groups:
            first, second = leaving[rows, group[0]], leaving[rows, h]
            if min(np.abs(first - second).max(), np.abs(first + second).max()) < MOVE_CLOSURE_TOLERANCE:
                group.append(h)
                break
        else:
            groups.append([h])
    return groups


def _lines(leaving: Reals, group: list[int]) -> list[tuple[list[int], list[int]]]:
    """The hinges on each line, in two lists by the sense in which they leave their stops."""
    lines: list[tuple[list[int], list[int]]] = []
    for columns in _equal_columns(leaving[:, group], list(range(len(leaving)))):
        hinges = [group[k] for k in columns]
        ahead = [h for h in hinges if leaving[:, h] @ leaving[:, hinges[0]] > 0.0]
        lines.append((ahead, [h for h in hinges if h not in ahead]))
    return lines


def simple_path(linkage: Linkage, margin: float) -> Reals | None:
    """Return the states of a path of simple moves, (k, n_hinges), from packed to flat; None where there is none.

    margin : panels are shrunk by it, m. Gaps are checked at the states only: `path_proofs.Prover` proves the path.
    """
    return SimpleMoves(linkage, margin).run(Budget(MAX_MOVE_STATES)) if linkage.loops else None


MAX_JUNCTION_LOOP_HINGES = 36
"""Greatest number of hinges in a loop whose junctions are listed: there are 2^18 products of each half."""
MAX_JUNCTION_COUNT = 20_000
"""Greatest number of junctions that are listed."""
EQUAL_POSE_TOLERANCE = 1e-9
"""Greatest difference of entries of equal poses, lengths over the pattern's size; rounding is 1e-14."""


@dataclass(frozen=True, eq=False)
class Junctions(ByValue):
    """Flat-folded closed states, sorted by their hinges as binary numbers.

    states : (k, n_hinges), rad, entries 0 and pi. complete : whether these are all; else a loop has more than
    `MAX_JUNCTION_LOOP_HINGES` hinges, or there are more than `MAX_JUNCTION_COUNT`.
    """

    states: Reals
    complete: bool


def junctions_of(linkage: Linkage) -> Junctions:
    """Return all flat-folded closed states of a linkage, including packed and flat."""
    known, complete = np.zeros((1, linkage.n_hinges), bool), True
    listed: set[int] = set()
    for walk in linkage.loops:
        if len(walk) > MAX_JUNCTION_LOOP_HINGES:
            return Junctions(np.zeros((0, linkage.n_hinges)), False)
        loop_states, loop_complete = _closed(linkage, walk)
        hinges = [hinge for hinge, _ in walk]
        shared = [k for k, hinge in enumerate(hinges) if hinge in listed]
        listed.update(hinges)
        known_rows, loop_rows, pairs_complete = _matched(
            _numbers(known[:, [hinges[k] for k in shared]]), _numbers(loop_states[:, shared])
        )
        known = known[known_rows]
        known[:, hinges] = loop_states[loop_rows]
        complete = complete and loop_complete and pairs_complete
    for hinge in set(range(linkage.n_hinges)) - listed:  # in no loop: it turns freely
        turned = known.copy()
        turned[:, hinge] = True
        known = np.concatenate([known, turned])[:MAX_JUNCTION_COUNT]
        complete = complete and 2 * len(turned) <= MAX_JUNCTION_COUNT
    return Junctions(math.pi * known[np.lexsort(known.T[::-1])], complete)


def clear_junctions(linkage: Linkage, space: Space, stack: StateStack) -> Reals:
    """Return the junctions other than packed and flat at which all pairs of a space keep apart, shape (k, n_hinges)."""
    states = junctions_of(linkage).states
    inner = states.any(axis=1) & (states != space.folded).any(axis=1)
    return np.array(
        [state for state in states[inner] if place_state(space, state, space.min_gap, pick_state(stack, 0))], float
    ).reshape(-1, linkage.n_hinges)


def _closed(linkage: Linkage, walk: Walk) -> tuple[Flags, bool]:
    """Closed hinges of a loop, a row for each state in which the loop closes; and whether the list is complete."""
    hinges = [hinge for hinge, _ in walk]
    turns = _half_turns(linkage.directions[hinges], linkage.points[hinges] / linkage.pattern.size)
    middle = len(hinges) // 2
    # half turns are their own inverses: the second half, backwards, is the product of its turns from the last on
    first_products = _products(turns[:middle])
    second_products = _products(turns[: middle - 1 : -1] if middle else turns[::-1])
    first, second, fits = _matched(*_matching_entries(first_products, second_products))
    same = np.abs(first_products[first] - second_products[second]).max(axis=(1, 2), initial=0.0) <= EQUAL_POSE_TOLERANCE
    bits = [_bits(first[same], middle), _bits(second[same], len(hinges) - middle)[:, ::-1]]
    return np.concatenate(bits, axis=1), fits


def _half_turns(directions: Reals, points: Reals) -> Reals:
    """Half turns about lines, shape (k, 4, 4): x -> 2 u (u . x) - x, about a point of the line."""
    turns = np.zeros((len(directions), 4, 4))
    turns[:, :3, :3] = 2.0 * directions[:, :, None] * directions[:, None] - np.eye(3)
    turns[:, :3, 3] = points - np.einsum("kij,kj->ki", turns[:, :3, :3], points)
    turns[:, 3, 3] = 1.0
    return turns


def _products(turns: Reals) -> Reals:
    """Products of all subsets of turns, in order, shape (2^k, 4, 4); turn j is in subset i where bit j of i is 1."""
    products = np.eye(4)[None]
    for turn in turns:
        products = np.concatenate([products, products @ turn])
    return products


def _bits(numbers: WholeNumbers, count: int) -> Flags:
    """The lowest bits of numbers, shape (k, count), the lowest first."""
    bits: Flags = (numbers[:, None] >> np.arange(count)) & 1 == 1
    return bits


def _numbers(bits: Flags) -> WholeNumbers:
    """Rows of up to `MAX_JUNCTION_LOOP_HINGES` bits, the lowest first, as numbers."""
    numbers: WholeNumbers = bits @ (1 << np.arange(bits.shape[1]))
    return numbers


def _matching_entries(first: Reals, second: Reals) -> tuple[WholeNumbers, WholeNumbers]:
    """A number for each pose of two lists: the same where poses are equal, and seldom where they are not.

    Poses are sorted by one weighted sum of their entries; a new number begins where the next sum differs by more than
    rounding.
    """
    weights = np.random.default_rng(0).uniform(0.5, 1.0, 12)
    sums = np.concatenate([first, second])[:, :3].reshape(-1, 12) @ weights
    order = np.argsort(sums, kind="stable")
    numbers = np.empty(len(sums), np.int64)
    numbers[order] = np.cumsum(np.diff(sums[order], prepend=sums[order[0]]) > 12.0 * EQUAL_POSE_TOLERANCE)
    return numbers[: len(first)], numbers[len(first) :]


def _matched(left_numbers: WholeNumbers, right_numbers: WholeNumbers) -> tuple[WholeNumbers, WholeNumbers, bool]:
    """Indices of equal numbers in two lists, all pairs or the first `MAX_JUNCTION_COUNT`; and whether these are all."""
    order = np.argsort(right_numbers, kind="stable")
    low, high = (np.searchsorted(right_numbers[order], left_numbers, side) for side in ("left", "right"))
    ends = np.cumsum(high - low)
    total = int(ends[-1]) if len(ends) else 0
    pairs = np.arange(min(total, MAX_JUNCTION_COUNT))
    first = np.searchsorted(ends, pairs, "right")
    return first, order[low[first] + pairs - (ends - high + low)[first]], total <= MAX_JUNCTION_COUNT
