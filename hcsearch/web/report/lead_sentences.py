"""The first sentence of the page of a design: what the design is, and whether it opens."""

from __future__ import annotations

from hcsearch.basics.vocabulary import plural
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.panel_sizes import PanelSize, panel_text
from hcsearch.springs.flight.stowage import Stowage

_ENDINGS = {
    "movable": "A path on which its panels do not collide is proved: motors can open it.",
    "undecided": "It is undecided whether it opens: neither a path nor a lock is proved.",
    "locked": "It is proved locked: it cannot open.",
    "twisted": "The loop is twisted: it cannot open.",
}


def design_sentence(
    circuit: Circuit, panel: PanelSize, status: str, room: Stowage | None, seconds: float | None = None
) -> str:
    """Return what a design is, and whether it opens.

    status : of its best folding, `driven` where drives open it, any other word where no stage has judged it. room : of
    this folding, None where the design has none. seconds : time until springs or drives have opened it.
    """
    loop = f"{circuit.n} {plural(circuit.grid.exact_noun)} of {panel_text(panel)} mm form a closed loop"
    if room is None:
        return f"{loop}, which does not fold into two stacks."
    return f"{loop}, which folds into two stacks of {room.packed.text} together. {_ending(status, seconds)}"


def _ending(status: str, seconds: float | None) -> str:
    if status in ("deploys", "driven"):
        return opened_sentence(seconds, driven=status == "driven")
    return _ENDINGS.get(status, "Whether it opens has not been judged.")


def opened_sentence(seconds: float | None, *, driven: bool) -> str:
    """Return that springs or drives open a linkage without a collision; seconds : the time that this takes."""
    time = "" if seconds is None else f" in {seconds:.3g} s"
    return f"{'Its drives' if driven else 'Springs alone'} open it{time}, and its panels are certified not to collide."
