"""Packed states of drawn patterns: each panel in a layer, hinges closed or flat, loops closed, no layer filled twice.

A state that a file states may also have hinges between these stops; only loops and collisions are checked then.

A closed hinge reflects the next panel in its line, as seen from above, and moves it up or down by one layer: up where
the hinge is on the upper side. So the panels' places follow from the hinges that close, and their layers from the faces
of these hinges (`panel_layers`). States that a file does not state are searched for: first with all hinges closed, then
with more and more of them flat.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import combinations, islice

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.basics.errors import PatternError
from hcsearch.motion.collision.distances import cuts_through
from hcsearch.motion.kinematics.closing import close_linkage
from hcsearch.motion.kinematics.within_stops import close_within_stops
from hcsearch.search.own_patterns.drawn_linkages import (
    pattern_of_drawing,
    stated_angles,
    states_angles,
    states_between_stops,
)
from hcsearch.search.own_patterns.fold_reading import SAME_DRAWN_POINT_SHARE, PatternDrawing
from hcsearch.search.own_patterns.panel_layers import LayerSearch, overlapping_panels
from hcsearch.search.own_patterns.recognition import on_grid, panel_named
from hcsearch.shape.linkage import Linkage, hinge_tree
from hcsearch.shape.pattern import Crease, PanelFace, Pattern
from hcsearch.springs.deployment.outcomes import FLAT_FOLD_ANGLE
from hcsearch.system.work_steps import work_step

MAX_FLAT_SETS = 2_000
"""Greatest number of sets of hinges that are tried as the flat ones."""
MAX_SET_PAIRS = 2e7
"""Limit of the number of these sets times the squared number of panels, as the time for a set grows with pairs of
panels."""
CLOSED_PLACE_SHARE = 1e-12
"""Places of panels nearer than this share of the pattern's size coincide: rounding is a hundred times less."""
MAX_DRAWN_OPENING = 0.02
"""Greatest turn (rad), or gap over the size, that may be due to the drawing, for each hinge of a loop."""
SHADOW_OVERLAP_SHARE = 1e-3
"""Panels overlap, seen from above, where they share more than this share of a panel's area."""
MOVED_OVERLAP_FACTOR = 50.0
"""Allowed overlap of neighbours in rounded drawings, per relative distance by which points were moved."""
MAX_NAMED = 8
"""Greatest number of hinges, or of panels, that a message names."""
MIN_TOLD_TURN, MAX_STATED_TURN = 0.01, 20.0
"""Turns (degrees) that close a stated state: turns above the first are reported, and turns above the second lead to
another state."""
ROUNDED_CLOSURE_RESIDUAL = 1e-9
"""Closure residual (rad, or gap over the size) of a stated state that counts as closed, though rounding opens it."""
MAX_ROUNDING_TURN, MAX_TURN_PER_OPENING, MAX_ROUNDING_OPENING = 1e-3, 1e3, 1e-4
"""Loops that rounding opens by less than the third (rad, or gap over the size) close near the stated state where no
hinge turns by more than the first (rad), or by more than the second times the opening."""
STOP_ROUNDING = 1e-9
"""Hinges of a closed state nearer to a stop than this (rad) are at it."""
MAX_POINT_STEPS = 8
"""Newton steps by which points are moved until the packed state closes."""

PlaneMotion = tuple[complex, complex, bool]
"""A motion of the plane: z -> turn z + shift, or turn conj(z) + shift where it reflects."""
_REST: PlaneMotion = (1 + 0j, 0j, False)


@dataclass(frozen=True, eq=False)
class PackedPattern(ByValue):
    """A pattern with the hinges that are folded in its packed state, or without such a state.

    Parameters
    ----------
    pattern
        The pattern, whose hinges have the faces and the fold angles of its packed state.
    packed
        Whether there is one.
    sentence
        How it was found, or why there is none.
    moved
        The greatest distance (m) by which points were moved to close it.
    assumed
        The hinges of unassigned creases with the faces that were found for them, as a sentence; empty without any.
    """

    pattern: Pattern
    packed: bool
    sentence: str
    moved: float = 0.0
    assumed: str = ""


