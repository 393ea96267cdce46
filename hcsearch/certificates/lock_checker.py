"""Check a certificate of a lock by arithmetic of its own: `python lock_checker.py FILE`.

A lock states that no motion with closed loops and hinges between their stops leaves a set of boxes of fold angles, in
which the packed or the flat state lies and the other one does not. Every face by which the set could be left is proved
here to hold no closed state, by branch and bound. This file needs NumPy alone and imports nothing of hcsearch. Bounds
are widened by what rounding to doubles may add to them. Why these checks prove the claim:
docs/explanation/certificates.md.
"""

from __future__ import annotations

import json
import sys
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Reals = NDArray[np.float64]
ROUNDING = 1e-14  # of an equation, for each hinge, over 1 and the greatest distance; times what it is multiplied by
BATCH = 256
FEWEST, FACTOR = 20_000, 6  # boxes: so many, and times what the certificate states, are tried
MOST = 10**8
NARROW = 1e-6  # a box that is no wider (rad) is not split
SWEEPS, GAIN, WIDE = 3, 0.1, 0.2  # how often, and for which gain, a box is contracted again; sides that may be split


class NotProvedError(Exception):
    """The certificate does not prove what it claims."""


def need(condition: Any, reason: str) -> None:
    """Refuse the certificate unless a condition holds."""
    if not condition:
        raise NotProvedError(reason)


def lines_of(data: Any) -> tuple[list[tuple[int, ...]], Reals, Reals]:
    """Panels, points, (n, 3), and directions of hinges in the flat state, over its size; positive angles close them."""
    facets = [[(int(x), int(y)) for x, y in facet] for facet in data["facets"]]
    stretch, height = np.array([np.sqrt(float(int(data["root"]))), 1.0, 1.0]), int(data["thickness"])
    need(min(int(data["root"]), height) > 0, "a length is not positive")
    panel_of = {int(f): k for k, panel in enumerate(data["panels"]) for f in panel}
    need(sorted(panel_of) == list(range(len(facets))), "a facet is in no panel")
    ends, points, ways = [], [], []
    for hinge in data["hinges"]:
        one, two = (facets[int(f)] for f in hinge["facets"])
        shared = [(p, q) for p, q in zip(one, one[1:] + one[:1], strict=True)
                  if (q, p) in zip(two, two[1:] + two[:1], strict=True)]  # fmt: skip
        need(len(shared) == 1 and hinge["face"] in ("top", "bottom"), "a hinge is no edge that two facets share")
        ends.append(tuple(panel_of[int(f)] for f in hinge["facets"]))
        (p, q), top = shared[0], hinge["face"] == "top"
        points.append((*p, height if top else 0))
        ways.append(np.subtract(p, q) if top else np.subtract(q, p))
    points, ways = np.array(points, float) * stretch, np.pad(np.array(ways, float), ((0, 0), (0, 1))) * stretch
    return ends, points / np.abs(points).max(), ways / np.linalg.norm(ways, axis=1, keepdims=True)


def loops_of(ends: list[tuple[int, ...]]) -> list[list[tuple[int, int]]]:
    """A loop for each hinge that a tree of panels leaves out: hinges and the senses in which they are crossed."""
    way: dict[int, list[tuple[int, int]]] = {0: []}
    waiting, loops = [0], []
    while waiting:
        panel = waiting.pop(0)
        for k, pair in enumerate(ends):
            for here, there, sense in ((*pair, 1), (*pair[::-1], -1)):
                if here == panel and there not in way:
                    way[there] = [*way[here], (k, sense)]
                    waiting.append(there)
    used = {k for steps in way.values() for k, _ in steps}
    for k, (one, two) in enumerate(ends):
        if k not in used and one in way:
            back = [(h, -s) for h, s in reversed(way[two])]
            steps = [*way[one], (k, 1), *back]
            while len(steps) > 1 and steps[0][0] == steps[-1][0]:
                steps = steps[1:-1]
            loops.append(steps)
    need(loops, "no loop is closed by the hinges")
    return loops


