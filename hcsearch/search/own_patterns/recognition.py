"""Designs in drawings: the grid of equal panels, the circuit through their creases, and the folding.

How long panels are and how they are turned is taken from all of them, and each is placed by a neighbour that is placed:
so drawings may be rounded, or stretched a little, however many panels lie in a row.
"""

from __future__ import annotations

import cmath
import math
from collections import Counter, defaultdict, deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import PatternError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, foldings
from hcsearch.designs.grid import GRIDS, Grid
from hcsearch.designs.grid.arrays import check_size
from hcsearch.designs.grid.tilings import LatticePoint
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.search.own_patterns.drawn_lines import place_text
from hcsearch.search.own_patterns.fold_reading import POINT_ERROR_SHARE, FacetJoin, PatternDrawing
from hcsearch.shape.mesh import Facet
from hcsearch.shape.pattern import FacetPair

CELL_CORNER_TOLERANCE = 10.0 * POINT_ERROR_SHARE
"""Share of a side that corners of a panel may be off those of a cell at the same middle."""
CELL_STEP_TOLERANCE = 0.1
"""Share of a side that the middles of two neighbours may be off a step of the grid."""
_GRID_OF = {3: "triangle", 4: "square", 6: "hex"}
_SHAPES = {3: "equilateral triangle", 4: "rectangle", 6: "regular hexagon"}


@dataclass(frozen=True)
class DrawingGrid:
    """A grid laid under a drawing.

    turn : unit number by which the grid is turned. length, width : of a panel, in units of the drawing. places : the
    lattice point of each panel.
    """

    grid: Grid
    turn: complex
    length: float
    width: float
    places: tuple[LatticePoint, ...]


def drawing_grid_of(drawing: PatternDrawing) -> DrawingGrid:
    """The grid that the facets of a drawing are cells of; PatternError names a panel that is none."""
    corners = _corners_of(drawing)
    try:
        return _fitted(drawing, corners, len(drawing.facets))
    except PatternError:
        return _fitted(drawing, corners, 1)  # the message names what differs from the first panel


def _fitted(drawing: PatternDrawing, corners: int, count: int) -> DrawingGrid:
    """The grid whose cells are as long, and turned, as the first panels of a drawing are."""
    turn, sizes = _laid(drawing.facets[:count], corners)
    grid = GRIDS[_GRID_OF[corners]]
    if corners == 4 and (_differ(sizes) or drawing.notation.startswith("rectangle:")):
        grid = GRIDS["rectangle"]
    else:
        mean = float(np.concatenate(sizes).mean())
        sizes = (np.array([mean]), np.array([mean]))
    return _Laying(drawing, grid, turn, float(sizes[0].mean()), float(sizes[1].mean())).tiling()


def panel_named(drawing: PatternDrawing, panel: int) -> str:
    """A panel by its number and its middle, as drawings seldom show numbers."""
    facet = drawing.facets[panel]
    return f"panel {panel} at {place_text(np.mean(facet, axis=0).tolist(), math.dist(facet[0], facet[1]))}"


def _corners_of(drawing: PatternDrawing) -> int:
    """The number of corners that all panels have."""
    numbers = Counter(map(len, drawing.facets))
    corners, _ = numbers.most_common(1)[0]
    if corners in _GRID_OF and len(numbers) == 1:
        return corners
    which = ""
    if corners in _GRID_OF:
        other = next(k for k, facet in enumerate(drawing.facets) if len(facet) != corners)
        which = f", as {panel_named(drawing, other)} with {len(drawing.facets[other])}"
    raise PatternError(
        f"panels with {', '.join(map(str, sorted(numbers)))} corners are no tiling{which}: draw equal triangles, "
        "rectangles or regular hexagons edge to edge, with flat edges (F) where two are one panel"
    )


