"""Labels of pages in queries: `degrees of freedom <= 6` as `dof<=6`, in capitals or not."""

from __future__ import annotations

import re
from functools import cache

from hcsearch.store.columns import VIEWS

_SPACED_SIGN = re.compile(r"(?<!\s)\s*(<=|>=|!=|=|<|>)\s*")


def with_column_names(query: str, view: str) -> str:
    """Return a query with labels of columns, and names in any case, replaced by names, and no space around signs.

    The longest label that fits is taken. Values are not replaced. `named` of grammar.js does the same on pages.
    """
    labels, names = _labels_of(view)
    tight = _SPACED_SIGN.sub(r"\1", query)
    # some letters beyond ASCII match one of a name without regard to case, as U+017F does `s`
    return labels.sub(lambda match: names.get(" ".join(match[0].lower().split()), match[0]), tight)


@cache
def _labels_of(view: str) -> tuple[re.Pattern[str], dict[str, str]]:
    """Return a pattern of all names and labels of the columns of a view, and the name by each in lower case."""
    names = {text.lower(): quantity.name for quantity in VIEWS[view] for text in (quantity.title, quantity.name)}
    longest_first = sorted(names, key=len, reverse=True)
    any_label = "|".join(re.escape(text).replace(r"\ ", r"\s+") for text in longest_first)
    return re.compile(rf"(?<![^\s(])(?:{any_label})(?=[<>=!\s()]|$)", re.IGNORECASE), names
