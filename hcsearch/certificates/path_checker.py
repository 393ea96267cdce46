"""Check a certificate of a path by arithmetic of its own: python path_checker.py FILE

A path leads a linkage from packed to flat with closed loops, with hinges between their stops, and with panels, shrunk
by a margin on every face, that do not overlap. Packed, flat and flat-folded states are decided in fractions; all else is
computed with polynomials whose coefficients have a radius for all errors, those of rounding too. Sums and products are
taken to be rounded to the nearest double, sines and cosines to be off by two units in the last place at most. This file
needs NumPy alone and imports nothing of hcsearch. Why these checks prove the claim: docs/explanation/certificates.md.
"""

import hashlib
import json
import sys
from fractions import Fraction
from math import pi

import numpy as np

EPS = 2.0**-52
TERMS = 9  # coefficients of a polynomial on -1 <= x <= 1; the last one also holds all that is of higher order
FIRST = np.eye(TERMS)[0]
ROUNDED = (3 * np.arange(TERMS) + 5) * EPS  # of sums of 3, 6, 9, ... products of entries of vectors of norms 1
GAMMA = 20 * EPS  # rounding of what bounds are computed from
TINY = 1e-13  # radius of a tube (rad) that is added to what is computed
DEPTH, BATCH = 16, 512  # how often a piece is halved for its gaps, and pieces that are computed at once


class Refused(Exception):
    """The certificate does not prove what it claims."""


def need(condition, reason):
    """Refuse the certificate unless a condition holds."""
    if not condition:
        raise Refused(reason)