def _laid(facets: Sequence[Facet], corners: int) -> tuple[complex, tuple[Reals, Reals]]:
    """How the grid is turned, and the lengths of sides: those along its first direction, and the others."""
    rings = np.array(facets)
    table = rings[..., 0] + 1j * rings[..., 1]
    sides = np.roll(table, -1, axis=1) - table
    first = 0
    if corners == 4:
        # the side of the first panel that is nearest to the x axis is its length
        first = max(range(2), key=lambda k: abs(sides[0, k].real) / abs(sides[0, k]))
        first += 2 * (sides[0, first].real < 0.0)
    model = GRIDS[_GRID_OF[corners]].corners((0, 0, 0) if corners == 3 else (0, 0))
    start = 3 if corners == 4 else 0  # the lower side of a rectangle, in the order of its corners
    own = complex(*model[(start + 1) % corners]) - complex(*model[start])
    turn = sides[0, first] / abs(sides[0, first]) * abs(own) / own
    ways = sides / turn
    symmetry = {3: 6, 4: 4, 6: 6}[corners]  # directions of sides, those of triangles pointing down among them
    off = np.angle((ways / np.abs(ways) * abs(own) / own) ** symmetry) / symmetry
    turn *= cmath.exp(1j * float(np.median(off)))
    ways = sides / turn
    along = np.abs(ways.real) > np.abs(ways.imag) if corners == 4 else np.ones_like(ways, bool)
    lengths = np.abs(ways)
    return complex(turn), (lengths[along], lengths[~along])


def _differ(sizes: tuple[Reals, Reals]) -> bool:
    """Whether lengths and widths differ by more than a drawing may be off, and than those of one kind do."""
    length, width = (float(np.median(own)) for own in sizes)
    spread = max(float(np.abs(own - np.median(own)).max()) for own in sizes)
    return abs(length - width) > POINT_ERROR_SHARE * length + min(spread, 2.0 * POINT_ERROR_SHARE * length)


class _Laying:
    """A drawing whose panels are placed on a grid, one by the other."""

    def __init__(self, drawing: PatternDrawing, grid: Grid, turn: complex, length: float, width: float) -> None:
        self.drawing, self.grid, self.turn, self.length, self.width = drawing, grid, turn, length, width
        # seen from the grid, from the first panel on
        self.facets = [[complex(*corner) / turn for corner in facet] for facet in drawing.facets]
        self.middles = [sum(facet) / len(facet) for facet in self.facets]
        self.beside: dict[int, list[int]] = defaultdict(list)
        for i, j in drawing.joins:
            self.beside[i].append(j)
            self.beside[j].append(i)

    def tiling(self) -> DrawingGrid:
        """The places of all panels, and the size that fits them best."""
        places: dict[int, LatticePoint] = {}
        for start in range(len(self.facets)):
            if start in places:
                continue
            # panels that no crease leads to are placed by the first one
            origin = self._cell_like(start) if not places else self._beyond(start, places[0])
            self._check(start, origin)
            places[start] = origin
            waiting = deque([start])
            while waiting:
                i = waiting.popleft()
                for j in sorted(self.beside[i]):
                    if j not in places:
                        places[j] = self._stepped(i, j, places[i])
                        self._check(j, places[j])
                        waiting.append(j)
        self._check_places(places)
        length, width = self._fitted([places[k] for k in range(len(places))])
        return DrawingGrid(self.grid, self.turn, length, width, tuple(places[k] for k in range(len(places))))

    def _scaled(self, x: float, y: float) -> complex:
        return complex(self.length * x, self.width * y)

    def _cell_like(self, panel: int) -> LatticePoint:
        """A lattice point near the origin whose cell is turned as a panel is: of triangles up, or else down."""
        if not self.grid.is_triangle:
            return (0, 0)
        up, down = self.grid.point((0, 0, 0)), self.grid.point((0, 0, 1))
        return min((up, down), key=lambda place: self._off(panel, place))

    def _beyond(self, panel: int, first: LatticePoint) -> LatticePoint:
        """The lattice point that is nearest to a panel, counted from the first one."""
        way = self.middles[panel] - self.middles[0]
        basis = np.array([self.grid.position((1, 0)), self.grid.position((0, 1))]).T
        x, y = np.linalg.solve(basis, [way.real / self.length, way.imag / self.width]).round().astype(int).tolist()
        place = (first[0] + x, first[1] + y)
        return place if self.grid.point(self.grid.cell(place)) == place else first

    def _stepped(self, one: int, two: int, place: LatticePoint) -> LatticePoint:
        """The place of a panel beside another one."""
        way = self.middles[two] - self.middles[one]
        steps = [(self._way(to, place), to) for _, to in self.grid.neighbours(place)]
        off, best = min((abs(step - way), to) for step, to in steps)
        if off > CELL_STEP_TOLERANCE * max(self.length, self.width):
            raise self._wrong(two)
        return best

    def _way(self, to: LatticePoint, place: LatticePoint) -> complex:
        return self._scaled(*self.grid.position((to[0] - place[0], to[1] - place[1])))

    def _off(self, panel: int, place: LatticePoint) -> float:
        """How far a corner of a panel is off those of a cell that is moved to its middle."""
        middle = self._scaled(*self.grid.position(place))
        cell = [self._scaled(*corner) - middle for corner in self.grid.corners(self.grid.cell(place))]
        own = [corner - self.middles[panel] for corner in self.facets[panel]]
        return max(min(abs(corner - other) for other in cell) for corner in own)

    def _check(self, panel: int, place: LatticePoint) -> None:
        if self._off(panel, place) > CELL_CORNER_TOLERANCE * self.length:
            raise self._wrong(panel)

    def _wrong(self, panel: int) -> PatternError:
        shape = _SHAPES[len(self.facets[panel])]
        what = f"cell of the {self.grid.name} grid that {panel_named(self.drawing, 0)} begins" if panel else shape
        within = ", and edges within a panel as J" if len(self.facets[panel]) == 3 and not panel else ""
        return PatternError(
            f"{panel_named(self.drawing, panel)} is no {what}: draw equal {shape}s edge to edge{within}"
        )

    def _check_places(self, places: dict[int, LatticePoint]) -> None:
        """Refuse two panels on one cell, and panels with a common edge on cells without."""
        at: dict[LatticePoint, int] = {}
        for panel, place in sorted(places.items()):
            if at.setdefault(place, panel) != panel:
                raise PatternError(
                    f"{panel_named(self.drawing, at[place])} and {panel_named(self.drawing, panel)} lie on one cell of "
                    f"the {self.grid.name} grid: draw panels edge to edge"
                )
        for i, j in self.drawing.joins:
            (x, y), (to_x, to_y) = places[i], places[j]
            if (to_x - x, to_y - y) not in self.grid.steps:
                raise self._wrong(j)

    def _fitted(self, places: list[LatticePoint]) -> tuple[float, float]:
        """The length and the width of panels for which all middles come nearest to where they are drawn."""
        if len(places) < 2:
            return self.length, self.width
        cells = np.array([self.grid.position(place) for place in places])
        drawn = np.array([(middle.real, middle.imag) for middle in self.middles])
        cells, drawn = cells - cells.mean(axis=0), drawn - drawn.mean(axis=0)
        squares, products = (cells * cells).sum(axis=0), (cells * drawn).sum(axis=0)
        if self.grid.name != "rectangle":
            size = float(products.sum() / squares.sum())
            return size, size
        sizes = [
            float(product / square) if square > 0.0 else own
            for product, square, own in zip(products, squares, (self.length, self.width), strict=True)
        ]
        return sizes[0], sizes[1]


