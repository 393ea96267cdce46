"""The search for single-DoF units: arrangements of two or four copies of an element.

By the thesis's rule (5.2) consecutive copies share panels and merge hinges, and no mountain lies on a valley. We also
require that no crease of a copy lies in a slit of another, since such unions have no folded state or close the slit
permanently; and we allow inverted copies, as in 6.1.
"""

from __future__ import annotations

import json
import math
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import lru_cache

from hcsearch.basics.errors import PatternError
from hcsearch.library.assemblies.eight_r import unit_i, unit_ii, unit_iii
from hcsearch.library.assemblies.named_assembly import Parameters
from hcsearch.library.unit_search.copies import (
    CopyPlacement,
    CopyRings,
    CopySheet,
    PlacedMark,
    UnionKey,
    congruence_key,
    least_kutzbach,
    marks_of_copies,
)
from hcsearch.library.unit_search.elements import Element
from hcsearch.library.unit_search.unit_proofs import (
    UnitProof,
    closes_when_folded,
    generic_freedom,
    has_shared_places,
    prove_unit,
)
from hcsearch.motion.searching import Budget
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import Pattern, overlay
from hcsearch.system.work_steps import Progress


@dataclass(frozen=True)
class Unit:
    """A union of copies of one element whose generic state has one degree of freedom, with its proof.

    copies : placements, the first at the identity. pattern : their union. known_name : its name in `hcsearch assembly`,
    or empty.
    """

    element: Element
    copies: tuple[CopyPlacement, ...]
    pattern: Pattern
    proof: UnitProof
    known_name: str

    def row(self) -> dict[str, object]:
        """Return the columns for the store."""
        folding, pattern, proof = self.element.folding, self.pattern, self.proof
        return {
            "grid": folding.circuit.grid.name,
            "n": folding.circuit.n,
            "circuit": folding.circuit.notation,
            "crease": folding.crease,
            "alpha": self.element.alpha,
            "shape": self.element.shape,
            "merged": int(self.element.merged),
            "element_dof": self.element.dof,
            "copies": len(self.copies),
            "placements": self.placements,
            "panels": len(pattern.panels),
            "hinges": len(pattern.hinges),
            "directions": _directions(pattern),
            "loops": len(Linkage(pattern).loops),
            "kutzbach": pattern.kutzbach,
            "dof": proof.dof,
            "dof_folded": proof.dof_folded,
            "dof_flat": proof.dof_flat,
            "rank_gap": float(proof.rank_gap),
            "deployment_ratio": proof.deployment_ratio,
            "ways": proof.path_count,
            "path": proof.path,
            "closure_error": proof.closure_error,
            "contact": None if proof.contact is None else int(proof.contact),
            "known": self.known_name,
        }

    @property
    def placements(self) -> str:
        """The placements of the copies as JSON: turned over, inverted, turn (degrees) and shift (mm), in this order."""
        unit = CopySheet(self.element.pattern, lattice=True).unit
        rows = [
            {
                "over": motion.isometry.reflects,
                "inverted": motion.inverts,
                "turn": _tidy(math.degrees(motion.isometry.angle) % 360.0, 6) % 360.0,
                "shift": [_tidy(1e3 * unit * v, 6) for v in (motion.isometry.shift.real, motion.isometry.shift.imag)],
            }
            for motion in self.copies
        ]
        return json.dumps(rows, separators=(",", ":"))


@dataclass(frozen=True)
class ElementSearchResult:
    """The result of the search over one element.

    placements : number of placements of a copy on the element. unions : number of arrangements up to congruence.
    low_kutzbach : unions whose Kutzbach count admits one degree of freedom; of these `tested` were tested, `foldable`
        have a folded state without coincident panels, `single_dof` one degree of freedom at a generic state, and
        `units` pass all tests of `prove`.
    skipped : why the element was not searched, or empty. complete : whether all arrangements were tested within the
        budget. refuted : unions of `single_dof` without a smooth motion of one degree of freedom from folded to flat.
    """

    element: Element
    placements: int = 0
    unions: int = 0
    low_kutzbach: int = 0
    tested: int = 0
    foldable: int = 0
    single_dof: int = 0
    units: tuple[Unit, ...] = ()
    refuted: tuple[Unit, ...] = ()
    skipped: str = ""
    complete: bool = True
    seconds: float = 0.0


UNIT_SEARCH_BUDGET = Budget(efforts=20_000)
"""The default budget of the search over one element, in unions."""


def find_units(
    element: Element,
    *,
    copies: tuple[int, ...] = (2, 4),
    budget: Budget = UNIT_SEARCH_BUDGET,
    strict: bool = True,
    progress: Progress | None = None,
) -> ElementSearchResult:
    """Enumerate the arrangements of copies of an element, and test which unions are single-DoF units.

    copies : 2 for pairs, 4 for rings of four. strict : whether to exclude creases in slits of another copy.
    """
    return _Search(element, budget, strict, progress).run(copies)


