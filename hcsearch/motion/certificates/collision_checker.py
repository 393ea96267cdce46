"""Check a certificate of a lock by collision: `python collision_checker.py FILE`, beside `lock_checker.py`.

Such a lock states that no motion with closed loops, hinges between their stops, and facets that do not overlap where
each is shrunk by a margin, leaves a set of boxes of fold angles. Faces are proved to hold no closed state without an
overlap: a segment of one facet pierces another one at all closed states of a box. This file needs NumPy and the
arithmetic of `lock_checker` alone. Theory: docs/explanation/certificates.md.
"""

import sys
from copy import copy
from fractions import Fraction
from typing import Any

import numpy as np

if __package__:
    from hcsearch.motion.certificates import lock_checker as locks
else:  # a program by itself, in a folder with the other one
    import lock_checker as locks  # type: ignore[import-not-found, no-redef]

Reals = np.ndarray[Any, np.dtype[np.float64]]
Form = tuple[Reals, Reals, Reals]  # value, slopes and error: value + slopes . d + error for offsets d in boxes
TRIES, TOUCH = 3, 1e-5  # piercings that are tried in a box; panels that are pierced less are taken to be clear
NotProvedError, need = locks.NotProvedError, locks.need


class Pair:
    """Two facets less a margin as prisms, with the paths between; a segment of the second may pierce the first."""

    def __init__(self, one: Any, two: Any, height: float, margin: float, ways: list[Any]) -> None:
        self.ways, self.low, self.high = ways, margin, height - margin
        self.normals, self.far, _ = shrunk(one, margin)
        ring, n = shrunk(two, margin)[2], len(two)
        flat = np.concatenate([ring, 0.5 * (ring + ring.mean(0)), ring.mean(0)[None]])
        self.samples = np.concatenate([np.insert(flat, 2, z, 1) for z in (self.low, self.high)])
        corners = [*range(n), *range(2 * n + 1, 3 * n + 1)]
        upright = [(k, k + 2 * n + 1) for k in range(2 * n + 1)]
        self.segments = np.array(upright + [(i, j) for i in corners for j in corners if i < j != i + 2 * n + 1]).T

    def pierced(self, middles: Reals, radii: Reals) -> tuple[Reals, Any, Any, Reals]:
        """Return the deepest piercings at middles of boxes: depths, 0 without, paths, both samples, and heights."""
        count = np.arange(len(middles))
        by = np.argmin([radii[:, way.hinges].sum(1) for way in self.ways], 0)
        x = np.zeros((len(middles), *self.samples.shape))
        for k, way in enumerate(self.ways):
            x[by == k] = way.seen(self.samples, middles[by == k])[2]
        ends = x[:, self.segments]
        z = ends[..., 2]
        height = np.clip(0.5 * z.sum(1), self.low, self.high)
        over = np.abs(z - height[:, None])
        within = self.far - ends[..., :2] @ self.normals.T
        length = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=2)
        inside = (over[:, 1, :, None] * within[:, 0] + over[:, 0, :, None] * within[:, 1]).min(2) / length
        apart = (z.max(1) > height) & (height > z.min(1))
        depth = np.where(apart, np.minimum(over.min(1), inside), 0.0)
        best = depth.argmax(1)
        swap = z[count, 0, best] < z[count, 1, best]
        pick = np.where(swap[:, None], self.segments[::-1, best].T, self.segments[:, best].T)
        return depth[count, best], by, pick, height[count, best]

    def least(self, way: Any, ends: Any, height: Reals, closure: Any) -> tuple[Reals, Reals]:
        """Return the least depth of piercings at closed states of boxes, and the contribution of each angle to it."""
        axes, places, x = way.seen(self.samples, closure.middles)
        upper, lower = (x[np.arange(len(x)), own] for own in ends.T)
        along = upper - lower
        crossing = upper - ((upper[:, 2] - height) / along[:, 2])[:, None] * along
        up = np.tile([0.0, 0.0, 1.0], (len(x), 1))
        top, bottom, middle, step = (
            Traced(way, axes, places, place, point, closure)
            for place, point in ((upper, 1), (lower, 1), (crossing, 1), (along, 0))
        )
        tests = [top(up, upper[:, 2] - height), bottom(-up, height - lower[:, 2])]
        rise, level = step(up, along[:, 2]), middle(up, crossing[:, 2] - height)
        for normal, far in zip(self.normals, self.far, strict=True):
            out = np.tile([*normal, 0.0], (len(x), 1))
            inside = middle(-out, far - crossing[:, :2] @ normal)
            lean = step(out, along[:, :2] @ normal)
            tests.append(plus(times(rise, inside, closure.radii), times(level, lean, closure.radii)))
        lows, shares = zip(*(least(closure, *test) for test in tests), strict=True)
        worst = np.argmin(lows, 0)
        return np.min(lows, 0), np.array(shares)[worst, np.arange(len(x))]


