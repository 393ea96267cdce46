"""A second checker of locks, also by collision, in whole numbers: it shares no code with those of the project.

A part of a face is empty if the equations of closed loops, expanded about a state with rational rotations, have a
combination that is 0 nowhere in it. Values, slopes and bends are computed exactly and rounded once; remainders are
bounded by the theorems 2 and 3 of docs/explanation/locks.md. NumPy only guesses combinations, which may be any.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import isqrt
from operator import mul
from typing import Any, NamedTuple

import numpy as np

from tests.certificates.exact_arrays import (
    FINE,
    FINE_BITS,
    ONE,
    PI_HIGH,
    PI_LOW,
    STILL,
    Array,
    Pose,
    Vector,
    dot,
    down,
    half_turn,
    length,
    listed,
    need,
    real,
    root_up,
    up,
    whole,
)

MIX = 1 << 40
"""The greatest factor of a combination."""
FEWEST_BOXES, BOX_FACTOR, MOST_BOXES = 5_000, 12, 10**6
NARROWEST = ONE >> 26
MAX_SWEEPS, LEAST_GAIN, WIDE_SHARE = 3, 0.1, 0.2
SAMPLE_SHARES = (Fraction(1), Fraction(1, 2))
"""Where points of a facet may pierce another one, beside its middle: at corners, and half-way to them."""

Box = tuple[list[int], list[int]]


class Line(NamedTuple):
    """A hinge on a way, at the middle of a box: `way` has a length of about FINE / sqrt(root), and `point` a place."""

    hinge: int
    sense: int
    way: Vector
    point: Vector


class Column(NamedTuple):
    """Coefficients of a product of offsets in the equations from a row on; the product is `weight` at the most."""

    row: int
    entries: list[int]
    weight: int
    owners: tuple[int, int]


class Middle:
    """A box about a state with rational rotations: the radii about it, as angles and in the scale of its lines."""

    def __init__(self, array: Array, low: Sequence[int], high: Sequence[int], hinges: Sequence[int]) -> None:
        self.array, self.low, self.high, self.unit = array, low, high, FINE // array.size
        self.half: dict[int, Fraction] = {}
        self.angle: dict[int, tuple[int, int]] = {}
        self.radius, self.scaled = [0] * len(low), [0] * len(low)
        self.factor: dict[int, tuple[int, int]] = {}
        for k in hinges:
            hinge, wide = array.hinges[k], high[k] - low[k]
            middle, bits = (low[k] + high[k]) / (2 * ONE), min(max(8 + 64 - wide.bit_length(), 12), 48)
            guess = math.tan(0.5 * middle) * math.sqrt(array.root / hinge.square)
            half = Fraction(round(guess * array.size * 2**bits), array.size * 2**bits)
            least, most = array.angle(k, half)
            radius = max(high[k] - least, most - low[k], 0)
            # a turn by d is d sqrt(root) / |way| in the scale of the lattice, and lines are scaled by FINE / length
            unit = FINE // isqrt(hinge.square)
            factor = isqrt(array.root * FINE * FINE // hinge.square) * ONE // unit
            self.half[k], self.angle[k], self.radius[k] = half, (least, most), radius
            self.factor[k] = factor, factor + (ONE >> 40)
            self.scaled[k] = (radius * self.factor[k][1] >> 64) + 1

    def walked(self, steps: Sequence[tuple[int, int]]) -> tuple[list[Line], Pose]:
        """The lines of hinges on a way, as seen from its first panel, and the pose of its last panel."""
        pose, lines = STILL, []
        for k, sense in steps:
            hinge = self.array.hinges[k]
            way = pose.vector(hinge.way, FINE // isqrt(hinge.square))
            lines.append(Line(k, sense, way, pose.point(hinge.point, self.unit)))
            pose = pose.then(self.array.turn(k, sense, self.half[k]))
        return lines, pose

    def across(self, line: Line, arrow: Vector) -> Vector:
        """The velocity of an arrow per scaled turn of a line."""
        (a, b, c), (x, y, z), root = line.way, arrow, self.array.root
        p, q, s = b * z - c * y, c * x - a * z, a * y - b * x
        if line.sense < 0:
            p, q, s = -p, -q, -s
        return p // root >> FINE_BITS, q >> FINE_BITS, s >> FINE_BITS

    def expanded(self, lines: Sequence[Line], target: Vector, placed: bool) -> tuple[list[Any], list[Any]]:
        """The first and the second orders of an arrow, or of a point, that is moved by all lines."""
        slopes = []
        for line in lines:
            arrow = tuple(a - b for a, b in zip(target, line.point, strict=True)) if placed else target
            slopes.append(self.across(line, arrow))  # type: ignore[arg-type]
        bends = [(i, j, self.across(lines[i], slopes[j])) for j in range(len(lines)) for i in range(j + 1)]
        return slopes, bends

    def weight(self, a: int, b: int, same: bool) -> int:
        """The greatest product of two offsets; of a square, which is half as much about half its greatest value."""
        product = self.scaled[a] * self.scaled[b]
        return -(-product >> 66) if same else -(-product >> 64)

    def rests(self, lines: Sequence[Line], slopes: Sequence[Vector]) -> tuple[int, int]:
        """Bounds of the third orders: of a rotation, and of the place of the point with these slopes."""
        moved, reaches = 0, []  # by the hinges between the line and the point
        for line, slope in zip(reversed(lines), reversed(slopes), strict=True):
            e, scaled = self.radius[line.hinge], self.factor[line.hinge][1]
            x, y, z = ((abs(a) >> FINE_BITS - 64) + 2 for a in slope)
            reach = (root_up(self.array.root * x * x + y * y + z * z) * scaled >> 64) + 1 + moved
            reaches.append(reach)
            moved += (e * reach >> 64) + 1
        total = cubes = 0
        for line, reach in zip(lines, reversed(reaches), strict=True):
            new = total + self.radius[line.hinge]
            cubes += -(-reach * (new**3 - total**3) >> 192)
            total = new
        return -(-(total**3) >> 128) // 6 + 1, cubes // 6 + 1


class Equations:
    """The equations of closed loops in a box, 12 for each: they are 0 at closed states."""

    def __init__(self, array: Array, loops: Sequence[Any], box: Middle) -> None:
        self.box, self.values, self.rests = box, list[int](), list[tuple[int, int]]()
        self.hinges = sorted({k for loop in loops for k, _ in loop})
        self.slopes = {k: [0] * 12 * len(loops) for k in self.hinges}
        self.bends: list[Column] = []
        for number, loop in enumerate(loops):
            self._add(array, 12 * number, loop)
        self.total = ONE + sum(box.scaled[k] for k in self.hinges)
        self.root = array.root

    def _add(self, array: Array, row: int, loop: Sequence[tuple[int, int]]) -> None:
        """Add a loop, cut into halves that lead from its first panel to one and the same panel."""
        box, radii = self.box, [self.box.radius[k] for k, _ in loop]
        cut = min(range(1, len(loop)), key=lambda c: abs(sum(radii[:c]) - sum(radii[c:])), default=1)
        corner = array.hinges[loop[cut % len(loop)][0]].point
        values, turned, placed = [0] * 12, 0, 0
        for sign, steps in ((1, loop[:cut]), (-1, [(k, -sense) for k, sense in reversed(loop[cut:])])):
            lines, pose = box.walked(steps)
            targets = [(pose.vector(axis, FINE), False) for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
            targets.append((pose.point(corner, box.unit), True))
            columns: dict[tuple[int, int], list[int]] = {}
            for target, is_point in targets:
                slopes, bends = box.expanded(lines, target, is_point)
                for line, slope in zip(lines, slopes, strict=True):
                    columns.setdefault((line.hinge, -1), []).extend(sign * a >> FINE_BITS - 64 for a in slope)
                for i, j, bend in bends:
                    own = columns.setdefault((lines[i].hinge, lines[j].hinge), [])
                    own.extend(sign * a >> FINE_BITS - 64 for a in bend)
            value = [sign * a >> FINE_BITS - 64 for target, _ in targets for a in target]
            for (a, b), entries in columns.items():
                if b < 0:
                    self.slopes[a][row : row + 12] = entries
                    continue
                weight = box.weight(a, b, a == b)
                self.bends.append(Column(row, entries, weight, (a, b)))
                if a == b:  # the square of an offset, halved, lies about a quarter of the greatest square
                    value = [v + (weight * x >> 64) for v, x in zip(value, entries, strict=True)]
            values = [a + b for a, b in zip(values, value, strict=True)]
            rest, moved = box.rests(lines, slopes)  # those of the point are the last ones
            turned, placed = turned + rest, placed + moved
        self.values += values
        self.rests.append((turned, placed))

    def guesses(self, rights: Sequence[Sequence[int]]) -> list[list[int]]:
        """Combinations that are large for given values and small for all unknown parts."""
        table = [[x * self.box.scaled[k] for x in column] for k, column in self.slopes.items()]
        columns = np.array(table, float) / ONE**2
        gram = columns.T @ columns
        for column in self.bends:
            own = slice(column.row, column.row + 12)
            part = np.array(column.entries, float) * (column.weight / ONE**2)
            gram[own, own] += np.outer(part, part)
        least = 1e-12 * np.trace(gram) + 1e-30
        rests = np.repeat([max(own) / ONE for own in self.rests], 12)
        self.gram = gram + np.diag(rests**2 + least)
        solved = np.linalg.solve(self.gram, np.array(rights, float).T / ONE)
        return rounded(solved / (np.abs(solved).max(0) + 1e-300))

    def compensation(self, slopes: Mapping[int, int]) -> list[int]:
        """The combination that takes most of the slopes of a form away, with the matrix of `guesses`."""
        right = np.zeros(len(self.values))
        for k, column in self.slopes.items():
            right -= np.array(column, float) * (slopes.get(k, 0) / ONE**2 * (self.box.scaled[k] / ONE) ** 2)
        (mix,) = rounded(np.linalg.solve(self.gram, right)[:, None])
        return mix

    def combined(self, mix: Sequence[int]) -> tuple[int, dict[int, int], int, dict[int, int]]:
        """The value of a combination, its slopes, a bound of all else, and what angles contribute to it."""
        value = sum(map(mul, mix, self.values))
        slopes = {k: sum(map(mul, mix, column)) for k, column in self.slopes.items()}
        parts = [mix[row : row + 12] for row in range(0, len(mix), 12)]
        unknown, shares = 0, dict.fromkeys(self.hinges, 0)
        for row, entries, weight, (a, b) in self.bends:
            bend = abs(sum(map(mul, parts[row // 12], entries))) * weight >> 64
            unknown += bend + 1
            shares[a] += bend
            shares[b] += bend
        root = self.root
        for part, (turned, placed) in zip(parts, self.rests, strict=True):
            # entries of a rotation in the lattice are those of an orthogonal one times ratios of sqrt(root)
            square = 0
            for column in range(3):
                for axis in range(3):
                    y = part[3 * column + axis]
                    if axis and not column:
                        square += root * y * y
                    elif column and not axis:
                        square += -(-y * y // root)
                    else:
                        square += y * y
            unknown += (root_up(2 * square) * turned) + 1
            x, y, z = part[9:]
            unknown += (root_up(-(-x * x // root) + y * y + z * z) * placed) + 1
        # each coefficient is rounded by less than 4 units, and is multiplied by products of two offsets at the most
        unknown += sum(map(abs, mix)) * (4 * (self.total * self.total >> 128) + 8)
        return value, slopes, unknown, shares


def rounded(mixes: Any) -> list[list[int]]:
    """Combinations, (rows, count), as whole multiples of 1 / MIX."""
    return [[round(x) for x in own] for own in np.nan_to_num(mixes * MIX, posinf=0.0, neginf=0.0).T.tolist()]


def contracted(array: Array, loops: Sequence[Any], low: list[int], high: list[int]) -> Any:
    """Contract a box onto its closed states: None if it has none, else the box, its equations, and shares of angles."""
    hinges = sorted({k for loop in loops for k, _ in loop})
    box = Middle(array, low, high, hinges)
    own = Equations(array, loops, box)
    low, high, first = list(low), list(high), None
    for mix in own.guesses([own.values, *own.slopes.values()]):
        value, slopes, unknown, shares = own.combined(mix)
        moves = {k: (abs(slope) * box.scaled[k] >> 64) + 1 for k, slope in slopes.items()}
        total = unknown + sum(moves.values())
        if abs(value) > total:
            return None
        if first is None:
            first = {k: moves[k] + shares[k] for k in hinges}
        for k, slope in slopes.items():
            if abs(slope) < MIX * ONE >> 30:
                continue
            far, value_at = total - moves[k], -value if slope > 0 else value
            least, most = (value_at - far) * ONE // abs(slope), -((-value_at - far) * ONE // abs(slope))
            small, great = box.factor[k]
            least = least * ONE // (great if least > 0 else small)
            most = -(-most * ONE // (small if most > 0 else great))
            low[k] = max(low[k], box.angle[k][0] + least)
            high[k] = min(high[k], box.angle[k][1] + most)
            if low[k] > high[k]:
                return None
    return low, high, first


def check_empty(array: Array, loops: Sequence[Any], boxes: list[Box], limit: int, overlap: Any) -> int:
    """Refuse parts of faces that are not proved to hold no closed state, or none without overlap, by so many boxes."""
    hinges, tried = sorted({k for loop in loops for k, _ in loop}), 0
    waiting = [(low, high, 0) for low, high in boxes]
    while waiting:
        below, above, sweeps = waiting.pop()
        tried += 1
        need(tried <= limit, "a face of its boxes is not proved to hold no closed state")
        left = contracted(array, loops, below, above)
        if left is None:
            continue
        low, high, shares = left
        before = sum(above[k] - below[k] for k in hinges)
        gain = 1 - sum(high[k] - low[k] for k in hinges) / max(before, 1)
        if gain > LEAST_GAIN and sweeps + 1 < MAX_SWEEPS:
            waiting.append((low, high, sweeps + 1))
            continue
        if overlap is not None:
            proved, hidden = overlap(low, high)
            if proved:
                continue
            shares = hidden or shares
        widest = max((high[k] - low[k] for k in hinges), default=0)
        need(widest > NARROWEST, "a face of its boxes holds what may be a closed state")
        side = max((k for k in hinges if high[k] - low[k] >= WIDE_SHARE * widest), key=lambda k: shares[k])
        middle = (low[side] + high[side]) // 2
        waiting.append((low, [middle if k == side else x for k, x in enumerate(high)], 0))
        waiting.append(([middle if k == side else x for k, x in enumerate(low)], high, 0))
    return tried


def uncovered(low: list[int], high: list[int], others: list[Box]) -> list[Box]:
    """The parts of a box that other boxes leave open, in numbers of cuts."""
    others = [(a, b) for a, b in others if all(x < q and p < y for x, y, p, q in zip(low, high, a, b, strict=True))]
    if not others:
        return [(low, high)]
    a, b = others[0]
    for k, (x, y) in enumerate(zip(low, high, strict=True)):
        for bound in (a[k], b[k]):
            if x < bound < y:
                lower = uncovered(low, [*high[:k], bound, *high[k + 1 :]], others)
                return lower + uncovered([*low[:k], bound, *low[k + 1 :]], high, others)
    return []  # the first one covers it


def faces(boxes: list[Box], tops: list[int]) -> list[Box]:
    """The parts of faces of boxes beyond which there is no other box, except for those at the stops."""
    parts = []
    for low, high in boxes:
        for k in range(len(low)):
            rest = [h for h in range(len(low)) if h != k]
            for level, stop, side in ((low[k], 0, 0), (high[k], tops[k], 1)):
                if level == stop:
                    continue
                beyond = [
                    ([a[h] for h in rest], [b[h] for h in rest])
                    for a, b in boxes
                    if (a[k] <= level < b[k] if side else a[k] < level <= b[k])
                ]
                for a, b in uncovered([low[h] for h in rest], [high[h] for h in rest], beyond):
                    parts.append(([*a[:k], level, *a[k:]], [*b[:k], level, *b[k:]]))
    return parts


def check_lock(claim: Any, array: Array, overlap: Any = None, limit: int | None = None) -> tuple[int, int]:
    """Check that no motion leaves the boxes of a claim; return the numbers of faces and of boxes that were tried."""
    count = len(array.hinges)
    need(array.loops, "no loop is closed by the hinges")
    need(array.is_closed(packed=True), "the packed state is not closed")
    cuts = [[real(x) for x in listed(own)] for own in listed(claim["cuts"])]
    need(len(cuts) == count and min(map(len, cuts)) > 1, "cuts are not those of the hinges")
    for own in cuts:
        need(own[0] == 0 and all(a < b for a, b in itertools.pairwise(own)), "cuts do not ascend from 0")
        need(own[-2] * ONE <= PI_LOW < PI_HIGH <= own[-1] * ONE < 3.2 * ONE, "cuts do not end just above pi")
    boxes = []
    need(len(listed(claim["lows"])) == len(listed(claim["highs"])) > 0, "there are no boxes")
    for low, high in zip(claim["lows"], claim["highs"], strict=True):
        need(len(listed(low)) == len(listed(high)) == count, "a box is none")
        good = all(
            type(a) is type(b) is int and 0 <= a < b < len(own) for a, b, own in zip(low, high, cuts, strict=True)
        )
        need(good, "a box is none")
        boxes.append((low, high))
    need(claim["end"] in ("packed", "flat"), "the end is none")
    held = dict.fromkeys(("packed", "flat"), False)
    for name in held:
        states = [(PI_LOW, PI_HIGH) if hinge.closes and name == "packed" else (0, 0) for hinge in array.hinges]
        for low, high in boxes:
            bounds = zip(cuts, low, high, states, strict=True)
            # pi is in no cut, so that a box whose cut is above the lower bound of pi may hold it
            held[name] |= all(own[a] * ONE <= most and least <= own[b] * ONE for own, a, b, (least, most) in bounds)
    other = "flat" if claim["end"] == "packed" else "packed"
    need(held[claim["end"]] and not held[other], "the boxes do not hold the one end alone")
    tops = [len(own) - 1 for own in cuts]
    parts = faces(boxes, tops)
    least = [[down(own[x]) for own, x in zip(cuts, low, strict=True)] for low, _ in parts]
    most = [[up(own[x]) for own, x in zip(cuts, high, strict=True)] for _, high in parts]
    tried = claim["tried"]
    need(type(tried) is int and tried >= 0, "the number of boxes that were tried is none")
    most_tried = FEWEST_BOXES + BOX_FACTOR * min(tried, MOST_BOXES) if limit is None else limit
    return len(parts), check_empty(array, array.loops, list(zip(least, most, strict=True)), most_tried, overlap)


class Form(NamedTuple):
    """A number that depends on fold angles in a box: its value and slopes, a bound of all else, and angles' shares."""

    value: int
    slopes: dict[int, int]
    unknown: int
    shares: dict[int, int]


