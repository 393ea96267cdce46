"""The turns of circuits on a grid: codes that rotations leave unchanged, and the tables on which kernels run."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hcsearch.designs.grid.tilings import Grid
from hcsearch.kernels.circuits.step_tables import StepTables


@lru_cache(maxsize=16)
def step_tables(grid: Grid) -> StepTables:
    """The tables of a grid's tiling."""
    tiling = grid.tiling
    count, sides = len(tiling.steps), tiling.edges_per_cell
    m, directed = tiling.directions, np.array(tiling.step_directions)
    following = np.empty((count, sides - 1), np.int64)
    turns = np.empty_like(following)
    for step in range(count):
        angles = {to: _turn(tiling, step, to) for to in tiling.leaving[tiling.step_kinds[step][1]]}
        following[step] = sorted(
            (to for to in angles if to != tiling.backwards[step]), key=angles.__getitem__, reverse=True
        )
        turns[step] = [angles[to] for to in following[step].tolist()]
    first_steps = _first_steps(tiling)
    codes = np.full((count, count), -1)
    first_codes = np.empty(count, np.int64)
    order = sorted(set(first_steps), key=lambda step: (tiling.step_kinds[step][0] > 0, step))
    for step, first in enumerate(first_steps):
        first_codes[step] = (sides - 1) * order.index(first)
        codes[step, following[step]] = first_codes[step] + np.arange(sides - 1)
    n_codes = int(codes.max()) + 1
    mirror = next(isometry for isometry in tiling.point_group if isometry.sign < 0).steps
    back = np.array(tiling.backwards)
    code_turns, mirrored, backwards = (np.empty(n_codes, np.int64) for _ in range(3))
    starts, after = np.full(n_codes, -1), np.zeros((n_codes, count), np.uint64)
    for step, to in np.argwhere(codes >= 0).tolist():
        code = codes[step, to]
        code_turns[code] = _turn(tiling, step, to)
        mirrored[code] = codes[mirror[step], mirror[to]]
        backwards[code] = codes[mirror[back[to]], mirror[back[step]]]
        after[code, step] = to
        if tiling.step_kinds[first_steps[step]][0] == 0:
            starts[code] = first_steps[step]
    carried = np.full((count, count), -1)
    for step, (kind, _) in enumerate(tiling.step_kinds):
        for edge in tiling.leaving[kind]:
            carried[step, edge] = tiling.carried(step, edge)
    return StepTables(
        m,
        directed,
        back,
        np.array(tiling.leaving),
        following,
        turns,
        codes,
        first_codes,
        code_turns,
        mirrored,
        backwards,
        starts,
        carried,
        after,
        max(3, (n_codes - 1).bit_length()),
    )


class EdgeClasses(NamedTuple):
    """Edges of a tiling up to all its symmetries, by the steps that cross them.

    firsts : the least step of each class from a cell of kind 0. bisected : whether the perpendicular bisector of such
    an edge is a mirror of its panel. classes : class of each step; reflected : whether only a reflection maps it to the
    first.
    """

    firsts: tuple[int, ...]
    bisected: tuple[bool, ...]
    classes: NDArray[np.int64]
    reflected: NDArray[np.bool_]


@lru_cache(maxsize=16)
def edge_classes(grid: Grid) -> EdgeClasses:
    """The classes of edges of a grid's tiling."""
    tiling = grid.tiling
    orbits = [{isometry.steps[step] for isometry in tiling.point_group} for step in range(len(tiling.steps))]
    firsts = tuple(sorted({min(orbit & set(tiling.leaving[0])) for orbit in orbits}))
    classes = np.array([next(k for k, first in enumerate(firsts) if first in orbit) for orbit in orbits])
    rotations = [isometry for isometry in tiling.point_group if isometry.sign > 0]
    turned = [{isometry.steps[step] for isometry in rotations} for step in range(len(tiling.steps))]
    reflected = np.array([firsts[k] not in turned[step] for step, k in enumerate(classes.tolist())])
    bisected = tuple(
        any(isometry.steps[first] == first for isometry in tiling.point_group if isometry.sign < 0) for first in firsts
    )
    return EdgeClasses(firsts, bisected, classes, reflected)


def directed_words(grid: Grid, words: NDArray[np.int8]) -> NDArray[np.int8]:
    """The directions of the steps of words; the words themselves where steps are directions."""
    if grid.has_directed_steps:
        return words
    directed: NDArray[np.int8] = np.array(grid.step_directions, np.int8)[words]
    return directed


def _turn(tiling: Grid, step: int, to: int) -> int:
    """The turn from one step to another, in units of 2 pi / directions, from -directions / 2 on."""
    m = tiling.directions
    return (tiling.step_directions[to] - tiling.step_directions[step] + m // 2) % m - m // 2


def _first_steps(tiling: Grid) -> list[int]:
    """The least image of each step under rotations, from a cell of kind 0 where there is one."""
    rotations = [isometry for isometry in tiling.point_group if isometry.sign > 0]
    return [
        min(
            (isometry.steps[step] for isometry in rotations), key=lambda image: (tiling.step_kinds[image][0] > 0, image)
        )
        for step in range(len(tiling.steps))
    ]