class Traced:
    """The position of a point (point: 1), or of a vector between two (0), along normals in boxes, as forms."""

    def __init__(self, way: Any, axes: Reals, places: Reals, place: Reals, point: int, boxes: Any) -> None:
        e, (p, q) = boxes.radii[:, way.hinges], way.pairs
        self.hinges, self.n = way.hinges, boxes.radii.shape[1]
        self.levers = np.cross(axes, place[:, None] - point * places)
        self.bends = np.cross(axes[:, p], self.levers[:, q]) * (e[:, p] * e[:, q])[..., None]
        self.squares = np.cross(axes, self.levers) * 0.25 * (e**2)[..., None]
        reach, total = np.linalg.norm(self.levers, axis=2), e.sum(1)
        far = 1.0 + np.linalg.norm(place, axis=1) + reach.max(1) + way.far
        rest = way.rests(np.ones(e.shape, bool), e, reach)[1]
        self.rest = rest + locks.ROUNDING * (e.shape[1] + 1) * far**2 * (1.0 + total + total**2)

    def __call__(self, normal: Reals, value: Reals) -> Form:
        """Return the form of the position along a normal, (count, 3), with its value at middles of boxes."""
        slopes, square = np.zeros((len(value), self.n)), (self.squares @ normal[..., None])[..., 0]
        slopes[:, self.hinges] = (self.levers @ normal[..., None])[..., 0]
        error = np.abs(self.bends @ normal[..., None]).sum((1, 2)) + np.abs(square).sum(1)
        return value + square.sum(1), slopes, error + self.rest


def shrunk(corners: Reals, margin: float) -> tuple[Reals, Reals, Reals]:
    """Return outward normals of an outline, the distances of its sides along these less a margin, and its corners."""
    along = np.roll(corners, -1, 0) - corners
    normals = np.stack([along[:, 1], -along[:, 0]], 1) / np.linalg.norm(along, axis=1)[:, None]
    far = (normals * corners).sum(1) - margin
    sides = np.stack([np.roll(normals, 1, 0), normals], 1), np.stack([np.roll(far, 1), far], 1)
    ring = np.linalg.solve(sides[0], sides[1][..., None])[..., 0]
    need((ring @ normals.T < far + 1e-12).all(), "a facet is not convex, or less than twice the margin wide")
    return normals, far, ring


def plus(one: Form, two: Form) -> Form:
    """The sum of two forms."""
    return one[0] + two[0], one[1] + two[1], one[2] + two[2]


def times(one: Form, two: Form, radii: Reals) -> Form:
    """The product of two forms."""
    (a, slope, error), (b, bend, rest) = one, two
    s, t = (np.abs(slopes) * radii for slopes in (slope, bend))
    s, t = s.sum(1), t.sum(1)
    unknown = s * t + error * (np.abs(b) + t + rest) + rest * (np.abs(a) + s)
    slopes = a[:, None] * bend + b[:, None] * slope
    return a * b, slopes, unknown * (1 + 1e-12) + locks.ROUNDING * (np.abs(a) + s) * (np.abs(b) + t)