@dataclass(frozen=True)
class RecognisedDesign:
    """A design in a drawing.

    circuit : in the canonical order. creases : of the foldings that the assignment allows, which are all where nothing
        is assigned. assigned : whether any crease is mountain, valley or flat. length, width : of a panel, in units.
    """

    circuit: Circuit
    creases: tuple[int, ...]
    assigned: bool
    length: float
    width: float

    @property
    def foldings(self) -> tuple[Folding, ...]:
        """The foldings that the assignment allows."""
        return tuple(Folding(self.circuit, crease) for crease in self.creases)


def recognise_design(drawing: PatternDrawing) -> RecognisedDesign:
    """The design that a drawing shows, in any position, direction and scale; PatternError says where there is none."""
    check_size(len(drawing.facets), "the drawing")
    tiling = drawing_grid_of(drawing)
    places = tiling.places
    walk = _circuit(drawing, len(places))
    n = len(walk)
    steps = [_direction(tiling.grid, places[walk[k]], places[walk[(k + 1) % n]]) for k in range(n)]
    circuit = Circuit(tiling.grid, tuple(steps))
    joins = [drawing.joins[_pair(walk[k], walk[(k + 1) % n])] for k in range(n)]
    letters = _in_order(circuit, "".join(join.assignment for join in joins))
    canonical = circuit.canonical()
    known = foldings(canonical)
    assigned = any(letter != "U" for letter in letters)
    fitting = tuple(folding.crease for folding in known if _fits(folding, letters))
    if assigned and known and not fitting:
        creases = ", ".join(str(folding.crease) for folding in known)
        raise PatternError(
            "the mountains and valleys are of no two-stack folding of the circuit "
            f"{canonical.notation}, which folds at creases {creases}: leave edges unassigned (U), or draw one of these"
        )
    return RecognisedDesign(canonical, fitting, assigned, tiling.length, tiling.width)


