"""Check a certificate of a lock by independent arithmetic: `python lock_checker.py FILE`.

A lock states that no motion with closed loops and hinges between their stops leaves a set of boxes of fold angles, in
which the packed or the flat state lies and the other one does not. Every face by which the set could be left is proved
here to hold no closed state, by branch and bound. This file needs NumPy, `balls.py` and `certificate_grammar.py` beside
it, and imports nothing else of hcsearch. Numbers in brackets are those of docs/explanation/certificates.md.
"""

from fractions import Fraction
from functools import cache
from math import pi
from typing import Any

import numpy as np

if __package__:
    from hcsearch.motion.certificates import balls
    from hcsearch.motion.certificates import certificate_grammar as grammar
else:  # a program by itself, in one folder with the others
    import balls  # type: ignore[import-not-found, no-redef]
    import certificate_grammar as grammar  # type: ignore[import-not-found, no-redef]

Reals = np.ndarray[Any, np.dtype[np.float64]]
EPS, up = balls.EPS, balls.up
BATCH, CELLS, MOST_CELLS = 256, 2**18, 2**20  # boxes at once; entries of expansions, at once and of one box
HINGES, BOXES, PARTS = 200, 100_000, 1_000_000  # limits of the format, and of the parts of faces
ANGLES = 4_000_000  # parts of faces times hinges, at most
FEWEST, FACTOR, MOST = 20_000, 6, 10**8  # boxes that are tried: FEWEST + FACTOR min(stated, MOST)
NARROW = 1e-6  # a box that is no wider (rad) is not split
SWEEPS, GAIN, WIDE = 3, 0.1, 0.2  # how often, and for which gain, a box is contracted again; sides that may be split


