"""Simulations that decide nothing: how they end, by the stored reason, and what may decide them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping

from hcsearch.basics.vocabulary import ENDINGS, counted

_COMPLIANT = "hcsearch deploy with --formulation compliant"
_BRANCHING, _TOUCHING = "branch-singular", "contact not decided"
UNDECIDED_REMEDIES = {
    "moving": "a scene with more seconds",
    "at rest": "other springs, as of hcsearch tune",
    "stuck": "stiffer springs, or less friction or harness",
    "jammed": _COMPLIANT,
    "diverged": _COMPLIANT,
    "out of steps": "hcsearch deploy with --formulation compliant or a larger --tolerance",
    _BRANCHING: _COMPLIANT,
    _TOUCHING: "hcsearch deploy with a smaller --tolerance",
}
"""By ending of an undecided simulation: what may decide it. A motion may become flat in several ways, depending on the
tolerance, or touch other panels so nearly that a collision is neither certain nor excluded."""


def undecided_ending(reason: str) -> str:
    """Return how a simulation with an undecided verdict ended, of `UNDECIDED_REMEDIES`, by its stored reason."""
    ending = next((ending for ending in ENDINGS if reason.startswith(f"{ending} at ")), "flat")
    if ending == "flat":
        return _BRANCHING if reason.startswith(_BRANCHING) else _TOUCHING
    return ending


def undecided_counts(reasons: Mapping[object, str]) -> dict[str, int]:
    """Return the number of undecided simulations by their ending, the most frequent first; reasons : by folding."""
    counts: dict[str, int] = defaultdict(int)
    for reason in reasons.values():
        counts[undecided_ending(reason)] += 1
    return dict(sorted(counts.items(), key=lambda item: -item[1]))


def undecided_sentences(counts: Mapping[str, int]) -> tuple[str, ...]:
    """Return a sentence on foldings that no simulation decides, and one on what may decide them; none without any."""
    if not counts:
        return ()
    endings = defaultdict(list)
    for ending in counts:
        endings[UNDECIDED_REMEDIES[ending]].append(ending)
    listed = ", ".join(f"{ending} {count:,}" for ending, count in counts.items())
    remedies = "; ".join(f"{' or '.join(names)}: {remedy}" for remedy, names in endings.items())
    return (
        f"not decided by simulation: {counted(sum(counts.values()), 'folding')} ({listed})",
        f"these may decide: {remedies}",
    )
