"""Built arrays in their plain form: hinge axes off their places, loops closed by Newton's method, shapes measured.

Nothing here is linear: panels are placed by products of rigid motions.
"""

from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.flight.build_errors import ErrorMap

UP = np.array([0.0, 0.0, 1.0])


def frames(starts: Reals, ends: Reals) -> Reals:
    """Frames (..., 4, 4) of lines: x along the line, y level, the origin half way."""
    along = (ends - starts) / np.linalg.norm(ends - starts, axis=-1, keepdims=True)
    level = np.cross(UP, along)
    level /= np.linalg.norm(level, axis=-1, keepdims=True)
    placed = np.zeros((*along.shape[:-1], 4, 4))
    placed[..., :3, :] = np.stack([along, level, np.cross(along, level), (starts + ends) / 2], axis=-1)
    placed[..., 3, 3] = 1.0
    return placed


@dataclass(frozen=True)
class BuiltArray:
    """A linkage and the order of errors of `ErrorMap`; errors are arrays (n_samples, n_columns)."""

    linkage: Linkage
    root: int = 0

    def across(self, errors: Reals, k: int) -> Reals:
        """The motion of the second panel of a hinge against its first, (n_samples, 4, 4)."""
        hinge, n = self.linkage.pattern.hinges[k], self.linkage.n_hinges
        thickness = self.linkage.pattern.thickness
        height = thickness / 2 if hinge.face == "top" else -thickness / 2
        ends = [np.array([*corner, height]) for corner in (hinge.start, hinge.end)]
        along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        shifts = errors[:, n + 4 * k : n + 4 * k + 4]
        nominal, placed = frames(*ends), []
        for panel, share in ((hinge.first, 0.5), (hinge.second, -0.5)):
            thicker = np.sign(height) * errors[:, 5 * n + panel, None] / 2 * UP
            moved = [
                end + share * (shifts[:, i, None] * np.cross(UP, along) + shifts[:, i + 2, None] * UP) + thicker
                for i, end in enumerate(ends)
            ]
            placed.append(frames(*moved) @ np.linalg.inv(nominal))
        angles = errors[:, k] * np.sign(along @ self.linkage.directions[k])
        turn = np.tile(np.eye(4), (len(errors), 1, 1))
        turn[:, 1, 1] = turn[:, 2, 2] = np.cos(angles)
        turn[:, 2, 1] = np.sin(angles)
        turn[:, 1, 2] = -turn[:, 2, 1]
        return placed[0] @ nominal @ turn @ np.linalg.inv(nominal) @ np.linalg.inv(placed[1])

    def panels(self, errors: Reals) -> list[Reals]:
        """The placement of each panel, found by walking from the root."""
        placed = {self.root: np.tile(np.eye(4), (len(errors), 1, 1))}
        while len(placed) < self.linkage.n_panels:
            for k, hinge in enumerate(self.linkage.pattern.hinges):
                if hinge.first in placed and hinge.second not in placed:
                    placed[hinge.second] = placed[hinge.first] @ self.across(errors, k)
                elif hinge.second in placed and hinge.first not in placed:
                    placed[hinge.first] = placed[hinge.second] @ np.linalg.inv(self.across(errors, k))
        return [placed[panel] for panel in range(self.linkage.n_panels)]

    def residual(self, errors: Reals) -> Reals:
        """What all loops are open by, (n_samples, 6 n_loops): turns, and shifts (m) of the drawing's origin."""
        rows = []
        for loop in self.linkage.loops:
            around = np.tile(np.eye(4), (len(errors), 1, 1))
            for k, sign in loop:
                step = self.across(errors, k)
                around = around @ (step if sign == 1 else np.linalg.inv(step))
            skew = 0.5 * (around[:, :3, :3] - np.swapaxes(around[:, :3, :3], 1, 2))
            rows += [skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0], *around[:, :3, 3].T]
        return np.stack(rows, axis=1) if rows else np.zeros((len(errors), 0))

    def slopes(self, scale: Reals) -> Reals:
        """The derivative of the residual by errors over their scale, by central differences."""
        steps = 1e-3 * np.diag(scale)
        return ((self.residual(steps) - self.residual(-steps)) / 2e-3).T

    def closed(self, errors: Reals, scale: Reals, steps: int = 12) -> Reals:
        """The nearest errors for which loops close, in proportion to their scale, by Newton's method."""
        slopes = self.slopes(scale)
        weights = np.where(np.arange(slopes.shape[0]) % 6 < 3, 1.0, 1.0 / self.linkage.pattern.size)[:, None]
        inverse = np.linalg.pinv(weights * slopes, rcond=1e-9)
        for _ in range(steps):
            errors = errors - scale * ((weights.T * self.residual(errors)) @ inverse.T)
        return errors

    def opening(self, errors: Reals) -> Reals:
        """The greatest entry of the residual of each sample, shifts over the size of the pattern."""
        residual = self.residual(errors)
        weights = np.where(np.arange(residual.shape[1]) % 6 < 3, 1.0, 1.0 / self.linkage.pattern.size)
        return np.abs(residual * weights).max(axis=1, initial=0.0)

    def flatness(self, errors: Reals) -> tuple[Reals, Reals]:
        """The greatest distance of a corner from the fitted plane, and the root mean square over area, by sample."""
        placed, pattern = self.panels(errors), self.linkage.pattern
        spots, heights, weights, corners, corner_heights = [], [], [], [], []
        for facet, panel in zip(pattern.facets, pattern.panel_of, strict=True):
            polygon = np.array(facet)
            pose = placed[panel][:, 2]
            corners += [polygon]
            corner_heights += [pose[:, :2] @ polygon.T + pose[:, 3:]]
            for k in range(1, len(polygon) - 1):
                triangle = polygon[[0, k, k + 1]]
                inner = (np.ones((3, 3)) + 3 * np.eye(3)) / 6 @ triangle  # exact for squares of heights, too
                area = abs(np.linalg.det(triangle[1:] - triangle[0])) / 2
                spots += [inner]
                heights += [pose[:, :2] @ inner.T + pose[:, 3:]]
                weights += [area / 3] * 3
        places, z, w = np.concatenate(spots), np.concatenate(heights, axis=1), np.sqrt(weights)
        ones = np.column_stack([np.ones(len(places)), places])
        plane = np.linalg.lstsq(w[:, None] * ones, (w * z).T, rcond=None)[0]
        rms = np.sqrt(((w * (z - (ones @ plane).T)) ** 2).sum(axis=1) / (w**2).sum())
        outline = np.concatenate(corners)
        away = np.concatenate(corner_heights, axis=1) - (np.column_stack([np.ones(len(outline)), outline]) @ plane).T
        return np.abs(away).max(axis=1), rms


def built_samples(built: BuiltArray, errors: ErrorMap, starts: Reals) -> Reals:
    """Built arrays within their tolerances: errors over their bounds, (n_samples, n_columns), closed and drawn in.

    Samples that leave their bounds where loops close are drawn in until they are within them.
    """
    over = starts
    for _ in range(12):
        over = built.closed(over * errors.bounds, errors.bounds) / np.where(errors.bounds > 0, errors.bounds, 1.0)
        most = np.abs(over).max(axis=1, keepdims=True)
        if most.max() <= 1.0:
            break
        over = np.where(most > 1.0, over * (1.0 - 1e-4) / most, over)
    inside = (np.abs(over).max(axis=1) <= 1.0) & (built.opening(over * errors.bounds) < 1e-11)
    return over[inside] * errors.bounds