class Array:
    """Panels and hinges in the flat state; lengths are divided by a size, which is a power of 2."""

    def __init__(self, data: Any) -> None:
        self.data = own = grammar.ArrayData(data)
        grammar.formed(0 < len(own.hinges) <= HINGES, f"a lock has not from 1 to {HINGES} hinges")
        self.panel_of, self.ends = own.panel_of, [[hinge.one, hinge.two] for hinge in own.hinges]
        points = np.array([[*hinge.p, own.height if hinge.top else 0] for hinge in own.hinges])
        ways = np.array([np.subtract(hinge.p, hinge.q) * (1 if hinge.top else -1) for hinge in own.hinges])
        largest = max(own.height, *(abs(x) for facet in own.facets for corner in facet for x in corner))
        self.size = 2.0 ** largest.bit_length()  # no coordinate is above sqrt(root)
        self.places = balls.lattice(points / self.size, own.root)
        self.axes = balls.directions(balls.lattice(np.insert(ways, 2, 0, 1), own.root))  # they close the hinge's face
        self.facets = [np.array(facet) * np.sqrt([float(own.root), 1.0]) / self.size for facet in own.facets]
        self.height, self.unit = own.height / self.size, own.unit
        self.packed = np.array([hinge.closes for hinge in own.hinges])
        way, loops = ways_from(0, self.ends), []
        grammar.formed(set(way) == set(self.panel_of), "the panels are not joined to one piece")
        for k in sorted(set(range(len(self.ends))) - {k for steps in way.values() for k, _ in steps}):
            start, back = (way[panel] for panel in self.ends[k])
            same = sum(a == b for a, b in zip(start, back, strict=False))  # ways from panel 0 part once
            loops.append([*start[same:], (k, 1), *((h, -sense) for h, sense in reversed(back[same:]))])
            grammar.formed(len(loops[-1]) > 1, "a hinge joins a panel to itself")
        grammar.need(loops, "no loop is closed by the hinges")
        terms = len(self.ends) + sum(len(steps) * (len(steps) + 1) // 2 for steps in loops)
        self.cells = 12 * len(loops) * terms
        grammar.formed(self.cells <= MOST_CELLS, "the loops of a lock have too many hinges")
        for steps in loops:
            grammar.need(is_closed([own.hinges[k] for k, _ in steps], own), "its packed state is not closed")
        self.loops = [Loop(steps, self.places, self.axes) for steps in loops]


def half_turn(hinge: Any, own: grammar.ArrayData) -> tuple[Any, Any]:
    """Return the exact rotation and shift by half a turn about a hinge of the flat state: 2 u (u.v) / u.u - v for v."""
    point, way = np.array([*hinge.p, own.height if hinge.top else 0]), np.subtract([*hinge.q, 0], [*hinge.p, 0])
    along = way * [own.root, 1, 1]
    half = 2 * np.outer(way, along) * Fraction(1, int(along @ way)) - np.eye(3, dtype=int)
    return half, point - half @ point


def is_closed(hinges: Any, own: grammar.ArrayData) -> bool:
    """Whether a loop is exactly closed where its hinges that close are folded flat, by half a turn each."""
    still = np.eye(3, dtype=int) * Fraction(1)
    turn, shift = still, 0 * still[0]
    for hinge in hinges:
        if hinge.closes:
            half, moved = half_turn(hinge, own)
            turn, shift = turn @ half, shift + turn @ moved
    return bool((turn == still).all() and not shift.any())


def ways_from(start: int, ends: Any, without: Any = ()) -> dict[int, Any]:
    """Shortest paths from a panel to all others that avoid some hinges, as hinges and senses (breadth-first)."""
    ways: dict[int, Any] = {start: []}
    for panel in (waiting := [start]):
        for k, (first, second) in enumerate(ends):
            for here, there, sense in ((first, second, 1), (second, first, -1)):
                if here == panel and there not in ways and k not in without:
                    ways[there] = [*ways[here], (k, sense)]
                    waiting.append(there)
    return ways


@cache
def pairs_of(n: int) -> tuple[Any, Any]:
    """The numbers of all pairs of n hinges, computed once for each n."""
    return np.triu_indices(n, 1)


class Loop:
    """A loop, cut into two halves that lead from its first panel to the same one, and expanded to second order."""

    def __init__(self, steps: Any, points: Any, ways: Any) -> None:
        self.hinges = np.array([hinge for hinge, _ in steps])
        self.ways = ways[self.hinges] * np.array([float(sense) for _, sense in steps])
        self.centre = points.mid[self.hinges].mean(0)
        self.points = points[self.hinges] - balls.exact(self.centre[:, 0])
        self.pairs = pairs_of(len(steps))

    def walk(self, angles: Reals, back: bool) -> tuple[Any, Any, Any, Any]:
        """Return axes and places of all hinges on a way, (count, n), and the poses before, between and behind them.

        back : the way goes backwards, from the last hinge, so that pose k + 1 is the one before hinge k.
        """
        count, n = angles.shape
        turns = balls.rotations(self.ways, angles)
        turns = turns.transposed if back else turns
        turn = balls.Ball(np.tile(np.eye(3), (count, 1, 1)), np.zeros(count), np.ones(count))
        shift = balls.exact(np.zeros((count, 3)))
        axes, places, poses = [], [], [(turn, shift)]
        for k in range(n)[::-1] if back else range(n):
            axes.append(turn @ self.ways[k])
            places.append(turn @ self.points[k] + shift)
            turn = turn @ turns[:, k]
            shift = places[-1] - turn @ self.points[k]
            poses.append((turn, shift))
        parts = (axes, places, *map(list, zip(*poses, strict=True)))
        return tuple(balls.stacked(part[::-1] if back else part, 1) for part in parts)  # type: ignore[return-value]

    def expanded(self, middles: Reals, radii: Reals) -> tuple[Reals, ...]:
        """Return values (count, 12), slopes (count, 12, n), squares and products times radii, and bounds [11]."""
        angles, e = middles[:, self.hinges], radii[:, self.hinges]
        n, before, boxes = e.shape[1], np.cumsum(e, 1) - e, np.arange(len(e))
        cut = 1 + np.abs(2.0 * before[:, 1:] - e.sum(1, keepdims=True)).argmin(1)
        first = np.arange(n) < cut[:, None]
        ahead, behind = self.walk(angles, back=False), self.walk(angles, back=True)
        axes, places = (balls.chosen(first, *own) for own in zip(ahead[:2], behind[:2], strict=True))
        (turn, shift), (other, offset) = ([own[boxes, cut] for own in way[2:]] for way in (ahead, behind))
        here, there = turn @ self.points[cut] + shift, other @ self.points[cut] + offset
        between, apart = other @ turn.transposed, here - there
        target = balls.chosen(first, here[:, None], there[:, None])
        cross = balls.crossed(axes)
        levers = cross @ (target - places)
        still = balls.Ball(np.eye(3), 0.0, 1.0)
        beyond = balls.chosen(first, still, between[:, None])
        steps, (p, q) = cross @ beyond, self.pairs
        # K_p K_q of the first half, and K_q K_p of the second one, which goes backwards, with the other sign
        front, back = first[:, q], ~first[:, p]
        lead, sign = balls.chosen(front, cross[:, p], cross[:, q]), np.where(front, 1.0, -1.0)
        bends, moved = (balls.chosen(front, x[:, q], x[:, p]) for x in (steps, levers))
        weights = (front | back) * sign * e[:, p] * e[:, q]
        bends, moved = lead @ bends * weights, lead @ moved * weights
        weights = np.where(first, 0.25, -0.25) * e**2
        squares, lifted = cross @ steps * weights, cross @ levers * weights
        values = np.concatenate([(np.eye(3) - between.mid).reshape(-1, 9), apart.mid[..., 0]], 1)
        slopes = np.concatenate([steps.mid.reshape(len(e), n, 9), levers.mid[..., 0]], 2)
        turning = np.concatenate([bends.mid, squares.mid], 1).reshape(len(e), -1, 9)
        bent = np.concatenate([turning, np.concatenate([moved.mid, lifted.mid], 1)[..., 0]], 2)
        values += bent[:, -n:].sum(1)  # the square of an angle lies between 0 and its greatest value
        turned, shifted = self.rests(first, e, levers.length)
        errors = [  # of each entry; squares count twice: once as added, once as unknown
            up(value.rad + (e * slope.rad).sum(1) + bend.rad.sum(1) + 2.0 * square.rad.sum(1), n * n + 9)
            for value, slope, bend, square in ((between, steps, bends, squares), (apart, levers, moved, lifted))
        ]
        return values, np.swapaxes(slopes, 1, 2), np.swapaxes(bent, 1, 2), turned, shifted, *errors

    def seen(self, points: Any, middles: Reals) -> tuple[Any, Any, Any]:
        """Return axes and places of hinges, and points behind the last hinge, in the frame before the first one."""
        axes, places, turns, shifts = self.walk(middles[:, self.hinges], back=False)
        centre = balls.exact(self.centre[:, 0])
        return axes, places + centre, turns[:, -1:] @ (points - centre) + shifts[:, -1:] + centre

    def rests(self, first: Any, e: Reals, reach: Reals) -> tuple[Reals, Reals]:
        """Return bounds of the third-order terms of the rotation and of the place; reach : lengths of levers."""
        turned = shifted = np.zeros(len(e))
        n = e.shape[1]
        for own, order in ((first, range(n)), (~first, range(n)[::-1])):
            wide, far, total, cubes = e * own, np.zeros_like(e), np.zeros(len(e)), np.zeros(len(e))
            for k in reversed(order):
                far[:, k] = reach[:, k] * own[:, k] + total
                total = total + wide[:, k] * far[:, k]
            total = np.zeros(len(e))
            for k in order:
                new = total + wide[:, k]
                cubes, total = cubes + far[:, k] * wide[:, k] * (new**2 + new * total + total**2), new
            turned, shifted = turned + total**3 / 6, shifted + cubes / 6
        return up(turned, 9 * n), up(shifted, 9 * n)


class Equations:
    """The closure of all loops in boxes, expanded to second order, and combinations of its equations."""

    def __init__(self, loops: list[Loop], middles: Reals, radii: Reals) -> None:
        (count, n), rows = middles.shape, 12 * len(loops)
        self.values, self.slopes, parts, owners = np.zeros((count, rows)), np.zeros((count, rows, n)), [], []
        self.rests, self.errors = np.zeros((count, rows)), np.zeros((count, rows))
        self.middles, self.radii = middles, radii
        for k, loop in enumerate(loops):
            own, one = slice(12 * k, 12 * k + 12), np.eye(n)[loop.hinges]
            values, slopes, bend, *unknown = loop.expanded(middles, radii)
            self.values[:, own], self.slopes[:, own, loop.hinges] = values, slopes
            parts.append(np.pad(bend, ((0, 0), (12 * k, rows - 12 * k - 12), (0, 0))))
            turned, shifted, turn_error, shift_error = (x[:, None] for x in unknown)
            self.rests[:, own] = np.where(np.arange(12) < 9, up(np.sqrt(2.0) * turned, 2), shifted)
            self.errors[:, own] = np.where(np.arange(12) < 9, turn_error, shift_error)
            owners += [one[loop.pairs[0]] + one[loop.pairs[1]], 2.0 * one]  # hinges whose product a column holds
        self.bends, self.owners = np.concatenate(parts, 2), np.concatenate(owners)
        moves, bent = np.abs(self.slopes) @ radii[..., None], np.abs(self.bends).sum(2)
        self.steps = rows + 2 * self.bends.shape[2] + n + 20  # operations of a combination, with roundings
        self.errors = up(self.errors + self.steps * EPS * (np.abs(self.values) + moves[..., 0] + bent), self.steps)
        columns = np.concatenate([self.slopes * radii[:, None], self.bends], 2)
        gram = columns @ np.swapaxes(columns, 1, 2) + np.eye(rows) * (self.rests**2)[:, None]
        self.gram = gram + np.eye(rows) * (1e-12 * np.trace(gram, axis1=1, axis2=2) + 1e-300)[:, None, None]

    def combined(self, mixes: Reals) -> tuple[Reals, ...]:
        """Return values, slopes and bends of combinations, (count, m, rows), and bounds of their unknown parts [12]."""
        value, slope = (mixes @ self.values[..., None])[..., 0], mixes @ self.slopes
        bent = np.abs(mixes @ self.bends)
        unknown = bent.sum(2) + (np.abs(mixes) @ self.errors[..., None])[..., 0]
        for k in range(0, mixes.shape[2], 12):  # norms of combined entries of a matrix, and of a vector
            for part in (slice(k, k + 9), slice(k + 9, k + 12)):
                unknown += balls.norms(mixes[..., part]) * self.rests[:, None, part.start]
        return value, slope, bent, up(unknown, self.steps), up(np.abs(slope) * self.radii[:, None], 1)


def centred(low: Reals, high: Reals) -> tuple[Reals, Reals]:
    """Return middles and radii of boxes; middles are rounded by less than 1e-15, as angles are below 4."""
    return 0.5 * (low + high), 0.5 * (high - low) * (1 + 1e-15) + 1e-15


def contracted(loops: list[Loop], low: Reals, high: Reals) -> tuple[Reals, Reals, Any, Any]:
    """Contract boxes onto their closed states; return them, which ones are not empty, and the sides to split [12]."""
    own = Equations(loops, *centred(low, high))
    right = np.concatenate([own.values[..., None], own.slopes], 2)
    mixes = np.swapaxes(np.linalg.solve(own.gram, right), 1, 2)
    mixes /= np.abs(mixes).max(2, keepdims=True) + 1e-300
    value, slope, bent, unknown, moves = own.combined(mixes)
    total, steps = up(unknown + moves.sum(2), low.shape[1] + 1), low.shape[1] + 4
    left = ~(np.abs(value) > total).any(1)
    far = total[..., None] * (1 + steps * EPS) - moves  # bounds the contribution of all other hinges
    bounds = np.stack([-value[..., None] - far, -value[..., None] + far]) / slope
    slack = 8 * EPS * (np.abs(bounds) + (np.abs(value) + total)[..., None] / np.abs(slope) + 4.0)
    known, middles = np.abs(slope) > 1e-9, own.middles[:, None]
    least = np.where(known, (bounds - slack).min(0) + middles, -np.inf).max(1)
    most = np.where(known, (bounds + slack).max(0) + middles, np.inf).min(1)
    least, most = np.maximum(low, least), np.minimum(high, most)
    left &= ~(least > most).any(1)
    shares = moves[:, 0] + (bent[:, :1] @ own.owners)[:, 0]
    return least, most, left, shares


def check_empty(array: Array, low: Reals, high: Reals, limit: int, clock: grammar.Clock, overlap: Any) -> int:
    """Refuse faces, (count, n) each, that `limit` boxes do not prove to be empty; return the number of boxes used.

    overlap : a function that proves overlaps of panels in boxes and names the sides to split others by; or None.
    """
    swept, tried, batch = np.zeros(len(low), int), 0, max(1, min(BATCH, CELLS // array.cells))
    while len(low):
        clock.check()
        below, above, sweeps = low[-batch:], high[-batch:], swept[-batch:]
        low, high, swept = low[:-batch], high[:-batch], swept[:-batch]
        tried += len(below)
        grammar.need(tried <= limit, "a face of its boxes is not proved to hold no closed state")
        least, most, left, shares = contracted(array.loops, below, above)
        gain = 1.0 - (most - least).sum(1) / np.maximum((above - below).sum(1), 1e-300)
        again = left & (gain > GAIN) & (sweeps + 1 < SWEEPS)
        split = left & ~again
        if overlap and (own := np.flatnonzero(split)).size:
            proved, hidden = overlap(Equations(array.loops, *centred(least[own], most[own])))
            split[own] = ~proved
            shares[own] = np.where(hidden.any(1, keepdims=True), hidden, shares[own])
        widths = np.where(left[:, None], most - least, 0.0)
        shares[widths < WIDE * widths.max(1, keepdims=True)] = -1.0
        pick, side = np.arange(len(least)), shares.argmax(1)
        narrow = split & ((most - least).max(1) < NARROW)
        grammar.need(not narrow.any(), "a face of its boxes holds what may be a closed state")
        middle = 0.5 * (least[pick, side] + most[pick, side])
        upper, lower = least.copy(), most.copy()
        upper[pick, side], lower[pick, side] = middle, middle
        low = np.concatenate([low, least[again], least[split], upper[split]])
        high = np.concatenate([high, most[again], lower[split], most[split]])
        swept = np.concatenate([swept, sweeps[again] + 1, np.zeros(2 * split.sum(), int)])
    return tried


def faces_of(low: Any, high: Any, tops: Any, clock: grammar.Clock) -> tuple[Any, Any]:
    """Return the faces of boxes that no other box covers [9]: lows and highs, (count, n) each, as numbers of cuts."""
    below, above = list[Any](), list[Any]()
    n = low.shape[1]
    most = min(PARTS, ANGLES // n)
    over = f"the faces of its boxes have more than {most} parts"
    for h in range(n):
        for value, at in ((low[:, h], 0), (high[:, h], 1)):
            for level in np.unique(value[(value > 0) & (value < tops[h])]):
                beyond = (low[:, h] <= level) & (level <= high[:, h]) & ((high if at else low)[:, h] != level)
                others, rest = np.flatnonzero(beyond), np.arange(n) != h
                their_low, their_high = low[others][:, rest], high[others][:, rest]
                for k in np.flatnonzero(value == level):
                    parts = [(low[k, rest], high[k, rest])]
                    met = ((their_low < parts[0][1]) & (their_high > parts[0][0])).all(1)
                    for a, b in zip(their_low[met], their_high[met], strict=True):
                        parts, whole = [], parts
                        for part in whole:
                            clock.check()
                            parts += outside(*part, a, b)
                            grammar.formed(len(below) + len(parts) <= most, over)
                    clock.check()
                    grammar.formed(len(below) + len(parts) <= most, over)
                    for a, b in parts:
                        below.append(np.insert(a, h, level))
                        above.append(np.insert(b, h, level))
    return np.array(below).reshape(-1, n), np.array(above).reshape(-1, n)


def outside(low: Any, high: Any, other_low: Any, other_high: Any) -> list[tuple[Any, Any]]:
    """Return the parts of a box that another one does not cover."""
    if not ((other_low < high) & (other_high > low)).all():
        return [(low, high)]
    parts, low, high = [], low.copy(), high.copy()
    for k in range(len(low)):
        for bound, side in ((other_low[k], 0), (other_high[k], 1)):
            if low[k] < bound < high[k]:
                a, b = low.copy(), high.copy()
                (a if side else b)[k] = bound
                parts.append((a, b))
                (high if side else low)[k] = bound
    return parts


def boxes_of(claim: Any, count: int) -> tuple[list[Reals], Any, Any]:
    """Return the cuts of each hinge, from 0 to above pi, and the boxes of a claim as indices into them."""
    cuts = [[grammar.real(cut, "a cut") for cut in own] for own in grammar.lists(claim, "cuts", count)]
    ascending = (own[0] == 0.0 and pi < own[-1] < 3.2 and sorted(set(own)) == own for own in cuts if own)
    grammar.formed(all(cuts) and all(ascending), "cuts do not ascend from 0 to above pi, and below 3.2")
    tables, tops = [grammar.lists(claim, key) for key in ("lows", "highs")], [len(own) - 1 for own in cuts]
    grammar.formed(0 < len(tables[0]) == len(tables[1]) <= BOXES, f"it has not from 1 to {BOXES} boxes")
    grammar.formed(all(len(row) == count for table in tables for row in table), "a box has not a bound for each hinge")
    low, high = (
        np.array([[grammar.whole(x, 0, top, "a bound") for x, top in zip(row, tops, strict=True)] for row in table])
        for table in tables
    )
    grammar.formed((low < high).all(), "a box is empty")
    return [np.array(own) for own in cuts], low, high


def check_lock(claim: Any, array: Array, clock: grammar.Clock, overlap: Any = None) -> str:
    """Check that no motion leaves a set of boxes [9, 10]; return the proved fact as a sentence."""
    cuts, low, high = boxes_of(claim, len(array.ends))
    end, tried = grammar.entry(claim, "end", str), grammar.whole(claim.get("tried"), 0, 10**12, "tried")
    grammar.formed(end in ("packed", "flat"), "its end is neither packed nor flat")
    tops = np.array([len(own) - 1 for own in cuts])
    # As points: 0 is the first cut. No double is pi, so that it lies between the first cut above it and the one before.
    above_pi = np.array([np.searchsorted(own, pi, "right") for own in cuts])
    states = {"packed": array.packed, "flat": np.zeros_like(array.packed)}
    holds = {
        name: np.where(at, (low < above_pi) & (above_pi <= high), low == 0).all(1).any() for name, at in states.items()
    }
    other = "flat" if end == "packed" else "packed"
    grammar.need(holds[end] and not holds[other], "the boxes do not hold the one end alone")
    below, above = faces_of(low, high, tops, clock)
    least, most = (np.stack([own[k] for own, k in zip(cuts, side.T, strict=True)], 1) for side in (below, above))
    check_empty(array, least, most, FEWEST + FACTOR * min(tried, MOST), clock, overlap)
    there = f"no motion leads from {end} to {other}"
    boxes = f"{len(low)} boxes" if len(low) > 1 else "one box"
    return f"{there}, or leaves {boxes} of fold angles: {len(below)} faces hold no closed state"


def check_kinematic_lock(claim: Any, clock: grammar.Clock) -> str:
    """Check a lock by closure alone; return the proved fact as a sentence."""
    return check_lock(claim, Array(claim.get("array")), clock)


def checked(claim: Any, clock: grammar.Clock | None = None) -> str:
    """Return the proved claim as a sentence; refuse a claim that is not proved, or not of the documented form."""
    return grammar.judged(claim, clock, check_kinematic_lock)


if __name__ == "__main__":
    grammar.main("lock", checked, __doc__)
