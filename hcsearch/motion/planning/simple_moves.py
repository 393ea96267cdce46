"""Paths of simple moves: between flat-folded states, one after the other, few hinges turn about parallel lines.

A flat-folded state has every hinge at a stop, and all loops closed. In a simple move two hinges on one line turn, and
what lies between them turns as one body; or 4, 6 or 8 on one line do, as many of them either way; or four parallel
hinges, a plane linkage of one freedom. All others stay at their stops. Each moving hinge goes from stop to stop. States
of such a path are found exactly or by Newton's method in the plane, and `proofs` proves each move as a stretch.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator
from itertools import combinations

import numpy as np

from hcsearch.basics.arrays import Reals
from hcsearch.kernels.collision.overlaps import deepest_overlap
from hcsearch.motion.collision.prisms import prisms_of
from hcsearch.motion.collision.solids import kept_apart, solid_pairs
from hcsearch.motion.locks.lattice import whole_end
from hcsearch.motion.planning.groups import turns_equally
from hcsearch.shape.linkage import Linkage

MAX_MOVE_STATES = 400
"""Flat-folded states that are looked at, at most."""
MOVE_STEP_TURN = 0.1
"""Turn of the fastest hinge between two states of a move (rad)."""
MOVE_CLOSURE_TOLERANCE = 1e-9
"""Closure residual of states that are closed, and difference of lines that are one."""
MAX_MOVE_CANDIDATES = 20000
"""Sets of hinges that are tried, at most: those of a large array are too many."""
MIN_LEAVING_RATE = 1e-6
"""A hinge that leaves its stop no faster than this, over all of them, stays there."""
COLLINEAR_HINGE_COUNTS = (2, 4, 6, 8)
"""Hinges on one line that turn together."""


class SimpleMoves:
    """Simple moves of one linkage with panels shrunk by a margin (m) on every face."""

    def __init__(self, linkage: Linkage, margin: float) -> None:
        self.linkage, self.left = linkage, MAX_MOVE_CANDIDATES
        self.prisms = prisms_of(linkage, margin)
        pairs = solid_pairs(linkage, prisms_of(linkage), kept_apart(linkage))
        self.pairs = np.ascontiguousarray(pairs.prisms)

    def path(self) -> Reals | None:
        """The states of a path from packed to flat, (k, n_hinges), by the fewest moves; None without one."""
        if not self.linkage.loops:
            return None
        first, last = _key(self.linkage.folded.astype(float)), _key(self.linkage.flat)
        before: dict[bytes, tuple[bytes, Reals] | None] = {first: None}
        waiting = deque([self.linkage.folded.astype(float)])
        while waiting and last not in before and len(before) < MAX_MOVE_STATES:
            state = waiting.popleft()
            for move in self._moves(state, before):
                before[_key(move[-1])] = (_key(state), move)
                waiting.append(move[-1])
        if last not in before:
            return None
        moves: list[Reals] = []
        own = before[last]
        while own is not None:
            moves.append(own[1])
            own = before[own[0]]
        return np.concatenate([self.linkage.folded[None], *(move[1:] for move in moves[::-1])])

    def _moves(self, state: Reals, known: dict[bytes, tuple[bytes, Reals] | None]) -> Iterator[Reals]:
        """The states of each simple move from a flat-folded state to one that is not known, in turn."""
        _, jacobian = self.linkage.closure(state)
        leaving = jacobian * np.where(state > 1.0, -1.0, 1.0)
        whole = whole_end(self.linkage, state)
        if whole is None:
            return
        for hinges in _candidates(leaving):
            if self.left <= 0:
                return
            self.left -= 1
            end = state.copy()
            end[hinges] = math.pi - end[hinges]
            if _key(end) in known or np.abs(self.linkage.closure(end)[0]).max() > MOVE_CLOSURE_TOLERANCE:
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
        """The closed states of a move; None where some hinge turns back, or does not come to its stop.

        rates : of the hinges as they leave their stops, or None where all turn by the same angle.
        """
        if rates is None:
            return state + np.linspace(0.0, 1.0, math.ceil(math.pi / MOVE_STEP_TURN) + 1)[:, None] * (end - state)
        sense = np.sign(end - state)[hinges]
        own, way, states = state.copy(), rates / rates.max() * sense, [state]
        for _ in range(math.ceil(4.0 * math.pi / MOVE_STEP_TURN)):
            before = own.copy()
            own[hinges] += MOVE_STEP_TURN * way / np.abs(way).max()
            if (
                np.abs(own[hinges] - end[hinges]).max() < 1.5 * MOVE_STEP_TURN
                or (sense * (own - end)[hinges]).max() > 0.0
            ):
                near = np.abs(before - end)[hinges].max() < 3.0 * MOVE_STEP_TURN
                return np.array([*states, end]) if near else None
            for _ in range(20):
                residual, jacobian = self.linkage.closure(own)
                if np.abs(residual).max() < 1e-13:
                    break
                own[hinges] -= np.linalg.lstsq(jacobian[:, hinges], residual, rcond=1e-9)[0]
            way = (own - before)[hinges]
            if np.abs(self.linkage.closure(own)[0]).max() > MOVE_CLOSURE_TOLERANCE or (sense * way).min() <= 0.0:
                return None
            states.append(own.copy())
        return None

    def _apart(self, states: Reals) -> bool:
        """Whether panels keep apart in all states, as they are shrunk."""
        return not deepest_overlap(self.linkage.chain, self.prisms, self.pairs, np.ascontiguousarray(states))


def _key(state: Reals) -> bytes:
    """Which hinges of a flat-folded state are closed."""
    return (state > 1.0).tobytes()


def _candidates(leaving: Reals) -> Iterator[list[int]]:
    """Hinges of possible simple moves, few first.

    leaving : (n_rows, n_hinges), screws in the sense in which hinges leave their stops.
    """
    parallel = _alike(leaving, [k for k in range(len(leaving)) if k % 6 < 3])
    lines = [line for group in parallel for line in _lines(leaving, group)]
    for count in COLLINEAR_HINGE_COUNTS:
        for ahead, back in lines:
            for some in combinations(ahead, count // 2):
                for others in combinations(back, count // 2):
                    yield sorted([*some, *others])
        if count == 2:
            for group in parallel:
                yield from map(list, combinations(group, 4))


def _rates(leaving: Reals) -> Reals | None:
    """How fast four parallel hinges leave their stops; None where there is no one way, or one of them does not.

    leaving : (n_rows, 4), their screws in the sense in which they do.
    """
    if leaving.shape[1] != 4:
        return None
    _, values, ways = np.linalg.svd(leaving)
    rates: Reals = ways[3] * (1.0 if ways[3].sum() > 0.0 else -1.0)
    return rates if int((values > MOVE_CLOSURE_TOLERANCE).sum()) == 3 and rates.min() > MIN_LEAVING_RATE else None


def _alike(leaving: Reals, rows: list[int]) -> list[list[int]]:
    """Hinges whose screws have the same entries in some rows, but for the sense."""
    groups: list[list[int]] = []
    for h in range(leaving.shape[1]):
        for group in groups:
            one, two = leaving[rows, group[0]], leaving[rows, h]
            if min(np.abs(one - two).max(), np.abs(one + two).max()) < MOVE_CLOSURE_TOLERANCE:
                group.append(h)
                break
        else:
            groups.append([h])
    return groups


def _lines(leaving: Reals, group: list[int]) -> list[tuple[list[int], list[int]]]:
    """Hinges that lie on each line, as they leave their stops the one way and the other."""
    lines: list[tuple[list[int], list[int]]] = []
    for own in _alike(leaving[:, group], list(range(len(leaving)))):
        hinges = [group[k] for k in own]
        ahead = [h for h in hinges if leaving[:, h] @ leaving[:, hinges[0]] > 0.0]
        lines.append((ahead, [h for h in hinges if h not in ahead]))
    return lines


def simple_path(linkage: Linkage, margin: float) -> Reals | None:
    """The states of a path of simple moves, (k, n_hinges), from packed to flat; None where there is none.

    margin : m, by which panels are shrunk. The gaps are those at the states: `proofs.Prover` proves the path.
    """
    return SimpleMoves(linkage, margin).path()
