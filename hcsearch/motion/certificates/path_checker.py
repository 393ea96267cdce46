"""Check a certificate of a path by independent arithmetic: `python path_checker.py FILE`.

The path leads from packed to flat with closed loops, hinges between their stops, and shrunk facets that do not overlap.
Closure at stops is decided in fractions; all else is computed with polynomials with radii for all errors. This file
needs NumPy, and beside it `balls.py`, `polynomials.py` and `certificate_grammar.py`, and imports nothing else of
hcsearch. Numbers in brackets are those of docs/explanation/certificates.md.
"""

from fractions import Fraction
from math import pi
from typing import Any

import numpy as np

if __package__:
    from hcsearch.motion.certificates import balls, certificate_grammar
    from hcsearch.motion.certificates.certificate_grammar import NotProvedError, formed, need
    from hcsearch.motion.certificates.polynomials import CHAIN, FIRST, ONE, TERMS, Poly, folded, shifted, sines
else:  # a program by itself, in one folder with the others
    import balls  # type: ignore[import-not-found, no-redef]
    import certificate_grammar  # type: ignore[import-not-found, no-redef]
    from certificate_grammar import NotProvedError, formed, need  # type: ignore[no-redef]
    from polynomials import (  # type: ignore[import-not-found, no-redef]
        CHAIN,
        FIRST,
        ONE,
        TERMS,
        Poly,
        folded,
        shifted,
        sines,
    )

__all__ = ["NotProvedError", "checked"]
Reals = np.ndarray[Any, np.dtype[np.float64]]
EPS, up, Clock, entry = balls.EPS, balls.up, certificate_grammar.Clock, certificate_grammar.entry
TINY, STOPS = 1e-13, 1e-3  # added to the computed radius of a tube (rad); tolerance of stops (rad)
DEPTH, BATCH = 16, 512  # halvings of a piece for its gaps, at most; pieces that are computed at once
CELLS, MOST_CELLS = 2**20, 2**17  # entries of derivatives: of pieces at once, and of one state
CORNERS, ANGLES = 100, 500_000  # limits of the format: corners of a facet, and pieces times hinges
EQUAL, HEIGHTS = 16, 2**22  # pieces of equal turns; heights of corners along directions, of pieces at once


def across(one: Any, two: Any) -> Any:
    """The cross product of vectors in the plane of X and Y: 0 if parallel; exact for whole numbers."""
    return one[..., 0] * two[..., 1] - one[..., 1] * two[..., 0]


