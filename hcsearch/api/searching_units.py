"""Search for units with one degree of freedom, made of copies of one element."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import nullcontext

from hcsearch.api.kinds import check_kinds
from hcsearch.basics.errors import HcsearchError
from hcsearch.library.unit_search.elements import Element, elements_of_designs, isosceles_elements
from hcsearch.library.unit_search.unit_search import (
    ElementSearchResult,
    search_elements,
)
from hcsearch.motion.searching import Budget
from hcsearch.store import record_units
from hcsearch.subjects.names import Place, writing_database
from hcsearch.system.work_steps import Progress

DEFAULT_COPY_COUNTS = (2, 4)
"""Numbers of copies of an element in a unit."""
DEFAULT_MAX_UNIONS = 20_000


def search_units(
    grid: str,
    n: int,
    *,
    alpha: float | None = None,
    max_dof: int | None = None,
    copies: Sequence[int] = DEFAULT_COPY_COUNTS,
    most: int = DEFAULT_MAX_UNIONS,
    seconds: float | None = None,
    db: Place | None = None,
    progress: Progress | None = None,
) -> Iterator[tuple[ElementSearchResult, int]]:
    """Search for units made of copies of each element of n panels, as `hcsearch units` does.

    Parameters
    ----------
    grid
        The grid of the panels.
    n
        The number of panels of an element.
    alpha
        Base angle of isosceles triangles in place of regular ones, degrees.
    max_dof
        Elements with more degrees of freedom are left out.
    copies
        The numbers of copies of an element in a unit: 2, 4 or both.
    most
        Greatest number of unions tried for one element.
    seconds
        The greatest time for one element.
    db
        A database in which units are stored.
    progress
        Called with the numbers of unions that are tested and of all, and the name of the element.

    Yields
    ------
    tuple of ElementSearchResult and int
        The result for an element, and the number of its units that are new in the database.
    """
    check_kinds(search_units, locals())
    budget = Budget(most) if seconds is None else Budget(most, seconds)
    with nullcontext() if db is None else writing_database(db, create=True) as database:
        searched = search_elements(
            _elements(grid, n, alpha), max_dof=max_dof, copies=tuple(copies), budget=budget, progress=progress
        )
        for result in searched:
            rows = [unit.row() for unit in result.units]
            yield result, 0 if database is None else record_units(database, rows)


def _elements(grid: str, n: int, alpha: float | None) -> Iterator[Element]:
    if alpha is None:
        return elements_of_designs(grid, n)
    if grid != "triangle":
        raise HcsearchError("--alpha is the base angle of triangles: give --grid triangle, or leave it out")
    return isosceles_elements(n, alpha)