class Array:
    """Panels and hinges in the flat state; whole coordinates X, Y, Z stand for (sqrt(root) X, Y, Z) units."""

    def __init__(self, data):
        self.root, self.height, self.unit = int(data["root"]), int(data["thickness"]), Fraction(data["unit"])
        self.facets = [[(int(x), int(y)) for x, y in facet] for facet in data["facets"]]
        self.panel_of = {int(f): k for k, panel in enumerate(data["panels"]) for f in panel}
        need(min(self.root, self.height, self.unit) > 0, "a length is not positive")
        need(sorted(self.panel_of) == list(range(len(self.facets))), "a facet is in no panel")
        for facet in self.facets:
            sides = list(zip(facet, facet[1:] + facet[:1], strict=True))
            need(min(area(*side, p) for side in sides for p in facet) >= 0, "a facet is not convex")
        self.hinges, self.packed = [], [int(bool(hinge["closes"])) for hinge in data["hinges"]]
        for hinge in data["hinges"]:  # (first panel, second panel, point, way): positive angles close the hinge's face
            one, two = (self.facets[int(f)] for f in hinge["facets"])
            edges = set(zip(two, two[1:] + two[:1], strict=True))
            shared = [(p, q) for p, q in zip(one, one[1:] + one[:1], strict=True) if (q, p) in edges]
            need(len(shared) == 1 and hinge["face"] in ("top", "bottom"), "a hinge is no edge that two facets share")
            (p, q), (sign, z) = shared[0], (-1, self.height) if hinge["face"] == "top" else (1, 0)
            panels = (self.panel_of[int(f)] for f in hinge["facets"])
            self.hinges.append((*panels, (*p, z), (sign * (q[0] - p[0]), sign * (q[1] - p[1]), 0)))
        self.way = {0: []}  # hinges and senses that lead from panel 0 to each
        for panel in (waiting := [0]):
            for k, (one, two, *_) in enumerate(self.hinges):
                for here, there, sense in ((one, two, 1), (two, one, -1)):
                    if here == panel and there not in self.way:
                        self.way[there] = [*self.way[here], (k, sense)]
                        waiting.append(there)
        need(len(self.way) == len(set(self.panel_of.values())), "the panels are not joined to one piece")
        used = {k for way in self.way.values() for k, _ in way}
        self.loops = [[*self.way[one], (k, 1), *((h, -s) for h, s in reversed(self.way[two]))]
                      for k, (one, two, *_) in enumerate(self.hinges) if k not in used]  # fmt: skip
        for loop in self.loops:
            while loop[0] == (loop[-1][0], -loop[-1][1]):
                del loop[0], loop[-1]
        corners = np.array([point for facet in self.facets for point in facet], float)
        self.middle, self.size = (
            np.array([*np.rint(corners.mean(0)), self.height // 2]),
            np.abs(corners).max() + self.height,
        )
        self.stretch = np.array([np.sqrt(float(self.root)), 1.0, 1.0])
        self.points = (np.array([hinge[2] for hinge in self.hinges]) - self.middle) * self.stretch / self.size
        ways = np.array([hinge[3] for hinge in self.hinges]) * self.stretch
        self.ways = ways / np.linalg.norm(ways, axis=1, keepdims=True)

    def lines_at(self, closed, loop):
        """The lines of a loop where some hinges are closed: (hinge, point, way) in whole coordinates, exactly."""
        turn, shift, lines = (
            np.array([[Fraction(i == j) for j in range(3)] for i in range(3)]),
            np.array([Fraction(0)] * 3),
            [],
        )
        for hinge, sense in loop:
            p, u = turn @ self.hinges[hinge][2] + shift, sense * (turn @ self.hinges[hinge][3])
            lines.append((hinge, p, u))
            if closed[hinge]:  # by half a turn v goes to 2 u (u.v) / u.u - v
                w = u * [self.root, 1, 1]
                half = 2 * np.outer(u, w) / (w @ u) - np.eye(3, dtype=int)
                turn, shift = half @ turn, p + half @ (shift - p)
        need((turn == np.eye(3)).all() and (shift == 0).all(), "a loop is open at a state where it should be closed")
        return lines

    def turn(self, hinge, sense, sincos):
        """The rotation about a hinge, and the shift of the origin by it, as polynomials."""
        (sin, sr), (low, lr) = ((part[0][:, hinge], part[1][:, hinge]) for part in sincos)
        k, lever = crossed(self.ways[hinge]), self.points[hinge][:, None]
        bent = sense * sin[..., None, None] * k + low[..., None, None] * (k @ k)
        rad = sr + lr + 3 * EPS * (np.abs(sin) + np.abs(low) + FIRST)
        return (bent + FIRST[:, None, None] * np.eye(3), rad), (-bent @ lever, rad * (np.linalg.norm(lever) + EPS))

    def walked(self, steps, sincos):
        """The rotation and the shift that steps of hinges come to, and the axis and the moment of each on the way."""
        count, screws = len(sincos[0][0]), []
        rotation = np.tile(FIRST[:, None, None] * np.eye(3), (count, 1, 1, 1)), np.zeros((count, TERMS))
        shift = np.zeros((count, TERMS, 3, 1)), np.zeros((count, TERMS))
        for hinge, sense in steps:
            way, point = (fixed(vector) for vector in (sense * self.ways[hinge], self.points[hinge]))
            axis, place = times(rotation, way, (True, False)), plus(times(rotation, point, (True, False)), shift)
            screws.append((hinge, axis, times((crossed(place[0][..., 0]), 2 * place[1]), axis)))
            own, moved = self.turn(hinge, sense, sincos)
            shift = plus(shift, times(rotation, moved, (True, False)))
            rotation = times(rotation, own, (True, True))
        return rotation, shift, screws

    def closure(self, angles):
        """Twists of T - 1 of all loops, (6 n_loops,), and derivatives, (6 n_loops, n), with radii, and norms of T - 1."""
        sincos, count, n, rows = sines(angles), len(angles[0]), len(self.hinges), 6 * len(self.loops)
        twists, errors, off = np.zeros((count, TERMS, rows)), np.zeros((count, TERMS)), np.zeros((count, TERMS))
        slopes, rads = np.zeros((count, TERMS, rows, n)), np.zeros((count, TERMS, n))
        for row, loop in zip(range(0, rows, 6), self.loops, strict=True):
            (r, rad), shift, screws = self.walked(loop, sincos)
            skew = r - np.swapaxes(r, 2, 3)
            twists[..., row : row + 3] = 0.5 * np.stack([skew[..., 2, 1], skew[..., 0, 2], skew[..., 1, 0]], -1)
            twists[..., row + 3 : row + 6] = shift[0][..., 0]
            errors += rad + shift[1]
            far = norms((r - FIRST[:, None, None] * np.eye(3), rad)) + rad + norms(shift) + shift[1]
            off += far
            for hinge, axis, moment in screws:
                slopes[:, :, row : row + 6, hinge] += np.concatenate([axis[0], moment[0]], 2)[..., 0]
                # the derivative of T is the screw times T, which differs from 1 by `far`
                rads[:, :, hinge] += axis[1] + moment[1] + 1.5 * folded(norms(axis) + norms(moment) + axis[1], far)
        return (twists, errors), (slopes, rads), off

    def equations(self, closed, moving):
        """Rows that say whether loops are closed while the moving hinges turn, and the screws of those, exactly.

        Turns about one line, or about parallel lines, stay in the group of these, which fewer rows decide.
        """
        rows, screws = [], np.full((6 * len(self.loops), len(self.hinges)), Fraction(0))
        for row, loop in zip(range(0, len(screws), 6), self.loops, strict=True):
            lines = self.lines_at(closed, loop)
            for hinge, p, u in lines:
                x, y, z = p - self.middle.astype(int)
                screws[row : row + 6, hinge] += [*u, -z * u[1], z * u[0], x * u[1] - y * u[0]]
            own = [(p, u) for hinge, p, u in lines if moving[hinge]]
            if not own:
                continue
            p, u = own[0]
            first = 0 if self.root * u[0] ** 2 >= u[1] ** 2 else 1
            if any(u[0] * b[1] != u[1] * b[0] for _, b in own):
                rows += range(row, row + 6)
            elif any((a[0] - p[0]) * u[1] != (a[1] - p[1]) * u[0] or a[2] != p[2] for a, _ in own):
                rows += [row + first, row + 4 - first, row + 5]
            else:
                rows += [row + first]
        return rows, screws[rows][:, moving]


def area(p, q, r):
    """Twice the area of a triangle."""
    return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])


