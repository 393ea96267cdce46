"""Check a certificate of a lock by independent arithmetic: `python lock_checker.py FILE`.

A lock states that no motion with closed loops and hinges between their stops leaves a set of boxes of fold angles, in
which the packed or the flat state lies and the other one does not. Every face by which the set could be left is proved
here to hold no closed state, by branch and bound. This file needs NumPy alone and imports nothing of hcsearch. Bounds
are widened by what rounding to doubles may add to them. Theory: docs/explanation/certificates.md.
"""

import json
import sys
from math import pi
from pathlib import Path
from typing import Any

import numpy as np

Reals = np.ndarray[Any, np.dtype[np.float64]]
ROUNDING = 1e-14  # of an equation, for each hinge, over 1 and the greatest distance; times what it is multiplied by
BATCH = 256
FEWEST, FACTOR, MOST = 20_000, 6, 10**8  # boxes that are tried: so many, and times what is stated up to the last one
NARROW = 1e-6  # a box that is no wider (rad) is not split
SWEEPS, GAIN, WIDE = 3, 0.1, 0.2  # how often, and for which gain, a box is contracted again; sides that may be split


class NotProvedError(Exception):
    """The certificate does not prove what it claims."""


def need(condition: Any, reason: str) -> None:
    """Refuse the certificate unless a condition holds."""
    if not condition:
        raise NotProvedError(reason)


class Array:
    """Panels and hinges in the flat state; lengths over a size."""

    def __init__(self, data: Any) -> None:
        facets, root, height = [np.array(facet) for facet in data["facets"]], data["root"], data["thickness"]
        whole = np.array([root, height, *(number for facet in facets for number in facet.flat)])
        need(whole.dtype == int and np.abs(whole / 1e6).max() < 1 and min(root, height) > 0, "a length is not whole")
        owned = sorted((facet, panel) for panel, own in enumerate(data["panels"]) for facet in own)
        need([facet for facet, _ in owned] == list(range(len(facets))), "a facet is not in one panel")
        self.panel_of, self.ends, points, ways = dict(owned), [], [], []
        for hinge in data["hinges"]:
            one, two = (list(zip(x, x[1:] + x[:1], strict=True)) for x in (facets[k].tolist() for k in hinge["facets"]))
            shared = [(p, q) for p, q in one if (q, p) in two]
            need(len(shared) == 1 and hinge["face"] in ("top", "bottom"), "a hinge is no edge that two facets share")
            (p, q), top = shared[0], hinge["face"] == "top"
            self.ends.append([self.panel_of[facet] for facet in hinge["facets"]])
            points.append([*p, height if top else 0])
            ways.append(np.subtract([*p, 0], [*q, 0]) * (1 if top else -1))  # positive angles close the hinge's face
        stretch = np.sqrt([root, 1.0, 1.0])
        places, axes = np.array(points) * stretch, np.array(ways) * stretch
        self.size = np.abs(places).max()
        self.places, self.axes = places / self.size, axes / np.linalg.norm(axes, axis=1, keepdims=True)
        self.facets = [facet * stretch[:2] / self.size for facet in facets]
        self.height, self.unit = height / self.size, data["unit"]
        way, self.loops = ways_from(0, self.ends), []
        for k in set(range(len(self.ends))) - {k for steps in way.values() for k, _ in steps}:
            start, back = (way[panel] for panel in self.ends[k])
            same = sum(a == b for a, b in zip(start, back, strict=False))  # ways from panel 0 part once
            steps = [*start[same:], (k, 1), *((h, -sense) for h, sense in reversed(back[same:]))]
            self.loops.append(Loop(steps, self.places, self.axes))
        need(self.loops, "no loop is closed by the hinges")


