"""Check a certificate of a lock by collision: `python collision_checker.py FILE`, beside `lock_checker.py`.

Such a lock states that no motion with closed loops, hinges between their stops, and facets that do not overlap where
each is shrunk by a margin, leaves a set of boxes of fold angles. Faces are proved to hold no closed state without an
overlap: a segment of one facet pierces another one at all closed states of a box. This file needs NumPy, and the files
that `lock_checker` needs. Numbers in brackets are those of docs/explanation/certificates.md.
"""

from copy import copy
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np

if __package__:
    from hcsearch.motion.certificates import balls
    from hcsearch.motion.certificates import certificate_grammar as grammar
    from hcsearch.motion.certificates import lock_checker as locks
else:  # a program by itself, in a folder with the other ones
    import balls  # type: ignore[import-not-found, no-redef]
    import certificate_grammar as grammar  # type: ignore[import-not-found, no-redef]
    import lock_checker as locks  # type: ignore[import-not-found, no-redef]

Reals = np.ndarray[Any, np.dtype[np.float64]]
Form = tuple[Reals, Reals, Reals]  # value, slopes and error: value + slopes . d + error for offsets d in boxes
EPS, up = balls.EPS, balls.up
TRIES, TOUCH = 3, 1e-5  # piercings that are tried in a box; depth below which panels count as clear
PAIRS, CORNERS, SLACK = 10_000, 12, 1e-11  # limits of the format; extra shrinking of facets, beyond the margin
UP, SIDE = np.array([0.0, 0.0, 1.0]), 4.0  # up; no angle of a box is further than this from its middle


class Pair:
    """Two facets as prisms less a margin, and the paths between them; a segment of the second may pierce the first."""

    def __init__(self, one: Any, two: Any, height: float, margin: float, ways: list[Any]) -> None:
        self.ways, self.low, self.high = ways, margin, height - margin
        self.normals, self.far, _ = shrunk(one, margin)
        ring, n = shrunk(two, margin)[2], len(two)
        flat = np.concatenate([ring, 0.5 * (ring + ring.mean(0)), ring.mean(0)[None]])
        self.samples = np.concatenate([np.insert(flat, 2, z, 1) for z in (self.low, self.high)])
        self.points = balls.exact(self.samples)
        corners = [*range(n), *range(2 * n + 1, 3 * n + 1)]
        upright = [(k, k + 2 * n + 1) for k in range(2 * n + 1)]
        self.segments = np.array(upright + [(i, j) for i in corners for j in corners if i < j != i + 2 * n + 1]).T

    def pierced(self, middles: Reals, radii: Reals) -> tuple[Reals, Any, Any, Reals]:
        """Return the deepest piercings at middles of boxes: depths (0 if none), paths, both samples, and heights."""
        count = np.arange(len(middles))
        by = np.argmin([radii[:, way.hinges].sum(1) for way in self.ways], 0)
        x = np.zeros((len(middles), *self.samples.shape))
        for k, way in enumerate(self.ways):
            x[by == k] = way.seen(self.points, middles[by == k])[2].mid[..., 0]
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
        """Return the least depth of piercings at closed states of boxes, and the contribution of each angle [13]."""
        axes, places, points = way.seen(self.points, closure.middles)
        upper, lower = (points[np.arange(len(ends)), own] for own in ends.T)
        along = upper - lower
        share = (upper.mid[:, 2, 0] - height) / along.mid[:, 2, 0]
        crossing = upper - along * share
        top, bottom, middle = (Traced(way, axes, places, point, True, closure) for point in (upper, lower, crossing))
        step = Traced(way, axes, places, along, False, closure)
        tests = [top(UP, -height), bottom(-UP, height)]
        rise, level = step(UP), middle(UP, -height)
        for normal, far in zip(self.normals, self.far, strict=True):
            out = np.array([*normal, 0.0])
            inside, lean = middle(-out, far), step(out)
            tests.append(plus(times(rise, inside, closure.radii), times(level, lean, closure.radii)))
        lows, shares = zip(*(least(closure, *test) for test in tests), strict=True)
        worst = np.argmin(lows, 0)
        return np.min(lows, 0), np.array(shares)[worst, np.arange(len(ends))]


