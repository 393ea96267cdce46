"""Rows as columns in little text: what is the same everywhere once, words that repeat once each."""

from __future__ import annotations

from collections.abc import Sequence

Packed = list[object] | dict[str, object]


def packed(values: Sequence[object]) -> Packed:
    """A column as JSON takes it; `unpack` of table.js gives the values back.

    `{"all": value}` where all are alike, `{"words": [...], "at": [...]}` where few texts repeat, else the values.
    """
    kinds = list(dict.fromkeys(values))
    if len(kinds) <= 1:
        return {"all": kinds[0] if kinds else None}
    if all(value is None or isinstance(value, str) for value in kinds) and 2 * len(kinds) < len(values):
        places = {value: place for place, value in enumerate(kinds)}
        return {"words": kinds, "at": [places[value] for value in values]}
    return list(values)
