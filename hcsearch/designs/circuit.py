"""Circuits: closed walks through the panels of an array, their notation, canonical form and symmetry."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from hcsearch.basics.errors import ArrayError, NotationError, expect_kind
from hcsearch.designs.grid import Array, Cell, Grid, LatticePoint, check_size, grid_named
from hcsearch.designs.grid.step_names import name_steps, read_steps
from hcsearch.designs.grid.turning import step_tables
from hcsearch.shape.drawing import draw_circuit


class Renumbering(NamedTuple):
    """A renumbering of the n creases and panels of a circuit: from another crease on, perhaps in the other direction.

    start : the crease that gets the number 0.
    """

    n: int
    start: int
    backwards: bool

    def __call__(self, crease: int) -> int:
        """The new number of a crease."""
        return (self.start - crease if self.backwards else crease - self.start) % self.n

    def panel(self, panel: int) -> int:
        """The new number of a panel: crease k joins panels k and k + 1 in either numbering."""
        return (self(panel) + self.backwards) % self.n


@dataclass(frozen=True, repr=False)
class Circuit:
    """A Hamiltonian circuit of an array, up to translation; make one with `from_notation`.

    Parameters
    ----------
    grid
        The grid of the panels.
    word
        The n steps, as `Grid.steps` numbers them; crease k lies between panels k and k + 1 (mod n), and step k crosses
        it.
    start
        The lattice point of panel 0, by default near the origin. It is ignored when circuits are compared.
    """

    grid: Grid
    word: tuple[int, ...]
    start: LatticePoint | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        expect_kind(
            "the grid of a circuit", self.grid, Grid, "a Grid, such as GRIDS['hex'], or use Circuit.from_notation"
        )
        check_size(self.n, "the circuit")
        if len(self.word) < 3 or any(not 0 <= step < len(self.grid.steps) for step in self.word):
            raise NotationError(
                f"malformed circuit {self.notation!r}: write the grid, a colon and at least three {_digits(self.grid)}"
            )
        if min(self._turn_codes) < 0:
            raise NotationError(
                f"circuit {self.notation!r} makes a turn that the {self.grid.name} grid does not have: check its steps"
            )
        end = (sum(self.grid.steps[d][0] for d in self.word), sum(self.grid.steps[d][1] for d in self.word))
        if end != (0, 0) or len(set(self.points)) < self.n:
            raise NotationError(f"circuit {self.notation!r} does not close or meets a panel twice: check its steps")

    @staticmethod
    def from_notation(text: str, start: LatticePoint | None = None) -> Circuit:
        """Read the notation that `notation` writes, such as `hex:024`; start places panel 0.

        Raises
        ------
        NotationError
            For a text that is no circuit.
        SizeError
            For more panels than an array has cells.
        """
        expect_kind("the notation of a circuit", text, str, "a text, such as 'hex:024'")
        name, colon, steps = text.partition(":")
        grid = grid_named(name)
        if not colon or not re.fullmatch("[0-9]+" if grid.has_directed_steps else "[b-l]?[0-9]+", steps, re.ASCII):
            raise NotationError(f"malformed circuit {text!r}: write the grid, a colon and {_digits(grid)}")
        return Circuit(grid, read_steps(grid, steps), start)

    @property
    def notation(self) -> str:
        """The grid and the digits of the steps (`grid.step_names`); `from_notation` reads it."""
        return f"{self.grid.name}:{name_steps(self.grid, self.word)}"

    def __str__(self) -> str:
        return self.notation

    def __repr__(self) -> str:
        start = "" if self.start is None else f", start={self.start!r}"
        return f"Circuit.from_notation({self.notation!r}{start})"

    def _repr_svg_(self) -> str:
        return draw_circuit(self.grid, self.cells, numbers=True, title=self.notation)

    @property
    def n(self) -> int:
        """Number of panels, and of creases."""
        return len(self.word)

    @cached_property
    def points(self) -> tuple[LatticePoint, ...]:
        """Lattice points of the panels in circuit order, the first at `start`, or near the origin."""
        x, y = self.start or self.grid.point((0, 0, self.grid.step_kinds[self.word[0]][0]))
        points = []
        for d in self.word:
            points.append((x, y))
            x, y = x + self.grid.steps[d][0], y + self.grid.steps[d][1]
        return tuple(points)

    @property
    def cells(self) -> tuple[Cell, ...]:
        """Cells of the panels in circuit order."""
        return tuple(map(self.grid.cell, self.points))

    @property
    def array(self) -> Array:
        """The array that the circuit runs through."""
        return Array.from_cells(self.grid, self.cells)

    @property
    def turns(self) -> tuple[int, ...]:
        """The turn at each panel between the steps into and out of it, in units of 2 pi / directions."""
        turns: list[int] = step_tables(self.grid).code_turns[list(self._turn_codes)].tolist()
        return tuple(turns)

    @property
    def directions(self) -> tuple[int, ...]:
        """The direction of each step."""
        return tuple(self.grid.step_directions[step] for step in self.word)

    @cached_property
    def _turn_codes(self) -> tuple[int, ...]:
        """The code of the turn at each panel (`StepTables`); -1 where there is no such turn."""
        codes: list[int] = step_tables(self.grid).codes[[*self.word[-1:], *self.word[:-1]], self.word].tolist()
        return tuple(codes)

    @property
    def creases(self) -> tuple[LatticePoint, ...]:
        """Exact coordinates of the creases (`Grid.edge`): crease k joins panels k and k + 1."""
        return tuple(self.grid.edge(p, q) for p, q in zip(self.points, self.points[1:] + self.points[:1], strict=True))

    @cached_property
    def _canonical(self) -> tuple[tuple[int, ...], int]:
        """The canonical word, and the number of congruences that map the circuit to it."""
        least_key = min(self._keys())
        codes, first = least_key
        tables = step_tables(self.grid)
        word = [int(tables.starts[codes[0]]) + first]
        for code in codes[:-1]:
            word.append(int(tables.following[word[-1], code - tables.first_codes[word[-1]]]))
        # computed twice rather than stored: keys together take memory of the square of the length
        return tuple(word), sum(key == least_key for key in self._keys())

    def _keys(self) -> Iterator[tuple[bytes, int]]:
        """A key for each start of the circuit and of its mirror image, both walked counterclockwise.

        The key is the cyclic word of the codes of turns after a step, and the class of the step.
        """
        tables, classes = step_tables(self.grid), self.grid.step_classes
        codes = np.array(self._turn_codes)
        if sum(self.turns) < 0:
            codes = tables.mirrored[codes]
        ahead, mirrored = bytes(codes.tolist()), bytes(tables.reversed[codes].tolist())
        for k in range(self.n):
            first = self.word[k] % classes
            yield ahead[k + 1 :] + ahead[: k + 1], first
            yield mirrored[k::-1] + mirrored[:k:-1], first

    def canonical(self) -> Circuit:
        """The canonical circuit of the congruence class, with the same first panel and direction for each member."""
        return Circuit(self.grid, self._canonical[0])

    def canonical_crease(self, crease: int) -> int:
        """The number of a crease, 0 to n - 1, in the canonical circuit; one of several if there are symmetries."""
        return self.renumberings()[0](crease)

    def renumberings(self) -> list[Renumbering]:
        """The renumberings that make the circuit canonical, one for each of its symmetries."""
        keys = list(self._keys())
        least_key = min(keys)
        positions = [divmod(place, 2) for place, key in enumerate(keys) if key == least_key]
        return [Renumbering(self.n, start, bool(backwards)) for start, backwards in positions]

    def on(self, array: Array) -> Circuit:
        """Move the circuit to the cells of an array that is congruent with its own; ArrayError for another array.

        Panels and creases keep their numbers. The first symmetry of the grid that fits is applied.

        Examples
        --------
        >>> from hcsearch import GRIDS, Circuit, parse_array
        >>> wall = parse_array(GRIDS["square"], "3x2")
        >>> Circuit.from_notation("square:001223").on(wall).array == wall
        True
        """
        expect_kind("the array of a circuit", array, Array, "an Array, such as parse_array('hex', '3-4-3')")
        array_points = set(array.points)
        array_corner = min(array_points)
        for isometry in self.grid.point_group if array.grid == self.grid and array.n == self.n else ():
            images = [isometry(point) for point in self.points]
            image_corner = min(images)
            dx, dy = array_corner[0] - image_corner[0], array_corner[1] - image_corner[1]
            is_translation = self.grid.cell(image_corner)[2:] == self.grid.cell(array_corner)[2:]
            if is_translation and array_points == {(x + dx, y + dy) for x, y in images}:
                word = tuple(isometry.steps[step] for step in self.word)
                return Circuit(self.grid, word, (images[0][0] + dx, images[0][1] + dy))
        raise ArrayError(f"{self.notation} is no circuit of {array.notation}: its array is {self.array.notation}")

    @property
    def symmetry(self) -> int:
        """Order of the circuit's symmetry group."""
        return self._canonical[1]

    @property
    def n_fixed(self) -> int:
        """Number of fixed circuits (different up to translation) that are congruent to this one."""
        return len(self.grid.point_group) // self.symmetry

    @property
    def orbit_size(self) -> int:
        """Number of images of the circuit under the symmetries of its array."""
        return self.array.symmetry // self.symmetry


def _digits(grid: Grid) -> str:
    """The meaning of the digits of a grid's notations, with an example, for messages."""
    if grid.has_directed_steps:
        return f"directions 0 to {grid.directions - 1}, as hex:024"
    return f"numbers of edges, 0 to {grid.edges_per_cell - 1}, after a letter if the first panel is not of kind 0"
