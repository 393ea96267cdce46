"""The closed state at which a deployment starts."""

from __future__ import annotations

from hcsearch.basics.arrays import Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.motion.kinematics.within import close_within_stops
from hcsearch.shape.linkage import Linkage


def start_state(linkage: Linkage, share: float) -> Reals:
    """Fold angles of the closed state nearest to a share of the folded ones, within the stops.

    The thesis's start, every hinge at 0.999 pi, does not close. Where no state near it closes, the start is the folded
    state itself, as with foldings locked there at first order; those locked there at second order may start 1e-6 to
    4e-6 rad beside it.
    """
    if not 0.0 < share <= 1.0:
        raise HcsearchError(f"no deployment starts at {share:g} of the folded angles: give a share above 0, up to 1")
    folded: Reals = linkage.folded
    if share == 1.0:
        return folded
    closed, _ = close_within_stops(linkage, share * folded)
    if closed is not None:
        return closed.angles
    if share < 0.9:
        raise HcsearchError(f"no closed state lies near {share:g} of the folded angles: start nearer to 1")
    return folded