class Loop:
    """A loop, cut into two halves that lead from its first panel to the same one, and expanded to second order."""

    def __init__(self, steps: list[tuple[int, int]], points: Reals, ways: Reals) -> None:
        self.hinges = np.array([hinge for hinge, _ in steps])
        self.ways = np.array([sense * ways[hinge] for hinge, sense in steps])
        self.points = points[self.hinges] - points[self.hinges].mean(0)
        self.pairs = np.triu_indices(len(steps), 1)
        self.cross = crossed(self.ways)
        self.far = 1.0 + 2.0 * np.linalg.norm(self.points, axis=1).max() * 2.0

    def halves(self, angles: Reals, cut: Any) -> tuple[Reals, Reals, list[tuple[Reals, Reals]]]:
        """Axes and places of all hinges as either half has them, and the pose to which each half leads."""
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
        """Values (count, 12), slopes (count, 12, n), bends (count, 12, pairs and squares) times radii, and bounds."""
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
        bends = (
            np.concatenate([bends.reshape(*a.shape[:2], 9), moved], 2) * ((front | back) * e[:, p] * e[:, q])[..., None]
        )
        squares = (crossed(axes) @ crossed(axes) @ matrices).reshape(len(e), n, 9)
        squares = (
            np.concatenate([squares, np.cross(axes, levers)], 2) * (np.where(first, 0.25, -0.25) * e**2)[..., None]
        )
        values += squares.sum(1)  # the square of an angle lies between 0 and its greatest value
        bends = np.concatenate([bends, squares], 1)
        turned, shifted = self.rests(first, e, np.linalg.norm(levers, axis=2))
        far = 1.0 + np.linalg.norm(levers, axis=2).max(1) + self.far
        total = e.sum(1)
        error = ROUNDING * n * far**2 * (1.0 + total + total**2)
        return values, np.swapaxes(slopes, 1, 2), np.swapaxes(bends, 1, 2), turned, shifted, error

    def rests(self, first: Any, e: Reals, reach: Reals) -> tuple[Reals, Reals]:
        """What third orders come to: of the rotation, and of the place."""
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
    """Matrices of cross products with vectors."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], -1).reshape(*x.shape, 3, 3)


def contracted(loops: list[Loop], low: Reals, high: Reals) -> tuple[Reals, Reals, Any, Any]:
    """Boxes less what is proved to hold no closed state, which of them are left, and by which sides to split them."""
    middles, radii = 0.5 * (low + high), 0.5 * (high - low) * (1 + 1e-15) + 1e-15
    count, n = low.shape
    rows = 12 * len(loops)
    values, slopes, parts = np.zeros((count, rows)), np.zeros((count, rows, n)), []
    rests, errors, hinges = np.zeros((count, rows)), np.zeros((count, rows)), []
    for k, loop in enumerate(loops):
        own = slice(12 * k, 12 * k + 12)
        values[:, own], slope, bend, turned, shifted, error = loop.expanded(middles, radii)
        slopes[:, own, loop.hinges] += slope
        parts.append(np.pad(bend, ((0, 0), (12 * k, rows - 12 * k - 12), (0, 0))))
        rests[:, own] = np.where(np.arange(12) < 9, np.sqrt(2.0) * turned[:, None], shifted[:, None])
        errors[:, own] = error[:, None]
        hinges.append(np.array([(loop.hinges[i], loop.hinges[j]) for i, j in zip(*loop.pairs, strict=True)]))
        hinges.append(np.stack([loop.hinges, loop.hinges], 1))
    bends, owners = np.concatenate(parts, 2), np.concatenate(hinges)
    columns = np.concatenate([slopes * radii[:, None], bends], 2)
    gram = columns @ np.swapaxes(columns, 1, 2) + np.eye(rows) * (rests**2)[:, None]
    gram += np.eye(rows) * (1e-12 * np.trace(gram, axis1=1, axis2=2) + 1e-300)[:, None, None]
    mixes = np.swapaxes(np.linalg.solve(gram, np.concatenate([values[..., None], slopes], 2)), 1, 2)
    mixes /= np.abs(mixes).max(2, keepdims=True) + 1e-300
    value, slope = (mixes @ values[..., None])[..., 0], mixes @ slopes
    bent = np.abs(mixes @ bends)
    unknown = bent.sum(2) + (np.abs(mixes) @ errors[..., None])[..., 0]
    for k in range(0, rows, 12):  # the norm of a combination of the entries of one matrix, and of one vector
        for part in (slice(k, k + 9), slice(k + 9, k + 12)):
            unknown += np.linalg.norm(mixes[..., part], axis=2) * rests[:, None, part.start]
    moves = np.abs(slope) * radii[:, None]
    unknown += ROUNDING * (np.abs(value) + unknown + moves.sum(2))
    left = ~(np.abs(value) > unknown + moves.sum(2)).any(1)
    with np.errstate(divide="ignore", invalid="ignore"):
        far = (unknown + moves.sum(2))[..., None] - moves
        bounds = np.stack([(-value[..., None] - far) / slope, (-value[..., None] + far) / slope])
    known = np.abs(slope) > 1e-9
    least = np.where(known, bounds.min(0), -np.inf).max(1) + middles - 1e-14
    most = np.where(known, bounds.max(0), np.inf).min(1) + middles + 1e-14
    least, most = np.maximum(low, least), np.minimum(high, most)
    left &= ~(least > most).any(1)
    shares = moves[:, 0].copy()
    for k, (one, two) in enumerate(owners):
        shares[:, [one, two]] += bent[:, 0, k, None]
    widths = np.where(left[:, None], most - least, 0.0)
    shares[widths < WIDE * widths.max(1, keepdims=True)] = -1.0
    return least, most, left, shares.argmax(1)


def check_empty(loops: list[Loop], low: Reals, high: Reals, limit: int) -> int:
    """Refuse faces, (count, n) each, that are not proved to hold no closed state by so many boxes; how many it took."""
    swept, tried = np.zeros(len(low), int), 0
    while len(low):
        rest = slice(None, -BATCH) if len(low) > BATCH else slice(0, 0)
        own = slice(-BATCH, None)
        below, above, sweeps = low[own], high[own], swept[own]
        low, high, swept = low[rest], high[rest], swept[rest]
        tried += len(below)
        need(tried <= limit, "a face of its boxes is not proved to hold no closed state")
        least, most, left, side = contracted(loops, below, above)
        gain = 1.0 - (most - least).sum(1) / np.maximum((above - below).sum(1), 1e-300)
        again = left & (gain > GAIN) & (sweeps + 1 < SWEEPS)
        split = left & ~again
        pick = np.arange(len(least))
        need(
            not (split & ((most - least).max(1) < NARROW)).any(), "a face of its boxes holds what may be a closed state"
        )
        middle = 0.5 * (least[pick, side] + most[pick, side])
        upper, lower = least.copy(), most.copy()
        upper[pick, side], lower[pick, side] = middle, middle
        low = np.concatenate([low, least[again], least[split], upper[split]])
        high = np.concatenate([high, most[again], lower[split], most[split]])
        swept = np.concatenate([swept, sweeps[again] + 1, np.zeros(2 * split.sum(), int)])
    return tried


def faces_of(low: Any, high: Any, tops: Any) -> tuple[Any, Any]:
    """Faces of boxes, (count, n) each in numbers of cuts, behind which another box does not lie: lows and highs."""
    below, above = [], []
    n = low.shape[1]
    for h in range(n):
        for value, at in ((low[:, h], 0), (high[:, h], 1)):
            for level in np.unique(value[(value > 0) & (value < tops[h])]):
                beyond = (
                    (low[:, h] <= level) & (high[:, h] > level) if at else (low[:, h] < level) & (high[:, h] >= level)
                )
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
    """The parts of a box that another one does not cover."""
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


def check_lock(claim: Any) -> str:
    """Check that no motion leaves a set of boxes; what is proved, in words."""
    ends, points, ways = lines_of(claim["array"])
    loops = [Loop(steps, points, ways) for steps in loops_of(ends)]
    cuts = [np.array(own, float) for own in claim["cuts"]]
    low, high = (np.array(claim[name], int) for name in ("lows", "highs"))
    tops = np.array([len(own) - 1 for own in cuts])
    need(low.shape == high.shape == (len(low), len(ends)) and len(cuts) == len(ends), "a box is none")
    need(all(own[0] == 0.0 and pi < own[-1] < 3.2 and (np.diff(own) > 0).all() for own in cuts), "cuts do not reach pi")
    need((low >= 0).all() and (low < high).all() and (high <= tops).all(), "a box is none")
    need(claim["end"] in ("packed", "flat"), "the lock is at no end")
    packed = np.array([bool(hinge["closes"]) for hinge in claim["array"]["hinges"]])
    states = {"packed": packed, "flat": np.zeros_like(packed)}
    held = {end: ((low == 0) | at) & ((high == tops) | ~at) for end, at in states.items()}
    holds = {end: bool(own.all(1).any()) for end, own in held.items()}
    other = "flat" if claim["end"] == "packed" else "packed"
    need(holds[claim["end"]] and not holds[other], "the boxes do not hold the one end alone")
    below, above = faces_of(low, high, tops)

    def take(numbers: Any) -> Reals:
        return np.stack([cuts[h][numbers[:, h]] for h in range(len(cuts))], 1)

    limit = FEWEST + FACTOR * min(int(claim["tried"]), MOST)
    check_empty(loops, take(below), take(above), limit)
    there = f"no motion leads from {claim['end']} to {other}"
    return f"{there}, or leaves {len(low)} boxes of fold angles: {len(below)} faces hold no closed state"


def checked(claim: Any) -> str:
    """What is proved by a claim, in words; refused where it is not proved, or not of the documented form."""
    try:
        with np.errstate(all="ignore"):  # what overflows proves nothing
            return check_lock(claim)
    except (KeyError, TypeError, ValueError, IndexError, AttributeError, ArithmeticError, RecursionError) as error:
        raise NotProvedError(f"the claim is not of the documented form ({type(error).__name__}: {error})") from error
    except (np.linalg.LinAlgError, MemoryError) as error:
        raise NotProvedError(f"the claim cannot be computed with ({error})") from error


def main(path: str) -> None:
    """Check the claims of a file that are locks; stop with what is wrong, if anything is."""
    try:
        data = json.loads(Path(path).read_text(encoding="utf-8"))
        for claim in [claim for claim in data["claims"] if claim["kind"] == "lock"]:
            print(f"{data['of']}: proved: {checked(claim)}")
    except (NotProvedError, OSError, ValueError, LookupError, TypeError, RecursionError) as error:
        sys.exit(f"{path}: not proved: {error}")


if __name__ == "__main__":
    main(sys.argv[1]) if len(sys.argv) == 2 else sys.exit(__doc__)
