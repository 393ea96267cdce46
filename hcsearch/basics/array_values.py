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
Integers16 = NDArray[np.int16]
Integers32 = NDArray[np.int32]
Bitsets = NDArray[np.uint64]


class ByValue:
    """Base class of dataclasses with `eq=False` that compare by value, arrays included.

    Instances of the same class are equal if all their compared fields are; arrays are equal if all their entries are.
    NaN, which stands for an unknown value, equals NaN.
    """

    __slots__ = ()

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return self is other or all(_same_values(*pair) for pair in zip(_compared(self), _compared(other), strict=True))

    def __hash__(self) -> int:
        return hash((type(self).__qualname__, *map(_hash_key, _compared(self))))


def _compared(value: Any) -> list[Any]:
    return [getattr(value, field.name) for field in fields(value) if field.compare]


def _same_values(first: Any, second: Any) -> bool:
    """Return whether two field values are equal."""
    if first is second:
        return True
    if isinstance(first, np.ndarray) or isinstance(second, np.ndarray):
        return isinstance(first, np.ndarray) and isinstance(second, np.ndarray) and _same_arrays(first, second)
    if isinstance(first, (tuple, list)):
        return type(first) is type(second) and len(first) == len(second) and all(map(_same_values, first, second))
    if isinstance(first, Mapping):
        return (
            isinstance(second, Mapping)
            and first.keys() == second.keys()
            and all(_same_values(first[key], second[key]) for key in first)
        )
    return bool(first == second) or (first != first and second != second)  # noqa: PLR0124 - only NaN differs from itself


def _same_arrays(first: np.ndarray[Any, Any], second: np.ndarray[Any, Any]) -> bool:
    may_hold_nan = first.dtype.kind in "fc" and second.dtype.kind in "fc"
    return np.array_equal(first, second, equal_nan=may_hold_nan)


def _hash_key(content: Any) -> Any:
    """Return a hashable value that equal field values share: shape of arrays, keys of mappings."""
    if isinstance(content, np.ndarray):
        return content.shape
    if isinstance(content, (tuple, list)):
        return tuple(map(_hash_key, content))
    if isinstance(content, Mapping):
        return frozenset(content)
    return None if content != content else content  # noqa: PLR0124 - as above
