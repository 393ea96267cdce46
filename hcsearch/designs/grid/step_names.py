"""Names of steps in the notations of circuits: a text of digits, one for each step.

On triangles, squares, rectangles and hexagons a step is written as its direction. On the other grids it is written as
the label of the edge that it crosses. Labels stand on the panel of kind 0, in the order of its corners, and each
further panel of a circuit has the mirror image of the labels of the panel before it. A letter before the digits names
the kind of the first panel, `b` for kind 1 and so on, if that is not 0.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.errors import NotationError
from hcsearch.designs.grid.tilings import Grid
from hcsearch.kernels.circuits.words import label_words

_KIND_LETTERS = "abcdefghijkl"


@lru_cache(maxsize=16)
def _frames(grid: Grid) -> tuple[NDArray[np.int64], NDArray[np.int64], list[int]]:
    """The label of each step and the next frame, by frame, shape (n_frames, L), and the first frame of each kind.

    A frame is the element of the point group that maps the panel of kind 0, with its labels, to a panel.
    """
    group = grid.point_group
    images = [tuple(isometry.steps[step] for step in grid.labels) for isometry in group]
    labels, after = np.full((len(group), len(grid.steps)), -1), np.full((len(group), len(grid.steps)), -1)
    for frame, edges in enumerate(images):
        for label, step in enumerate(edges):
            labels[frame, step] = label
            after[frame, step] = images.index(tuple(grid.carried(step, edge) for edge in edges))
    kinds = [grid.step_kinds[edges[0]][0] for edges in images]
    return labels, after, [kinds.index(kind) for kind in range(grid.kinds)]


class ReadingFrames(NamedTuple):
    """The step that a digit names in a frame, and the next frame, by frame and digit; the first frame of each kind."""

    steps: list[list[int]]
    after: list[list[int]]
    first: list[int]


@lru_cache(maxsize=16)
def reading_frames(grid: Grid) -> ReadingFrames:
    """The tables by which the digits of a circuit are read; there is one frame where digits are directions."""
    if grid.has_directed_steps:
        count = len(grid.steps)
        return ReadingFrames([list(range(count))], [[0] * count], [0] * grid.kinds)
    labels, after, first = _frames(grid)
    places = [np.argsort(row)[-grid.edges_per_cell :] for row in labels]
    return ReadingFrames(
        [place.tolist() for place in places],
        [row[place].tolist() for row, place in zip(after, places, strict=True)],
        first,
    )


def name_steps(grid: Grid, word: tuple[int, ...]) -> str:
    """The text of a closed word of steps, which `read_steps` reads."""
    if grid.has_directed_steps or not word or not all(0 <= step < len(grid.steps) for step in word):
        return "".join(map(str, word))
    labels, after, first = _frames(grid)
    kind = grid.step_kinds[word[0]][0]
    frame = first[kind]
    digits = [_KIND_LETTERS[kind] if kind else ""]
    for step in word:
        digits.append(str(labels[frame, step]))
        frame = after[frame, step]
    return "".join(digits)


def read_steps(grid: Grid, text: str) -> tuple[int, ...]:
    """Read the text that `name_steps` writes; NotationError where a letter names no kind or a digit no edge."""
    if grid.has_directed_steps:
        return tuple(map(int, text))
    kind = _KIND_LETTERS.index(text[0]) if text[0].isalpha() else 0
    if kind >= grid.kinds:
        raise NotationError(
            f"circuit '{grid.name}:{text}' begins on a panel of no kind of the grid: write a letter from b to "
            f"{_KIND_LETTERS[grid.kinds - 1]} before the digits, or none"
        )
    digits = list(map(int, text[1 if kind else 0 :]))
    if max(digits) >= grid.edges_per_cell:
        raise NotationError(
            f"circuit '{grid.name}:{text}' crosses an edge that a panel of the grid does not have: write edges "
            f"0 to {grid.edges_per_cell - 1}"
        )
    frames = reading_frames(grid)
    frame = frames.first[kind]
    word = []
    for digit in digits:
        word.append(frames.steps[frame][digit])
        frame = frames.after[frame][digit]
    return tuple(word)


def step_digits(grid: Grid, words: NDArray[np.int8]) -> NDArray[np.uint8]:
    """The digits, as ASCII codes, of canonical words, which begin on a panel of kind 0."""
    if grid.has_directed_steps:
        return (words + ord("0")).astype(np.uint8)
    labels, after, first = _frames(grid)
    digits = np.empty(words.shape, np.uint8)
    label_words(words, labels, after, first[0], digits)
    return digits