class Traced:
    """Position of a point, or of a vector between two points (`fixed` false), along normals in boxes, as forms [13]."""

    def __init__(self, way: Any, axes: Any, places: Any, place: Any, fixed: bool, boxes: Any) -> None:
        e, (p, q) = boxes.radii[:, way.hinges], way.pairs
        self.hinges, self.n, self.place, cross = way.hinges, boxes.radii.shape[1], place, balls.crossed(axes)
        self.levers = cross @ (place[:, None] - places if fixed else place[:, None])
        self.bends = cross[:, p] @ self.levers[:, q] * (e[:, p] * e[:, q])
        self.squares = cross @ self.levers * (0.25 * e**2)
        steps, columns = len(way.hinges) ** 2 + 20, (self.bends, self.squares)
        held = place.rad + (e * self.levers.rad).sum(1) + sum(column.rad.sum(1) for column in columns)
        size = place.bound + (e * self.levers.bound).sum(1) + sum(column.bound.sum(1) for column in columns)
        third = way.rests(np.ones(e.shape, bool), e, self.levers.length)[1]
        self.rest, self.steps = up(third + 2.0 * held + 4 * steps * EPS * size, steps), steps

    def __call__(self, normal: Reals, offset: Any = 0.0) -> Form:
        """Return the form of the position along a unit normal (3), less an offset, in boxes."""
        value, slope, bend, square = (
            (part.mid[..., 0] @ normal) for part in (self.place, self.levers, self.bends, self.squares)
        )
        slopes = np.zeros((len(value), self.n))
        slopes[:, self.hinges] = slope
        value, error = value + square.sum(1) + offset, np.abs(bend).sum(1) + np.abs(square).sum(1)
        return value, slopes, up(error + self.rest + 2 * EPS * (np.abs(value) + np.abs(offset)), self.steps)


def shrunk(corners: Reals, margin: float) -> tuple[Reals, Reals, Reals]:
    """Return the outward normals of an outline, its sides' distances along them less a margin, and its corners.

    The corners exceed these distances by at most 1e-12, in spite of rounding.
    """
    along = np.roll(corners, -1, 0) - corners
    normals = np.stack([along[:, 1], -along[:, 0]], 1) / np.linalg.norm(along, axis=1)[:, None]
    far = (normals * corners).sum(1) - margin
    sides = np.stack([np.roll(normals, 1, 0), normals], 1), np.stack([np.roll(far, 1), far], 1)
    ring = np.linalg.solve(sides[0], sides[1][..., None])[..., 0]
    grammar.need((ring @ normals.T < far + 1e-12).all(), "a facet is not convex, or less than twice the margin wide")
    return normals, far, ring


def plus(one: Form, two: Form) -> Form:
    """The sum of two forms."""
    value, slopes, errors = (a + b for a, b in zip(one, two, strict=True))
    return value, slopes, up(errors + 2 * EPS * (np.abs(value) + SIDE * np.abs(slopes).sum(1)), slopes.shape[1] + 5)


def times(one: Form, two: Form, radii: Reals) -> Form:
    """The product of two forms."""
    (a, slope, error), (b, bend, rest), n = one, two, radii.shape[1]
    s, t = (up((np.abs(slopes) * radii).sum(1), n) for slopes in (slope, bend))
    unknown = s * t + error * (np.abs(b) + t + rest) + rest * (np.abs(a) + s)
    slopes = a[:, None] * bend + b[:, None] * slope
    return a * b, slopes, up(unknown + 4 * EPS * (np.abs(a) + s) * (np.abs(b) + t), 9)


def part(closure: Any, some: Any) -> Any:
    """The closure equations of a subset of the boxes."""
    own = copy(closure)
    arrays = {name for name, value in vars(closure).items() if isinstance(value, np.ndarray)} - {"owners"}
    own.__dict__.update({name: vars(closure)[name][some] for name in arrays})
    return own


def least(closure: Any, value: Reals, slopes: Reals, error: Reals) -> tuple[Reals, Reals]:
    """Return the minimum of forms at closed states of boxes, and the contribution of each angle to its uncertainty.

    A combination of the closure equations, which is 0 there, is added.
    """
    moves, steps = np.abs(slopes) * closure.radii, closure.radii.shape[1] + 9
    alone, sizes = value - error - moves.sum(1), np.abs(value) + error + moves.sum(1)
    scaled = (closure.slopes * closure.radii[:, None]) @ (slopes * closure.radii)[..., None]
    added, slope, bent, unknown, _ = closure.combined(-np.swapaxes(np.linalg.solve(closure.gram, scaled), 1, 2))
    moves = np.abs(slopes + slope[:, 0]) * closure.radii
    low = value + added[:, 0] - error - unknown[:, 0] - moves.sum(1)
    sizes += np.abs(added[:, 0]) + unknown[:, 0] + moves.sum(1)
    return np.fmax(alone, low) - 2 * steps * EPS * sizes, moves + bent[:, 0] @ closure.owners


