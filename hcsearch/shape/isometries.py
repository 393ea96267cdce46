"""Isometries of the plane, with points as complex numbers: an optional reflection, then a rotation and a shift."""

from __future__ import annotations

import cmath
from typing import Any, NamedTuple

PlaneCoordinates = tuple[float, float]


class Isometry(NamedTuple):
    """The map of z to turn * z + shift, or to turn * conj(z) + shift if it reflects; turn : of absolute value 1."""

    reflects: bool
    turn: complex
    shift: complex

    @staticmethod
    def by(angle: float = 0.0, shift: PlaneCoordinates = (0.0, 0.0), *, reflects: bool = False) -> Isometry:
        """Reflect in the x axis if `reflects`, then rotate about the origin by an angle (rad), then shift."""
        return Isometry(reflects, cmath.rect(1.0, angle), complex(*shift))

    @staticmethod
    def carrying(source: tuple[complex, complex], target: tuple[complex, complex], *, reflects: bool) -> Isometry:
        """The isometry that maps one segment onto another of the same length, start onto start."""
        (c, d), (a, b) = source, target
        if reflects:
            c, d = c.conjugate(), d.conjugate()
        turn = (b - a) / (d - c)
        turn /= abs(turn)
        # map midpoint to midpoint, so that rounding favours neither end
        return Isometry(reflects, turn, (a + b) / 2 - turn * (c + d) / 2)

    @staticmethod
    def mirror(point: complex, normal: complex) -> Isometry:
        """The reflection in the line through a point with a given normal of absolute value 1."""
        turn = -normal * normal
        return Isometry(True, turn, point - turn * point.conjugate())

    def __call__(self, points: Any) -> Any:
        """The image of a point, or of an array of points."""
        return self._spin(points) + self.shift

    def __matmul__(self, first: Isometry) -> Isometry:
        """The composition of `first`, then this isometry."""
        return Isometry(self.reflects != first.reflects, self._spin(first.turn), self(first.shift))

    def _spin(self, vectors: Any) -> Any:
        return self.turn * (vectors.conjugate() if self.reflects else vectors)

    @property
    def inverse(self) -> Isometry:
        """The inverse isometry."""
        turn = self.turn if self.reflects else self.turn.conjugate()
        back = self.shift.conjugate() if self.reflects else self.shift
        return Isometry(self.reflects, turn, -turn * back)

    @property
    def angle(self) -> float:
        """The angle of rotation, rad."""
        return cmath.phase(self.turn)

    def image(self, point: PlaneCoordinates) -> PlaneCoordinates:
        """The image of a point given by two coordinates."""
        moved = self(complex(*point))
        return moved.real, moved.imag
