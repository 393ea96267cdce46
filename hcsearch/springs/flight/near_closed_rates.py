"""Closed rates in boxes of fold angles around states of a motion, from those at the middles.

Along the motion the screws of hinges change at known rates, by which closed rates at the middle are corrected to first
order. What is left to open the loops is of second order in how far the box reaches, and of first order in how far its
states are from a straight line; the least singular value of closure bounds the rates that close it again
(docs/explanation/flight_margins.md, 5).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import ByValue, Flags, Reals, WholeNumbers
from hcsearch.kernels.planning.series import centre_screws
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.flight.torque_margin import CLOSED_RATE_TOLERANCE


@dataclass(frozen=True, eq=False)
class StateBoxes(ByValue):
    """Boxes of fold angles of k states of a motion: middle + u drift + rest, for -1 <= u <= 1 and |rest| <= rests.

    middles, drifts, rests : (k, n_hinges), rad.
    """

    middles: Reals
    drifts: Reals
    rests: Reals

    @property
    def turns(self) -> Reals:
        """How far hinges are from the middles at most, (k, n_hinges)."""
        turns: Reals = np.abs(self.drifts) + self.rests
        return turns


@dataclass(frozen=True, eq=False)
class NearClosedRates(ByValue):
    """How rates that are closed at the middles of k boxes change, to be closed elsewhere in these.

    screws : (k, n_rows, n_hinges), closure at the middles, in units of its loops. drifts : their changes at the end of
    the drift, to first order. rests : (k, n_loops, n_hinges), the greatest other changes. inverse : (k, n_hinges,
    n_rows), of closure on the hinges that may correct rates. firm : (k,), the least singular value of closure on these
    hinges in all of the box; 0 or less where its equations may depend on each other. dependent : (k,), where they do at
    the middle, on the hinges between their stops.
    """

    screws: Reals
    drifts: Reals
    rests: Reals
    inverse: Reals
    firm: Reals
    dependent: Flags

    @staticmethod
    def of(linkage: Linkage, jacobians: Reals, boxes: StateBoxes, free: Flags, between: Flags) -> NearClosedRates:
        """Return the changes in boxes; jacobians : (k, n_rows, n_hinges), at the middles, of `Linkage.closure`.

        free : (k, n_hinges), hinges whose rates may be corrected; between : hinges between their stops at the middle.
        """
        screws, (count, _, n) = jacobians.copy(), jacobians.shape
        drifts, rests = np.zeros(screws.shape), np.zeros((count, len(linkage.loops), n))
        moments = np.zeros((count, n))
        for number, loop in enumerate(linkage.loops):
            hinges, rows = np.array([hinge for hinge, _ in loop]), slice(6 * number, 6 * number + 6)
            for k in range(count):
                centre_screws(screws[k], 6 * number, hinges, np.empty(3), moments[k])
            own = moments[:, hinges]
            gains = 0.5 * (own + np.sqrt(own * own + 4.0))  # of the bracket with a screw
            along = screws[:, rows][:, :, hinges]
            moved = np.cumsum(boxes.drifts[:, None, hinges] * along, axis=2)
            # seen from the panel half way round the loop, turns between it and a hinge move the hinge's line
            before = moved - boxes.drifts[:, None, hinges] * along
            half = len(hinges) // 2
            drifts[:, rows, hinges] = _brackets(before - before[:, :, half : half + 1], along)
            reach = _beyond(gains * boxes.turns[:, hinges], half)
            small = _beyond(gains * boxes.rests[:, hinges], half) + np.expm1(reach) - reach
            rests[:, number, hinges] = small * np.linalg.norm(along, axis=1)
        if not linkage.loops:
            return NearClosedRates(screws, drifts, rests, screws, np.full(count, np.inf), np.zeros(count, bool))
        least, inverse = _inverses(screws, free)
        dependent = least < CLOSED_RATE_TOLERANCE
        dependent[dependent] = _inverses(screws[dependent], between[dependent])[0] < CLOSED_RATE_TOLERANCE
        grown = (np.linalg.norm(part * free[:, None], axis=(1, 2)) for part in (drifts, rests))
        return NearClosedRates(screws, drifts, rests, inverse, least - sum(grown), dependent)

    def changes(self, boxes: WholeNumbers, rates: Reals) -> tuple[Reals, Reals]:
        """Return changes of rates at the end of the drift, (k, n_hinges), and how far closed rates are from them, (k,).

        rates : closed at the middles of some boxes. At u times the drift the rates with u times their changes are
        nearer to closed ones than this distance, infinite where loops are not firm.
        """
        screws, drifts, firm = self.screws[boxes], self.drifts[boxes], self.firm[boxes]
        turned = _applied(drifts, rates)
        changes = -_applied(self.inverse[boxes], turned)
        errors = (_applied(screws, rates), turned + _applied(screws, changes), _applied(drifts, changes))
        opened = sum(np.linalg.norm(error.reshape(len(boxes), self.rests.shape[1], 6), axis=2) for error in errors)
        opened = np.linalg.norm(opened + _applied(self.rests[boxes], np.abs(rates) + np.abs(changes)), axis=1)
        return changes, np.where(firm > 0.0, opened / np.where(firm > 0.0, firm, 1.0), np.inf)


def _applied(matrices: Reals, vectors: Reals) -> Reals:
    """Return the products of k matrices and vectors."""
    products: Reals = (matrices @ vectors[:, :, None])[:, :, 0]
    return products


def _beyond(values: Reals, half: int) -> Reals:
    """Return sums of values (k, m) of the hinges between the middle panel of a loop and each of its hinges."""
    sums = np.c_[np.zeros(len(values)), np.cumsum(values, axis=1)]
    beyond: Reals = np.c_[sums[:, half : half + 1] - sums[:, 1 : half + 1], sums[:, half:-1] - sums[:, half : half + 1]]
    return beyond


def _brackets(first: Reals, second: Reals) -> Reals:
    """Return the Lie brackets of screws, (k, 6, m)."""
    turns = np.cross(first[:, :3], second[:, :3], axis=1)
    moments = np.cross(first[:, 3:], second[:, :3], axis=1) + np.cross(first[:, :3], second[:, 3:], axis=1)
    return np.concatenate([turns, moments], axis=1)


def _inverses(screws: Reals, chosen: Flags) -> tuple[Reals, Reals]:
    """Return the least singular values of closure on chosen hinges, (k,), and its inverses, (k, n_hinges, n_rows).

    The values are 0 where there are fewer than equations. Values near 0 are left out of the inverses.
    """
    left, values, right = np.linalg.svd(screws * chosen[:, None, :], full_matrices=False)
    height, kept = screws.shape[1], values > CLOSED_RATE_TOLERANCE
    least = values[:, height - 1] if values.shape[1] >= height else np.zeros(len(screws))
    scaled = right * (kept / np.where(kept, values, 1.0))[:, :, None]
    return least, chosen[:, :, None] * (scaled.transpose(0, 2, 1) @ left.transpose(0, 2, 1))
