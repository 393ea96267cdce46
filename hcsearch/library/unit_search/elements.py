"""Elements: designs of the search whose opposite flat creases are made rigid (thesis 5.1.1), with few freedoms or many.

Of all pairs of opposite creases only the flat ones of a two-stack folding can be rigid without losing the fold: any
other crease is closed in the stacks, its panels lie on each other there and beside each other in the flat state.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

from hcsearch.basics.errors import SizeError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, foldings
from hcsearch.designs.grid import grid_named
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.designs.twisting import twist
from hcsearch.library.unit_search.proofs import closes, locked
from hcsearch.motion.kinematics.generic import generic_rank
from hcsearch.search.enumeration import PolygonSearch, search_all
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import Pattern


@dataclass(frozen=True)
class Element:
    """A folding with rigid flat creases.

    merged : whether panels that meet on a mirror axis through the flat creases are made one.
    shape : of isosceles triangles, which corner is the apex and how the outer triangles lie; empty on regular grids.
    alpha : base angle of isosceles triangles in degrees; None on regular grids.
    """

    folding: Folding
    merged: bool
    pattern: Pattern
    shape: str = ""
    alpha: float | None = None

    @property
    def name(self) -> str:
        """The folding's notation, with what else makes the element."""
        parts = [self.folding.notation, "merged" if self.merged else "", self.shape]
        if self.alpha is not None:
            parts.append(f"alpha={self.alpha:g}")
        return " ".join(filter(None, parts))

    @cached_property
    def linkage(self) -> Linkage:
        """The element as a linkage."""
        return Linkage(self.pattern)

    @cached_property
    def dof(self) -> int | None:
        """Degrees of freedom at a generic state; None undecided."""
        return generic_rank(self.linkage).nullity

    @cached_property
    def locked(self) -> bool:
        """Whether its folded or its flat state is proved locked."""
        return locked(self.linkage)


@dataclass(frozen=True)
class RigidPair:
    """What becomes of a design when two opposite creases are made rigid.

    verdict : `no fold` where other creases are flat or none are, `twisted`, `locked`, or `element`.
    dof : degrees of freedom with the pair rigid; dof_merged : with mirror pairs of panels made one too; None where
        there is no such element, or it is undecided.
    """

    crease: int
    opposite: int
    verdict: str
    dof: int | None = None
    dof_merged: int | None = None


def rigid_pairs(circuit: Circuit) -> list[RigidPair]:
    """Each pair of opposite creases of a design: whether both can be rigid, and what freedom that leaves."""
    half = circuit.n // 2
    known = {folding.crease: folding for folding in foldings(circuit)}
    return [_rigid_pair(known.get(crease), crease, half) for crease in range(half if circuit.n % 2 == 0 else 0)]


def _rigid_pair(folding: Folding | None, crease: int, half: int) -> RigidPair:
    if folding is None:
        return RigidPair(crease, crease + half, "no fold")
    if twist(folding):
        return RigidPair(crease, crease + half, "twisted")
    plain, *merged = elements_of(folding)
    verdict = "locked" if plain.locked else "element"
    return RigidPair(crease, crease + half, verdict, plain.dof, merged[0].dof if merged else None)


def elements_of(folding: Folding) -> list[Element]:
    """The element of a folding on its regular grid, and the one with mirror pairs merged where there are some."""
    size = default_panel(folding.circuit.grid.name)
    variants = [Element(folding, False, folding.pattern(size))]
    if folding.mirror_pairs:
        variants.append(Element(folding, True, folding.pattern(size, flat_pairs="merged")))
    return variants


def elements(grid: str, n: int) -> Iterator[Element]:
    """The elements of all untwisted foldings of all designs of n panels, those without a folded state left out."""
    for folding in untwisted(grid, n):
        for element in elements_of(folding):
            if element.linkage.n_hinges and closes(element.linkage):
                yield element


def untwisted(grid: str, n: int) -> Iterator[Folding]:
    """The untwisted foldings of all designs of n panels."""
    tiling = grid_named(grid)
    if n % 2 or n < 4:
        raise SizeError(f"{n} panels do not fold into two stacks: give an even number from 4 up")
    search = PolygonSearch(tiling, n) if n < 14 else search_all(tiling, n, "untwisted")
    for batch in search.batches():
        for word in batch.words.tolist():
            circuit = Circuit(tiling, tuple(word))
            yield from (folding for folding in foldings(circuit) if not twist(folding))
