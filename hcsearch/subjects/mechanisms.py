"""The mechanism of a folding in words: degrees of freedom, and proofs that an end state is locked."""

from __future__ import annotations

from dataclasses import dataclass

from hcsearch.basics.array_values import Reals
from hcsearch.designs.folding import Folding
from hcsearch.designs.panel_sizes import PanelSize
from hcsearch.motion.kinematics.numerical_rank import generic_rank, rank_at
from hcsearch.motion.locks.end_locks import lock_at
from hcsearch.motion.locks.tightness import tightness
from hcsearch.shape.linkage import Linkage


@dataclass(frozen=True)
class Freedoms:
    """Degrees of freedom for a joining of flat pairs; None if rounding leaves the rank undecided.

    joined : the joining in words. moving : at a generic state of the motion. folded, flat : at the end states, at
    first order.
    """

    joined: str
    moving: int | None
    folded: int | None
    flat: int | None
    kutzbach: int

    @property
    def sentence(self) -> str:
        """All numbers in one sentence."""
        moving, folded, flat = (
            "undecided" if number is None else number for number in (self.moving, self.folded, self.flat)
        )
        return (
            f"degrees of freedom, {self.joined}: {moving} during the motion, {folded} folded and {flat} flat at first "
            f"order; Kutzbach {self.kutzbach}"
        )


def freedoms_of(folding: Folding, panel: PanelSize) -> list[Freedoms]:
    """Return the freedoms of a folding with hinged flat pairs and, if it has mirror pairs, with these merged."""
    freedoms = [_freedoms("flat pairs hinged", folding.linkage(panel, flat_pairs="hinged"))]
    if folding.mirror_pairs:
        pairs = ", ".join(f"{a} {b}" for a, b in folding.mirror_pairs)
        freedoms.append(_freedoms(f"panels {pairs} merged", folding.linkage(panel, flat_pairs="merged")))
    return freedoms


def _freedoms(joined: str, linkage: Linkage) -> Freedoms:
    ranks = (generic_rank(linkage), rank_at(linkage, linkage.folded), rank_at(linkage, linkage.flat))
    moving, folded, flat = (rank.nullity for rank in ranks)
    return Freedoms(joined, moving, folded, flat, linkage.pattern.kutzbach)


NO_LOCK_SENTENCE = "neither the folded nor the flat state is proved locked by itself"


def lock_sentences(folding: Folding, panel: PanelSize) -> list[list[str]]:
    """Return a sentence on each end state proved locked, by joining of flat pairs, each followed by its tightness.

    If neither end is locked, a single sentence says so.
    """
    rigid, hinged = folding.linkage(panel, flat_pairs="rigid"), folding.linkage(panel, flat_pairs="hinged")
    return [
        *_locks("folded", {"rigid": (rigid, rigid.folded), "hinged": (hinged, hinged.folded)}),
        *_locks("flat", {"rigid": (rigid, rigid.flat), "hinged": (hinged, hinged.flat)}),
    ] or [[NO_LOCK_SENTENCE]]


def _locks(end: str, variants: dict[str, tuple[Linkage, Reals]]) -> list[list[str]]:
    """Return the sentences on an end state with rigid flat pairs and, if locked, hinged ones, which move more."""
    sentences: list[list[str]] = []
    for pairs, (linkage, angles) in variants.items():
        lock = lock_at(linkage, angles)
        if not lock.locked:
            break
        proof = "exact" if lock.exact else "numerical"
        tight = tightness(linkage, angles)
        sentence = f"{end}, flat pairs {pairs}: locked ({proof} proof), {lock.reason}"
        sentences.append([sentence] if tight is None else [sentence, tight.sentence])
    return sentences