def search_elements(
    elements: Iterable[Element],
    *,
    max_dof: int | None = None,
    copies: tuple[int, ...] = (2, 4),
    budget: Budget = UNIT_SEARCH_BUDGET,
    progress: Progress | None = None,
) -> Iterator[ElementSearchResult]:
    """Search elements in turn, skipping congruent and locked ones and open chains.

    max_dof : elements with more degrees of freedom are skipped.
    """
    first_names: dict[UnionKey, str] = {}
    for element in elements:
        skipped = _reason(element, max_dof, first_names)
        if skipped:
            yield ElementSearchResult(element, skipped=skipped)
        else:
            yield find_units(element, copies=copies, budget=budget, progress=progress)


def _reason(element: Element, max_dof: int | None, first_names: dict[UnionKey, str]) -> str:
    """Return why an element is skipped, or an empty text."""
    key = congruence_key(marks_of_copies(CopySheet(element.pattern, lattice=True)))
    first_name = first_names.setdefault(key, element.name)
    if first_name != element.name:
        return f"as {first_name}"
    if not element.linkage.loops:
        return "open chain"
    if element.locked:
        return "locked"
    if element.dof is None:
        return "undecided"
    if max_dof is not None and element.dof > max_dof:
        return f"more than {max_dof} degrees of freedom"
    return ""


@dataclass
class _Search:
    """The state of a search over one element."""

    element: Element
    budget: Budget
    strict: bool
    progress: Progress | None
    began: float = field(default_factory=time.monotonic)

    def run(self, copies: tuple[int, ...]) -> ElementSearchResult:
        sheet = CopySheet(self.element.pattern, lattice=self.element.alpha is None)
        rings = CopyRings(sheet, strict=self.strict)
        unions, complete = self._unions(rings, copies)
        low_kutzbach = [(key, ring) for key, (ring, marks) in unions.items() if least_kutzbach(marks) <= 1]
        known_names = _known_units(self.element.alpha)
        units: list[Unit] = []
        refuted: list[Unit] = []
        tested = foldable = 0
        for number, (key, ring) in enumerate(low_kutzbach):
            if self._is_over_time():
                complete = False
                break
            if self.progress is not None:
                self.progress(number + 1, len(low_kutzbach), self.element.name)
            tested += 1
            placements = tuple(map(rings.simplest_placement, ring))
            pattern = self._folding(sheet, placements)
            if pattern is None:
                continue
            foldable += 1
            if generic_freedom(pattern) == 1:
                unit = Unit(self.element, placements, pattern, prove_unit(pattern), known_names.get(key, ""))
                (units if unit.proof.holds else refuted).append(unit)
        seconds, tried = time.monotonic() - self.began, len(units) + len(refuted)
        counts = len(rings.placements), len(unions), len(low_kutzbach), tested, foldable, tried
        return ElementSearchResult(self.element, *counts, tuple(units), tuple(refuted), "", complete, seconds)

    def _is_over_time(self) -> bool:
        return time.monotonic() - self.began > self.budget.seconds

    def _unions(
        self, rings: CopyRings, copies: tuple[int, ...]
    ) -> tuple[dict[UnionKey, tuple[tuple[CopyPlacement, ...], list[PlacedMark]]], bool]:
        """Return one arrangement of each class of congruent unions, and whether the list is complete."""
        unions: dict[UnionKey, tuple[tuple[CopyPlacement, ...], list[PlacedMark]]] = {}
        visited = set()
        for ring in _arrangements(rings, copies):
            keys = frozenset(map(rings.key, ring))
            if keys in visited:
                continue
            visited.add(keys)
            if len(unions) >= self.budget.efforts or self._is_over_time():
                return unions, False
            marks = rings.marks(ring)
            unions.setdefault(congruence_key(marks), (ring, marks))
        return unions, True

    def _folding(self, sheet: CopySheet, ring: tuple[CopyPlacement, ...]) -> Pattern | None:
        """Return the union if it is a valid pattern with a folded state without coincident panels, else None."""
        try:
            pattern = overlay([motion.of(self.element.pattern, sheet.unit) for motion in ring])
            linkage = Linkage(pattern)
            fits = pattern.kutzbach <= 1 and closes_when_folded(linkage) and not has_shared_places(linkage)
        except PatternError:
            return None
        return pattern if fits else None


def _arrangements(rings: CopyRings, copies: tuple[int, ...]) -> Iterator[tuple[CopyPlacement, ...]]:
    if 2 in copies:
        yield from rings.pairs()
    if 4 in copies:
        yield from rings.rings()


@lru_cache(maxsize=8)
def _known_units(alpha: float | None) -> dict[UnionKey, str]:
    """Return the names of known units by congruence key; alpha : base angle in degrees, None for 60."""
    parameters = Parameters(alpha=math.radians(60.0 if alpha is None else alpha))
    names = {}
    for name, build in (("unit-i", unit_i), ("unit-ii", unit_ii), ("unit-iii", unit_iii)):
        names[congruence_key(marks_of_copies(CopySheet(build(parameters), lattice=False)))] = name
    return names


def _directions(pattern: Pattern) -> int:
    """Count the directions of the hinges in the flat state: 1 where all are parallel and the motion is planar."""
    angles = [math.atan2(h.end[1] - h.start[1], h.end[0] - h.start[0]) % math.pi for h in pattern.hinges]
    return len({round(angle, 6) % round(math.pi, 6) for angle in angles})


def _tidy(value: float, digits: int) -> float:
    return round(value, digits) + 0.0