class Pair:
    """Two facets less a margin; the second one may pierce the first one at all closed states of a box."""

    def __init__(self, array: Array, one: int, two: int, margin: Fraction) -> None:
        self.array, self.low, self.high = array, margin, array.thickness - margin
        need(self.low < self.high, "panels are no thicker than twice the margin")
        self.sides = shrunk_sides(array, array.facets[one], margin)
        self.inner = shrunk_points(array, array.facets[two], margin)
        self.samples = [(x, y, z) for z in (self.low, self.high) for x, y in self.inner]
        start, end = array.panel_of[one], array.panel_of[two]
        need(start != end, "two facets are in one panel")
        first = array.ways(start)[end]
        second = array.ways(start, frozenset(k for k, _ in first)).get(end)
        self.ways = [way for way in (first, second) if way]
        points = np.array(self.samples, float)
        i, j = np.nonzero(~np.eye(len(points), dtype=bool))
        self.segments = np.stack([i, j])

    def pierced(self, box: Middle) -> tuple[float, Any]:
        """The deepest piercing at the middle of a box, by floating-point numbers: two points, a height, and a way."""
        way = min(self.ways, key=lambda steps: sum(box.radius[k] for k, _ in steps))
        _, pose = box.walked(way)
        turn, shift = (
            np.array([[Fraction(x, pose.divisor) for x in np.ravel(own)]], float) for own in (pose.turn, pose.shift)
        )
        metric = np.sqrt([self.array.root, 1.0])
        seen = np.array(self.samples, float) @ turn.reshape(3, 3).T + shift
        upper, lower = seen[self.segments]
        best, found = 0.0, None
        for share in (0.5, 0.2, 0.8):
            height = float(self.low + (self.high - self.low) * Fraction(share))
            along = (upper[:, 2] - height) / np.where(upper[:, 2] == lower[:, 2], np.inf, upper[:, 2] - lower[:, 2])
            for near in (1.0, 0.5, 0.25, 0.1):
                ends = [along - near * along, along + near * (1.0 - along)]
                depth = np.full(len(along), np.inf)
                for end, sign in zip(ends, (1, -1), strict=True):
                    place = upper + end[:, None] * (lower - upper)
                    depth = np.minimum(depth, sign * (place[:, 2] - height))
                    for a, b, c in self.sides:
                        wide = np.hypot(a / metric[0], b)
                        depth = np.minimum(depth, (float(c) - place[:, :2] @ [a, b]) / wide)
                depth = np.where((along > 0) & (along < 1), depth, 0.0)
                k = int(depth.argmax())
                if depth[k] > best:
                    best, found = float(depth[k]), (*self.segments[:, k], ends[0][k], ends[1][k], height, way)
        return best, found

    def points(self, found: Any) -> list[tuple[Fraction, ...]]:
        """The upper and the lower point of a piercing, on the segment between two samples."""
        upper, lower = (self.samples[k] for k in found[:2])
        shares = [min(max(Fraction(round(x * 2**20), 2**20), Fraction(0)), Fraction(1)) for x in found[2:4]]
        return [tuple(a + s * (b - a) for a, b in zip(upper, lower, strict=True)) for s in shares]

    def forms(self, box: Middle, found: Any) -> list[Form]:
        """What is above 0 where the piercing lasts: heights of both points, and distances from all sides."""
        lines, pose = box.walked(found[5])
        height, forms = Fraction(found[4]), []
        need(self.low < height < self.high, "a piercing is not within the panel")
        for point, sign in zip(self.points(found), (1, -1), strict=True):
            scale = math.lcm(*(x.denominator for x in point))
            x, y, z = (int(own * scale) for own in point)
            moved = zip(pose.turn, pose.shift, strict=True)
            a, b, c = ((dot(row, (x, y, z)) + s * scale) * box.unit // (pose.divisor * scale) for row, s in moved)
            slopes, bends = box.expanded(lines, (a, b, c), True)
            rest = box.rests(lines, slopes)[1]
            tests = [((0, 0, sign), -sign * height), *(((-p, -q, 0), far) for p, q, far in self.sides)]
            for normal, far in tests:
                bits = max(map(abs, normal)).bit_length() + FINE_BITS - 64
                value = (dot(normal, (a, b, c)) + down(far * box.unit, 1)) >> bits
                form = Form(value, {}, 0, dict.fromkeys(box.half, 0))
                for line, slope in zip(lines, slopes, strict=True):
                    form.slopes[line.hinge] = dot(normal, slope) >> bits
                unknown, total = 0, ONE + sum(box.scaled[line.hinge] for line in lines)
                for i, j, bend in bends:
                    one, two = lines[i].hinge, lines[j].hinge
                    own, weight = dot(normal, bend) >> bits, box.weight(one, two, i == j)
                    value += (own * weight >> 64) if i == j else 0
                    part = (abs(own) * weight >> 64) + 1
                    unknown += part
                    form.shares[one] += part
                    form.shares[two] += part
                p, q, s = normal
                size = root_up(((p * p + self.array.root - 1) // self.array.root + q * q + s * s) << 128) >> bits - 36
                unknown += ((size + 1) * rest >> 64) + 1 + 4 * (total * total >> 128) + 8 + len(bends)
                forms.append(form._replace(value=value, unknown=unknown))
        return forms


def overlap_of(pairs: Sequence[Pair], array: Array) -> Any:
    """A function that proves that some pair overlaps at all closed states of a box, or names the sides to split."""

    def overlap(low: list[int], high: list[int]) -> tuple[bool, dict[int, int] | None]:
        hinges = {k for loop in array.loops for k, _ in loop} | {
            k for pair in pairs for way in pair.ways for k, _ in way
        }
        box = Middle(array, low, high, sorted(hinges))
        equations = Equations(array, array.loops, box)
        equations.guesses([equations.values])
        found = sorted(((*pair.pierced(box), pair) for pair in pairs), key=lambda own: -own[0])[:2]
        hidden = None
        for depth, where, pair in found:
            if depth <= 0:
                continue
            lows = [least(equations, form) for form in pair.forms(box, where)]
            worst = min(lows, key=lambda own: own[0])
            if worst[0] > 0:
                return True, None
            hidden = hidden or {k: share for k, share in worst[1].items() if k in equations.slopes}
        return False, hidden

    return overlap


def least(equations: Equations, form: Form) -> tuple[int, dict[int, int]]:
    """The least value of a form at closed states of a box, times MIX, and the contributions of angles."""
    scaled = equations.box.scaled
    alone = form.value - form.unknown - sum((abs(x) * scaled[k] >> 64) + 1 for k, x in form.slopes.items())
    value, slopes, unknown, shares = equations.combined(equations.compensation(form.slopes))
    moves = {
        k: (abs(slopes.get(k, 0) + MIX * form.slopes.get(k, 0)) * scaled[k] >> 64) + 1
        for k in {**slopes, **form.slopes}
    }
    low = MIX * (form.value - form.unknown) + value - unknown - sum(moves.values())
    own = {k: moves.get(k, 0) + MIX * form.shares.get(k, 0) + shares.get(k, 0) for k in moves}
    return max(MIX * alone, low), own


def shrunk_sides(array: Array, ring: Sequence[tuple[int, int]], margin: Fraction) -> list[tuple[int, int, Fraction]]:
    """The sides of a facet less a margin, as (a, b, c): a X + b Y <= c; a trifle more is cut off."""
    sides = []
    for (px, py), (qx, qy) in zip(ring, [*ring[1:], ring[0]], strict=True):
        a, b = qy - py, px - qx
        square = Fraction(array.root * (qx - px) ** 2 + (qy - py) ** 2, array.root)
        wide = Fraction(isqrt(up(square, ONE * ONE)) + 1, ONE)
        sides.append((a, b, a * px + b * py - margin * wide))
    return sides


def shrunk_points(array: Array, ring: Sequence[tuple[int, int]], margin: Fraction) -> list[tuple[Fraction, Fraction]]:
    """Points of a facet less a margin: its corners, and points half-way to the middle, and the middle."""
    sides, corners = shrunk_sides(array, ring, margin), []
    for (a, b, c), (d, e, f) in zip([sides[-1], *sides[:-1]], sides, strict=True):
        area = a * e - b * d
        if area:
            corners.append(((c * e - b * f) / area, (a * f - c * d) / area))
    x, y = (sum(own, Fraction(0)) / len(corners) for own in zip(*corners, strict=True))
    points = [(x + s * (p - x), y + s * (q - y)) for s in SAMPLE_SHARES for p, q in corners] + [(x, y)]
    inside = all(a * p + b * q <= c for a, b, c in sides for p, q in points)
    need(inside and all(a * x + b * y < c for a, b, c in sides), "a facet is less than twice the margin wide")
    return points


def clipped(ring: list[Any], cutter: list[Any]) -> list[Any]:
    """The part of a convex outline that lies in another one, both counterclockwise."""
    for (ax, ay), (bx, by) in zip(cutter, [*cutter[1:], cutter[0]], strict=True):
        left = [(bx - ax) * (y - ay) - (by - ay) * (x - ax) for x, y in ring]
        whole_ring, ring = ring, []
        for k, (p, s) in enumerate(zip(whole_ring, left, strict=True)):
            q, t = whole_ring[k - 1], left[k - 1]
            if (s > 0) != (t > 0):
                ring.append(tuple(b + t / (t - s) * (a - b) for a, b in zip(p, q, strict=True)))
            if s > 0:
                ring.append(p)
    return ring


def overlapping(array: Array, packed: bool, margin: Fraction) -> bool:
    """Whether facets of different panels, less a margin, overlap at an end."""
    ways, facets = array.ways(0), []
    for ring, panel in zip(array.facets, array.panel_of, strict=True):
        pose = STILL
        for k, _ in ways[panel]:
            if packed and array.hinges[k].closes:
                pose = pose.then(half_turn(array.hinges[k].point, array.hinges[k].way, array.root))
        inner = shrunk_points(array, ring, margin)
        corners, moved = inner[: len(inner) // 2], []
        for x, y in corners:
            at = [row[0] * x + row[1] * y + s for row, s in zip(pose.turn, pose.shift, strict=True)]
            moved.append((at[0] / pose.divisor, at[1] / pose.divisor))
        up_side = pose.turn[2][2] > 0
        level = Fraction(pose.shift[2], pose.divisor) - (0 if up_side else array.thickness)
        facets.append((panel, level, moved if up_side else moved[::-1]))
    for (one, low, ring), (two, level, other) in itertools.combinations(facets, 2):
        if one != two and abs(low - level) < array.thickness - 2 * margin and clipped(ring, other):
            return True
    return False


def check_collisions(claim: Any, array: Array, limit: int | None = None) -> tuple[int, int]:
    """Check that no motion leaves the boxes of a claim without overlap; return numbers as `check_lock`."""
    margin = length(claim["margin"]) / array.unit
    pairs = []
    for pair in listed(claim["pairs_of_facets"]):
        one, two = (whole(k) for k in listed(pair))
        need(min(one, two) >= 0 and max(one, two) < len(array.facets), "a pair is of no facets")
        pairs += [Pair(array, one, two, margin), Pair(array, two, one, margin)]
    need(pairs, "no facets are named that overlap")
    for packed in (True, False):
        need(not overlapping(array, packed, margin), "it says nothing: facets overlap at an end")
    return check_lock(claim, array, overlap_of(pairs, array), limit)
