"""Recognition of designs in drawings: the grid of equal panels, the circuit through their creases, and the foldings.

Size and orientation are averaged over all panels, and each panel is located relative to a located neighbour. Drawings
may therefore be rounded or slightly stretched, however many panels lie in a row.
"""

from __future__ import annotations

import cmath
import math
from collections import Counter, defaultdict, deque
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import PatternError
from hcsearch.basics.vocabulary import plural
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, foldings
from hcsearch.designs.grid import GRIDS, Grid, LatticePoint
from hcsearch.designs.grid.arrays import check_size
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.search.own_patterns.drawn_lines import place_text
from hcsearch.search.own_patterns.fold_reading import POINT_ERROR_SHARE, FacetJoin, PatternDrawing
from hcsearch.search.own_patterns.folded_forms import FOLDED_ANGLE_TOLERANCE
from hcsearch.shape.pattern import FacetPair

CELL_CORNER_TOLERANCE = 10.0 * POINT_ERROR_SHARE
"""Tolerance of a panel's corners from the corners of a cell with the same centre, over the length of a side."""
CELL_STEP_TOLERANCE = 0.1
"""Tolerance of the vector between the centres of neighbours from a step of the grid, over the length of a side."""
_TILINGS = tuple(grid for grid in GRIDS.values() if grid.tiling is grid)


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
    _check_corners(drawing)
    try:
        return _fitted(drawing, len(drawing.facets))
    except PatternError:
        return _fitted(drawing, 1)  # the message names a difference from the first panel


def on_grid(drawing: PatternDrawing) -> PatternDrawing:
    """Return a drawing with its panels at their exact places, in the axes of their grid.

    PatternError where they fit no grid. Loops of many linkages close at exact sizes only.
    """
    tiling = drawing_grid_of(drawing)
    cells = (tiling.grid.corners(tiling.grid.cell(place)) for place in tiling.places)
    facets = tuple(tuple((tiling.length * x, tiling.width * y) for x, y in cell) for cell in cells)
    return replace(drawing, facets=facets, outlines=facets)


def _fitted(drawing: PatternDrawing, count: int) -> DrawingGrid:
    """Fit a grid to a drawing, with shape, size and orientation from its first `count` panels."""
    rings = np.array(drawing.facets[:count])
    table = rings[..., 0] + 1j * rings[..., 1]
    sides = np.roll(table, -1, axis=1) - table
    grid, models = max(
        ((grid, _models(grid, sides)) for grid in _TILINGS if grid.edges_per_cell == sides.shape[1]),
        key=lambda fit: float(np.median(np.abs((_units(sides) * _units(fit[1]).conj()).sum(axis=1)))),
    )
    ratios = sides / models
    turn = complex(_units(ratios[0, 0]))
    turn *= cmath.exp(1j * float(np.median(np.angle(_units(ratios / turn) ** grid.axes))) / grid.axes)
    # the least rotation that fits: the side of a rectangle nearest to the x axis is its length
    turn = cmath.rect(1.0, math.remainder(cmath.phase(turn), 2.0 * math.pi / grid.axes))
    sizes = np.abs(ratios)
    length = width = float(sizes.mean())
    stretched = GRIDS["rectangle"]
    if grid is stretched.tiling:
        along = np.abs((sides / turn).real) > np.abs((sides / turn).imag)
        if _differ((sizes[along], sizes[~along])) or drawing.notation.startswith("rectangle:"):
            grid, length, width = stretched, float(sizes[along].mean()), float(sizes[~along].mean())
    return _Laying(drawing, grid, turn, length, width).tiling()


def panel_named(drawing: PatternDrawing, panel: int) -> str:
    """Name a panel by its number and its centre, since drawings seldom show numbers."""
    facet = drawing.facets[panel]
    return f"panel {panel} at {place_text(np.mean(facet, axis=0).tolist(), math.dist(facet[0], facet[1]))}"


def _all_shapes() -> str:
    *shapes, last = (plural(grid.shape) for grid in _TILINGS)
    return f"draw equal {', '.join(shapes)} or {last} edge to edge"


