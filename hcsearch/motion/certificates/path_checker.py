"""Check a certificate of a path by independent arithmetic: `python path_checker.py FILE`.

The path leads from packed to flat with closed loops, hinges between their stops, and shrunk facets that do not overlap.
Closure at stops is decided in fractions; all else is computed with polynomials with radii for all errors. Doubles are
taken to be rounded to nearest, sines to two units in the last place. Theory: docs/explanation/certificates.md.
"""

import json
import sys
from fractions import Fraction
from math import pi
from pathlib import Path
from typing import Any

import numpy as np

Reals = np.ndarray[Any, np.dtype[np.float64]]
EPS, GAMMA = 2.0**-52, 20 * 2.0**-52  # of one sum or product of doubles, and of what bounds are computed from
TERMS = 9  # coefficients of a polynomial on -1 <= x <= 1; the last one also holds all that is of higher order
FIRST, ONE = np.eye(TERMS)[0], np.eye(TERMS)[0][:, None, None]  # the constant 1, of numbers and of matrices
ROUNDED = (3 * np.arange(TERMS) + 5) * EPS  # of sums of 3, 6, 9, ... products of entries of vectors of norms 1
TINY, STOPS = 1e-13, 1e-3  # radius of a tube (rad) that is added to what is computed; what stops give (rad)
DEPTH, BATCH = 16, 512  # how often a piece is halved for its gaps, and pieces that are computed at once


class NotProvedError(Exception):
    """The certificate does not prove what it claims."""


def need(condition: Any, reason: str) -> None:
    """Refuse the certificate unless a condition holds."""
    if not condition:
        raise NotProvedError(reason)


class Poly:
    """Polynomials of matrices, (..., TERMS, m, n), with radii of coefficients, (..., TERMS); turning : of rotations."""

    def __init__(self, mid: Reals, rad: Reals, turning: bool = False) -> None:
        self.mid, self.rad, self.turning = mid, rad, turning

    def norms(self) -> Reals:
        """Return the norms of the coefficients; the first coefficient of a rotation is a rotation."""
        size: Reals = np.sqrt((self.mid**2).sum((-2, -1))) * (1 + GAMMA)
        if self.turning:
            size[..., 0] = 1 + GAMMA + self.rad[..., 0]
        return size

    def __add__(self, other: "Poly") -> "Poly":
        mid = self.mid + other.mid
        return Poly(mid, (self.rad + other.rad + EPS * Poly(mid, self.rad).norms()) * (1 + GAMMA))

    def __matmul__(self, other: "Poly") -> "Poly":
        mid, over, a, b = self.mid[..., :1, :, :] @ other.mid, 0.0, self.norms(), other.norms()
        for i in range(1, TERMS):
            mid[..., i:, :, :] += self.mid[..., i : i + 1, :, :] @ other.mid[..., : TERMS - i, :, :]
            over += a[..., i] * b[..., TERMS - i :].sum(-1)
        rad = folded(a, other.rad) + folded(self.rad, b + other.rad) + ROUNDED * folded(a, b)
        rad[..., -1] += over
        return Poly(mid, rad, self.turning and other.turning)


def folded(one: Reals, two: Reals) -> Reals:
    """Return the product of polynomials of norms; orders beyond the last one are added to the last."""
    product = one[..., :1] * two
    for i in range(1, TERMS):
        product[..., i:] += one[..., i : i + 1] * two[..., : TERMS - i]
        product[..., -1] += one[..., i] * two[..., TERMS - i :].sum(-1)
    return product * (1 + GAMMA)


