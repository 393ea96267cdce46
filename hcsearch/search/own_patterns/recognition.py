"""Recognition of designs in drawings: the grid of equal panels, the circuit through their creases, and the foldings.

Size and orientation are averaged over all panels, and each panel is located relative to a located neighbour. Drawings
may therefore be rounded or slightly stretched, however many panels lie in a row.
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
"""Tolerance of corners of a panel from those of a cell with the same centre, over the length of a side."""
CELL_STEP_TOLERANCE = 0.1
"""Tolerance of the vector between the centres of neighbours from a step of the grid, over the length of a side."""
_GRID_OF = {3: "triangle", 4: "square", 6: "hex"}
_SHAPES = {3: "equilateral triangle", 4: "rectangle", 6: "regular hexagon"}


@dataclass(frozen=True)
class DrawingGrid:
    """A grid fitted to a drawing.

    turn : unit complex number that rotates the grid. length, width : of a panel, in units of the drawing. places : the
    lattice point of each panel.
    """

    grid: Grid
    turn: complex
    length: float
    width: float
    places: tuple[LatticePoint, ...]


def drawing_grid_of(drawing: PatternDrawing) -> DrawingGrid:
    """Fit a grid whose cells are the facets of a drawing; PatternError names a panel that does not fit."""
    corners = _corners_of(drawing)
    try:
        return _fitted(drawing, corners, len(drawing.facets))
    except PatternError:
        return _fitted(drawing, corners, 1)  # the message names what differs from the first panel


def _fitted(drawing: PatternDrawing, corners: int, count: int) -> DrawingGrid:
    """Fit a grid to a drawing, with size and orientation from its first `count` panels."""
    turn, sizes = _laid(drawing.facets[:count], corners)
    grid = GRIDS[_GRID_OF[corners]]
    if corners == 4 and (_differ(sizes) or drawing.notation.startswith("rectangle:")):
        grid = GRIDS["rectangle"]
    else:
        mean = float(np.concatenate(sizes).mean())
        sizes = (np.array([mean]), np.array([mean]))
    return _Laying(drawing, grid, turn, float(sizes[0].mean()), float(sizes[1].mean())).tiling()


def panel_named(drawing: PatternDrawing, panel: int) -> str:
    """Name a panel by its number and its centre, since drawings seldom show numbers."""
    facet = drawing.facets[panel]
    return f"panel {panel} at {place_text(np.mean(facet, axis=0).tolist(), math.dist(facet[0], facet[1]))}"


def _corners_of(drawing: PatternDrawing) -> int:
    """Return the number of corners of all panels; PatternError where it differs or belongs to no grid."""
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
    """Return the rotation of the grid, and the lengths of sides along its first direction and of the others."""
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
    side_vector = complex(*model[(start + 1) % corners]) - complex(*model[start])
    turn = sides[0, first] / abs(sides[0, first]) * abs(side_vector) / side_vector
    relative = sides / turn
    symmetry = {3: 6, 4: 4, 6: 6}[corners]  # directions of sides, those of triangles pointing down among them
    deviations = np.angle((relative / np.abs(relative) * abs(side_vector) / side_vector) ** symmetry) / symmetry
    turn *= cmath.exp(1j * float(np.median(deviations)))
    relative = sides / turn
    along = np.abs(relative.real) > np.abs(relative.imag) if corners == 4 else np.ones_like(relative, bool)
    lengths = np.abs(relative)
    return complex(turn), (lengths[along], lengths[~along])


def _differ(sizes: tuple[Reals, Reals]) -> bool:
    """Whether lengths and widths differ by more than the error of drawings and the spread of either."""
    length, width = (float(np.median(kind)) for kind in sizes)
    spread = max(float(np.abs(kind - np.median(kind)).max()) for kind in sizes)
    return abs(length - width) > POINT_ERROR_SHARE * length + min(spread, 2.0 * POINT_ERROR_SHARE * length)


class _Laying:
    """The assignment of the panels of a drawing to the points of a grid, from neighbour to neighbour."""

    def __init__(self, drawing: PatternDrawing, grid: Grid, turn: complex, length: float, width: float) -> None:
        self.drawing, self.grid, self.turn, self.length, self.width = drawing, grid, turn, length, width
        # in the axes of the grid
        self.facets = [[complex(*corner) / turn for corner in facet] for facet in drawing.facets]
        self.middles = [sum(facet) / len(facet) for facet in self.facets]
        self.beside: dict[int, list[int]] = defaultdict(list)
        for i, j in drawing.joins:
            self.beside[i].append(j)
            self.beside[j].append(i)

    def tiling(self) -> DrawingGrid:
        """Locate all panels, and fit their size; PatternError where a panel does not fit."""
        places: dict[int, LatticePoint] = {}
        for start in range(len(self.facets)):
            if start in places:
                continue
            # panels that no crease connects to located ones are located relative to the first panel
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
        """Return a lattice point at the origin whose cell is oriented like a panel: a triangle points up or down."""
        if not self.grid.is_triangle:
            return (0, 0)
        up, down = self.grid.point((0, 0, 0)), self.grid.point((0, 0, 1))
        return min((up, down), key=lambda place: self._off(panel, place))

    def _beyond(self, panel: int, first: LatticePoint) -> LatticePoint:
        """Return the lattice point nearest to a panel, relative to that of the first one."""
        offset = self.middles[panel] - self.middles[0]
        basis = np.array([self.grid.position((1, 0)), self.grid.position((0, 1))]).T
        x, y = (
            np.linalg.solve(basis, [offset.real / self.length, offset.imag / self.width]).round().astype(int).tolist()
        )
        place = (first[0] + x, first[1] + y)
        return place if self.grid.point(self.grid.cell(place)) == place else first

    def _stepped(self, neighbour: int, panel: int, place: LatticePoint) -> LatticePoint:
        """Return the lattice point of a panel from that of a neighbour; PatternError where no step fits."""
        offset = self.middles[panel] - self.middles[neighbour]
        steps = [(self._vector(to, place), to) for _, to in self.grid.neighbours(place)]
        off, best = min((abs(step - offset), to) for step, to in steps)
        if off > CELL_STEP_TOLERANCE * max(self.length, self.width):
            raise self._wrong(panel)
        return best

    def _vector(self, to: LatticePoint, place: LatticePoint) -> complex:
        return self._scaled(*self.grid.position((to[0] - place[0], to[1] - place[1])))

    def _off(self, panel: int, place: LatticePoint) -> float:
        """Return the greatest distance of a panel's corners from those of a cell moved to its centre."""
        middle = self._scaled(*self.grid.position(place))
        cell = [self._scaled(*corner) - middle for corner in self.grid.corners(self.grid.cell(place))]
        panel_corners = [corner - self.middles[panel] for corner in self.facets[panel]]
        return max(min(abs(corner - other) for other in cell) for corner in panel_corners)

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
        """Refuse two panels on one cell, and joined panels on cells that are no neighbours; PatternError."""
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
        """Fit length and width of panels to the drawn centres by least squares."""
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
    """A design recognised in a drawing.

    circuit : in the canonical order. creases : of the foldings that fit the assignment; all where nothing is assigned.
        has_assignments : whether any crease is mountain, valley or flat. length, width : of a panel, in units.
    """

    circuit: Circuit
    creases: tuple[int, ...]
    has_assignments: bool
    length: float
    width: float

    @property
    def foldings(self) -> tuple[Folding, ...]:
        """The foldings that fit the assignment."""
        return tuple(Folding(self.circuit, crease) for crease in self.creases)


