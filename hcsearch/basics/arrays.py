"""Kinds of arrays, as annotations name them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Reals = NDArray[np.float64]
WholeNumbers = NDArray[np.int64]
Flags = NDArray[np.bool_]
Signs = NDArray[np.int8]