def sines(cubics: Reals, radii: Reals, order: int) -> tuple[Reals, Reals, Reals]:
    """Return sin and 1 - cos of cubics, (count, n, 4), and all radii; radii : (count, n), of one order."""
    mid = np.pad(cubics, ((0, 0), (0, 0), (0, TERMS - 4)))
    rad = 2 * EPS * (mid != 0.0)
    rad[..., order] += radii
    step, one = Poly((mid * (1 - FIRST))[..., None, None], rad), Poly(ONE, 0 * FIRST)
    square, far, sine, less = step @ step, (np.abs(step.mid[..., 0, 0]) + rad).sum(-1), one, one
    for m, n in ((72, 90), (42, 56), (20, 30), (6, 12)):  # Taylor's series, as Horner sums it
        sine, less = (one + Poly(part.mid / -k, part.rad / k) for part, k in ((square @ sine, m), (square @ less, n)))
    sine, less = step @ sine, square @ less  # sin, and 2 - 2 cos
    rads = sine.rad + 0.5 * less.rad + 2 * EPS * (FIRST + sine.norms() + 0.5 * less.norms())
    rads[..., -1] += far**11 / 3e7 + far**12 / 4e8  # less than 11! and 12!
    s, c, sin, low = np.sin(mid[..., :1]), np.cos(mid[..., :1]), sine.mid[..., 0, 0], 0.5 * less.mid[..., 0, 0]
    return s * FIRST + c * sin - s * low, (1 - c) * FIRST + s * sin + c * low, rads


def shifted(cubics: Reals, m: float, h: float) -> Any:
    """Return cubics of x = m + h u as cubics of u."""
    powers = [1, 0, 0, 0], [m, h, 0, 0], [m * m, 2 * m * h, h * h, 0], [m**3, 3 * m * m * h, 3 * m * h * h, h**3]
    return cubics @ np.array(powers)


def across(one: Any, two: Any) -> Any:
    """The cross product of vectors in the plane of X and Y: 0 if parallel; exact for whole numbers."""
    return one[..., 0] * two[..., 1] - one[..., 1] * two[..., 0]


