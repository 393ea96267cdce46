"""Pairs of panels whose distances the bench `collision` measures: random, degenerate, stacked."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from hcsearch.basics.array_values import Reals, WholeNumbers

Random = np.random.Generator

WIDTH, THICKNESS = 0.05, 0.006
"""Of a panel, m."""
SIDES = (3, 4, 6)


@dataclass(frozen=True)
class Sample:
    """Pairs of prisms: which shapes they have and where they are.

    width : of a panel, m. shapes : vertices, those of the bottom, then those above them. which : (k, 2).
    turns : (k, 2, 3, 3). shifts : (k, 2, 3), m.
    """

    width: float
    shapes: list[Reals]
    which: WholeNumbers
    turns: Reals
    shifts: Reals

    @property
    def counts(self) -> WholeNumbers:
        """Numbers of vertices, (2, k)."""
        return np.array([len(shape) for shape in self.shapes])[self.which.T].copy()

    def vertices(self) -> Reals:
        """Where the vertices are, (2, k, m, 3), m."""
        table = np.zeros((len(self.shapes), max(map(len, self.shapes)), 3))
        for row, shape in zip(table, self.shapes, strict=True):
            row[: len(shape)] = shape
        corners = np.empty((2, len(self.which), *table.shape[1:]))
        for side in range(2):
            moved = table[self.which[:, side]] @ self.turns[:, side].transpose(0, 2, 1)
            corners[side] = moved + self.shifts[:, side, None]
        return corners


@dataclass(frozen=True)
class Family:
    """Pairs of one kind."""

    name: str
    what: str
    make: Callable[[Random, int], Sample]


def prism(sides: int, width: float = WIDTH, thickness: float = THICKNESS) -> Reals:
    """A right prism over a regular polygon with sides of some width; its bottom is about the origin."""
    angles = 2 * math.pi * np.arange(sides) / sides
    radius = 0.5 * width / math.sin(math.pi / sides)
    bottom = np.column_stack([radius * np.cos(angles), radius * np.sin(angles), np.zeros(sides)])
    return np.concatenate([bottom, bottom + np.array([0.0, 0.0, thickness])])


def _random(rng: Random, n: int, width: float = WIDTH, thickness: float = THICKNESS) -> Sample:
    shifts = width * rng.normal(size=(n, 2, 3))
    shapes = [prism(sides, width, thickness) for sides in SIDES]
    return Sample(width, shapes, rng.integers(len(SIDES), size=(n, 2)), _turns(rng, n), shifts)


def _tiny(rng: Random, n: int) -> Sample:
    return _random(rng, n, 1e-6 * WIDTH, 1e-6 * THICKNESS)


def _thin(rng: Random, n: int) -> Sample:
    return _random(rng, n, thickness=1e-6 * WIDTH)


def _stacked(rng: Random, n: int) -> Sample:
    """Equal panels in layers that touch, straight above each other or moved by half and whole widths."""
    layers = rng.choice([-5, -3, -2, -1, -1, -1, 1, 1, 1, 2, 3, 5], n)
    sideways = rng.integers(-4, 5, (n, 2)) * rng.choice([0.0, 0.5 * WIDTH, 0.5 * WIDTH * math.sqrt(3.0)], (n, 2))
    return _together(rng, np.column_stack([sideways, THICKNESS * layers]))


def _coplanar(rng: Random, n: int) -> Sample:
    """Equal panels in one layer: side by side, corner to corner, within each other or apart."""
    steps = rng.integers(-4, 5, (n, 2)) * 0.5 * WIDTH
    steps[:, 1] *= rng.choice([1.0, math.sqrt(3.0)], n)
    return _together(rng, np.column_stack([steps, np.zeros(n)]))


def _together(rng: Random, shift: Reals) -> Sample:
    """Equal panels, the second moved, then both turned and moved together."""
    n = len(shift)
    which = np.repeat(rng.integers(len(SIDES), size=(n, 1)), 2, axis=1)
    turns = _turns(rng, n)
    turns[:, 1] = turns[:, 0]
    shifts = rng.normal(scale=0.2, size=(n, 2, 3))
    shifts[:, 1] = shifts[:, 0] + np.einsum("kij,kj->ki", turns[:, 0], shift)
    return Sample(WIDTH, [prism(sides) for sides in SIDES], which, turns, shifts)


def _above(rng: Random, n: int, tilt: Reals) -> Sample:
    """The second panel above the first, turned about the upright, tilted, at gaps over many decades."""
    turns = _spins(rng.uniform(0, 2 * math.pi, (n, 2)))
    angle = rng.uniform(0, 2 * math.pi, n)
    axes = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(n)])
    turns[:, 1] = _rotations(axes, tilt) @ turns[:, 1]
    gaps = 10.0 ** rng.uniform(-16, -1, n)
    shifts = np.zeros((n, 2, 3))
    shifts[:, 1, :2] = rng.normal(scale=0.5 * WIDTH, size=(n, 2))
    shifts[:, 1, 2] = THICKNESS + gaps
    return Sample(WIDTH, [prism(sides) for sides in SIDES], rng.integers(len(SIDES), size=(n, 2)), turns, shifts)


def _parallel(rng: Random, n: int) -> Sample:
    return _above(rng, n, np.zeros(n))


def _tilted(rng: Random, n: int) -> Sample:
    return _above(rng, n, 10.0 ** rng.uniform(-16, -1, n))


def _edges(rng: Random, n: int) -> Sample:
    """An upright edge of the first, laid flat, below one of the second: crossed, nearly parallel or parallel."""
    which = rng.integers(len(SIDES), size=(n, 2))
    laid = _rotations(np.tile([0.0, 1.0, 0.0], (n, 1)), np.full(n, -0.5 * math.pi))
    crossed = _spins(rng.choice([0.0, 1.0], n, p=(0.2, 0.8)) * 10.0 ** rng.uniform(-9, 0.5, n))
    over = _rotations(np.tile([1.0, 0.0, 0.0], (n, 1)), np.full(n, math.pi))
    # laid, a vertex at the distance of the radius is up, or down, and the edge goes back from there by the thickness
    radii = np.array([prism(sides)[:, 0].max() for sides in SIDES])[which]
    shifts = np.zeros((n, 2, 3))
    shifts[:, 0, 0] = 0.5 * THICKNESS
    shifts[:, 1] = 0.5 * THICKNESS * crossed[:, :, 0]
    shifts[:, 1, 2] = radii.sum(1) + rng.choice([0.0, 1.0], n) * 10.0 ** rng.uniform(-12, -1, n)
    turns = np.stack([laid, crossed @ over @ laid], axis=1)
    return Sample(WIDTH, [prism(sides) for sides in SIDES], which, turns, shifts)


def _hinged(rng: Random, n: int) -> Sample:
    """Two panels on a hinge of the top face, flat, folded or between: they always touch along an edge."""
    which = np.repeat(rng.integers(len(SIDES), size=(n, 1)), 2, axis=1)
    sides = np.array(SIDES)[which[:, 0]]
    turned = math.pi / sides  # until a side is upright
    apothem = 0.5 * WIDTH / np.tan(math.pi / sides)
    one = _spins(turned)
    two = _spins(turned + np.where(sides % 2, math.pi, 0.0))
    angle = np.where(rng.random(n) < 0.3, rng.choice([0.0, math.pi], n), rng.uniform(0, math.pi, n))
    fold = _rotations(np.tile([0.0, 1.0, 0.0], (n, 1)), -angle)
    hinge = np.column_stack([apothem, np.zeros(n), np.full(n, THICKNESS)])
    flat = np.column_stack([2 * apothem, np.zeros(n), np.zeros(n)])
    moved = hinge + np.einsum("kij,kj->ki", fold, flat - hinge)
    whole = _turns(rng, n)[:, 0]
    turns = np.stack([whole @ one, whole @ fold @ two], axis=1)
    shifts = np.stack([np.zeros((n, 3)), np.einsum("kij,kj->ki", whole, moved)], axis=1)
    return Sample(WIDTH, [prism(sides) for sides in SIDES], which, turns, shifts)


def _corners(rng: Random, n: int) -> Sample:
    """A vertex of the second on a vertex, the middle of an edge or of a face of the first."""
    sample = _random(rng, n)
    solids, counts = sample.vertices(), sample.counts
    rows = np.arange(n)
    first = (rng.integers(1 << 30, size=n) % (counts[0] // 2))[:, None]
    on = np.concatenate([first, (first + 1) % (counts[0] // 2)[:, None]], axis=1)
    kind = rng.integers(3, size=n)
    corner, side = solids[0][rows, on[:, 0]], solids[0][rows[:, None], on].mean(1)
    face = (solids[0][:, :6] * (np.arange(6) < counts[0][:, None] // 2)[..., None]).sum(1) / (counts[0] // 2)[:, None]
    point = np.choose(kind[:, None], [corner, side, face])
    sample.shifts[:, 1] += point - solids[1][rows, rng.integers(1 << 30, size=n) % counts[1]]
    return sample


def _same(rng: Random, n: int) -> Sample:
    """The same panel twice, or all but."""
    return _together(rng, rng.choice([0.0, 1e-16, 1e-12, 1e-9, 1e-6], (n, 3)))


def _turns(rng: Random, n: int) -> Reals:
    """Random rotations, (n, 2, 3, 3)."""
    axes = rng.normal(size=(2 * n, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    return _rotations(axes, rng.uniform(0, 2 * math.pi, 2 * n)).reshape(n, 2, 3, 3)


def _spins(angles: Reals) -> Reals:
    """Rotations about the upright."""
    flat = angles.ravel()
    return _rotations(np.tile([0.0, 0.0, 1.0], (len(flat), 1)), flat).reshape(*angles.shape, 3, 3)


def _rotations(axes: Reals, angles: Reals) -> Reals:
    """Rotations about unit axes."""
    matrices: Reals = Rotation.from_rotvec(axes * angles[:, None]).as_matrix()
    return matrices


FAMILIES = (
    Family("random", "anyhow, some overlap", _random),
    Family("stacked", "layers of 6 mm that touch, moved by half and whole widths, turned together", _stacked),
    Family("coplanar", "one layer: side by side, corner to corner, within each other, turned together", _coplanar),
    Family("parallel", "one above the other, gaps of 1e-16 to 0.1 m", _parallel),
    Family("tilted", "the same, tilted by 1e-16 to 0.1 rad", _tilted),
    Family("edges", "edge across edge, crossed, nearly parallel or parallel, gaps of 0 and 1e-12 to 0.1 m", _edges),
    Family("hinged", "both on a hinge, flat, folded or between", _hinged),
    Family("corners", "a vertex on a vertex, an edge or a face", _corners),
    Family("same", "the same panel twice, moved by 0 to 1e-6 m", _same),
    Family("thin", "anyhow, 5e-8 m thick", _thin),
    Family("tiny", "anyhow, 5e-8 m wide, 6e-9 m thick", _tiny),
)
