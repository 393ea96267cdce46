"""Words that commands, files, databases and Python share, each list once; play in millimetres."""

from __future__ import annotations

import math
from typing import Literal, get_args

Keep = Literal["all", "two-stack", "untwisted"]
KEEPS: tuple[Keep, ...] = get_args(Keep)
"""Designs that a run keeps."""

Status = Literal["deploys", "movable", "undecided", "locked"]
STATUSES: tuple[Status, ...] = get_args(Status)
"""Statuses of an untwisted folding in a scene, best first; a design has that of its best folding."""
FOLDING_STATUSES = (*STATUSES, "twisted")
"""Statuses of any folding."""
DESIGN_STATUSES = (*FOLDING_STATUSES, "no_folding")
"""Statuses of a design."""

StatusEvidence = Literal["deployment", "path_proved", "path_met", "no_path_met", "kept_apart", "locked_at_end", "twist"]
STATUS_EVIDENCE: tuple[StatusEvidence, ...] = get_args(StatusEvidence)
"""What stands behind the status of a folding: a deployment by springs; a path, proved or not; a search that met none;
a proof that loops and stops, or panels too, keep both ends apart, or that no hinge can leave an end; its twist."""

MotionEnd = Literal["packed", "flat"]
MOTION_ENDS: tuple[MotionEnd, ...] = get_args(MotionEnd)
"""The two ends of a motion."""

Verdict = Literal["deploys", "undecided", "collides"]
VERDICTS: tuple[Verdict, ...] = get_args(Verdict)
"""Verdicts on one deployment."""

Ending = Literal["flat", "moving", "at rest", "jammed", "diverged", "out of steps"]
ENDINGS: tuple[Ending, ...] = get_args(Ending)
"""How a simulated deployment ends: `moving` when its time is over, `jammed` where stops and loops let nothing move."""

Way = Literal["rigid", "hinged", "merged"]
WAYS: tuple[Way, ...] = get_args(Way)
"""How flat pairs are joined; `merged`: rigid, and mirror pairs of panels made one."""

UnitPath = Literal["flat", "stopped", "stepwise", "none", "locked"]
UNIT_PATHS: tuple[UnitPath, ...] = get_args(UnitPath)
"""How the motion of a unit from its folded state ends: see `unit_search.proofs.UnitProof`."""

Formulation = Literal["constrained", "compliant", "penalty", "quasistatic"]
FORMULATIONS: tuple[Formulation, ...] = get_args(Formulation)
"""Equations of a deployment: loops closed exactly, by springs, by the thesis's springs, or without inertia."""

Integrator = Literal["bogacki-shampine", "dormand-prince", "dormand-prince-8", "implicit"]
INTEGRATORS: tuple[Integrator, ...] = get_args(Integrator)
"""Explicit Runge-Kutta methods of orders 3(2) (the thesis's), 5(4) and 8(5,3); extrapolated linearly implicit Euler."""


MILLIMETRE_DECIMALS = 6
"""Gaps are stated to so many digits of a millimetre, a nanometre: what is less is rounding, and stated as 0."""


def millimetres(length: float | None) -> float | None:
    """A gap or a margin (m) in millimetres, rounded to a nanometre; None where there is none."""
    if length is None or math.isnan(length):
        return None
    return round(1e3 * length, MILLIMETRE_DECIMALS) + 0.0  # not -0


def play_sentence(needed_margin: float | None) -> str | None:
    """How much to leave between faces for a motion that needs a margin (mm) on every face; None without one.

    Two faces that would touch are two margins apart once either panel is smaller by one.
    """
    if needed_margin is None:
        return None
    smaller = f"panels {needed_margin:.4g} mm smaller on every face, and hinges where they are"
    return f"leave {2.0 * needed_margin:.4g} mm between faces: certified clear with {smaller}"