class Array:
    """Panels and hinges in the flat state; integers X, Y, Z stand for (sqrt(root) X, Y, Z) units, over a size."""

    def __init__(self, data: Any) -> None:
        self.root, self.height, sizes = data["root"], data["thickness"], np.array([[len(x)] for x in data["facets"]])
        need(sizes.size * sizes.max() + len(data["hinges"]) < 1500 and set(data["unit"]) <= {*"0123456789/"}, "no size")
        self.corner = corner = np.minimum(np.arange(sizes.max()), sizes - 1)  # the last one again where some have more
        facets = np.array([np.reshape(x, (len(x), 2))[own] for x, own in zip(data["facets"], corner, strict=True)])
        whole, chords = np.array([self.root, self.height, *facets.flat]), facets[:, None] - facets[:, :, None]
        need(whole.dtype == int and np.abs(whole / 1e6).max() < 1 and whole[:2].min() > 0, "a length is not whole")
        self.facets, self.sides = facets, np.take_along_axis(facets, ((corner + 1) % sizes)[..., None], 1) - facets
        need(sizes.min() > 2 and across(self.sides[:, :, None], chords).min() >= 0, "a facet is not convex")
        owned = sorted((facet, panel) for panel, facets in enumerate(data["panels"]) for facet in facets)
        need([facet for facet, _ in owned] == list(range(len(self.facets))), "a facet is not in one panel")
        panel_of, self.panels, self.unit = dict(owned), [panel for _, panel in owned], Fraction(data["unit"])
        self.packed = [{True: 1, False: 0}[hinge["closes"]] for hinge in data["hinges"]]
        self.middle = np.array([*np.rint(self.facets.mean((0, 1))).astype(int), self.height // 2])
        self.size, self.stretch = int(np.abs(self.facets).max()) + self.height, np.sqrt([self.root, 1.0, 1.0])
        self.flat = (self.facets - self.middle[:2]) * self.stretch[:2] / self.size
        self.reach = float(np.linalg.norm(self.flat, axis=2).max()) + self.height / self.size
        self.hinges: list[Any] = []  # (first panel, second panel, point, way): positive angles close the hinge's face
        for hinge in data["hinges"]:
            one, two = (list(zip(x, x[1:] + x[:1], strict=True)) for x in (data["facets"][k] for k in hinge["facets"]))
            shared = [(p, q) for p, q in one if (q, p) in two]
            need(len(shared) == 1 and hinge["face"] in ("top", "bottom"), "a hinge is no edge that two facets share")
            (p, q), (sign, z) = shared[0], (-1, self.height) if hinge["face"] == "top" else (1, 0)
            way = sign * np.subtract([*q, 0], [*p, 0])
            self.hinges.append((*(panel_of[facet] for facet in hinge["facets"]), np.array([*p, z]), way))
        points, ways = (np.array([hinge[k] for hinge in self.hinges]) * self.stretch for k in (2, 3))
        self.points = ((points - self.middle * self.stretch) / self.size)[..., None]
        self.ways = (ways / np.linalg.norm(ways, axis=1, keepdims=True))[..., None]
        self.skew = 1 if np.isin(self.ways, (-1, 0, 1)).all() else 7  # EPS of a turn; none of ways along X and Y
        self.way: dict[int, Any] = {0: []}  # hinges and senses that lead from panel 0 to each
        for panel in (waiting := [0]):
            for k, (one, two, *_) in enumerate(self.hinges):
                for here, there, sense in ((one, two, 1), (two, one, -1)):
                    if here == panel and there not in self.way:
                        self.way[there] = [*self.way[here], (k, sense)]
                        waiting.append(there)
        need(set(self.way) == set(self.panels), "the panels are not joined to one piece")
        self.loops = []
        for k in set(range(len(self.hinges))) - {k for way in self.way.values() for k, _ in way}:
            start, back = (self.way[panel] for panel in self.hinges[k][:2])
            same = sum(a == b for a, b in zip(start, back, strict=False))  # ways from panel 0 part once
            self.loops.append([*start[same:], (k, 1), *((h, -sense) for h, sense in reversed(back[same:]))])

    def lines_at(self, closed: list[int], loop: Any) -> list[Any]:
        """Return the exact lines of a loop where some hinges are closed: (hinge, point, way) in whole coordinates."""
        still, lines = np.eye(3, dtype=int) * Fraction(1), []
        turn, shift = still, 0 * still[0]
        for hinge, sense in loop:
            p, u = turn @ self.hinges[hinge][2] + shift, sense * (turn @ self.hinges[hinge][3])
            lines.append((hinge, p, u))
            if closed[hinge]:  # by half a turn v goes to 2 u (u.v) / u.u - v
                w = u * [self.root, 1, 1]
                half = 2 * np.outer(u, w) / (w @ u) - still
                turn, shift = half @ turn, p + half @ (shift - p)
        need((turn == still).all() and not shift.any(), "a loop is open at a state where it should be closed")
        return lines

    def equations(self, closed: list[int], moving: Any) -> tuple[list[int], Reals]:
        """Return the rows that decide closure for the moving hinges, and their left null space over all screws."""
        rows, s, size = list[int](), self.stretch[0], self.size
        screws = np.full((6 * len(self.loops), len(self.hinges)), Fraction(0))
        for row, loop in zip(range(0, len(screws), 6), self.loops, strict=True):
            lines = self.lines_at(closed, loop)
            for hinge, p, u in lines:
                x, y, z = p - self.middle
                screws[row : row + 6, hinge] += [*u, -z * u[1], z * u[0], x * u[1] - y * u[0]]
            own = [(p, u) for hinge, p, u in lines if moving[hinge]]
            for p, u in own[:1]:  # turns about one line, or parallel ones, stay in a group of such
                first = 0 if self.root * u[0] ** 2 >= u[1] ** 2 else 1
                if any(across(u, b) for _, b in own):
                    rows += range(row, row + 6)
                else:
                    apart = any(across(a - p, u) or a[2] != p[2] for a, _ in own)
                    rows += [row + first, row + 4 - first, row + 5] if apart else [row + first]
        table, count = [*np.hstack([screws[rows][:, moving], np.eye(len(rows), dtype=int) * Fraction(1)])], moving.sum()
        for column in range(count):
            for pivot in [own for own in table if own[column]][:1]:
                table = [own - own[column] / pivot[column] * pivot for own in table if own is not pivot]
        wrenches = np.array([own[count:] for own in table], float).reshape(len(table), len(rows))
        wrenches /= np.array([s, 1, 1, 1 / size, s / size, s / size])[np.array(rows, int) % 6]
        return rows, wrenches / np.linalg.norm(wrenches, axis=1, keepdims=True)

    def walked(self, steps: Any, angles: Any) -> tuple[Poly, Poly, list[Any]]:
        """Return the rotation and the shift of a walk along hinges, and the axis and the moment of each hinge."""
        count, screws, still = len(angles[0]), [], ONE * np.eye(3)
        rotation = Poly(np.tile(still, (count, 1, 1, 1)), np.zeros((count, TERMS)), turning=True)
        shift = Poly(np.zeros((count, TERMS, 3, 1)), np.zeros((count, TERMS)))
        for hinge, sense in steps:
            way, point, (sin, low, rads) = sense * self.ways[hinge], self.points[hinge], (x[:, hinge] for x in angles)
            axis, place = (rotation @ Poly(ONE * x, 2 * EPS * np.linalg.norm(x) * FIRST) for x in (way, point))
            place += shift
            screws.append((hinge, axis, Poly(np.cross(np.eye(3), np.swapaxes(place.mid, 2, 3)), 2 * place.rad) @ axis))
            cross = np.cross(np.eye(3), way[:, 0])
            bent = sin[..., None, None] * cross + low[..., None, None] * (cross @ cross)
            rounded = EPS * (np.abs(sin) + np.abs(low) + FIRST)
            rad = 1.5 * rads + self.skew * rounded  # errors of sin and of 1 - cos are at right angles
            shift += rotation @ Poly(-bent @ point, (rad + 3 * rounded) * np.linalg.norm(point) * (1 + GAMMA))
            rotation @= Poly(bent + still, rad, turning=True)
        return rotation, shift, screws

    def closure(self, cubics: Reals, radii: Reals, order: int) -> tuple[Poly, Poly, Reals]:
        """Twists of T - 1 of loops, (6 n_loops, 1), derivatives, radii of columns, and bounds of T - 1, (count,)."""
        angles, count, n, rows = sines(cubics, radii, order), len(cubics), len(self.hinges), 6 * len(self.loops)
        twists = Poly(np.zeros((count, TERMS, rows, 1)), np.zeros((count, TERMS)))
        slopes, off = Poly(np.zeros((count, TERMS, rows, n)), np.zeros((count, TERMS, n))), np.zeros(count)
        for row, loop in zip(range(0, rows, 6), self.loops, strict=True):
            turn, shift, screws = self.walked(loop, angles)
            skew = 0.5 * (turn.mid - np.swapaxes(turn.mid, 2, 3))
            twists.mid[..., row : row + 3, 0] = np.stack([skew[..., 2, 1], skew[..., 0, 2], skew[..., 1, 0]], -1)
            twists.mid[..., row + 3 : row + 6, :] = shift.mid
            twists.rad += turn.rad + shift.rad
            far = Poly(turn.mid - ONE * np.eye(3), turn.rad).norms() + turn.rad + shift.norms() + shift.rad
            off += far.sum(1)
            for hinge, axis, moment in screws:
                slopes.mid[:, :, row : row + 6, hinge] += np.concatenate([axis.mid, moment.mid], 2)[..., 0]
                size = axis.norms() + moment.norms() + axis.rad  # a derivative is a screw times T, 1 but for `far`
                slopes.rad[:, :, hinge] += axis.rad + moment.rad + 1.5 * folded(size, far)
        return twists, slopes, off

    def tube(self, rows: list[int], moving: Any, cubics: Reals, wrenches: Reals, radii: Any = None) -> Reals:
        """Return bounds, (count, n), of closed states c + G y beside pieces: y - S F(c + G y) maps a box into itself.

        Infinite if not proved. wrenches : those that no hinge works against at c where x is 0; if there are any, states
        are c + x G y for 0 <= x <= 1, and equations along wrenches are divided by x^2, others by x. radii : of a box
        about c at x = 0 in which two closed states lie that are to be joined.
        """
        order, (_, values, others) = int(len(wrenches) > 0), np.linalg.svd(wrenches)
        need((values > 1e-6).all(), "wrenches at an end are not independent")

        def divided(parts: Reals) -> Reals:  # of what is 0 along wrenches where x is 0
            along = np.pad(wrenches @ parts[:, 1:], ((0, 0), (0, 1), (0, 0), (0, 0)))
            return np.concatenate([others[len(wrenches) :] @ parts, along], 2)

        around = np.zeros(cubics.shape[:2]) if radii is None else radii.copy()
        twists, slopes, _ = self.closure(cubics, around, order)
        u, values, v = np.linalg.svd(divided(slopes.mid[:, :2, rows][..., moving])[:, 0], full_matrices=False)
        scaling, gains = np.swapaxes(u, 1, 2) / np.maximum(values, 1e-12)[..., None], np.swapaxes(v, 1, 2)
        norm, size = np.linalg.norm(scaling, axis=2), np.abs(gains)
        twist = (scaling[:, None] @ divided(twists.mid[:, order:, rows]))[..., 0]
        rest = (1 + order) * twists.rad[:, order:].sum(1)
        if radii is not None:  # F is 0 at both: the mean derivative between them maps their difference to 0
            twist, rest = 0.0 * twist, 4.0 * (slopes.rad.sum(1) * radii).sum(1)
        rest = norm * rest[:, None] + TINY
        start, step = np.abs(twist).sum(1) + rest, around[:, moving] + np.abs(twist @ v).sum(1)
        product = scaling[:, None] @ divided(slopes.mid[:, :, rows][..., moving] @ gains[:, None])
        product[:, 0] -= np.eye(len(rows))
        far, floor = np.abs(product).sum(1), 0.1 * start.max(1, keepdims=True, initial=0.0)
        wide = np.abs(np.linalg.solve(np.eye(len(rows)) - far, (3.0 * start + floor)[..., None]))  # any box will do
        turned = (size @ wide)[..., 0]
        around[:, moving] += turned
        _, slopes, off = self.closure(cubics, around, order)
        rough = (1 + order) * np.einsum("pth,ph->p", slopes.rad[..., moving], turned) + 10 * GAMMA * turned.sum(1)
        moved = (start + (far @ wide)[..., 0] + norm * rough[:, None]) * (1 + GAMMA)
        around[:, moving] = step + (size @ (rest + moved - start)[..., None])[..., 0]
        around[~((moved < wide[..., 0]).all(1) & (off < 0.05))] = np.inf
        return around

    def led_by_cubics(self, data: Any, closed: list[int]) -> tuple[Reals, Reals, list[int]]:
        """Prove a stretch along cubics; return its pieces, the deviations of closed states, and its end state."""
        at, angles, rates = (np.array(data[name], float) for name in ("times", "angles", "rates"))
        need(angles.shape == rates.shape == (*at.shape, len(self.hinges)) and len(at) > 2, "a stretch has no states")
        steps, ended = np.diff(at)[:, None], [int(angle > 1) for angle in angles[-1]]
        stops = pi * np.array([closed, ended])
        need((angles[[0, -1]] == stops).all() and (steps > 0).all(), "a stretch ends at no stop, or times do not rise")
        ends = np.stack([angles[:-1], steps * rates[:-1], np.diff(angles, axis=0), steps * rates[1:]], -1)
        spans = ends @ [[1, 0, 0, 0], [0, 1, -2, 1], [0, 0, 3, -2], [0, 0, -1, 1]]  # cubics of 0 <= x <= 1
        moving, cubics, inner = (angles != angles[0]).any(0) | rates.any(0), shifted(spans, 0.5, 0.5), [0, len(spans)]
        rows, around = self.equations(closed, moving)[0], np.zeros((len(spans), len(self.hinges)))
        for state, cubic, place in ((closed, spans[0], 0), (ended, shifted(spans[-1], 1.0, -1.0), -1)):
            own, wrenches = self.equations(state, moving)
            if len(wrenches):  # the piece leaves a state with singular closure
                cubic[:, 0] = pi * np.array(state)
                around[place] = self.tube(own, moving, cubic[None], wrenches)[0]
                inner[place] += 1 + 2 * place
        first, end = inner
        around[first:end] = self.tube(rows, moving, cubics[first:end], wrenches[:0])
        sides, end = np.pad(around, ((1, 1), (0, 0)), "edge"), end + 1  # pieces are joined where they meet
        wide = np.maximum(sides[1:], sides[:-1]) + 1e-14 * moving
        places = np.concatenate([cubics[:1] @ [1, -1, 1, -1], cubics.sum(2)])[first:end, :, None] * [1, 0, 0, 0]
        wide[first:end] = self.tube(rows, moving, places, wrenches[:0], wide[first:end])
        need(np.isfinite(wide).all(), "closed states are not proved to lie beside a path, and to be joined")
        return cubics, np.maximum(wide[:-1], wide[1:]), ended

    def led_by_equal_turns(self, data: Any, closed: list[int]) -> tuple[Reals, Reals, list[int]]:
        """Prove a stretch in which hinges turn from stop to stop by one angle x; return as `led_by_cubics`."""
        moving = np.array([hinge in data["hinges"] for hinge in range(len(self.hinges))])
        for loop in self.loops:
            lines, level = [line for line in self.lines_at(closed, loop) if moving[line[0]]], 0  # turned by level x
            sums = np.zeros((2 * len(lines) + 1, 2), int) * Fraction(1)  # T moves a point by a sum of e^ijx p - e^ikx p
            for hinge, p, u in lines:
                first = lines[0][2]
                need(across(first, u) == 0, "hinges that turn by one angle are not parallel")
                sums[level] += [across(p, first), p[2]]
                level += 1 if (self.root * first[0] * u[0] + first[1] * u[1] > 0) != closed[hinge] else -1
                sums[level] -= [across(p, first), p[2]]
            need(level == 0 and not sums.any(), "hinges that turn by one angle open a loop")
        ended = [one ^ int(move) for one, move in zip(closed, moving, strict=True)]
        at = pi * (np.array(closed) + np.linspace(0.0, 1.0, 17)[:, None] * np.subtract(ended, closed))
        cubics = np.stack([0.5 * (at[1:] + at[:-1]), 0.5 * (at[1:] - at[:-1]), 0 * at[1:], 0 * at[1:]], -1)
        return cubics, np.full(cubics.shape[:2], 1e-14) * moving, ended

    def shrink(self, margin: float) -> None:
        """Make facets prisms less a margin, (facets, corners, 3), with directions of sides; list pairs of panels."""
        sides = self.sides * self.stretch[:2] / np.linalg.norm(self.sides * self.stretch[:2], axis=2, keepdims=True)
        normals, hinge_of = sides[..., ::-1] * [-1, 1], np.full((len(sides), len(sides)), len(self.hinges))
        before = np.take_along_axis(normals, self.corner[..., None] - 1, 1)
        inner = self.flat + margin * (before + normals) / (1.0 + (before * normals).sum(2, keepdims=True))
        left = ((np.roll(inner, -1, 1) - inner) * sides).sum(2)[np.roll(self.corner, -1, 1) != self.corner].min() > 0
        need(left and 0 < margin < 0.5 * self.height / self.size, "the margin leaves nothing of a panel")
        levels = ((z - self.middle[2]) / self.size + s * margin for z, s in ((0, 1), (self.height, -1)))
        self.corners = np.concatenate([np.insert(inner, 2, level, 2) for level in levels], 1)
        self.edges, self.normals = (np.insert(np.insert(x, 2, 0.0, 2), 0, [0, 0, 1], 1) for x in (sides, normals))
        for k, (one, two, point, way) in enumerate(self.hinges):  # panels on two sides keep apart within its stops
            beside = across(way, self.facets - point[:2]) * (-1 if point[2] else 1)
            mine, yours = np.equal(self.panels, one), np.equal(self.panels, two)
            if beside[mine].min() >= 0 >= beside[yours].max():
                hinge_of[np.ix_(mine, yours)] = hinge_of[np.ix_(yours, mine)] = k
        self.pairs = np.argwhere(np.triu(np.not_equal.outer(self.panels, self.panels)))
        self.hinge_of, self.give = hinge_of[tuple(self.pairs.T)], 0.25 * margin / self.reach

    def check_gaps(self, cubics: Reals, radii: Reals) -> None:
        """Refuse pieces in which shrunk facets may overlap or hinges pass their stops; halve undecided pieces."""
        middles = self.corners.mean(1, keepdims=True)
        wide = np.linalg.norm(self.corners - middles, axis=2).max(1)[self.pairs].sum(1)[:, None] + 1e-12
        every, (one, two) = np.ones((len(cubics), len(self.pairs)), bool), self.pairs.T
        waiting = [(cubics[k : k + 64], radii[k : k + 64], every[k : k + 64], 0) for k in range(0, len(cubics), 64)]
        while waiting:
            cubics, radii, pairs, depth = waiting.pop()
            turned = np.abs(cubics - [0.5 * pi, 0, 0, 0]).sum(2) + radii
            left = pairs & ~np.pad(turned < 0.5 * pi + self.give, ((0, 0), (0, 1)))[:, self.hinge_of]
            angles = sines(cubics, radii, 0)
            poses = {panel: self.walked(way, angles)[:2] for panel, way in self.way.items()}
            posed = zip(*(poses[panel] for panel in self.panels), strict=True)
            turns, shifts = (Poly(np.stack([x.mid for x in own]), np.stack([x.rad for x in own])) for own in posed)
            places = (turns.mid @ np.swapaxes(middles, 1, 2)[:, None, None] + shifts.mid)[..., 0]
            reach = np.linalg.norm(places[:, :, 1:], axis=3).sum(2) + (self.reach * turns.rad + shifts.rad).sum(2)
            left &= ~(np.linalg.norm(places[one, :, 0] - places[two, :, 0], axis=2) > reach[one] + reach[two] + wide).T
            number, pair = np.nonzero(left)
            for k in (slice(start, start + BATCH) for start in range(0, len(number), BATCH)):
                left[number[k], pair[k]] = ~self.separated(turns, shifts, number[k], self.pairs[pair[k]].T)
            keep = left.any(1) | ~(turned < 0.5 * pi + STOPS).all(1)
            need(depth < DEPTH or not keep.any(), "panels are not proved to keep apart, or hinges within their stops")
            if keep.any():
                radii = radii[keep] + 8 * EPS * np.abs(cubics[keep]).sum(2)  # halves are rounded
                waiting += [(shifted(cubics[keep], x, 0.5), radii, left[keep], depth + 1) for x in (-0.5, 0.5)]

    def separated(self, turns: Poly, shifts: Poly, number: Any, facets: Any) -> Any:
        """Whether a direction fixed to one of two prisms separates them throughout each piece, (count,)."""
        (f, g), size, apart = facets, len(number), np.zeros(len(number), bool)
        turn, other = (Poly(turns.mid[k, number], turns.rad[k, number], turning=True) for k in facets)
        shift, offset = (Poly(shifts.mid[k, number], shifts.rad[k, number]) for k in facets)
        back = Poly(np.swapaxes(turn.mid, 2, 3), turn.rad, turning=True)
        turn, shift = back @ other, back @ (offset + Poly(-shift.mid, shift.rad))  # of the second, for the first one
        back = Poly(np.swapaxes(turn.mid, 2, 3), turn.rad, turning=True)
        mine, yours, home = self.corners[f], self.corners[g], back.mid[:, 0]
        crosses = np.cross(self.edges[f][:, :, None], (self.edges[g] @ home)[:, None]).reshape(size, -1, 3)
        tried = np.concatenate([self.normals[f], self.normals[g] @ home, crosses], 1)
        tried = np.swapaxes(tried / np.maximum(np.linalg.norm(tried, axis=2, keepdims=True), 1e-6), 1, 2)
        a, b = mine @ tried, (yours @ home + shift.mid[:, :1, :, 0]) @ tried
        gaps = np.concatenate([b.min(1) - a.max(1), a.min(1) - b.max(1)], 1)
        way = np.concatenate([tried, -tried], 2)[np.arange(size), :, gaps.argmax(1), None]
        orders = ((mine, yours, turn, shift, way), (yours, mine, back, back @ Poly(-shift.mid, shift.rad), -home @ way))
        for still, other, turn, shift, way in orders:
            heights = np.swapaxes(way, 1, 2)[:, None] @ (turn.mid @ np.swapaxes(other, 1, 2)[:, None] + shift.mid)
            low = heights[:, 0, 0] - np.abs(heights[:, 1:, 0]).sum(1)
            error = (self.reach * turn.rad + shift.rad).sum(1) * (1 + GAMMA) + 1e-13
            apart |= low.min(1) - error > (still @ way)[..., 0].max(1)
        return apart


def checked(claim: Any) -> str:
    """Return the proved claim as a sentence; refuse a claim that is not proved, or not of the documented form."""
    try:
        with np.errstate(all="ignore"):  # what overflows proves nothing
            array, parts = Array(claim["array"]), []
            closed, lead = array.packed, {"equal": array.led_by_equal_turns, "cubics": array.led_by_cubics}
            for stretch in claim["stretches"]:
                *part, closed = lead[stretch["kind"]](stretch, closed)
                parts.append(part)
            need(parts and not any(closed), "the path does not end flat")
            array.shrink(float(claim["margin"]) / float(array.unit) / array.size)
            array.check_gaps(*(np.concatenate(own) for own in zip(*parts, strict=True)))
    except (LookupError, TypeError, ValueError, AttributeError, ArithmeticError, RuntimeError, MemoryError) as error:
        raise NotProvedError(f"the claim is not of the documented form ({type(error).__name__}: {error})") from error
    return f"a path from packed to flat, {STOPS:g} rad beyond stops at most, facets shrunk by {claim['margin']} m"


def main(path: str) -> None:
    """Check the claims of paths in a file; stop with the reason if one fails."""
    try:
        data = json.loads(Path(path).read_text(encoding="utf-8"))
        claims = [claim for claim in data["claims"] if claim["kind"] == "path"] or ["no path is claimed"]
        print(*(f"{data['of']}: proved: {checked(claim)}" for claim in claims), sep="\n")
    except (NotProvedError, OSError, ValueError, LookupError, TypeError, RecursionError) as error:
        sys.exit(f"{path}: not proved: {error}")


if __name__ == "__main__":
    main(sys.argv[1]) if len(sys.argv) == 2 else sys.exit(__doc__)