def recognise_design(drawing: PatternDrawing) -> RecognisedDesign:
    """Recognise the design in a drawing of any position, orientation and scale; PatternError says why there is none."""
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
    """Return the facets in the order of the closed walk along creases, ignoring the flat edges of merged panels."""
    joins = dict(drawing.joins)
    neighbours = _beside(joins, n)
    if any(len(near) > 2 for near in neighbours) and any(join.assignment == "F" for join in joins.values()):
        joins = _without_merged(joins, n)
        neighbours = _beside(joins, n)
    for facet, near in enumerate(neighbours):
        if len(near) > 2:
            listed = ", ".join(map(str, sorted(near)))
            raise PatternError(
                f"{panel_named(drawing, facet)} has {len(near)} creases, to panels {listed}: "
                "a circuit has two at each panel; make the others slits"
            )
        if len(near) < 2:
            raise PatternError(
                f"{panel_named(drawing, facet)} has {'one crease' if near else 'no crease'}: a circuit has two at each "
                "panel; join it to its neighbours"
            )
    walk = [0]
    while len(walk) < 2 or walk[-1] != 0:
        before = walk[-2] if len(walk) > 1 else -1
        walk.append(next((other for other in sorted(neighbours[walk[-1]]) if other != before), 0))
    if len(walk) - 1 < n:
        unvisited = min(set(range(n)) - set(walk))
        raise PatternError(
            f"the creases are more than one closed walk: one runs through {len(walk) - 1} of {n} panels, and not "
            f"through {panel_named(drawing, unvisited)}; draw one circuit through all"
        )
    return walk[:-1]