def crossed(vectors):
    """Matrices of cross products with vectors."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.stack([0 * x, -z, y, z, 0 * x, -x, -y, x, 0 * x], -1).reshape(*x.shape, 3, 3)


def fixed(vector):
    """A vector as a polynomial (mid, rad): coefficients (..., TERMS, 3, 1), and radii of their errors, (..., TERMS)."""
    return FIRST[:, None, None] * vector[:, None], 2 * EPS * FIRST


def folded(one, two):
    """The product of polynomials of norms, with all orders beyond the last in the last."""
    product = np.zeros(np.broadcast_shapes(one.shape, two.shape))
    for i in range(TERMS):
        product[..., i:] += one[..., i : i + 1] * two[..., : TERMS - i]
        product[..., -1] += one[..., i] * two[..., TERMS - i :].sum(-1)
    return product * (1 + GAMMA)


def norms(poly, turning=False):
    """Norms of coefficients; turning : whether the first one is a rotation."""
    size = np.sqrt((poly[0] ** 2).sum((-2, -1))) * (1 + GAMMA)
    if turning:
        size[..., 0] = 1 + GAMMA + poly[1][..., 0]
    return size


def times(one, two, turning=(False, False)):
    """The product of two polynomials."""
    shape = np.broadcast_shapes(one[0].shape[:-2], two[0].shape[:-2])
    mid, over = np.zeros((*shape, one[0].shape[-2], two[0].shape[-1])), np.zeros(shape[:-1])
    a, b = norms(one, turning[0]), norms(two, turning[1])
    for i in range(TERMS):
        mid[..., i:, :, :] += one[0][..., i : i + 1, :, :] @ two[0][..., : TERMS - i, :, :]
        over += a[..., i] * b[..., TERMS - i :].sum(-1)
    rad = folded(a, two[1]) + folded(one[1], b + two[1]) + ROUNDED * folded(a, b)
    rad[..., -1] += over
    return mid, rad


def plus(one, two, sign=1.0):
    """The sum of two polynomials, or their difference."""
    mid = one[0] + sign * two[0]
    return mid, one[1] + two[1] + EPS * norms((mid, 0))


def sines(angles):
    """Polynomials sin and 1 - cos, with radii, of angles that are polynomials, (..., TERMS) with radii."""
    one, none = np.zeros((*angles[0].shape, 1, 1)), np.zeros_like(angles[1])
    one[..., 0, :, :] = 1.0
    step = (angles[0] * (1 - FIRST))[..., None, None], angles[1]
    square, far = times(step, step), (np.abs(step[0][..., 0, 0]) + step[1]).sum(-1)
    sin = low = one, none
    for s, c in ((72, 90), (42, 56), (20, 30), (6, 12)):  # Taylor's series, as Horner sums it
        sin, low = (times(square, part) for part in (sin, low))
        sin, low = plus((one, none), (sin[0] / s, sin[1] / s), -1.0), plus((one, none), (low[0] / c, low[1] / c), -1.0)
    (sin, sr), (low, lr) = times(step, sin), times((square[0] / 2, square[1] / 2), low)
    rads = sr + lr + 2 * EPS * (FIRST + norms((sin, sr)) + norms((low, lr)))
    rads[..., -1] += far**11 / 3e7 + far**12 / 4e8  # less than 11! and 12!
    first = angles[0][..., :1]
    s, c, bent, sin, low = np.sin(first), np.cos(first), 2.0 * np.sin(0.5 * first) ** 2, sin[..., 0, 0], low[..., 0, 0]
    return (s * FIRST + c * sin - s * low, rads), (bent * FIRST + s * sin + c * low, rads)


def polynomials(cubics, radii, order=0):
    """Fold angles of pieces, (count, n, 4) cubics; radii : of the coefficients of an order, (count, n) or 0."""
    mid = np.concatenate([cubics, np.zeros((*cubics.shape[:2], TERMS - 4))], 2)
    rad = 2 * EPS * (mid != 0.0)
    rad[..., order] += radii
    return mid, rad


def shifted(cubics, low, high):
    """Cubics of x, in the variable that is -1 and 1 where x is low and high."""
    m, h = 0.5 * (low + high), 0.5 * (high - low)
    a, b, c, d = np.moveaxis(cubics, -1, 0)
    return np.stack(
        [a + m * (b + m * (c + m * d)), h * (b + m * (2 * c + 3 * m * d)), h * h * (c + 3 * m * d), h**3 * d], -1
    )


def scaled(jacobian):
    """Scalings S and gains G, orthonormal columns, with S J G = 1, and the norms of the rows of S."""
    u, values, v = np.linalg.svd(jacobian, full_matrices=False)
    scaling = np.swapaxes(u, -1, -2) / np.maximum(values, 1e-12)[..., None]
    return scaling, np.swapaxes(v, -1, -2), np.linalg.norm(scaling, axis=-1)


def tube(array, rows, moving, cubics, radii=None):
    """What closed states c + G y lie beside each piece, (count, n), as y - S F(c + G y) maps a ball into itself.

    Infinite where it is not proved to. radii : where given, (count, n), of a box about c at x = 0 in which two closed
    states lie that are to be joined.
    """
    twists, slopes, _ = array.closure(polynomials(cubics, 0.0 if radii is None else radii))
    scaling, gains, norm = scaled(slopes[0][:, 0][:, rows][:, :, moving])
    size, around = np.abs(gains), np.zeros(cubics.shape[:2]) if radii is None else radii.copy()
    if radii is None:
        twist = twists[0][:, :, rows] @ np.swapaxes(scaling, 1, 2)
        rest = norm * twists[1].sum(1)[:, None] + TINY
        start, step = np.abs(twist).sum(1) + rest, np.abs(twist @ np.swapaxes(gains, 1, 2)).sum(1)
    else:
        # F is 0 at both, so its mean derivative between them maps their difference to 0, and any part of it to no more
        # than what derivatives differ by in the box
        rest = start = norm * 4.0 * (slopes[1].sum(1) * radii).sum(1)[:, None] + TINY
        step = radii[:, moving]
    wide = 3.0 * start + 0.1 * start.max(1, keepdims=True)
    turned = (size @ wide[..., None])[..., 0]
    around[:, moving] += turned
    _, slopes, off = array.closure(polynomials(cubics, around))
    product = scaling[:, None] @ (slopes[0][:, :, rows][:, :, :, moving] @ gains[:, None])
    product[:, 0] -= np.eye(len(rows))
    rough = np.einsum("pth,ph->p", slopes[1][:, :, moving], turned) + 10 * GAMMA * turned.sum(1)
    moved = (np.abs(product).sum(1) @ wide[..., None])[..., 0] + norm * rough[:, None]
    around[:, moving] = step + (size @ (rest + moved)[..., None])[..., 0]
    around[~((start + moved < wide).all(1) & (off.sum(1) < 0.05))] = np.inf
    return around


def eliminated(rows):
    """Combinations of the rows of a matrix of fractions that are 0, a basis of them."""
    kept, zero = [], []
    for number, row in enumerate(rows):
        own, mix = row.copy(), np.array([Fraction(k == number) for k in range(len(rows))])
        for column, other, parts in kept:
            share = own[column] / other[column]
            own, mix = own - share * other, mix - share * parts
        if own.any():
            kept.append((np.flatnonzero(own)[0], own, mix))
        else:
            zero.append(mix)
    return zero


def departed(array, rows, screws, moving, cubic):
    """What closed states lie beside a cubic, (n, 4), that leaves a state with singular closure by 0 <= u <= 1, (n,).

    Equations along the wrenches that no hinge works against are divided by u^2, those across these by u. The states are
    cubic + u G y. None where it is not proved.
    """
    scale = np.array(
        [array.stretch[0], 1, 1, 1 / array.size, *array.stretch[:1] / array.size, array.stretch[0] / array.size]
    )
    zero = np.array([[float(x) for x in mix] for mix in eliminated(screws)]) / scale[np.array(rows) % 6]
    zero /= np.linalg.norm(zero, axis=1, keepdims=True)
    across = np.linalg.svd(zero)[2][len(zero) :]
    need(np.linalg.cond(np.vstack([zero, across])) < 1e6, "wrenches at an end are not independent")
    (twists, errors), (slopes, _), _ = (part for part in array.closure(polynomials(cubic[None], 0.0)))
    twist, jacobian = twists[0][:, rows], slopes[0][:, rows][:, :, moving]
    scaling, gains, norm = scaled(np.vstack([across @ jacobian[0], zero @ jacobian[1]]))
    # what is of order 0, and along the wrenches also what is of order 1, is 0 exactly
    rest = np.abs(across @ twist[-1]).sum() + 2.0 * errors[0, 1:].sum()
    twist = np.concatenate([twist[1:-1] @ across.T, twist[2:] @ zero.T], axis=1)
    start = np.abs(twist @ scaling.T).sum(0) + norm * rest + TINY
    wide, around = 3.0 * start + 0.1 * start.max(), np.zeros(len(cubic))
    around[moving] = np.abs(gains) @ wide
    _, (slopes, rads), off = array.closure(polynomials(cubic[None], around, order=1))
    product = slopes[0][:, rows][:, :, moving] @ gains
    mids = scaling @ np.concatenate([across @ product[:-1], zero @ product[1:]], axis=1)
    mids[0] -= np.eye(len(rows))
    rough = 2.0 * (rads[0] @ around).sum() + np.abs(across @ product[-1]).sum() * wide.max() + TINY * wide.sum()
    proved = (start + np.abs(mids).sum(0) @ wide + norm * rough < wide).all() and off[0].sum() < 0.05
    return around if proved else None


def led_by_cubics(array, data, closed):
    """A stretch along cubics between states: pieces, what closed states differ from them by, and where it leads."""
    at, angles, rates = (np.array(data[name], float) for name in ("times", "angles", "rates"))
    need(
        angles.ndim == 2 and angles.shape == rates.shape == (len(at), len(array.hinges)) and len(at) > 2,
        "a stretch has no states",
    )
    steps, ended = np.diff(at)[:, None], np.rint(angles[-1] / pi).astype(int)
    need(np.isfinite(angles).all() and np.isfinite(rates).all() and (steps > 0).all(), "times of a stretch do not rise")
    need(
        np.abs(angles[[0, -1]] - pi * np.array([closed, ended])).max() < 1e-15,
        "a stretch does not lead from stop to stop",
    )
    rise, one, two = np.diff(angles, axis=0), steps * rates[:-1], steps * rates[1:]
    a, b, c, d = angles[:-1], one, 3 * rise - 2 * one - two, one + two - 2 * rise
    moving, cubics = (angles != angles[0]).any(0) | rates.any(0), shifted(np.stack([a, b, c, d], -1), 0.0, 1.0)
    rows, around = array.equations(closed, moving)[0], np.zeros(angles[1:].shape)
    ends, singular = (
        (np.stack([a, b, c, d], -1)[0], np.stack([a + b + c + d, -b - 2 * c - 3 * d, c + 3 * d, -d], -1)[-1]),
        [],
    )
    for state, cubic, place in zip((closed, list(ended)), ends, (0, -1), strict=True):
        own, screws = array.equations(state, moving)
        singular.append(bool(eliminated(screws)) or len(own) < len(rows))
        if singular[-1]:  # the piece leaves the state
            left = departed(array, own, screws, moving, np.column_stack([pi * np.array(state), cubic[:, 1:]]))
            need(left is not None, "how a path leaves or reaches a state with singular closure is not proved")
            around[place] = left
    inner = slice(int(singular[0]), len(cubics) - int(singular[1]))
    around[inner] = np.concatenate([tube(array, rows, moving, own) for own in batches(cubics[inner])])
    need(np.isfinite(around).all(), "closed states are not proved to lie beside a path")
    places = np.concatenate([cubics[:1] @ [1, -1, 1, -1], cubics.sum(2)])
    wide = np.maximum(around[np.r_[0, : len(cubics)]], around[np.r_[: len(cubics), -1]]) + 1e-14 * moving
    inner = slice(int(singular[0]), len(places) - int(singular[1]))  # where pieces meet, and regular ends
    still = np.pad(places[inner, :, None], ((0, 0), (0, 0), (0, 3)))
    pairs = zip(batches(still), batches(wide[inner]), strict=True)
    wide[inner] = np.concatenate([tube(array, rows, moving, own, box) for own, box in pairs])
    need(np.isfinite(wide).all(), "closed states of two pieces of a path are not proved to be joined")
    return cubics, np.maximum(wide[:-1], wide[1:]), list(ended)


def batches(table):
    """A table in parts."""
    return [table[k : k + BATCH] for k in range(0, len(table), BATCH)]


def led_by_equal_turns(array, data, closed):
    """A stretch in which hinges turn from stop to stop by one angle x, as `led_by_cubics` has it; closed exactly.

    Before a hinge at p the loop has turned by j x, and after it by k x. T moves a point by a sum of (e^ijx - e^ikx) p.
    """
    moving, width = np.isin(np.arange(len(array.hinges)), [int(hinge) for hinge in data["hinges"]]), 16
    for loop in array.loops:
        sums, level = {}, 0
        lines = [line for line in array.lines_at(closed, loop) if moving[line[0]]]
        for hinge, p, u in lines:
            first = lines[0][2]
            need(first[0] * u[1] == first[1] * u[0], "hinges that turn by one angle are not parallel")
            sense = (1 if array.root * first[0] * u[0] + first[1] * u[1] > 0 else -1) * (-1 if closed[hinge] else 1)
            place = np.array([p[0] * first[1] - p[1] * first[0], p[2]])
            sums[level] = sums.get(level, 0) + place
            level += sense
            sums[level] = sums.get(level, 0) - place
        need(level == 0 and not any(own.any() for own in sums.values()), "hinges that turn by one angle open a loop")
    ended = [one ^ int(move) for one, move in zip(closed, moving, strict=True)]
    cubics = np.zeros((width, len(moving), 4))
    at = np.linspace(0.0, 1.0, width + 1)[:, None, None] * (np.array(ended) - closed) * pi + pi * np.array(closed)
    cubics[..., 0], cubics[..., 1] = 0.5 * (at[1:, 0] + at[:-1, 0]), 0.5 * (at[1:, 0] - at[:-1, 0])
    return cubics, np.full(cubics.shape[:2], 1e-14) * moving, ended


class Solids:
    """Facets as prisms less a margin, (facets, corners, 3), with directions of their sides, and pairs that may meet."""

    def __init__(self, array, margin, give):
        flat = [(np.array(facet) - array.middle[:2]) * array.stretch[:2] / array.size for facet in array.facets]
        need(len({len(facet) for facet in flat}) == 1, "facets have different numbers of corners")
        need(0 < margin < 0.5 * array.height / array.size, "the margin leaves nothing of a panel")
        corners = np.array(flat)
        sides = np.roll(corners, -1, 1) - corners
        sides /= np.linalg.norm(sides, axis=2, keepdims=True)
        normals = np.stack([-sides[..., 1], sides[..., 0]], -1)
        heights = (normals * corners).sum(2) + margin
        both = np.stack([np.roll(normals, 1, 1), normals], 2), np.stack([np.roll(heights, 1, 1), heights], 2)
        inner = np.linalg.solve(both[0], both[1][..., None])[..., 0]
        need(((np.roll(inner, -1, 1) - inner) * sides).sum(2).min() > 0, "the margin leaves nothing of a panel")
        levels = ((z - array.middle[2]) / array.size + s * margin for z, s in ((0, 1), (array.height, -1)))
        self.corners = np.concatenate([np.pad(inner, ((0, 0), (0, 0), (0, 1)), constant_values=z) for z in levels], 1)
        upright = np.tile([0.0, 0.0, 1.0], (len(flat), 1, 1))
        self.edges, self.normals = (
            np.concatenate([upright, np.pad(x, ((0, 0), (0, 0), (0, 1)))], 1) for x in (sides, normals)
        )
        self.middles = self.corners.mean(1)
        self.reaches = np.linalg.norm(self.corners - self.middles[:, None], axis=2).max(1) + 1e-12
        apart, panels = set(), {k: [f for f in array.panel_of if array.panel_of[f] == k] for k in array.way}
        for one, two, point, way in array.hinges:  # panels on the two sides of a hinge keep apart within its stops
            own = [np.concatenate([np.array(array.facets[f]) for f in panels[k]]) - point[:2] for k in (one, two)]
            beside = [(way[0] * x[:, 1] - way[1] * x[:, 0]) * (-1 if point[2] else 1) for x in own]
            far = max(np.linalg.norm(x * array.stretch[:2], axis=1).max() + array.height for x in own) / array.size
            if beside[0].min() >= 0 >= beside[1].max() and 2 * give * far < margin:
                apart.add(frozenset((one, two)))
        kept = [(f, g) for f, one in array.panel_of.items() for g, two in array.panel_of.items()
                if f < g and one != two and frozenset((one, two)) not in apart]  # fmt: skip
        self.pairs = np.array(kept, int).reshape(-1, 2)


def check_gaps(array, solids, cubics, radii):
    """Refuse pieces in which shrunk panels are not proved to keep apart; halves those where pairs are left."""
    waiting = [(cubics[k : k + 64], radii[k : k + 64], None, 0) for k in range(0, len(cubics), 64)]
    while waiting:
        cubics, radii, pairs, depth = waiting.pop()
        left = open_pairs(array, solids, cubics, radii, pairs)
        keep = left.any(1)
        need(depth < DEPTH or not keep.any(), "two panels are not proved to keep apart")
        if keep.any():
            waiting += [(shifted(cubics[keep], x, x + 1.0), radii[keep], left[keep], depth + 1) for x in (-1.0, 0.0)]


def open_pairs(array, solids, cubics, radii, pairs):
    """Which pairs of facets, (count, pairs), are not proved to keep apart throughout each piece."""
    sincos = sines(polynomials(cubics, radii))
    poses = {panel: array.walked(way, sincos)[:2] for panel, way in array.way.items()}
    turns, shifts = (
        [np.stack([poses[array.panel_of[f]][i][j] for f in range(len(array.facets))]) for j in (0, 1)] for i in (0, 1)
    )
    places = (turns[0] @ solids.middles[:, None, None, :, None] + shifts[0])[..., 0]
    spread = (
        np.linalg.norm(places[:, :, 1:], axis=3).sum(2) + (3 * turns[1] + shifts[1]).sum(2) + solids.reaches[:, None]
    )
    one, two = solids.pairs.T
    left = ~(np.linalg.norm(places[one, :, 0] - places[two, :, 0], axis=2) > spread[one] + spread[two]).T
    left = left if pairs is None else left & pairs
    number, pair = np.nonzero(left)
    for own, which in zip(batches(number), batches(pair), strict=True):
        bodies = [(solids.corners[f], solids.normals[f], solids.edges[f], *((x[0][f, own], x[1][f, own]) for x in (turns, shifts)))
                  for f in solids.pairs[which].T]  # fmt: skip
        left[own, which] = ~separated(*bodies)
    return left


def separated(one, two):
    """Whether a direction fixed to one of two prisms separates them throughout each piece, (count,)."""
    (mine, *ways), (yours, *others) = (
        (corners @ back + shift[0][:, :1, :, 0], normals @ back, edges @ back)
        for corners, normals, edges, turn, shift in (one, two)
        for back in (np.swapaxes(turn[0][:, 0], 1, 2),)
    )
    crosses = np.cross(ways[1][:, :, None], others[1][:, None]).reshape(len(mine), -1, 3)
    tried = np.concatenate([ways[0], others[0], crosses], 1)
    long = np.linalg.norm(tried, axis=2, keepdims=True)
    tried = np.where(long > 1e-6, tried / np.maximum(long, 1e-6), 0.0)
    a, b = mine @ np.swapaxes(tried, 1, 2), yours @ np.swapaxes(tried, 1, 2)
    above, below = b.min(1) - a.max(1), a.min(1) - b.max(1)
    best, pick = np.maximum(above, below).argmax(1), np.arange(len(mine))
    way = np.where(above > below, 1.0, -1.0)[pick, best, None] * tried[pick, best]
    return apart(one, two, way) | apart(two, one, -way)


def apart(one, two, way):
    """Whether a direction that turns with the first of two prisms separates them; as it is at x = 0, (count, 3)."""
    (mine, *_, turn, shift), (yours, *_, other, offset) = one, two
    way = np.swapaxes(turn[0][:, 0], 1, 2) @ way[..., None]
    moved = times(turn, (FIRST[:, None, None] * way[:, None], 0.0 * turn[1]), (True, False))
    row = np.swapaxes(moved[0], 2, 3), moved[1]
    along, by = times(row, other, (False, True)), times(row, plus(offset, shift, -1.0))
    heights = (along[0] @ np.swapaxes(yours, 1, 2)[:, None] + by[0])[:, :, 0]
    low = heights[:, 0] - np.abs(heights[:, 1:]).sum(1)
    error = (3 * along[1] + by[1]).sum(1) + 1e-13
    return low.min(1) - error > (mine @ way)[..., 0].max(1)


def check_path(claim):
    """Check that stretches lead from packed to flat, with loops closed, stops kept and shrunk panels apart."""
    array, parts = Array(claim["array"]), []
    margin, closed = float(Fraction(claim["margin"]) / array.unit / Fraction(array.size)), array.packed
    for stretch in claim["stretches"]:
        *part, closed = (led_by_equal_turns if stretch["kind"] == "equal" else led_by_cubics)(array, stretch, closed)
        parts.append(part)
    need(parts and not any(closed), "the path does not end flat")
    cubics, radii = (np.concatenate(own) for own in zip(*parts, strict=True))
    need(
        np.isfinite(cubics).all() and np.isfinite(radii).all() and np.abs(cubics).max() < 9.0,
        "fold angles are out of range",
    )
    ends, give = np.linspace(-1.0, 1.0, 17), 0.0
    for low, high in zip(ends[:-1], ends[1:], strict=True):
        own = shifted(cubics, low, high)
        wide = np.abs(own[..., 1:]).sum(-1) + radii
        give = max(give, float((wide - own[..., 0]).max()), float((wide + own[..., 0]).max() - pi))
    check_gaps(array, Solids(array, margin, give), cubics, radii)
    return f"a path from packed to flat, {give:.1g} rad beyond stops at most, panels shrunk by {float(Fraction(claim['margin'])):g} m"


def checked(claim):
    """What is proved by a claim, in words; Refused where it is not proved, or not of the form that is documented."""
    try:
        with np.errstate(all="ignore"):  # what overflows proves nothing
            return check_path(claim)
    except (KeyError, TypeError, ValueError, IndexError, AttributeError, ArithmeticError, RecursionError) as error:
        raise Refused(f"the claim is not of the documented form ({type(error).__name__}: {error})") from error
    except (np.linalg.LinAlgError, MemoryError) as error:
        raise Refused(f"the claim cannot be computed with ({error})") from error


def main(path):
    """Check the claims of a file that are paths; the exit code is 0 if they hold, 1 if not, and 2 if there are none."""
    try:
        with open(path, encoding="utf-8") as file:
            data = json.load(file)
        text = json.dumps({key: data[key] for key in data if key != "sha256"}, sort_keys=True, separators=(",", ":"))
        need(data["sha256"] == hashlib.sha256(text.encode()).hexdigest(), "the checksum is another")
        claims = [claim for claim in data["claims"] if claim["kind"] == "path"]
        for claim in claims:
            print(f"{data['of']}: proved: {checked(claim)}")
    except Refused as reason:
        print(f"{path}: not proved: {reason}", file=sys.stderr)
        return 1
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        print(f"{path} is no certificate: {type(error).__name__}: {error}", file=sys.stderr)
        return 2
    if not claims:
        print(f"{path} has no claim of a path", file=sys.stderr)
    return 0 if claims else 2


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]) if len(sys.argv) == 2 else __doc__)