def overlaps(pairs: list[Pair], closure: Any, clock: grammar.Clock) -> tuple[Any, Reals]:
    """Return which boxes are proved to hold no closed state without overlap; for others, the angles' contributions."""
    count = np.arange(len(closure.radii))
    proved, shares, found = np.zeros(len(count), bool), np.zeros_like(closure.radii), []
    for pair in pairs:
        clock.check()
        found.append(pair.pierced(closure.middles, closure.radii))
    depths = np.array([own[0] for own in found])
    for tries in range(TRIES):
        best, waiting = depths.argmax(0), ~proved & (depths.max(0) > TOUCH)
        for k, (pair, (_, by, ends, height)) in enumerate(zip(pairs, found, strict=True)):
            for number, way in enumerate(pair.ways):
                every = np.flatnonzero(waiting & (best == k) & (by == number))
                batch = max(1, locks.CELLS // (9 * len(way.hinges) ** 2))
                for mine in (every[start : start + batch] for start in range(0, len(every), batch)):
                    clock.check()
                    low, own = pair.least(way, ends[mine], height[mine], part(closure, mine))
                    proved[mine] = low > 0.0
                    if tries == 0:
                        shares[mine] = own
        depths[best, count] = 0.0
    return proved, shares


def pairs_of(array: Any, numbers: Any, margin: str, clock: grammar.Clock) -> list[Pair]:
    """Return the pairs of facets shrunk by a margin (m), each in both orders."""
    share = float(grammar.fraction(margin, "margin") / array.unit) / array.size * (1 + 1e-15) + SLACK
    grammar.need(2 * share < array.height, "panels are no thicker than twice the margin")
    grammar.formed(
        isinstance(numbers, list) and 0 < len(numbers) <= PAIRS, f"it has not from 1 to {PAIRS} pairs of facets"
    )
    named = grammar.rows(
        numbers, [2] * len(numbers), lambda k: grammar.whole(k, 0, len(array.facets) - 1, "a facet"), "pairs"
    )

    @cache
    def ways(start: int, end: int) -> list[Any]:
        first = locks.ways_from(start, array.ends)[end]
        second = locks.ways_from(start, array.ends, {k for k, _ in first}).get(end)
        return [locks.Loop(way, array.places, array.axes) for way in (first, second) if way]

    pairs = []
    for one, two in [own for a, b in named for own in ((a, b), (b, a))]:
        clock.check()
        start, end = array.panel_of[one], array.panel_of[two]
        grammar.formed(start != end, "two facets are in one panel")
        grammar.formed(
            max(len(array.facets[k]) for k in (one, two)) <= CORNERS, f"a facet has more than {CORNERS} corners"
        )
        pairs.append(Pair(array.facets[one], array.facets[two], array.height, share, ways(start, end)))
    return pairs


def check_ends(array: Any, margin: Fraction, clock: grammar.Clock) -> None:
    """Refuse a claim if facets overlap at one of its ends: no motion without overlap begins or ends there [14].

    margin : in units of coordinates.
    """
    own, still = array.data, (np.eye(3, dtype=int) * Fraction(1), np.zeros(3, dtype=int))
    folded, flat = {0: still}, [still] * len(own.panels)
    for panel, way in [*locks.ways_from(0, array.ends).items()][1:]:  # each is hinged to one that is placed already
        clock.check()
        hinge = own.hinges[way[-1][0]]
        turn, shift = folded[hinge.one + hinge.two - panel]
        half, moved = locks.half_turn(hinge, own) if hinge.closes else still
        folded[panel] = turn @ half, shift + turn @ moved
    for end, at in (("packed", folded), ("flat", flat)):
        facets = list[Any]()
        for corners, panel in zip(own.facets, own.panel_of, strict=True):
            turn, shift = at[panel]
            places = [[*(turn @ [*corner, 0] + shift)] for corner in corners]
            level = places[0][2] + min(turn[2, 2], 0) * own.height  # height of its lower face
            facets.append((panel, level, [place[:2] for place in places][:: 1 if turn[2, 2] > 0 else -1]))
        for k, (panel, level, ring) in enumerate(facets):
            for h, (other, height, outline) in enumerate(facets[:k]):
                clock.check()
                near = panel != other and abs(level - height) < own.height - 2 * margin
                apart = not near or beside(ring, outline, own.root, margin) or beside(outline, ring, own.root, margin)
                grammar.need(apart, f"it says nothing: facets {h} and {k} overlap at its {end} state")


def beside(ring: Any, other: Any, root: int, margin: Fraction) -> bool:
    """Whether an outline lies beyond a side of another one, or reaches over it by at most twice the margin."""
    for (ax, ay), (bx, by) in zip(ring, ring[1:] + ring[:1], strict=True):
        x, y = bx - ax, by - ay
        depth = max(x * (q - ay) - y * (p - ax) for p, q in other)  # over the length of the side, and over sqrt(root)
        if depth <= 0 or root * depth**2 <= 4 * margin**2 * (root * x**2 + y**2):
            return True
    return False


def check_collisions(claim: Any, clock: grammar.Clock) -> str:
    """Check that no motion leaves a set of boxes without collisions; return the proved fact as a sentence."""
    array, margin = locks.Array(claim.get("array")), claim.get("margin")
    pairs = pairs_of(array, claim.get("pairs_of_facets"), margin, clock)
    check_ends(array, grammar.fraction(margin, "margin") / array.unit, clock)
    proved = locks.check_lock(claim, array, clock, lambda closure: overlaps(pairs, closure, clock))
    return f"{proved} without an overlap of facets that are shrunk by {margin} m"


def checked(claim: Any, clock: grammar.Clock | None = None) -> str:
    """Return the proved claim as a sentence; refuse a claim that is not proved, or not of the documented form."""
    return grammar.judged(claim, clock, check_collisions)


if __name__ == "__main__":
    grammar.main("collision", checked, __doc__)
