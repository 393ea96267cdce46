"""The group of motions in which loops close where only some hinges turn, as the kernels take it.

Screws of hinges that turn about parallel lines, or about one line, generate a group of fewer dimensions than that of
all motions (docs/explanation/motion.md, 8): closure is as many equations as it has dimensions.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.arrays import Reals, WholeNumbers


class Group(NamedTuple):
    """Hinges that turn, and the equations in which their loops close.

    rows : (k, 6 n_loops), orthonormal: the part of the twists of T - 1 that is to vanish. moving : (m,), whether a
    hinge turns. starts, hinges : those that turn, of each loop in order, as `Loops` has all of them.
    """

    rows: Reals
    moving: NDArray[np.bool_]
    starts: WholeNumbers
    hinges: WholeNumbers
