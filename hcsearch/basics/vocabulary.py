"""Vocabulary shared by commands, files, databases and Python: each list of words once; lengths in millimetres."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal, get_args

Keep = Literal["all", "two-stack", "untwisted"]
KEEPS: tuple[Keep, ...] = get_args(Keep)
"""Selections of designs that a run keeps."""

Status = Literal["deploys", "movable", "undecided", "locked"]
STATUSES: tuple[Status, ...] = get_args(Status)
"""Statuses of an untwisted folding in a scene, best first; a design has the status of its best folding."""
FOLDING_STATUSES = (*STATUSES, "twisted")
"""Statuses of any folding."""
DESIGN_STATUSES = (*FOLDING_STATUSES, "no_folding")
"""Statuses of a design."""

StageName = Literal["circuits", "foldings", "twist", "mobility", "motion", "deployment", "flight"]
STAGE_NAMES: tuple[StageName, ...] = get_args(StageName)
"""Stages of the search, in the order in which they run."""

StatusEvidence = Literal["deployment", "path_proved", "path_met", "no_path_met", "kept_apart", "locked_at_end", "twist"]
STATUS_EVIDENCE: tuple[StatusEvidence, ...] = get_args(StatusEvidence)
"""Evidence for the status of a folding: a deployment by springs; a path, proved or not; a search without a path; a
proof that loops and stops, or also panels, keep both ends apart, or that no hinge can move at an end; its twist."""

MotionEnd = Literal["packed", "flat"]
MOTION_ENDS: tuple[MotionEnd, ...] = get_args(MotionEnd)
"""The two ends of a motion."""

Verdict = Literal["deploys", "undecided", "collides"]
VERDICTS: tuple[Verdict, ...] = get_args(Verdict)
"""Verdicts on one deployment."""

Ending = Literal["flat", "moving", "at rest", "stuck", "jammed", "diverged", "out of steps", "branch-singular"]
ENDINGS: tuple[Ending, ...] = get_args(Ending)
"""Endings of a simulated deployment: `moving` when time is up, `stuck` where friction holds what would move without it,
`jammed` where stops and loops block all motion, `branch-singular` where rounding decides how it goes on."""

Until = Literal["end", "flat", "folded", "stop", "event", "bifurcation"]
UNTILS: tuple[Until, ...] = get_args(Until)
"""What ends a motion that is followed, beside a stop: `end`, the flat or the folded state, whichever comes first; one
of them; `stop`, nothing else; `event`, the first singular state on the way; `bifurcation`, the first where it branches.
"""

Way = Literal["rigid", "hinged", "merged"]
WAYS: tuple[Way, ...] = get_args(Way)
"""Ways to join flat pairs: `rigid`, `hinged`, or `merged` (rigid, with mirror pairs of panels made one)."""

UnitPath = Literal["flat", "stopped", "stepwise", "none", "locked"]
UNIT_PATHS: tuple[UnitPath, ...] = get_args(UnitPath)
"""Endings of the motion of a unit from its folded state; see `unit_search.proofs.UnitProof`."""

MotionTerm = Literal["stiffness", "stiffness-by-law", "stiffness-by-hinge", "damping", "friction", "gravity", "drag"]
MOTION_TERMS: tuple[MotionTerm, ...] = get_args(MotionTerm)
"""Terms of a scene that are fitted to a film: one factor for all springs, for those of each law of the scene, or for
each; a damper and a friction that all hinges have; the direction of gravity; the drag of panels."""

Formulation = Literal["constrained", "compliant", "penalty", "quasistatic"]
FORMULATIONS: tuple[Formulation, ...] = get_args(Formulation)
"""Formulations of a deployment: loops closed exactly, by springs, by the springs of the thesis, or without inertia."""

ReplaySource = Literal["path", "springs"]
"""Motions of a folding that are played or exported: its path, or its deployment by springs."""

Integrator = Literal["bogacki-shampine", "dormand-prince", "dormand-prince-8", "implicit", "linearly-implicit"]
INTEGRATORS: tuple[Integrator, ...] = get_args(Integrator)
"""Explicit Runge-Kutta methods of orders 3(2) (as in the thesis), 5(4) and 8(5,3); an implicit one of order 4(3);
extrapolated linearly implicit Euler, of order 4(3)."""


MILLIMETRE_DECIMALS = 6
"""Decimals of gaps in millimetres, down to a nanometre: smaller values are rounding errors, and become 0."""


def plural(noun: str) -> str:
    """Return the plural of a noun, such as `hinges` and `rhombuses`."""
    return f"{noun}es" if noun.endswith("s") else f"{noun}s"


def counted(count: int, noun: str) -> str:
    """Return a number of things in words, such as `1 hinge` and `2 hinges`."""
    return f"{count:,} {noun if count == 1 else plural(noun)}"


def sizes_text(facts: Mapping[str, Any]) -> str:
    """Return the numbers of panels, hinges and loops of a linkage in words."""
    return ", ".join(counted(facts[f"{part}s"], part) for part in ("panel", "hinge", "loop"))


def percent(share: float) -> str:
    """Return a share in whole per cent, such as `40 %`."""
    return f"{100.0 * share:.0f} %"


def listed(words: Sequence[str], joined_by: str) -> str:
    """Return words as a list in a sentence, such as `path, lock or neither`."""
    return f" {joined_by} ".join(filter(None, (", ".join(words[:-1]), words[-1])))


def finite_or_none(value: Any) -> Any:
    """Replace numbers that are not finite by None, also in lists: not all files and databases hold such numbers."""
    if isinstance(value, list):
        return [finite_or_none(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def millimetres(length: float | None) -> float | None:
    """Convert a gap or margin (m) to millimetres, rounded to a nanometre; None for None or NaN."""
    if length is None or math.isnan(length):
        return None
    return round(1e3 * length, MILLIMETRE_DECIMALS) + 0.0  # not -0


def play_sentence(needed_margin: float | None) -> str | None:
    """Return advice on the play between faces for a motion that needs a margin (mm) on every face; None without one.

    Two faces that would touch are two margins apart if each panel is smaller by one margin.
    """
    if needed_margin is None:
        return None
    smaller = f"panels {needed_margin:.4g} mm smaller on every face, and hinges where they are"
    return f"leave {2.0 * needed_margin:.4g} mm between faces: certified clear with {smaller}"
