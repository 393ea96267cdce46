"""Linkages and tolerances for tests of flight numbers."""

import itertools

import numpy as np

from hcsearch.kernels.linkage.boxed_programs import greatest_in_box
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import MOUNTAIN_CREASE, VALLEY_CREASE, Pattern
from hcsearch.springs.flight.build_errors import BuildTolerances

SIDE, THICKNESS = 0.05, 0.006


def strip(faces):
    """Squares in a row, joined by hinges on these faces: an open chain."""
    squares = [
        ((k * SIDE, 0.0), ((k + 1) * SIDE, 0.0), ((k + 1) * SIDE, SIDE), (k * SIDE, SIDE))
        for k in range(len(faces) + 1)
    ]
    creases = {(k, k + 1): VALLEY_CREASE if face == "top" else MOUNTAIN_CREASE for k, face in enumerate(faces)}
    return Linkage(Pattern.from_polygons(squares, creases, THICKNESS))


def tolerances_of(linkage, stops=1e-3, play=0.0, offset=0.0, thickness=0.0):
    """The same tolerances at all hinges."""
    n = linkage.n_hinges
    return BuildTolerances((stops,) * n, (play,) * n, offset, thickness)


def scaled(tolerances, by):
    """All tolerances multiplied by a number."""
    stops, play = (tuple(by * value for value in values) for values in (tolerances.stops, tolerances.play))
    return BuildTolerances(stops, play, by * tolerances.offset, by * tolerances.thickness)


def greatest_errors(built, goals):
    """Errors within their bounds that close all loops at first order and are best for some goals, (n, n_columns)."""
    rows, _ = built.independent_rows(built.bounds)
    weighed = np.ascontiguousarray(goals * built.bounds)
    points = np.empty_like(weighed)
    greatest_in_box(rows, weighed, np.empty(len(goals)), np.empty((len(goals), len(rows))), points)
    return points


def exact_rank(rows):
    """The rank of a matrix of fractions, by Gauss's elimination."""
    rows, rank = [list(row) for row in rows], 0
    for column in range(len(rows[0]) if rows else 0):
        pivot = next((k for k in range(rank, len(rows)) if rows[k][column]), None)
        if pivot is None:
            continue
        rows[rank], rows[pivot] = rows[pivot], rows[rank]
        for k in itertools.chain(range(rank), range(rank + 1, len(rows))):
            share = rows[k][column] / rows[rank][column]
            rows[k] = [a - share * b for a, b in zip(rows[k], rows[rank], strict=True)]
        rank += 1
    return rank
