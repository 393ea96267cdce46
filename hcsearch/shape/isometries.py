"""Isometries of the plane, whose points are complex numbers: a turn and a shift, after a reflection or without."""

from __future__ import annotations

import cmath
from typing import Any, NamedTuple

PlaneCoordinates = tuple[float, float]


class Isometry(NamedTuple):
    """z to turn * z + shift, with conj(z) in the place of z where it reflects; turn : of absolute value 1."""

    reflects: bool
    turn: complex
    shift: complex

    @staticmethod
    def by(angle: float = 0.0, shift: PlaneCoordinates = (0.0, 0.0), *, reflects: bool = False) -> Isometry:
        """Perhaps reflect in the x axis, then turn about the origin by an angle (rad), then shift."""
        return Isometry(reflects, cmath.rect(1.0, angle), complex(*shift))

    @staticmethod
    def carrying(source: tuple[complex, complex], target: tuple[complex, complex], *, reflects: bool) -> Isometry:
        """What lays one segment onto another of the same length, start on start."""
        (c, d), (a, b) = source, target
        if reflects:
            c, d = c.conjugate(), d.conjugate()
        turn = (b - a) / (d - c)
        turn /= abs(turn)
        # the middles are laid on each other: no end is favoured by rounding
        return Isometry(reflects, turn, (a + b) / 2 - turn * (c + d) / 2)

    @staticmethod
    def mirror(point: complex, normal: complex) -> Isometry:
        """The reflection in the line through a point that has a normal of absolute value 1."""
        turn = -normal * normal
        return Isometry(True, turn, point - turn * point.conjugate())

    def __call__(self, points: Any) -> Any:
        """Image of a point, or of an array of points."""
        return self._spin(points) + self.shift

    def __matmul__(self, first: Isometry) -> Isometry:
        """The isometry that comes of `first`, then this one."""
        return Isometry(self.reflects != first.reflects, self._spin(first.turn), self(first.shift))

    def _spin(self, vectors: Any) -> Any:
        return self.turn * (vectors.conjugate() if self.reflects else vectors)

    @property
    def inverse(self) -> Isometry:
        """The isometry that takes this one back."""
        turn = self.turn if self.reflects else self.turn.conjugate()
        back = self.shift.conjugate() if self.reflects else self.shift
        return Isometry(self.reflects, turn, -turn * back)

    @property
    def angle(self) -> float:
        """By which it turns, rad."""
        return cmath.phase(self.turn)

    def image(self, point: PlaneCoordinates) -> PlaneCoordinates:
        """Where a point of two coordinates comes to lie."""
        moved = self(complex(*point))
        return moved.real, moved.imag