def ways_from(start: int, ends: Any, without: Any = ()) -> dict[int, Any]:
    """Shortest paths from a panel to each other one, as hinges and senses, without some hinges (breadth-first)."""
    ways: dict[int, Any] = {start: []}
    for panel in (waiting := [start]):
        for k, (first, second) in enumerate(ends):
            for here, there, sense in ((first, second, 1), (second, first, -1)):
                if here == panel and there not in ways and k not in without:
                    ways[there] = [*ways[here], (k, sense)]
                    waiting.append(there)
    return ways


class Loop:
    """A loop, cut into two halves that lead from its first panel to the same one, and expanded to second order."""

    def __init__(self, steps: Any, points: Reals, ways: Reals) -> None:
        self.hinges = np.array([hinge for hinge, _ in steps])
        self.ways = np.array([sense * ways[hinge] for hinge, sense in steps])
        self.centre = points[self.hinges].mean(0)
        self.points = points[self.hinges] - self.centre
        self.pairs = np.triu_indices(len(steps), 1)
        self.cross = crossed(self.ways)
        self.far = 1.0 + 2.0 * np.linalg.norm(self.points, axis=1).max() * 2.0

    def halves(self, angles: Reals, cut: Any) -> tuple[Reals, Reals, list[tuple[Reals, Reals]]]:
        """Return axes and places of all hinges in the frame of each half, and the pose at the end of each half."""
        count, n = angles.shape
        axes, places, ends = np.zeros((count, n, 3)), np.zeros((count, n, 3)), []
        turns = self.cross * np.sin(angles)[..., None, None]
        turns = turns + (self.cross @ self.cross) * (2.0 * np.sin(0.5 * angles) ** 2)[..., None, None] + np.eye(3)
        for order, own in ((range(n), np.arange(n) < cut[:, None]), (range(n)[::-1], np.arange(n) >= cut[:, None])):
            turn, shift = np.tile(np.eye(3), (count, 1, 1)), np.zeros((count, 3))
            for k in order:
                mine = own[:, k]
                way, place = turn @ self.ways[k], turn @ self.points[k] + shift
                axes[mine, k], places[mine, k] = way[mine], place[mine]
                step = turns[:, k] if order[0] == 0 else np.swapaxes(turns[:, k], 1, 2)
                step = np.where(mine[:, None, None], step, np.eye(3))
                shift = place - (turn @ step @ self.points[k])
                turn = turn @ step
            ends.append((turn, shift))
        return axes, places, ends

    def expanded(self, middles: Reals, radii: Reals) -> tuple[Reals, ...]:
        """Return values (count, 12), slopes (count, 12, n), squares and products times radii, and bounds."""
        angles, e = middles[:, self.hinges], radii[:, self.hinges]
        n, before = e.shape[1], np.cumsum(e, 1) - e
        cut = 1 + np.abs(2.0 * before[:, 1:] - e.sum(1, keepdims=True)).argmin(1)
        first = np.arange(n) < cut[:, None]
        axes, places, ((turn, shift), (other, offset)) = self.halves(angles, cut)
        middle = self.points[cut]
        here, there = (turn @ middle[..., None])[..., 0] + shift, (other @ middle[..., None])[..., 0] + offset
        between = other @ np.swapaxes(turn, 1, 2)
        levers = np.cross(axes, np.where(first[..., None], here[:, None], there[:, None]) - places)
        values = np.concatenate([(np.eye(3) - between).reshape(-1, 9), here - there], 1)
        matrices = np.where(first[..., None, None], np.eye(3), between[:, None])
        slopes = np.concatenate([(crossed(axes) @ matrices).reshape(len(e), n, 9), levers], 2)
        p, q = self.pairs
        a, b = axes[:, p], axes[:, q]
        # K_p K_q of the first half, and K_q K_p of the second one, which goes backwards, with the other sign
        front, back = first[:, q], ~first[:, p]
        inner, outer = (a * b).sum(2)[..., None, None] * np.eye(3), a[..., :, None] * b[..., None, :]
        bends = np.where(front[..., None, None], np.swapaxes(outer, 2, 3) - inner, (inner - outer) @ between[:, None])
        moved = np.where(front[..., None], np.cross(a, levers[:, q]), -np.cross(b, levers[:, p]))
        bends = np.concatenate([bends.reshape(*a.shape[:2], 9), moved], 2)
        bends *= ((front | back) * e[:, p] * e[:, q])[..., None]
        squares = (crossed(axes) @ crossed(axes) @ matrices).reshape(len(e), n, 9)
        squares = np.concatenate([squares, np.cross(axes, levers)], 2)
        squares *= (np.where(first, 0.25, -0.25) * e**2)[..., None]
        values += squares.sum(1)  # the square of an angle lies between 0 and its greatest value
        bends = np.concatenate([bends, squares], 1)
        turned, shifted = self.rests(first, e, np.linalg.norm(levers, axis=2))
        far = 1.0 + np.linalg.norm(levers, axis=2).max(1) + self.far
        total = e.sum(1)
        error = ROUNDING * n * far**2 * (1.0 + total + total**2)
        return values, np.swapaxes(slopes, 1, 2), np.swapaxes(bends, 1, 2), turned, shifted, error

    def seen(self, points: Reals, middles: Reals) -> tuple[Reals, Reals, Reals]:
        """Return axes and places of hinges, and points behind the last hinge, in the frame before the first one."""
        angles = middles[:, self.hinges]
        axes, places, ((turn, shift), _) = self.halves(angles, np.full(len(angles), angles.shape[1]))
        seen = (points - self.centre) @ np.swapaxes(turn, 1, 2) + shift[:, None] + self.centre
        return axes, places + self.centre, seen

    def rests(self, first: Any, e: Reals, reach: Reals) -> tuple[Reals, Reals]:
        """Return bounds of the third orders: of the rotation, and of the place."""
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
                cubes, total = cubes + far[:, k] * (new**3 - total**3), new
            turned, shifted = turned + total**3 / 6, shifted + cubes / 6
        return turned * (1 + 1e-12), shifted * (1 + 1e-12)