def _without_merged(joins: dict[FacetPair, FacetJoin], n: int) -> dict[FacetPair, FacetJoin]:
    """Drop the flat edges of merged mirror pairs: those at panels that already have two folds."""
    folds = {pair: join for pair, join in joins.items() if join.assignment != "F"}
    full = [len(near) == 2 for near in _beside(folds, n)]
    return {pair: join for pair, join in joins.items() if pair in folds or not (full[pair[0]] or full[pair[1]])}


def _beside(joins: dict[FacetPair, FacetJoin], n: int) -> list[set[int]]:
    neighbours: list[set[int]] = [set() for _ in range(n)]
    for i, j in joins:
        neighbours[i].add(j)
        neighbours[j].add(i)
    return neighbours


def _in_order(circuit: Circuit, letters: str) -> str:
    """Return the creases' letters in the canonical order of the circuit; mirror images do not exchange M and V."""
    word, m, n = circuit.canonical().word, circuit.grid.directions, circuit.n
    target = bytes(word)
    senses = [(circuit.word, letters), ([(d + m // 2) % m for d in reversed(circuit.word)], letters[::-1])]
    for steps, marks in senses:
        for isometry in circuit.grid.point_group:
            image = bytes((isometry.sign * d + isometry.offset) % m for d in steps)
            at = (image + image).find(target)
            if at >= 0:
                return (marks + marks)[at : at + n]
    raise AssertionError("a circuit is congruent to its canonical form")  # pragma: no cover


def _fits(folding: Folding, letters: str) -> bool:
    """Whether a folding has the given assignment, directly or with the sheet turned over; U fits all."""
    letters_up = ["F" if fold == "flat" else "V" if fold == "valley" else "M" for fold in folding.assignment]
    letters_down = [{"V": "M", "M": "V"}.get(letter, letter) for letter in letters_up]
    return any(all(b in ("U", a) for a, b in zip(side, letters, strict=True)) for side in (letters_up, letters_down))


def _direction(grid: Grid, here: LatticePoint, there: LatticePoint) -> int:
    return grid.steps.index((there[0] - here[0], there[1] - here[1]))


def _pair(i: int, j: int) -> FacetPair:
    return min(i, j), max(i, j)


def drawn_panel_size(design: RecognisedDesign, drawing: PatternDrawing) -> str | None:
    """Return the panel size as a value of `--panel`, in mm; None where the drawing has no physical unit.

    Where the drawing states no thickness, panels have the slenderness of those in the scene `default`.
    """
    if drawing.unit is None:
        return None
    length, _, slender = default_panel(design.circuit.grid.name)
    thickness = design.length * slender / length if drawing.thickness is None else drawing.thickness
    sizes = (design.length, design.width, thickness)
    return "x".join(f"{1e3 * drawing.unit * size:.7g}" for size in sizes)
