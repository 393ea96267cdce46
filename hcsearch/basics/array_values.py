"""Array types for annotations, and equality of dataclasses that hold arrays."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

Reals = NDArray[np.float64]
WholeNumbers = NDArray[np.int64]
Flags = NDArray[np.bool_]
Signs = NDArray[np.int8]


class ByValue:
    """Base class of dataclasses with `eq=False` that compare by value, arrays included.

    Instances of the same class are equal if all their compared fields are; arrays are equal if all their entries are.
    NaN, which stands for an unknown value, equals NaN.
    """

    __slots__ = ()

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return self is other or all(_same(*pair) for pair in zip(_compared(self), _compared(other), strict=True))

    def __hash__(self) -> int:
        return hash((type(self).__qualname__, *map(_rough, _compared(self))))


def _compared(value: Any) -> list[Any]:
    return [getattr(value, own.name) for own in fields(value) if own.compare]


def _same(one: Any, two: Any) -> bool:
    """Return whether two field values are equal."""
    if one is two:
        return True
    if isinstance(one, np.ndarray) or isinstance(two, np.ndarray):
        return isinstance(one, np.ndarray) and isinstance(two, np.ndarray) and _same_numbers(one, two)
    if isinstance(one, (tuple, list)):
        return type(one) is type(two) and len(one) == len(two) and all(map(_same, one, two))
    if isinstance(one, Mapping):
        return isinstance(two, Mapping) and one.keys() == two.keys() and all(_same(one[key], two[key]) for key in one)
    return bool(one == two) or (one != one and two != two)  # noqa: PLR0124 - only NaN differs from itself


def _same_numbers(one: np.ndarray[Any, Any], two: np.ndarray[Any, Any]) -> bool:
    unknown = one.dtype.kind in "fc" and two.dtype.kind in "fc"
    return np.array_equal(one, two, equal_nan=unknown)


def _rough(content: Any) -> Any:
    """Return a hashable value that equal field values share: shape of arrays, keys of mappings."""
    if isinstance(content, np.ndarray):
        return content.shape
    if isinstance(content, (tuple, list)):
        return tuple(map(_rough, content))
    if isinstance(content, Mapping):
        return frozenset(content)
    return None if content != content else content  # noqa: PLR0124 - as above