def part(closure: Any, some: Any) -> Any:
    """The closure equations of a subset of the boxes."""
    own = copy(closure)
    own.__dict__.update({name: value[some] for name, value in vars(closure).items() if name != "owners"})
    return own


def least(closure: Any, value: Reals, slopes: Reals, error: Reals) -> tuple[Reals, Reals]:
    """Return the minimum of forms at closed states of boxes, and the contribution of each angle to its uncertainty.

    A combination of the closure equations, which is 0 there, is added.
    """
    moves = np.abs(slopes) * closure.radii
    alone, sizes = value - error - moves.sum(1), np.abs(value) + error + moves.sum(1)
    scaled = (closure.slopes * closure.radii[:, None]) @ (slopes * closure.radii)[..., None]
    added, slope, bent, unknown, _ = closure.combined(-np.swapaxes(np.linalg.solve(closure.gram, scaled), 1, 2))
    moves = np.abs(slopes + slope[:, 0]) * closure.radii
    low = value + added[:, 0] - error - unknown[:, 0] - moves.sum(1)
    sizes += np.abs(added[:, 0]) + unknown[:, 0] + moves.sum(1)
    return np.fmax(alone, low) - locks.ROUNDING * sizes, moves + bent[:, 0] @ closure.owners


def overlaps(pairs: list[Pair], closure: Any) -> tuple[Any, Reals]:
    """Return which boxes are proved to hold no closed state without overlap; for others, the angles' contributions."""
    count = np.arange(len(closure.radii))
    proved, shares = np.zeros(len(count), bool), np.zeros_like(closure.radii)
    found = [pair.pierced(closure.middles, closure.radii) for pair in pairs]
    depths = np.array([own[0] for own in found])
    for tries in range(TRIES):
        best, waiting = depths.argmax(0), ~proved & (depths.max(0) > TOUCH)
        for k, (pair, (_, by, ends, height)) in enumerate(zip(pairs, found, strict=True)):
            for number, way in enumerate(pair.ways):
                mine = np.flatnonzero(waiting & (best == k) & (by == number))
                if len(mine):
                    low, own = pair.least(way, ends[mine], height[mine], part(closure, mine))
                    proved[mine] = low > 0.0
                    if tries == 0:
                        shares[mine] = own
        depths[best, count] = 0.0
    return proved, shares


def pairs_of(array: Any, numbers: Any, margin: str) -> list[Pair]:
    """Return the pairs of facets less a margin (m), each in both orders."""
    share = float(Fraction(margin) / Fraction(array.unit)) / array.size * (1 + 1e-9) + 1e-12
    need(0 < 2 * share < array.height, "panels are no thicker than twice the margin")
    pairs = []
    for one, two in [own for a, b in numbers for own in ((a, b), (b, a))]:
        start, end = array.panel_of[one], array.panel_of[two]
        need(start != end, "two facets are in one panel")
        first = locks.ways_from(start, array.ends)[end]
        second = locks.ways_from(start, array.ends, {k for k, _ in first}).get(end)
        ways = [locks.Loop(way, array.places, array.axes) for way in (first, second) if way]
        pairs.append(Pair(array.facets[one], array.facets[two], array.height, share, ways))
    need(pairs, "no facets are named that overlap")
    return pairs


def check_collisions(claim: Any) -> str:
    """Check that no motion leaves a set of boxes without collisions; return the proved fact as a sentence."""
    array, margin = locks.Array(claim["array"]), claim["margin"]
    pairs = pairs_of(array, claim["pairs_of_facets"], margin)
    proved = locks.check_lock(claim, array, lambda closure: overlaps(pairs, closure))
    return f"{proved} without an overlap of facets that are shrunk by {margin} m"


def checked(claim: Any) -> str:
    """Return the proved claim as a sentence; refuse a claim that is not proved, or not of the documented form."""
    return str(locks.checked(claim, check_collisions))


if __name__ == "__main__":
    locks.main(sys.argv[1], "collision", checked) if len(sys.argv) == 2 else sys.exit(__doc__)