def _check_corners(drawing: PatternDrawing) -> None:
    """Refuse panels whose numbers of corners differ or belong to no grid; PatternError."""
    numbers = Counter(map(len, drawing.facets))
    corners, _ = numbers.most_common(1)[0]
    known = corners in {grid.edges_per_cell for grid in GRIDS.values()}
    if known and len(numbers) == 1:
        return
    which = ""
    if known:
        other = next(k for k, facet in enumerate(drawing.facets) if len(facet) != corners)
        which = f", as {panel_named(drawing, other)} with {len(drawing.facets[other])}"
    raise PatternError(
        f"panels with {', '.join(map(str, sorted(numbers)))} corners are no tiling{which}: {_all_shapes()}, with flat "
        "edges (F) where two are one panel"
    )


def _models(grid: Grid, sides: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """The sides of a grid's panel, or of its mirror image, that correspond by their directions to sides of facets."""
    corners = np.array([complex(*corner) for corner in grid.corners((0, 0, 0))])
    rings = [np.roll(ring, -k) for ring in (corners, corners.conj()[::-1]) for k in range(len(corners))]
    ways = np.roll(rings, -1, axis=1) - rings
    best = np.abs(_units(sides) @ _units(ways).conj().T).argmax(axis=1)
    models: NDArray[np.complex128] = ways[best]
    return models


def _units(vectors: NDArray[np.complex128]) -> NDArray[np.complex128]:
    units: NDArray[np.complex128] = vectors / np.abs(vectors)
    return units


def _differ(sizes: tuple[Reals, Reals]) -> bool:
    """Whether lengths and widths differ by more than the error of drawings and the spread of either."""
    length, width = (float(np.median(kind)) for kind in sizes)
    spread = max(float(np.abs(kind - np.median(kind)).max()) for kind in sizes)
    return abs(length - width) > POINT_ERROR_SHARE * length + min(spread, 2.0 * POINT_ERROR_SHARE * length)


class _Laying:
    """The assignment of the panels of a drawing to the points of a grid, from neighbour to neighbour."""

    def __init__(self, drawing: PatternDrawing, grid: Grid, turn: complex, length: float, width: float) -> None:
        self.drawing, self.grid, self.turn, self.length, self.width = drawing, grid, turn, length, width
        # corners, in the axes of the grid
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
            origin = self._beyond(start, places.get(0, (0, 0)))
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

    def _beyond(self, panel: int, first: LatticePoint) -> LatticePoint:
        """Return the place of the cell nearest to a panel and oriented like it, if the first panel is placed."""
        origins = [self.grid.point((0, 0, kind)) for kind in range(self.grid.kinds)]
        kind, origin = min(enumerate(origins), key=lambda of: self._off(panel, of[1]))
        offset = self.middles[panel] - self.middles[0]
        if panel:
            offset += self._vector(first, origin)
        basis = [self._vector(self.grid.point((*cell, kind)), origin) for cell in ((1, 0), (0, 1))]
        x, y = np.linalg.solve([[v.real for v in basis], [v.imag for v in basis]], [offset.real, offset.imag]).round()
        return self.grid.point((int(x), int(y), kind))

    def _stepped(self, neighbour: int, panel: int, place: LatticePoint) -> LatticePoint:
        """Return the lattice point of a panel from the point of a neighbour; PatternError where no step fits."""
        offset = self.middles[panel] - self.middles[neighbour]
        steps = [(self._vector(to, place), to) for _, to in self.grid.neighbours(place)]
        off, best = min((abs(step - offset), to) for step, to in steps)
        if off > CELL_STEP_TOLERANCE * max(self.length, self.width):
            raise self._wrong(panel)
        return best

    def _vector(self, to: LatticePoint, place: LatticePoint) -> complex:
        return self._scaled(*self.grid.position((to[0] - place[0], to[1] - place[1])))

    def _off(self, panel: int, place: LatticePoint) -> float:
        """Return the greatest distance of a panel's corners from the corners of a cell moved to its centre."""
        middle = self._scaled(*self.grid.position(place))
        cell = [self._scaled(*corner) - middle for corner in self.grid.corners(self.grid.cell(place))]
        panel_corners = [corner - self.middles[panel] for corner in self.facets[panel]]
        return max(min(abs(corner - other) for other in cell) for corner in panel_corners)

    def _check(self, panel: int, place: LatticePoint) -> None:
        if self._off(panel, place) > CELL_CORNER_TOLERANCE * self.length:
            raise self._wrong(panel)

    def _wrong(self, panel: int) -> PatternError:
        shape, named = self.grid.tiling.shape, panel_named(self.drawing, panel)
        if panel:
            what = f"cell of the {self.grid.name} grid that {panel_named(self.drawing, 0)} begins"
            return PatternError(f"{named} is no {what}: draw equal {plural(shape)} edge to edge")
        within = ", and edges within a panel as J" if len(self.facets[0]) == 3 else ""
        return PatternError(f"{named} is no {shape}: {_all_shapes()}{within}")

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
            if places[j] not in dict(self.grid.neighbours(places[i])).values():
                raise self._wrong(j)

    def _fitted(self, places: list[LatticePoint]) -> tuple[float, float]:
        """Fit length and width of panels to the drawn centres by least squares."""
        if len(places) < 2:
            return self.length, self.width
        cells = np.array([self.grid.position(place) for place in places])
        drawn = np.array([(middle.real, middle.imag) for middle in self.middles])
        cells, drawn = cells - cells.mean(axis=0), drawn - drawn.mean(axis=0)
        squares, products = (cells * cells).sum(axis=0), (cells * drawn).sum(axis=0)
        if not self.grid.stretched:
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

    circuit : in the canonical order. creases : creases of the foldings that fit the assignment; all where nothing is
    assigned.
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
    steps = [_step(tiling.grid, places[walk[k]], places[walk[(k + 1) % n]]) for k in range(n)]
    circuit = Circuit(tiling.grid, tuple(steps))
    joins = [drawing.joins[_pair(walk[k], walk[(k + 1) % n])] for k in range(n)]
    letters = _in_order(circuit, "".join(join.assignment for join in joins))
    states = any(join.angle for join in joins)  # otherwise it is the flat state
    turns = _in_order(circuit, "".join(_turn(join) if states else "?" for join in joins))
    canonical = circuit.canonical()
    known = foldings(canonical)
    assigned = states or any(letter != "U" for letter in letters)
    fitting = tuple(folding.crease for folding in known if _fits(folding, letters, turns))
    if assigned and known and not fitting:
        creases = ", ".join(str(folding.crease) for folding in known)
        raise PatternError(
            "the mountains and valleys, or the fold angles, are of no two-stack folding of the circuit "
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
    """Drop the flat edges of merged mirror pairs: the flat edges of panels that already have two folds."""
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
    target = bytes(circuit.canonical().word)
    senses = [(circuit.word, letters), ([circuit.grid.backwards[d] for d in reversed(circuit.word)], letters[::-1])]
    for steps, marks in senses:
        for isometry in circuit.grid.point_group:
            image = bytes(isometry.steps[d] for d in steps)
            at = (image + image).find(target)
            if at >= 0:
                return (marks + marks)[at : at + circuit.n]
    raise AssertionError("a circuit is congruent to its canonical form")  # pragma: no cover


def _turn(join: FacetJoin) -> str:
    """Return the end at which a joint is stated: 0 flat, 1 closed, ? neither."""
    if join.angle is None or FOLDED_ANGLE_TOLERANCE < abs(join.angle) < 180.0 - FOLDED_ANGLE_TOLERANCE:
        return "?"
    return "0" if abs(join.angle) < 90.0 else "1"


def _fits(folding: Folding, letters: str, turns: str) -> bool:
    """Whether a folding has the given assignment, directly or with the sheet turned over; U and ? fit all."""
    letters_up = ["F" if fold == "flat" else "V" if fold == "valley" else "M" for fold in folding.assignment]
    letters_down = [{"V": "M", "M": "V"}.get(letter, letter) for letter in letters_up]
    if any(turn == ("1" if letter == "F" else "0") for letter, turn in zip(letters_up, turns, strict=True)):
        return False
    return any(all(b in ("U", a) for a, b in zip(side, letters, strict=True)) for side in (letters_up, letters_down))


def _step(grid: Grid, here: LatticePoint, there: LatticePoint) -> int:
    return next(step for step, to in grid.neighbours(here) if to == there)


def _pair(i: int, j: int) -> FacetPair:
    return min(i, j), max(i, j)


def drawn_panel_size(design: RecognisedDesign, drawing: PatternDrawing) -> str | None:
    """Return the panel size as a value of `--panel`, in mm; None where the drawing has no physical unit.

    Where the drawing states no thickness, panels are as slender as in the scene `default`.
    """
    if drawing.unit is None:
        return None
    length, _, slender = default_panel(design.circuit.grid.name)
    thickness = design.length * slender / length if drawing.thickness is None else drawing.thickness
    sizes = (design.length, design.width, thickness)
    return "x".join(f"{1e3 * drawing.unit * size:.7g}" for size in sizes)