def crossed(vectors: Reals) -> Reals:
    """Return the matrices of cross products with vectors."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.stack([0 * x, -z, y, z, 0 * x, -x, -y, x, 0 * x], -1).reshape(*x.shape, 3, 3)


class Equations:
    """The closure of all loops in boxes, expanded to second order, and combinations of its equations."""

    def __init__(self, loops: list[Loop], middles: Reals, radii: Reals) -> None:
        (count, n), rows = middles.shape, 12 * len(loops)
        self.values, self.slopes, parts, owners = np.zeros((count, rows)), np.zeros((count, rows, n)), [], []
        self.rests, self.errors = np.zeros((count, rows)), np.zeros((count, rows))
        self.middles, self.radii = middles, radii
        for k, loop in enumerate(loops):
            own, one = slice(12 * k, 12 * k + 12), np.eye(n)[loop.hinges]
            values, slopes, bend, turned, shifted, error = loop.expanded(middles, radii)
            self.values[:, own], self.slopes[:, own, loop.hinges] = values, slopes
            parts.append(np.pad(bend, ((0, 0), (12 * k, rows - 12 * k - 12), (0, 0))))
            self.rests[:, own] = np.where(np.arange(12) < 9, np.sqrt(2.0) * turned[:, None], shifted[:, None])
            self.errors[:, own] = error[:, None]
            owners += [one[loop.pairs[0]] + one[loop.pairs[1]], 2.0 * one]  # hinges of which a column is the product
        self.bends, self.owners = np.concatenate(parts, 2), np.concatenate(owners)
        columns = np.concatenate([self.slopes * radii[:, None], self.bends], 2)
        gram = columns @ np.swapaxes(columns, 1, 2) + np.eye(rows) * (self.rests**2)[:, None]
        self.gram = gram + np.eye(rows) * (1e-12 * np.trace(gram, axis1=1, axis2=2) + 1e-300)[:, None, None]

    def combined(self, mixes: Reals) -> tuple[Reals, ...]:
        """Return values, slopes and bends of combinations, (count, m, rows), and their other unknown parts."""
        value, slope = (mixes @ self.values[..., None])[..., 0], mixes @ self.slopes
        bent = np.abs(mixes @ self.bends)
        unknown = bent.sum(2) + (np.abs(mixes) @ self.errors[..., None])[..., 0]
        for k in range(0, mixes.shape[2], 12):  # the norm of a combination of the entries of one matrix, of one vector
            for part in (slice(k, k + 9), slice(k + 9, k + 12)):
                unknown += np.linalg.norm(mixes[..., part], axis=2) * self.rests[:, None, part.start]
        moves = np.abs(slope) * self.radii[:, None]
        unknown += ROUNDING * (np.abs(value) + unknown + moves.sum(2))
        return value, slope, bent, unknown, moves


def centred(low: Reals, high: Reals) -> tuple[Reals, Reals]:
    """Return middles and radii of boxes."""
    return 0.5 * (low + high), 0.5 * (high - low) * (1 + 1e-15) + 1e-15


def contracted(loops: list[Loop], low: Reals, high: Reals) -> tuple[Reals, Reals, Any, Any]:
    """Contract boxes onto their closed states; return them, which ones are not empty, and the sides to split."""
    own = Equations(loops, *centred(low, high))
    right = np.concatenate([own.values[..., None], own.slopes], 2)
    mixes = np.swapaxes(np.linalg.solve(own.gram, right), 1, 2)
    mixes /= np.abs(mixes).max(2, keepdims=True) + 1e-300
    value, slope, bent, unknown, moves = own.combined(mixes)
    left = ~(np.abs(value) > unknown + moves.sum(2)).any(1)
    far = (unknown + moves.sum(2))[..., None] - moves
    bounds = np.stack([(-value[..., None] - far) / slope, (-value[..., None] + far) / slope])
    known = np.abs(slope) > 1e-9
    least = np.where(known, bounds.min(0), -np.inf).max(1) + own.middles - 1e-14
    most = np.where(known, bounds.max(0), np.inf).min(1) + own.middles + 1e-14
    least, most = np.maximum(low, least), np.minimum(high, most)
    left &= ~(least > most).any(1)
    shares = moves[:, 0] + (bent[:, :1] @ own.owners)[:, 0]
    return least, most, left, shares


def check_empty(loops: list[Loop], low: Reals, high: Reals, limit: int, overlap: Any) -> int:
    """Refuse faces, (count, n) each, not proved to be empty by so many boxes; return the number of boxes used.

    overlap : a function that proves overlaps of panels in boxes and names the sides to split others by; or None.
    """
    swept, tried = np.zeros(len(low), int), 0
    while len(low):
        below, above, sweeps = low[-BATCH:], high[-BATCH:], swept[-BATCH:]
        low, high, swept = low[:-BATCH], high[:-BATCH], swept[:-BATCH]
        tried += len(below)
        need(tried <= limit, "a face of its boxes is not proved to hold no closed state")
        least, most, left, shares = contracted(loops, below, above)
        gain = 1.0 - (most - least).sum(1) / np.maximum((above - below).sum(1), 1e-300)
        again = left & (gain > GAIN) & (sweeps + 1 < SWEEPS)
        split = left & ~again
        if overlap and (own := np.flatnonzero(split)).size:
            proved, hidden = overlap(Equations(loops, *centred(least[own], most[own])))
            split[own] = ~proved
            shares[own] = np.where(hidden.any(1, keepdims=True), hidden, shares[own])
        widths = np.where(left[:, None], most - least, 0.0)
        shares[widths < WIDE * widths.max(1, keepdims=True)] = -1.0
        pick, side = np.arange(len(least)), shares.argmax(1)
        narrow = split & ((most - least).max(1) < NARROW)
        need(not narrow.any(), "a face of its boxes holds what may be a closed state")
        middle = 0.5 * (least[pick, side] + most[pick, side])
        upper, lower = least.copy(), most.copy()
        upper[pick, side], lower[pick, side] = middle, middle
        low = np.concatenate([low, least[again], least[split], upper[split]])
        high = np.concatenate([high, most[again], lower[split], most[split]])
        swept = np.concatenate([swept, sweeps[again] + 1, np.zeros(2 * split.sum(), int)])
    return tried


def faces_of(low: Any, high: Any, tops: Any) -> tuple[Any, Any]:
    """Return the faces of boxes, (count, n) each in numbers of cuts, that no other box covers: lows and highs."""
    below, above = [], []
    n = low.shape[1]
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
                        parts = [piece for part in parts for piece in outside(*part, a, b)]
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


def check_lock(claim: Any, array: Array, overlap: Any = None) -> str:
    """Check that no motion leaves a set of boxes; return the proved fact as a sentence."""
    end, hinges = claim["end"], claim["array"]["hinges"]
    count = len(hinges)
    cuts, low, high = [np.array(own, float) for own in claim["cuts"]], np.array(claim["lows"]), np.array(claim["highs"])
    tops = np.array([len(own) - 1 for own in cuts])
    shapes = low.shape == high.shape == (len(low), count) == (len(low), len(cuts))
    need(shapes and low.dtype == high.dtype == int, "a box is none")
    need(all(own[0] == 0.0 and pi < own[-1] < 3.2 and (np.diff(own) > 0).all() for own in cuts), "cuts do not reach pi")
    need((low >= 0).all() and (low < high).all() and (high <= tops).all(), "a box is none")
    packed = np.array([{True: True, False: False}[hinge["closes"]] for hinge in hinges])
    starts = np.array([np.searchsorted(own, pi, "right") for own in cuts])  # no double is pi, so that it lies between
    states = {"packed": packed, "flat": np.zeros_like(packed)}
    holds = {  # as points: 0 is the first cut, and pi lies in boxes with a cut below it and another one above it
        name: np.where(at, (low < starts) & (starts <= high), low == 0).all(1).any() for name, at in states.items()
    }
    other = "flat" if end == "packed" else "packed"
    need(holds[end] and not holds[other], "the boxes do not hold the one end alone")
    below, above = faces_of(low, high, tops)
    least, most = (np.stack([own[k] for own, k in zip(cuts, side.T, strict=True)], 1) for side in (below, above))
    check_empty(array.loops, least, most, FEWEST + FACTOR * min(int(claim["tried"]), MOST), overlap)
    there = f"no motion leads from {end} to {other}"
    boxes = f"{len(low)} boxes" if len(low) > 1 else "one box"
    return f"{there}, or leaves {boxes} of fold angles: {len(below)} faces hold no closed state"


def checked(claim: Any, check: Any = None) -> str:
    """Return the proved claim as a sentence; refuse a claim that is not proved, or not of the documented form."""
    try:
        with np.errstate(all="ignore"):  # what overflows proves nothing
            return str(check(claim) if check else check_lock(claim, Array(claim["array"])))
    except (LookupError, TypeError, ValueError, AttributeError, ArithmeticError, RuntimeError, MemoryError) as error:
        raise NotProvedError(f"the claim is not of the documented form ({type(error).__name__}: {error})") from error


def main(path: str, kind: str, check: Any) -> None:
    """Check the claims of one kind in a file; stop with the reason if one fails."""
    try:
        data = json.loads(Path(path).read_text(encoding="utf-8"))
        claims = [claim for claim in data["claims"] if claim["kind"] == kind] or [f"no {kind} is claimed"]
        print(*(f"{data['of']}: proved: {check(claim)}" for claim in claims), sep="\n")
    except (NotProvedError, OSError, ValueError, LookupError, TypeError, RecursionError) as error:
        sys.exit(f"{path}: not proved: {error}")


if __name__ == "__main__":
    main(sys.argv[1], "lock", checked) if len(sys.argv) == 2 else sys.exit(__doc__)