def pack_drawing(drawing: PatternDrawing, panel: str | None = None) -> PackedPattern:
    """Return the pattern of a drawing with its packed state: the stated state, or one that is found.

    panel : as in `pattern_of_drawing`. PatternError as there, and where creases are unassigned and hinges are stated
    partly closed, or no mountains and valleys pack the panels.
    """
    pattern = pattern_of_drawing(drawing, panel)
    if drawing.form_fault:
        raise PatternError(drawing.form_fault)
    if not pattern.hinges:
        raise PatternError("all panels of the drawing are one, joined by flat edges (F): assign mountains and valleys")
    search = _PackingSearch(drawing, pattern)
    if states_between_stops(drawing):
        if search.free:
            raise _unassigned(drawing, "the file states a state with hinges between 0 and 180 degrees")
        return _between_stops(drawing, pattern, panel)
    found = search.packed()
    if found is None and search.free:
        raise _unassigned(drawing, f"no mountains and valleys were found that pack the panels, as {search.fault}")
    if found is None:
        return PackedPattern(search.pattern, False, f"no packed state is known: {search.fault}")
    flat = sum(not hinge.closes for hinge in found.hinges)
    if flat == len(found.hinges):
        return PackedPattern(search.pattern, False, "no packed state is known: the file keeps all hinges flat")
    how = "stated by the file" if search.stated else "found"
    hinges = "all hinges closed" if not flat else f"{flat} of {len(found.hinges)} hinges flat, the others closed"
    moved = max(map(math.dist, found.vertices, search.pattern.vertices))
    return PackedPattern(found, True, f"packed state {how}: {hinges}", moved, _assumed(found, search.free))


def _assumed(pattern: Pattern, free: set[int]) -> str:
    """Return a sentence on the hinges that the drawing leaves unassigned, with their faces; empty without any."""
    told = []
    for fold, face in (("valley", "top"), ("mountain", "bottom")):
        hinges = [str(k) for k in sorted(free) if pattern.hinges[k].face == face]
        if len(hinges) == 1:
            told.append(f"hinge {hinges[0]}, unassigned, is taken as a {fold}")
        elif hinges:
            told.append(f"hinges {', '.join(hinges)}, unassigned, are taken as {fold}s")
    return "; ".join(told)


def _unassigned(drawing: PatternDrawing, why: str) -> PatternError:
    """Return the error for a drawing whose creases need assignments; why : as a clause."""
    pair = next(pair for pair, join in drawing.joins.items() if join.assignment == "U" and join.face is None)
    return PatternError(
        f"the crease between {panel_named(drawing, pair[0])} and panel {pair[1]} is unassigned (U), and {why}: assign "
        "M and V, which say on which face each hinge is"
    )


def _between_stops(drawing: PatternDrawing, pattern: Pattern, panel: str | None) -> PackedPattern:
    """Return a pattern in the state that its file states between the stops, closed.

    Panels of a grid are moved to their exact places, at which more loops close.
    """
    with suppress(PatternError):
        pattern = pattern_of_drawing(on_grid(drawing), panel)
    linkage, stated = Linkage(pattern), stated_angles(drawing, pattern)
    angles = _closed_near(linkage, stated)
    if isinstance(angles, str):
        return PackedPattern(pattern, False, f"no packed state is known: {angles}")
    if angles.max() <= FLAT_FOLD_ANGLE:
        return PackedPattern(pattern, False, "no packed state is known: the file keeps all hinges flat")
    if cuts_through(linkage, angles[None]):
        fault = "thick panels penetrate each other in the state that the file states, between 0 and 180 degrees"
        return PackedPattern(pattern, False, f"no packed state is known: {fault}")
    turned = float(np.degrees(np.abs(angles - stated).max()))
    near = f", after hinges turn by up to {turned:.3g} degrees to close the loops" if turned > MIN_TOLD_TURN else ""
    between = int(((angles > 0.0) & (angles < math.pi)).sum())
    sentence = f"packed state stated by the file: {between} of {len(angles)} hinges between 0 and 180 degrees{near}"
    return PackedPattern(_with_folded_angles(pattern, angles), True, sentence)


def _closed_near(linkage: Linkage, stated: Reals) -> Reals | str:
    """Return the closed state near stated fold angles, (n_hinges,), or why there is none.

    Loops that close at exact sizes only, such as loops with more freedom than the Kutzbach criterion predicts, stay
    open by the rounding of a drawing: closing them leads far away, along the motion that rounding takes from them.
    """
    angles = np.clip(close_linkage(linkage, stated, tolerance=ROUNDED_CLOSURE_RESIDUAL).angles, 0.0, math.pi)
    angles[angles < STOP_ROUNDING] = 0.0
    angles[angles > math.pi - STOP_ROUNDING] = math.pi
    within, _ = close_within_stops(linkage, angles)
    closes = _opening(linkage, angles) <= ROUNDED_CLOSURE_RESIDUAL
    if within is not None and (not closes or float(np.abs(within.angles - angles).max()) <= MAX_ROUNDING_TURN):
        closes, angles = True, within.angles
    turned, opening = float(np.abs(angles - stated).max()) if closes else math.inf, _opening(linkage, stated)
    if opening < MAX_ROUNDING_OPENING and turned > max(MAX_ROUNDING_TURN, MAX_TURN_PER_OPENING * opening):
        return (
            f"in the state that the file states loops are open by {opening:.1g} of the pattern's size, and close at "
            "exact sizes only: give points with more decimals"
        )
    if math.degrees(turned) > MAX_STATED_TURN:
        return "thick panels have no closed state near the one that the file states, between 0 and 180 degrees"
    return angles


