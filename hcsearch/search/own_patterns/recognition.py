"""Designs in drawings: an array of equal panels, the circuit through their creases, and the folding that is drawn."""

from __future__ import annotations

from dataclasses import dataclass

from hcsearch.basics.errors import PatternError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, foldings
from hcsearch.designs.grid import Grid
from hcsearch.designs.grid.arrays import check_size
from hcsearch.designs.grid.tilings import LatticePoint
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.search.own_patterns.fold_reading import Drawing, Join
from hcsearch.search.own_patterns.tiling import panel_named, tiling_of
from hcsearch.shape.pattern import FacetPair


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
    tiling = tiling_of(drawing)
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
    return Recognised(canonical, fitting, assigned, tiling.length, tiling.width)


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


def _without_merged(joins: dict[FacetPair, Join], n: int) -> dict[FacetPair, Join]:
    """Joins without the flat edges by which mirror pairs of panels are one: those at panels with two folds already."""
    folds = {pair: join for pair, join in joins.items() if join.assignment != "F"}
    full = [len(own) == 2 for own in _beside(folds, n)]
    return {pair: join for pair, join in joins.items() if pair in folds or not (full[pair[0]] or full[pair[1]])}


def _beside(joins: dict[FacetPair, Join], n: int) -> list[set[int]]:
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
