"""Certificates as plain data: claims about an array, and paths as stretches, in pieces that a checker proves."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from fractions import Fraction
from typing import Any

import numpy as np

from hcsearch.basics.array_values import Flags, Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.motion.certificates import path_checker
from hcsearch.motion.certificates.certificate_grammar import FORMAT, MAX_WHOLE, VERSION, NotProvedError, checksum
from hcsearch.motion.certificates.path_checker import Array
from hcsearch.motion.certificates.polynomials import shifted
from hcsearch.motion.collision.panel_prisms import plates_of
from hcsearch.motion.locks.boxes import MAX_BOX_ANGLE
from hcsearch.motion.locks.enclosures import Enclosure
from hcsearch.motion.locks.lattice import lattice_frame_of
from hcsearch.motion.planning.stretches import Tube, cubics_of
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import Pattern

WANDER_LIMIT_SHARES = (0.02, 0.004, 0.0008)
"""Greatest deviations of closed states from a piece (rad), summed over hinges and divided by the margin as a share of
the array's size; the next is used where the states of neighbouring pieces are not joined."""
MAX_REFINEMENT_HALVINGS = 16
"""Greatest number of halvings of a step."""
REFINEMENT_BATCH_SIZE = path_checker.BATCH

StepSpan = tuple[int, float, float]
"""A step of a path, and the shares of it at which the span begins and ends."""


@np.errstate(over="ignore", invalid="ignore")  # an overflow proves nothing
def stretch_data(array: Array, tube: Tube, closed: list[int], margin: float) -> tuple[dict[str, Any], list[int]]:
    """Return a stretch as a certificate holds it, and which hinges are closed (1) at its end.

    closed : flags of the hinges that are closed at its beginning. margin : as a share of the array's size.
    NotProvedError where the checker does not prove the stretch, however short its pieces are.
    """
    track = tube.track
    if track is None:
        raise NotProvedError("a stretch is not proved")
    count = int(track.state_count[0])
    times, angles, rates = track.times[:count], track.angles[:count], track.rates[:count]
    if tube.turns_equally:
        data = {"kind": "equal", "hinges": np.flatnonzero(angles[0] != angles[-1]).tolist()}
        return data, array.led_by_equal_turns(data, closed)[-1]
    refinement = _Refinement(array, times, angles, rates, closed)
    for wander in WANDER_LIMIT_SHARES[:-1]:
        data = refinement.data(wander * margin)
        with suppress(NotProvedError):
            return data, array.led_by_cubics(data, closed)[-1]
    data = refinement.data(WANDER_LIMIT_SHARES[-1] * margin)
    return data, array.led_by_cubics(data, closed)[-1]


class _Refinement:
    """A stretch along cubics, (steps, n, 4) in the share of each step, that is refined until the checker proves it."""

    def __init__(self, array: Array, times: Reals, angles: Reals, rates: Reals, closed: list[int]) -> None:
        self.array, self.times, self.steps = array, times, np.diff(times)
        self.cubics = cubics_of(times, angles, rates)
        self.moving: Flags = (angles != angles[0]).any(0) | rates.any(0)
        self.rows = array.equations(closed, self.moving)[0]
        self.ends = angles[[0, -1]]
        self.leaves = self._left(0), self._left(1)

    def data(self, limit: float) -> dict[str, Any]:
        """Return the stretch as data, in pieces from which closed states deviate by less than a limit (rad)."""
        spans = self._halved(self._spans(), limit)
        shares = [*spans, (spans[-1][0], spans[-1][2], 1.0)]
        times, angles, rates = [], [], []
        for step, share, _ in shares:
            a, b, c, d = np.moveaxis(self.cubics[step], -1, 0)
            times.append(float(self.times[step] + share * self.steps[step]))
            angles.append(a + share * (b + share * (c + share * d)))
            rates.append((b + share * (2 * c + 3 * share * d)) / self.steps[step])
        angles[0], angles[-1] = self.ends
        rows = {name: np.array(own).tolist() for name, own in (("angles", angles), ("rates", rates))}
        return {"kind": "cubics", "times": times, **rows}

    def _spans(self) -> list[StepSpan]:
        """The spans of the steps; the first and the last one are cut where they leave a state with singular closure."""
        spans: list[StepSpan] = [(step, 0.0, 1.0) for step in range(len(self.cubics))]
        begin, end = self.leaves
        if begin:
            spans[:1] = [(0, 0.0, begin), (0, begin, 1.0)]
        if end:
            step, low, _ = spans[-1]
            spans[-1:] = [(step, low, 1.0 - end), (step, 1.0 - end, 1.0)]
        return spans

    def _left(self, side: int) -> float:
        """Return the share of a step that leaves the first or the last state; 0 where closure is regular there.

        It is half of the first share among 1, 1/2, 1/4, ... that is proved: deviations are smaller there.
        """
        state = [round(angle / math.pi) for angle in self.ends[side]]
        rows, wrenches = self.array.equations(state, self.moving)
        if not len(wrenches):
            return 0.0
        _, b, c, d = np.moveaxis(self.cubics[-side], -1, 0)
        cubic = np.stack([-b - 2 * c - 3 * d, c + 3 * d, -d] if side else [b, c, d], -1)
        proved = False
        for halving in range(MAX_REFINEMENT_HALVINGS):
            course = np.column_stack([self.ends[side], cubic * 0.5 ** (halving * np.arange(1, 4))])
            departs = bool(np.isfinite(self.array.tube(rows, self.moving, course[None], wrenches)).all())
            if proved and departs:
                return 0.5**halving
            proved = departs
        raise NotProvedError("how a path leaves or reaches a state with singular closure is not proved")

    def _halved(self, spans: list[StepSpan], limit: float) -> list[StepSpan]:
        """Halve the spans until closed states are proved beside each, except for spans that leave an end."""
        inner = slice(bool(self.leaves[0]), len(spans) - bool(self.leaves[1]))
        done, waiting = [*spans[: inner.start], *spans[inner.stop :]], spans[inner]
        while waiting:
            batch, waiting = waiting[-REFINEMENT_BATCH_SIZE:], waiting[:-REFINEMENT_BATCH_SIZE]
            cubics = np.array([self._part(*span) for span in batch])
            deviations = self.array.tube(self.rows, self.moving, cubics, np.zeros((0, len(self.rows)))).sum(1)
            for (step, low, high), deviation in zip(batch, deviations, strict=True):
                if deviation < limit:
                    done.append((step, low, high))
                    continue
                if high - low < 0.5**MAX_REFINEMENT_HALVINGS:
                    raise NotProvedError("closed states are not proved to lie beside a path")
                middle = 0.5 * (low + high)
                waiting += [(step, low, middle), (step, middle, high)]
        return sorted(done)

    def _part(self, step: int, low: float, high: float) -> Reals:
        """The cubics of a span, in the variable that is -1 and 1 at its ends."""
        part: Reals = shifted(self.cubics[step], 0.5 * (low + high), 0.5 * (high - low))
        return part


