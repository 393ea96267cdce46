"""How well a drive tracks its plan: its greatest torques under control against those planned, and why they differ."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.shape.labels import labels_of
from hcsearch.springs.drive.driven_folding import Drive

DRIVE_TORQUE_TOLERANCE = 0.05
"""A drive follows where the greatest torque of each driven hinge is within this share of the greatest planned one."""
MIN_COMPARED_TORQUE_SHARE = 0.01
"""Hinges whose planned torque is below this share of the greatest of all are compared to that share of it."""
DRIVE_ANGLE_TOLERANCE = 0.02
"""It does not follow where a hinge misses its planned angle by more than this (rad)."""
DEAD_POINT_SINGULAR_VALUE = 0.05
"""Least singular value of the reduced Jacobian below which a dead point is near."""

SINGULAR_CLOSURE_VALUE = 0.01
"""Least singular value of closure below which loops are nearly singular."""


@dataclass(frozen=True)
class Following:
    """How well a drive follows its plan.

    follows : whether it does. share : greatest difference between the greatest torques of a driven hinge under control
    and planned, over the planned one. sentence : both, with the remedy where it does not follow.
    """

    follows: bool
    share: float
    sentence: str


def judge_following(drive: Drive) -> Following:
    """How well a drive follows its plan."""
    planned, own = np.abs(drive.torques.torques).max(axis=0), drive.greatest
    shares = np.abs(own - planned) / np.maximum(
        np.maximum(planned, MIN_COMPARED_TORQUE_SHARE * planned.max(initial=0.0)), 1e-12
    )
    worst = int(shares.argmax())
    share = float(shares[worst])
    if share <= DRIVE_TORQUE_TOLERANCE and drive.missed <= DRIVE_ANGLE_TOLERANCE:
        return Following(True, share, f"follows: greatest torques are within {_percent(share)} of those planned")
    what = f"hinges miss their planned angles by up to {drive.missed:.2g} rad"
    if share > DRIVE_TORQUE_TOLERANCE:
        hinge = labels_of(drive.linkage).hinges[drive.drives.hinges[worst]]
        what = f"hinge {hinge} takes {own[worst]:.3g} N m where {planned[worst]:.3g} are planned"
    return Following(False, share, f"does not follow: {what}; {_remedy(drive)}")


def _remedy(drive: Drive) -> str:
    """What would make the drive follow, or what to rely on where nothing does.

    Where loops are nearly singular, closed states bend sharply, and what a controller adds there hangs on rounding.
    """
    assert drive.deployment.driven is not None
    own, driven = drive.drives, drive.deployment.driven
    times = np.linspace(0.0, drive.timed.seconds, 5000)
    asked, plan = own.asked(times), own.at(times)
    apart = _most(asked[2] - plan[2] + own.stiffness * (asked[0] - plan[0]) + own.damping * (asked[1] - plan[1]))
    if apart > 0.5 * _most(driven.torques - driven.planned):
        return "give a shorter --period, or a smaller --rate"
    if drive.choice.least < DEAD_POINT_SINGULAR_VALUE:
        return "a dead point is near: drive more hinges (a greater --firm)"
    if drive.choice.closure < SINGULAR_CLOSURE_VALUE:
        place = f"{drive.choice.closure_place:.2g} of the path"
        return f"its loops are nearly singular at {place}: size motors by simulated torques, or try other panels"
    return "give a smaller --rate and --acceleration, or drive more hinges (a greater --firm)"


def _most(values: Reals) -> float:
    return float(np.abs(values).max(initial=0.0))


def _percent(share: float) -> str:
    return f"{max(100.0 * share, 0.1):.2g} %"