def _circuit(drawing: PatternDrawing, n: int) -> list[int]:
    """The facets in the order of the one closed walk along creases; flat edges that join others are left out."""
    joins = dict(drawing.joins)
    near = _beside(joins, n)
    if any(len(own) > 2 for own in near) and any(join.assignment == "F" for join in joins.values()):
        joins = _without_merged(joins, n)
        near = _beside(joins, n)
    for facet, own in enumerate(near):
        if len(own) > 2:
            raise PatternError(
                f"{panel_named(drawing, facet)} has {len(own)} creases, to panels {', '.join(map(str, sorted(own)))}: "
                "a circuit has two at each panel; make the others slits"
            )
        if len(own) < 2:
            raise PatternError(
                f"{panel_named(drawing, facet)} has {'one crease' if own else 'no crease'}: a circuit has two at each "
                "panel; join it to its neighbours"
            )
    walk = [0]
    while len(walk) < 2 or walk[-1] != 0:
        before = walk[-2] if len(walk) > 1 else -1
        walk.append(next((other for other in sorted(near[walk[-1]]) if other != before), 0))
    if len(walk) - 1 < n:
        missed = min(set(range(n)) - set(walk))
        raise PatternError(
            f"the creases are more than one closed walk: one runs through {len(walk) - 1} of {n} panels, and not "
            f"through {panel_named(drawing, missed)}; draw one circuit through all"
        )
    return walk[:-1]


def _without_merged(joins: dict[FacetPair, FacetJoin], n: int) -> dict[FacetPair, FacetJoin]:
    """Joins without the flat edges by which mirror pairs of panels are one: those at panels with two folds already."""
    folds = {pair: join for pair, join in joins.items() if join.assignment != "F"}
    full = [len(own) == 2 for own in _beside(folds, n)]
    return {pair: join for pair, join in joins.items() if pair in folds or not (full[pair[0]] or full[pair[1]])}


def _beside(joins: dict[FacetPair, FacetJoin], n: int) -> list[set[int]]:
    near: list[set[int]] = [set() for _ in range(n)]
    for i, j in joins:
        near[i].add(j)
        near[j].add(i)
    return near


def _in_order(circuit: Circuit, letters: str) -> str:
    """Letters of creases in the canonical order of the circuit; mirror images exchange nothing here."""
    word, m, n = circuit.canonical().word, circuit.grid.directions, circuit.n
    target = bytes(word)
    ways = [(circuit.word, letters), ([(d + m // 2) % m for d in reversed(circuit.word)], letters[::-1])]
    for own, marks in ways:
        for isometry in circuit.grid.point_group:
            image = bytes((isometry.sign * d + isometry.offset) % m for d in own)
            at = (image + image).find(target)
            if at >= 0:
                return (marks + marks)[at : at + n]
    raise AssertionError("a circuit is congruent to its canonical form")  # pragma: no cover


def _fits(folding: Folding, letters: str) -> bool:
    """Whether a folding has the assignment, or the one of the sheet turned over; U fits all."""
    own = ["F" if fold == "flat" else "V" if fold == "valley" else "M" for fold in folding.assignment]
    over = [{"V": "M", "M": "V"}.get(letter, letter) for letter in own]
    return any(all(b in ("U", a) for a, b in zip(side, letters, strict=True)) for side in (own, over))


def _direction(grid: Grid, here: LatticePoint, there: LatticePoint) -> int:
    return grid.steps.index((there[0] - here[0], there[1] - here[1]))


def _pair(i: int, j: int) -> FacetPair:
    return min(i, j), max(i, j)


def drawn_panel_size(design: RecognisedDesign, drawing: PatternDrawing) -> str | None:
    """The size of a panel as `--panel` takes it, in mm; None where the drawing has no physical unit.

    A drawing that says nothing of their thickness has panels as slender as those of the scene `default`.
    """
    if drawing.unit is None:
        return None
    length, _, slender = default_panel(design.circuit.grid.name)
    thickness = design.length * slender / length if drawing.thickness is None else drawing.thickness
    sizes = (design.length, design.width, thickness)
    return "x".join(f"{1e3 * drawing.unit * size:.7g}" for size in sizes)