def array_data(linkage: Linkage) -> dict[str, Any]:
    """Return the panels and hinges of a linkage in integer coordinates of its lattice (`lattice.lattice_frame_of`).

    HcsearchError where some point is off the lattice, or where the coordinates are not below `MAX_WHOLE`.
    """
    frame, pattern = lattice_frame_of(linkage), linkage.pattern
    facets = [] if frame is None else [frame.points(np.array(facet)) for facet in pattern.facets]
    lattice = [facet.tolist() for facet in facets if facet is not None]
    if frame is None or len(lattice) < len(facets):
        raise HcsearchError(
            "certificates hold whole numbers, on the lattice of a tiling, and this pattern is on none: see what "
            "hcsearch check says of it"
        )
    if max(frame.steps[2], *(abs(x) for facet in lattice for point in facet for x in point)) >= MAX_WHOLE:
        raise HcsearchError(
            f"certificates hold whole numbers below {MAX_WHOLE:,}, and the thickness of "
            f"{1e3 * pattern.thickness:.6g} mm is no simple part of the lattice: give --panel LENGTHxTHICKNESS in "
            "whole mm, or state frame_unit and hcsearch:thickness in the file"
        )
    return {
        "unit": str(Fraction(frame.unit).limit_denominator(10**15)),
        "root": frame.q,
        "thickness": frame.steps[2],
        "facets": lattice,
        "panels": [list(panel) for panel in pattern.panels],
        "hinges": [
            {"facets": _facets(pattern, number), "face": hinge.face, "closes": bool(hinge.closes)}
            for number, hinge in enumerate(pattern.hinges)
        ],
    }


def _facets(pattern: Pattern, hinge: int) -> list[int]:
    """Two facets that share an edge along a hinge; the facet of its first panel comes first."""
    first, second = next(
        pair for pair, crease in pattern.creases.items() if crease.face and pattern.hinge_of(pair) == hinge
    )
    return [first, second] if pattern.panel_of[first] == pattern.hinges[hinge].first else [second, first]


def lock_claim(linkage: Linkage, enclosure: Enclosure) -> dict[str, Any]:
    """Return the claim that no motion leaves the boxes of a lock; with panels, that none does without a collision."""
    cuts = [[0.0, MAX_BOX_ANGLE] for _ in range(linkage.n_hinges)]
    lows = np.zeros((len(enclosure.lows), linkage.n_hinges), int)
    highs = np.ones_like(lows)
    for column, hinge in enumerate(linkage.looped.tolist()):
        low, high = enclosure.lows[:, column], enclosure.highs[:, column]
        values = np.unique(np.concatenate([[0.0, MAX_BOX_ANGLE], low, high]))
        cuts[hinge] = values.tolist()
        lows[:, hinge], highs[:, hinge] = np.searchsorted(values, low), np.searchsorted(values, high)
    boxes = {"cuts": cuts, "lows": lows.tolist(), "highs": highs.tolist()}
    claim = {"array": array_data(linkage), "end": enclosure.end, "tried": enclosure.boxes, **boxes}
    if enclosure.margin is None:
        return {"kind": "lock", **claim}
    pairs = plates_of(linkage, enclosure.margin).pairs.tolist()
    return {"kind": "collision", **claim, "margin": repr(enclosure.margin), "pairs_of_facets": pairs}


def path_claim(linkage: Linkage, tubes: Sequence[Tube], margin: float) -> dict[str, Any]:
    """Return the claim that a path leads from packed to flat with a margin (m), with its stretches.

    NotProvedError where the checker does not prove a stretch.
    """
    data = array_data(linkage)
    array = Array(data)
    share, closed = float(Fraction(margin) / array.unit / Fraction(array.size)), array.packed
    stretches = []
    for tube in tubes:
        stretch, closed = stretch_data(array, tube, closed, share)
        stretches.append(stretch)
    return {"kind": "path", "array": data, "margin": repr(float(margin)), "stretches": stretches}


def certificate(claims: Sequence[dict[str, Any]], of: str, panel_mm: str | None) -> dict[str, Any]:
    """Return the certificate of a folding, or of a pattern, with its checksum.

    of : the notation of the folding, or the name of the pattern. panel_mm : None for a pattern.
    """
    kind = {"format": FORMAT, "version": VERSION}
    data: dict[str, Any] = {**kind, "of": of, "panel_mm": panel_mm, "claims": list(claims)}
    return {**data, "sha256": checksum(data)}