class Array:
    """Panels and hinges in the flat state; integers X, Y, Z stand for (sqrt(root) X, Y, Z) units, divided by a size."""

    def __init__(self, data: Any, clock: certificate_grammar.Clock | None = None) -> None:
        own, self.clock = certificate_grammar.ArrayData(data), clock or Clock()
        self.root, self.height, self.unit, self.panels = own.root, own.height, own.unit, own.panel_of
        sizes = np.array([[len(facet)] for facet in own.facets])
        formed(sizes.max() <= CORNERS, f"a facet of a path has more than {CORNERS} corners")
        self.corner = corner = np.minimum(np.arange(sizes.max()), sizes - 1)  # the last repeats where others have more
        facets = np.array([np.array(facet)[at] for facet, at in zip(own.facets, corner, strict=True)])
        self.facets, self.sides = facets, np.take_along_axis(facets, ((corner + 1) % sizes)[..., None], 1) - facets
        self.packed = [int(hinge.closes) for hinge in own.hinges]
        self.middle = np.array([*np.rint(facets.mean((0, 1))).astype(int), own.height // 2])
        largest = int(np.abs(facets - self.middle[:2]).max()) + own.height
        self.size = 2.0 ** largest.bit_length()  # no coordinate is above sqrt(root)
        self.stretch = np.sqrt([own.root, 1.0, 1.0])
        self.flat = (facets - self.middle[:2]) / self.size * self.stretch[:2]
        self.reach = float(up(balls.norms(self.flat).max() + own.height / self.size, 5))
        self.hinges: list[Any] = []  # (first panel, second panel, point, way): positive angles close the hinge's face
        for one, two, p, q, top, _ in own.hinges:
            way = (-1 if top else 1) * np.subtract([*q, 0], [*p, 0])
            self.hinges.append((one, two, np.array([*p, own.height if top else 0]), way))
        points, ways = (np.array([hinge[k] for hinge in self.hinges]).reshape(-1, 3) for k in (2, 3))
        self.points = balls.lattice((points - self.middle) / self.size, own.root)
        self.ways = balls.directions(balls.lattice(ways, own.root))
        self.way: dict[int, Any] = {0: []}  # hinges and senses that lead from panel 0 to each
        for panel in (waiting := [0]):
            for k, (one, two, *_) in enumerate(self.hinges):
                for here, there, sense in ((one, two, 1), (two, one, -1)):
                    if here == panel and there not in self.way:
                        self.way[there] = [*self.way[here], (k, sense)]
                        waiting.append(there)
        formed(set(self.way) == set(self.panels), "the panels are not joined to one piece")
        self.loops = []
        for k in sorted(set(range(len(self.hinges))) - {k for way in self.way.values() for k, _ in way}):
            start, back = (self.way[panel] for panel in self.hinges[k][:2])
            same = sum(a == b for a, b in zip(start, back, strict=False))  # ways from panel 0 part once
            self.loops.append([*start[same:], (k, 1), *((h, -sense) for h, sense in reversed(back[same:]))])
        self.cells = 6 * max(1, len(self.loops)) * max(1, len(self.hinges))
        formed(self.cells <= MOST_CELLS, "the loops of a path have too many hinges")

    def lines_at(self, closed: list[int], loop: Any) -> list[Any]:
        """Return the exact lines of a loop where some hinges are closed: (hinge, point, way) in whole coordinates."""
        still, lines = np.eye(3, dtype=int) * Fraction(1), []
        turn, shift = still, 0 * still[0]
        for hinge, sense in loop:
            self.clock.check()
            p, u = turn @ self.hinges[hinge][2] + shift, sense * (turn @ self.hinges[hinge][3])
            lines.append((hinge, p, u))
            if closed[hinge]:  # by half a turn v goes to 2 u (u.v) / u.u - v
                w = u * [self.root, 1, 1]
                half = 2 * np.outer(u, w) / (w @ u) - still
                turn, shift = half @ turn, p + half @ (shift - p)
        need((turn == still).all() and not shift.any(), "a loop is open at a state where it should be closed")
        return lines

    def equations(self, closed: list[int], moving: Any) -> tuple[list[int], Reals]:
        """Return the rows that decide closure for the moving hinges, and their left null space of all screws [3, 7]."""
        rows, s, size = list[int](), self.stretch[0], self.size
        screws = np.full((6 * len(self.loops), len(self.hinges)), Fraction(0))
        for row, loop in zip(range(0, len(screws), 6), self.loops, strict=True):
            lines = self.lines_at(closed, loop)
            for hinge, p, u in lines:
                x, y, z = p - self.middle
                screws[row : row + 6, hinge] += [*u, -z * u[1], z * u[0], x * u[1] - y * u[0]]
            own = [(p, u) for hinge, p, u in lines if moving[hinge]]
            for p, u in own[:1]:  # turns about one line, or about parallel lines, form a group
                first = 0 if self.root * u[0] ** 2 >= u[1] ** 2 else 1
                if any(across(u, b) for _, b in own):
                    rows += range(row, row + 6)
                else:
                    apart = any(across(a - p, u) or a[2] != p[2] for a, _ in own)
                    rows += [row + first, row + 4 - first, row + 5] if apart else [row + first]
        table, count = [*np.hstack([screws[rows][:, moving], np.eye(len(rows), dtype=int) * Fraction(1)])], moving.sum()
        for column in range(count):
            for pivot in [own for own in table if own[column]][:1]:
                table, every = [], table
                for own in every:
                    self.clock.check()
                    table += [] if own is pivot else [own - own[column] / pivot[column] * pivot]
        wrenches = np.array([own[count:] for own in table], float).reshape(len(table), len(rows))
        wrenches /= np.array([s, 1, 1, 1 / size, s / size, s / size])[np.array(rows, int) % 6]
        return rows, wrenches / np.linalg.norm(wrenches, axis=1, keepdims=True)

    def walked(self, steps: Any, angles: Any) -> tuple[Poly, Poly, list[Any]]:
        """Return the rotation and the shift of a walk along hinges, and the axis and the moment of each hinge."""
        count, screws, still = len(angles[0]), [], ONE * np.eye(3)
        rotation = Poly(np.tile(still, (count, 1, 1, 1)), np.zeros((count, TERMS)), turning=True)
        shift = Poly(np.zeros((count, TERMS, 3, 1)), np.zeros((count, TERMS)))
        for hinge, sense in steps:
            self.clock.check()
            way, point, (sin, low, rads) = self.ways[hinge], self.points[hinge], (x[:, hinge] for x in angles)
            axis, place = (rotation @ Poly(ONE * x.mid, x.rad * FIRST) for x in (way, point))
            place += shift
            axis = Poly(sense * axis.mid, axis.rad)
            screws.append((hinge, axis, Poly(np.cross(np.eye(3), np.swapaxes(place.mid, 2, 3)), 2 * place.rad) @ axis))
            cross = balls.crossed(way)
            square = cross @ cross
            bent = sense * sin[..., None, None] * cross.mid + low[..., None, None] * square.mid
            sizes = np.abs(sin) + np.abs(low)
            rounded = EPS * (sizes + FIRST)
            rad = up(1.5 * rads + (cross.rad + square.rad) * sizes + 4 * rounded, CHAIN)  # errors are at right angles
            moved = up((rad + 3 * rounded) * point.size + sizes * point.rad, CHAIN)
            shift += rotation @ Poly(-bent @ point.mid, moved)
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
            twists.rad += up(turn.rad + shift.rad + 2 * EPS * turn.norms(), CHAIN)
            far = (
                Poly(turn.mid - ONE * np.eye(3), turn.rad).norms() + turn.rad + shift.norms() + shift.rad + EPS * FIRST
            )
            far = up(far, CHAIN)
            off += up(far.sum(1), CHAIN)
            for hinge, axis, moment in screws:
                slopes.mid[:, :, row : row + 6, hinge] += np.concatenate([axis.mid, moment.mid], 2)[..., 0]
                size = axis.norms() + moment.norms() + axis.rad  # a derivative is a screw times T, 1 up to `far`
                slopes.rad[:, :, hinge] += up(axis.rad + moment.rad + 1.5 * folded(size, far), CHAIN)
        return twists, slopes, off

    def tube(self, rows: list[int], moving: Any, cubics: Reals, wrenches: Reals, radii: Any = None) -> Reals:
        """Return bounds, (count, n), of closed states c + G y beside pieces: y - S F(c + G y) maps a box into itself.

        Infinite if not proved. wrenches : the wrenches that no hinge works against at c where x is 0; if there are any,
        states are c + x G y for 0 <= x <= 1, and equations along wrenches are divided by x^2, others by x. radii : half
        widths of a box about c at x = 0 that holds two closed states, which are to be joined [4 to 6].
        """
        batch = max(1, CELLS // (TERMS * self.cells))
        parts = [slice(start, start + batch) for start in range(0, max(1, len(cubics)), batch)]
        tubes = [self.tube_of(rows, moving, cubics[k], wrenches, None if radii is None else radii[k]) for k in parts]
        return np.concatenate(tubes)

    def tube_of(self, rows: list[int], moving: Any, cubics: Reals, wrenches: Reals, radii: Any) -> Reals:
        """Return as `tube`, for pieces that are computed at once."""
        self.clock.check()
        need(len(rows) <= moving.sum(), "fewer hinges turn than equations close the loops")
        order, others = int(len(wrenches) > 0), np.linalg.svd(wrenches)[2][len(wrenches) :]
        rule = np.concatenate([others, wrenches])  # combines equations, with a norm of no more than `mixed`
        steps = 4 * len(self.hinges) + 12 * len(rows) + 60  # operations of a bound, with roundings
        mixed = up(np.sqrt(np.abs(rule @ rule.T).sum(1).max(initial=0.0)) + steps * EPS * len(rule), steps)

        def divided(parts: Reals) -> Reals:  # parts that are 0 along wrenches at x = 0
            along = np.pad(wrenches @ parts[:, 1:], ((0, 0), (0, 1), (0, 0), (0, 0)))
            return np.concatenate([others @ parts, along], 2)

        def sized(parts: Reals) -> Reals:  # bounds of products; rounding errors are a share of these
            sizes: Reals = np.abs(scaling) @ (np.abs(rule) @ np.abs(parts).sum(1))
            return sizes

        around = np.zeros(cubics.shape[:2]) if radii is None else radii.copy()
        twists, slopes, _ = self.closure(cubics, around, order)
        u, values, v = np.linalg.svd(divided(slopes.mid[:, :2, rows][..., moving])[:, 0], full_matrices=False)
        scaling, gains = np.swapaxes(u, 1, 2) / np.maximum(values, 1e-12)[..., None], np.swapaxes(v, 1, 2)
        norm, size = up((1 + order) * mixed * np.linalg.norm(scaling, axis=2), steps), np.abs(gains)
        twist = (scaling[:, None] @ divided(twists.mid[:, order:, rows]))[..., 0]
        rest = norm * twists.rad[:, order:].sum(1)[:, None] + steps * EPS * sized(twists.mid[:, order:, rows])[..., 0]
        if radii is not None:  # F is 0 at both: the mean derivative between them maps their difference to 0
            twist, rest = 0.0 * twist, 4.0 * norm * (slopes.rad.sum(1) * radii).sum(1)[:, None]
        rest = up(rest, steps) + TINY
        start = up(np.abs(twist).sum(1) + rest, steps)
        step = around[:, moving] + up(np.abs(twist @ v).sum(1) + steps * EPS * (size @ start[..., None])[..., 0], steps)

        def off_one(slopes: Poly) -> Reals:  # bounds of S J G - 1 at c
            own = slopes.mid[:, :, rows][..., moving]
            product = scaling[:, None] @ divided(own @ gains[:, None])
            product[:, 0] -= np.eye(len(rows))
            rounded = sized(np.abs(own).sum(1, keepdims=True) @ size[:, None]) + np.eye(len(rows))
            bounds: Reals = up(np.abs(product).sum(1) + steps * EPS * rounded, steps)
            return bounds

        floor = 0.1 * start.max(1, keepdims=True, initial=0.0)
        wide = np.linalg.solve(np.eye(len(rows)) - off_one(slopes), (3.0 * start + floor)[..., None])
        wide = np.abs(wide)  # any box will do
        turned = up((size @ wide)[..., 0], steps)
        around[:, moving] += turned
        _, slopes, off = self.closure(cubics, around, order)
        rough = norm * (slopes.rad[..., moving].sum(1) * turned).sum(1)[:, None]
        more = up((off_one(slopes) @ wide)[..., 0] + rough, steps)
        around[:, moving] = up(step + (size @ (rest + more)[..., None])[..., 0], steps)
        around[~((up(start + more, 1) < wide[..., 0]).all(1) & (off < 0.05))] = np.inf
        return around

    def led_by_cubics(self, data: Any, closed: list[int]) -> tuple[Reals, Reals, list[int]]:
        """Prove a stretch along cubics; return its pieces, the deviations of closed states, and its end state."""
        widths, names = [len(self.hinges)] * len(entry(data, "times", list)), ("angles", "rates")
        at = np.array(certificate_grammar.numbers([data["times"]], [len(widths)], "times")[0])
        angles, rates = (np.array(certificate_grammar.numbers(data.get(name), widths, name)) for name in names)
        formed(len(at) > 2, "a stretch has no states")
        steps, ended = np.diff(at)[:, None], [int(angle > 1) for angle in angles[-1]]
        stops = pi * np.array([closed, ended])
        need((angles[[0, -1]] == stops).all() and (steps > 0).all(), "a stretch ends at no stop, or times do not rise")
        ends = np.stack([angles[:-1], steps * rates[:-1], np.diff(angles, axis=0), steps * rates[1:]], -1)
        spans = ends @ [[1, 0, 0, 0], [0, 1, -2, 1], [0, 0, 3, -2], [0, 0, -1, 1]]  # cubics of 0 <= x <= 1
        moving, cubics, inner = (angles != angles[0]).any(0) | rates.any(0), shifted(spans, 0.5, 0.5), [0, len(spans)]
        lines, around = self.equations(closed, moving)[0], np.zeros((len(spans), len(self.hinges)))
        for state, cubic, place in ((closed, spans[0], 0), (ended, shifted(spans[-1], 1.0, -1.0), -1)):
            own, wrenches = self.equations(state, moving)
            if len(wrenches):  # the piece leaves a state with singular closure
                cubic[:, 0] = pi * np.array(state)
                around[place] = self.tube(own, moving, cubic[None], wrenches)[0]
                inner[place] += 1 + 2 * place
        first, end = inner
        around[first:end] = self.tube(lines, moving, cubics[first:end], wrenches[:0])
        sides, end = np.pad(around, ((1, 1), (0, 0)), "edge"), end + 1  # pieces are joined where they meet
        starts, ends = cubics @ [1.0, -1.0, 1.0, -1.0], cubics.sum(2)
        apart = np.abs(np.concatenate([starts, stops[1:]]) - np.concatenate([stops[:1], ends]))
        rounded = np.pad(32 * EPS * np.abs(cubics).sum(2) + 1e-14, ((1, 1), (0, 0)), "edge")
        wide = up(np.maximum(sides[1:], sides[:-1]) + (apart + np.maximum(rounded[1:], rounded[:-1])) * moving, 9)
        places = np.concatenate([starts[:1], ends])[first:end, :, None] * [1, 0, 0, 0]
        wide[first:end] = self.tube(lines, moving, places, wrenches[:0], wide[first:end])
        need(np.isfinite(wide).all(), "closed states are not proved to lie beside a path, and to be joined")
        return cubics, np.maximum(wide[:-1], wide[1:]), ended

    def led_by_equal_turns(self, data: Any, closed: list[int]) -> tuple[Reals, Reals, list[int]]:
        """Prove a stretch in which hinges turn from stop to stop by one angle x [7]; return as `led_by_cubics`."""
        turned = {
            certificate_grammar.whole(hinge, 0, len(self.hinges) - 1, "a hinge")
            for hinge in entry(data, "hinges", list)
        }
        moving = np.array([hinge in turned for hinge in range(len(self.hinges))])
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
        at = pi * (np.array(closed) + np.linspace(0.0, 1.0, EQUAL + 1)[:, None] * np.subtract(ended, closed))
        cubics = np.stack([0.5 * (at[1:] + at[:-1]), 0.5 * (at[1:] - at[:-1]), 0 * at[1:], 0 * at[1:]], -1)
        return cubics, np.full(cubics.shape[:2], 1e-14) * moving, ended

    def shrink(self, margin: float) -> None:
        """Make facets prisms less a margin, (facets, corners, 3), with directions of sides; list pairs of panels."""
        sides = self.sides * self.stretch[:2] / np.linalg.norm(self.sides * self.stretch[:2], axis=2, keepdims=True)
        normals, hinge_of = sides[..., ::-1] * [-1, 1], np.full((len(sides), len(sides)), len(self.hinges))
        before = np.take_along_axis(normals, self.corner[..., None] - 1, 1)
        blunt = 1.0 + (before * normals).sum(2, keepdims=True)
        need(blunt.min() > 1e-6, "a corner of a facet is too sharp")
        inner = self.flat + margin * (before + normals) / blunt
        self.error = 1e-12 + 64 * EPS * margin / float(blunt.min()) ** 1.5  # error of corners, and of values from them
        left = ((np.roll(inner, -1, 1) - inner) * sides).sum(2)[np.roll(self.corner, -1, 1) != self.corner].min() > 0
        need(left, "the margin leaves nothing of a panel")
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
        """Refuse pieces in which shrunk facets may overlap or hinges pass their stops; halve undecided pieces [8]."""
        middles = self.corners.mean(1, keepdims=True)
        wide = 12.0 * self.error + np.linalg.norm(self.corners - middles, axis=2).max(1)[self.pairs].sum(1)[:, None]
        every, (one, two) = np.ones((1, len(self.pairs)), bool), self.pairs.T
        size = max(1, min(64, CELLS // (1 + len(self.pairs))))
        parts = [slice(k, k + size) for k in range(0, len(cubics), size)]
        corners = self.corners.shape[1] // 2
        batch = max(1, min(BATCH, HEIGHTS // ((corners + 3) ** 2 * 2 * corners)))
        waiting = [(cubics[k], radii[k], every, 0) for k in parts]
        while waiting:
            cubics, radii, pairs, depth = waiting.pop()
            self.clock.check()
            turned = np.abs(cubics - [0.5 * pi, 0, 0, 0]).sum(2) + radii + 1e-14  # rounding
            left = pairs & ~np.pad(turned < 0.5 * pi + self.give, ((0, 0), (0, 1)))[:, self.hinge_of]
            angles = sines(cubics, radii, 0)
            poses = {panel: self.walked(way, angles)[:2] for panel, way in self.way.items()}
            posed = zip(*(poses[panel] for panel in self.panels), strict=True)
            turns, shifts = (Poly(np.stack([x.mid for x in own]), np.stack([x.rad for x in own])) for own in posed)
            places = (turns.mid @ np.swapaxes(middles, 1, 2)[:, None, None] + shifts.mid)[..., 0]
            reach = np.linalg.norm(places[:, :, 1:], axis=3).sum(2) + (self.reach * turns.rad + shifts.rad).sum(2)
            left &= ~(np.linalg.norm(places[one, :, 0] - places[two, :, 0], axis=2) > reach[one] + reach[two] + wide).T
            number, pair = np.nonzero(left)
            for k in (slice(start, start + batch) for start in range(0, len(number), batch)):
                self.clock.check()
                left[number[k], pair[k]] = ~self.separated(turns, shifts, number[k], self.pairs[pair[k]].T)
            keep = left.any(1) | ~(turned < 0.5 * pi + STOPS).all(1)
            need(depth < DEPTH or not keep.any(), "panels are not proved to keep apart, or hinges within their stops")
            if keep.any():
                radii = radii[keep] + 8 * EPS * np.abs(cubics[keep]).sum(2)  # halves are rounded
                waiting += [(shifted(cubics[keep], x, 0.5), radii, left[keep], depth + 1) for x in (-0.5, 0.5)]

    def separated(self, turns: Poly, shifts: Poly, number: Any, facets: Any) -> Any:
        """Whether a direction fixed to one of two prisms separates them throughout each piece, (count,) [8]."""
        (f, g), size, apart = facets, len(number), np.zeros(len(number), bool)
        turn, other = (Poly(turns.mid[k, number], turns.rad[k, number], turning=True) for k in facets)
        shift, offset = (Poly(shifts.mid[k, number], shifts.rad[k, number]) for k in facets)
        back = Poly(np.swapaxes(turn.mid, 2, 3), turn.rad, turning=True)
        turn, shift = back @ other, back @ (offset + Poly(-shift.mid, shift.rad))  # the second one, seen from the first
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
            rounded = 16 * EPS * (self.reach * turn.norms() + shift.norms())
            error = up((self.reach * turn.rad + shift.rad + rounded).sum(1) + 2.0 * self.error, CHAIN)
            apart |= low.min(1) - error > (still @ way)[..., 0].max(1)
        return apart


def check_path(claim: Any, clock: certificate_grammar.Clock) -> str:
    """Check that a path leads from packed to flat; return the proved fact as a sentence."""
    array, margin = Array(claim.get("array"), clock), certificate_grammar.fraction(claim.get("margin"), "margin")
    parts, pieces, most = list[Any](), 0, ANGLES // max(1, len(array.hinges))
    closed, lead = array.packed, {"equal": array.led_by_equal_turns, "cubics": array.led_by_cubics}
    for stretch in entry(claim, "stretches", list):
        kind = entry(stretch, "kind", str)
        formed(kind in lead, "a stretch is of no known kind")
        clock.check()
        pieces += EQUAL if kind == "equal" else len(entry(stretch, "times", list))
        formed(pieces <= most, f"a path of {len(array.hinges)} hinges has more than {most} pieces")
        *part, closed = lead[kind](stretch, closed)
        parts.append(part)
    need(parts and not any(closed), "the path does not end flat")
    need(2 * margin < array.height * array.unit, "the margin leaves nothing of a panel")
    array.shrink(float(margin / array.unit) / array.size * (1 - 1e-15))
    array.check_gaps(*(np.concatenate(own) for own in zip(*parts, strict=True)))
    nothing = "" if any(array.packed) else "nothing folds, as packed and flat are one state: "
    path = f"a path from packed to flat, {STOPS:g} rad beyond stops at most"
    return f"{nothing}{path}, facets shrunk by {claim['margin']} m"


def checked(claim: Any, clock: certificate_grammar.Clock | None = None) -> str:
    """Return the proved claim as a sentence; refuse a claim that is not proved, or not of the documented form."""
    return certificate_grammar.judged(claim, clock, check_path)


if __name__ == "__main__":
    certificate_grammar.main("path", checked, __doc__)