def _opening(linkage: Linkage, angles: Reals) -> float:
    """Return the greatest closure residual of a state (rad, or gap over the size)."""
    return float(np.abs(linkage.closure(angles)[0]).max(initial=0.0))


def _with_folded_angles(pattern: Pattern, angles: Reals) -> Pattern:
    """Return a pattern with fold angles of its folded state, (n_hinges,), rad."""
    creases: dict[tuple[int, int], Crease] = {}
    for pair, crease in pattern.creases.items():
        if crease.face is not None:
            angle = float(angles[pattern.hinge_of(pair)])
            creases[pair] = Crease(crease.face, angle > 0.0, angle if angle > 0.0 else math.pi)
    return pattern.with_creases(creases)


class _PackingSearch:
    """The search for the packed state of one drawing.

    fault : why the last tried state is no packed state. stated : whether the file says which hinges close. free : the
    hinges that may be on either face.
    """

    def __init__(self, drawing: PatternDrawing, pattern: Pattern) -> None:
        self.pattern, self.linkage = pattern, Linkage(pattern)
        self.stated = states_angles(drawing)
        joints = [(pair, drawing.joins[pair]) for pair, crease in pattern.creases.items() if crease.face is not None]
        assigned = {pattern.hinge_of(pair) for pair, join in joints if join.assignment != "U" or join.face is not None}
        self.free = set(range(len(pattern.hinges))) - assigned
        self.kept_flat = {k for k, hinge in enumerate(pattern.hinges) if not hinge.closes}
        self.limit = SAME_DRAWN_POINT_SHARE * pattern.size
        self.fault = ""

    @work_step("searching for a packed state")
    def packed(self) -> Pattern | None:
        """Return the pattern in its packed state; None where none is found."""
        first_fault = ""
        for flat in self._flat_sets():
            found = self._packed_with(flat)
            if found is not None:
                return found
            first_fault = first_fault or self.fault
        self.fault = first_fault
        return None

    def _flat_sets(self) -> Iterator[set[int]]:
        """Yield the sets of hinges that may stay flat, small ones first; only the stated one where there is one."""
        yield self.kept_flat
        if self.stated or self.kept_flat:
            return
        looped = self.linkage.looped.tolist()
        sets = (set(some) for size in range(1, len(looped)) for some in combinations(looped, size))
        yield from islice(sets, min(MAX_FLAT_SETS, int(MAX_SET_PAIRS / len(self.pattern.panels) ** 2)))

    def _packed_with(self, flat: set[int]) -> Pattern | None:
        """Return the pattern packed with some hinges flat; None, with `fault`, where that is no state."""
        points = np.array([complex(*vertex) for vertex in self.pattern.vertices])
        closing = [k not in flat for k in range(len(self.pattern.hinges))]
        off = np.abs(self._openings(points, closing)).reshape(-1, 3).max(axis=1)
        limits = MAX_DRAWN_OPENING * np.array([len(loop) for loop in self.linkage.loops])
        if (off > limits).any():
            worst = int((off > limits).argmax())
            self.fault = f"with {self._hinge_words(flat)} {self._loop_words(worst)} does not close, seen from above"
            return None
        closed = self._closed(points, closing)
        if closed is None:
            self.fault = f"with {self._hinge_words(flat)} loops do not close, seen from above"
            return None
        pattern = replace(self.pattern, vertices=tuple((float(z.real), float(z.imag)) for z in closed))
        faces = self._faces(pattern, closing)
        if faces is None:
            self.fault = f"with {self._hinge_words(flat)} {self.fault}"
            return None
        creases: dict[tuple[int, int], Crease] = {}
        for pair, crease in pattern.creases.items():
            if crease.face is not None:
                hinge = pattern.hinge_of(pair)
                creases[pair] = Crease(faces[hinge], closing[hinge])
        return pattern.with_creases(creases)

    def _hinge_words(self, flat: set[int]) -> str:
        if not flat:
            return "all hinges closed"
        named = ", ".join(map(str, sorted(flat)[:MAX_NAMED])) + (" ..." if len(flat) > MAX_NAMED else "")
        return f"hinges {named} flat"

    def _loop_words(self, loop: int) -> str:
        """Name a loop by its panels."""
        panels = []
        for hinge, sign in self.linkage.loops[loop]:
            joint = self.pattern.hinges[hinge]
            panels.append(joint.first if sign > 0 else joint.second)
        named = ", ".join(map(str, panels[:MAX_NAMED])) + (" ..." if len(panels) > MAX_NAMED else "")
        return f"the loop of panels {named}"

    def _lines(self, points: Reals) -> list[tuple[complex, complex]]:
        """Return a point and the squared direction of each hinge's line, from vertices as complex numbers."""
        lines: list[tuple[complex, complex]] = [(0j, 1 + 0j)] * len(self.pattern.hinges)
        for pair, crease in self.pattern.creases.items():
            if crease.face is not None:
                start, end = (complex(points[v]) for v in self.pattern.edges[pair])
                along = (end - start) / abs(end - start)
                lines[self.pattern.hinge_of(pair)] = (start, along * along)
        return lines

    def _openings(self, points: Reals, closing: Sequence[bool]) -> Reals:
        """Return how far each loop is from closing, seen from above: turn (rad) and gap over size, (3 n_loops,)."""
        lines, openings = self._lines(points), []
        middle = points.mean()
        for loop in self.linkage.loops:
            motion = _REST
            for hinge, _ in loop:
                if closing[hinge]:
                    motion = _then_reflected(motion, lines[hinge], middle)
            turn, shift, reflects = motion
            # no loop closes with an odd number of closed hinges
            angle = math.pi if reflects else cmath.phase(turn)
            openings += [angle, shift.real / self.pattern.size, shift.imag / self.pattern.size]
        return np.array(openings)

    def _closed(self, points: Reals, closing: Sequence[bool]) -> Reals | None:
        """Return the vertices moved by least squares until all loops close, seen from above; None where they do not."""
        moved = points.copy()
        used = sorted(
            {v for pair, crease in self.pattern.creases.items() if crease.face for v in self.pattern.edges[pair]}
        )
        step = 1e-7 * self.pattern.size
        for _ in range(MAX_POINT_STEPS):
            openings = self._openings(moved, closing)
            if np.abs(openings).max(initial=0.0) <= CLOSED_PLACE_SHARE:
                return moved
            columns = []
            for v in used:
                for way in (step, 1j * step):
                    beside = moved.copy()
                    beside[v] += way
                    columns.append((self._openings(beside, closing) - openings) / step)
            change = np.linalg.lstsq(np.array(columns).T, -openings, rcond=1e-6)[0].reshape(-1, 2)
            moved[used] += change[:, 0] + 1j * change[:, 1]
            if np.abs(moved - points).max() > self.limit:
                return None
        return None

    def _faces(self, pattern: Pattern, closing: Sequence[bool]) -> list[PanelFace] | None:
        """Return the faces of all hinges with which panels lie in layers; None, and the fault, where there are none."""
        moved = max(map(math.dist, pattern.vertices, self.pattern.vertices))
        shared = max(SHADOW_OVERLAP_SHARE, MOVED_OVERLAP_FACTOR * moved / pattern.size)
        below = overlapping_panels(pattern, self._shadows(pattern, closing), shared)
        layers = LayerSearch(pattern, closing, self.free, below).found()
        if isinstance(layers, str):
            self.fault = layers
            return None
        return layers

    def _shadows(self, pattern: Pattern, closing: Sequence[bool]) -> list[Reals]:
        """Return the corners of each facet in the packed state, seen from above, as complex numbers over the size."""
        points = np.array([complex(*vertex) for vertex in pattern.vertices])
        lines, middle, tree = self._lines(points), points.mean(), hinge_tree(pattern, 0)
        motions: dict[int, PlaneMotion] = {}
        for panel in tree.order.tolist():
            parent, hinge = int(tree.parents[panel]), int(tree.hinges[panel])
            motion = motions.get(parent, _REST)
            motions[panel] = _then_reflected(motion, lines[hinge], middle) if parent >= 0 and closing[hinge] else motion
        shadows = []
        for facet, panel in zip(pattern.faces, pattern.panel_of, strict=True):
            turn, shift, reflects = motions[panel]
            corners = points[list(facet)] - middle
            shadows.append((turn * (corners.conj() if reflects else corners) + shift) / pattern.size)
        return shadows


def _then_reflected(motion: PlaneMotion, line: tuple[complex, complex], middle: complex) -> PlaneMotion:
    """Return a motion after the reflection in a line, about a middle point."""
    turn, shift, reflects = motion
    point, square = line[0] - middle, line[1]
    if reflects:
        point, square = point.conjugate(), square.conjugate()
    return turn * square, turn * (point - square * point.conjugate()) + shift, not reflects
