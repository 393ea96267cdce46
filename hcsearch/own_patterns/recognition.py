"""Designs in drawings: an array of equal panels, the circuit through their creases, and the folding that is drawn."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from hcsearch.circuit import Circuit
from hcsearch.errors import PatternError
from hcsearch.folding import Folding, foldings
from hcsearch.grid import GRIDS, Grid
from hcsearch.grid.arrays import check_size
from hcsearch.grid.tilings import Point as Place
from hcsearch.own_patterns.fold_reading import Drawing, Join
from hcsearch.pattern import Facet, Pair
from hcsearch.scenes import default_panel

SAME = 1e-3
"""Share of a side that corners may be off, as drawings are rounded."""
_GRID_OF = {3: "triangle", 4: "square", 6: "hex"}


@dataclass(frozen=True)
class Recognised:
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


def recognise(drawing: Drawing) -> Recognised:
    """The design that a drawing shows, in any position, direction and scale; PatternError says where there is none."""
    check_size(len(drawing.facets), "the drawing")
    grid, places, length, width = _tiled(drawing)
    walk = _circuit(drawing, len(places))
    n = len(walk)
    steps = [_direction(grid, places[walk[k]], places[walk[(k + 1) % n]]) for k in range(n)]
    circuit = Circuit(grid, tuple(steps))
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
    return Recognised(canonical, fitting, assigned, length, width)


def _tiled(drawing: Drawing) -> tuple[Grid, list[Place], float, float]:
    """The grid that facets are cells of, the lattice point of each, and the sides of one."""
    sizes = Counter(map(len, drawing.facets))
    corners, _ = sizes.most_common(1)[0]
    if corners not in _GRID_OF or len(sizes) > 1:
        raise PatternError(
            f"panels with {', '.join(map(str, sorted(sizes)))} corners are no tiling: draw equal triangles, "
            "rectangles or regular hexagons edge to edge, with flat edges (F) where two are one panel"
        )
    grid, own = GRIDS[_GRID_OF[corners]], drawing.facets[0]
    sides = [complex(*b) - complex(*a) for a, b in zip(own, (*own[1:], own[0]), strict=True)]
    length = width = sum(map(abs, sides)) / corners
    first = 0
    if corners == 4:
        # the side that is nearest to the x axis is the length
        first = max(range(2), key=lambda k: abs(sides[k].real) / abs(sides[k]))
        first += 2 * (sides[first].real < 0.0)
        length, width = abs(sides[first]), abs(sides[(first + 1) % 4])
        if abs(length - width) > SAME * length or drawing.notation.startswith("rectangle:"):
            grid = GRIDS["rectangle"]
        else:
            length = width = 0.5 * (length + width)
    cell = (0, 0, 0) if grid.is_triangle else (0, 0)
    model = [complex(length * x, width * y) for x, y in grid.corners(cell)]
    start = 3 if corners == 4 else 0  # the lower side of a rectangle, in the order of its corners
    turn = sides[first] / (model[(start + 1) % corners] - model[start])
    turn /= abs(turn)
    shift = complex(*own[first]) - turn * model[start]
    places = []
    for number, facet in enumerate(drawing.facets):
        place = _place(grid, facet, turn, shift, length, width)
        if place is None:
            shape = {3: "equilateral triangle", 4: "rectangle", 6: "regular hexagon"}[corners]
            what = f"cell of the {grid.name} grid that {_named(drawing, 0)} begins" if number else shape
            within = ", and edges within a panel as J" if corners == 3 and not number else ""
            raise PatternError(f"{_named(drawing, number)} is no {what}: draw equal {shape}s edge to edge{within}")
        places.append(place)
    return grid, places, length, width


def _named(drawing: Drawing, panel: int) -> str:
    """A panel by its number and its middle, as drawings seldom show numbers."""
    x, y = np.mean(drawing.facets[panel], axis=0)
    return f"panel {panel} at ({x:.4g}, {y:.4g})"


def _place(grid: Grid, facet: Facet, turn: complex, shift: complex, length: float, width: float) -> Place | None:
    """The lattice point of a facet; None where it is no cell of the grid."""
    corners = [(complex(*corner) - shift) / turn for corner in facet]
    middle = sum(corners) / len(corners)
    basis = np.array([grid.position((1, 0)), grid.position((0, 1))]).T
    near = np.linalg.solve(basis, [middle.real / length, middle.imag / width]).round().astype(int).tolist()
    place = (near[0], near[1])
    if grid.point(grid.cell(place)) == place:
        cell = [complex(length * x, width * y) for x, y in grid.corners(grid.cell(place))]
        if all(min(abs(corner - other) for other in cell) < 10 * SAME * length for corner in corners):
            return place
    return None


def _circuit(drawing: Drawing, n: int) -> list[int]:
    """The facets in the order of the one closed walk along creases; flat edges that join others are left out."""
    joins = dict(drawing.joins)
    near = _beside(joins, n)
    if any(len(own) > 2 for own in near) and any(join.assignment == "F" for join in joins.values()):
        joins = _without_merged(joins, n)
        near = _beside(joins, n)
    for facet, own in enumerate(near):
        if len(own) > 2:
            raise PatternError(
                f"{_named(drawing, facet)} has {len(own)} creases, to panels {', '.join(map(str, sorted(own)))}: "
                "a circuit has two at each panel; make the others slits"
            )
        if len(own) < 2:
            raise PatternError(
                f"{_named(drawing, facet)} has {'one crease' if own else 'no crease'}: a circuit has two at each "
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
            f"through {_named(drawing, missed)}; draw one circuit through all"
        )
    return walk[:-1]


def _without_merged(joins: dict[Pair, Join], n: int) -> dict[Pair, Join]:
    """Joins without the flat edges by which mirror pairs of panels are one: those at panels with two folds already."""
    folds = {pair: join for pair, join in joins.items() if join.assignment != "F"}
    full = [len(own) == 2 for own in _beside(folds, n)]
    return {pair: join for pair, join in joins.items() if pair in folds or not (full[pair[0]] or full[pair[1]])}


def _beside(joins: dict[Pair, Join], n: int) -> list[set[int]]:
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


def _direction(grid: Grid, here: Place, there: Place) -> int:
    return grid.steps.index((there[0] - here[0], there[1] - here[1]))


def _pair(i: int, j: int) -> Pair:
    return min(i, j), max(i, j)


def sized(design: Recognised, drawing: Drawing) -> str | None:
    """The size of a panel as `--panel` takes it, in mm; None where the drawing has no physical unit.

    A drawing that says nothing of their thickness has panels as slender as those of the scene `default`.
    """
    if drawing.unit is None:
        return None
    length, _, slender = default_panel(design.circuit.grid.name)
    thickness = design.length * slender / length if drawing.thickness is None else drawing.thickness
    sizes = (design.length, design.width, thickness)
    return "x".join(f"{1e3 * drawing.unit * size:.7g}" for size in sizes)
