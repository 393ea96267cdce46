"""Two-stack foldings: pairs of opposite creases that can stay flat while all other creases fold (thesis 3.2.1)."""

from __future__ import annotations

import re
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from numbers import Integral
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.errors import (
    HcsearchError,
    HcsearchWarning,
    NotationError,
    PatternError,
    expect_kind,
    wrong_kind_message,
)
from hcsearch.basics.vocabulary import WAYS, Way
from hcsearch.designs.circuit import Circuit, Renumbering
from hcsearch.designs.grid import grid_named
from hcsearch.designs.grid.turning import directed_words
from hcsearch.designs.panel_sizes import PanelSize, default_panel, panel_size_doubt, read_panel
from hcsearch.designs.records import CircuitBatch, FoldingBatch
from hcsearch.kernels.circuits.folds import fold_words
from hcsearch.shape.drawing import draw_circuit
from hcsearch.shape.pattern import RIGID_CREASE, Crease, FacetPair, Pattern
from hcsearch.system.notebooks import notebook_view

if TYPE_CHECKING:
    from hcsearch.shape.linkage import Linkage

Assignment = Literal["mountain", "valley", "flat"]
CreaseFace = Literal["top", "bottom"]


def fold(circuits: CircuitBatch) -> FoldingBatch:
    """All two-stack foldings of a batch of circuits; none where the number of panels is odd.

    Source: thesis section 3.2.1, where drawn edges are reflected; that is equivalent to sums of turns with alternating
    signs (docs/explanation/theory.md, 4).
    """
    n_circuits, n = circuits.words.shape
    if n % 2:
        return FoldingBatch(np.empty(0, np.int32), np.empty(0, np.int16))
    rows = np.empty(n_circuits * (n // 2), np.int32)
    creases = np.empty(len(rows), np.int16)
    grid = grid_named(circuits.grid)
    count = fold_words(directed_words(grid, circuits.words), grid.directions, rows, creases)
    return FoldingBatch(rows[:count].copy(), creases[:count].copy())


def divisible(circuits: CircuitBatch) -> NDArray[np.bool_]:
    """Whether the number m of directions divides T, the sum of turns with alternating signs, for each circuit.

    This is necessary to fold (docs/explanation/theory.md, 4), and fails on hexagons only. The number of panels is even.
    """
    grid = grid_named(circuits.grid)
    m, words = grid.directions, directed_words(grid, circuits.words)
    # each step contributes to two turns, with the same sign: T = 2 (d_0 - d_1 + d_2 - ..), mod m
    steps = words[:, ::2].sum(axis=1, dtype=np.int32) - words[:, 1::2].sum(axis=1, dtype=np.int32)
    divides: NDArray[np.bool_] = steps % (m // 2) == 0
    return divides


@dataclass(frozen=True)
class CongruentFolding:
    """A folding that is congruent to another one, and the congruence.

    panels : the corresponding panel for each panel of the other folding. turn : (3, 3), the matrix that maps directions
    in space from the other folding's sheet to this one's.
    """

    folding: Folding
    panels: tuple[int, ...]
    turn: tuple[tuple[float, float, float], ...]


@dataclass(frozen=True, repr=False)
class Folding:
    """A two-stack folding of a circuit: crease `crease` stays flat in the lowest layer, `opposite` in the highest.

    The top face of the sheet is the one seen from above in the flat state. The two lowest panels keep their top face up
    when the others fold.

    Parameters
    ----------
    circuit
        The circuit that folds.
    crease
        The flat crease in the lowest layer; `opposite` is the other one.
    """

    circuit: Circuit
    crease: int

    def __post_init__(self) -> None:
        expect_kind("the circuit of a folding", self.circuit, Circuit, "a Circuit, or use Folding.from_notation")
        expect_kind("the crease of a folding", self.crease, Integral, "the number of its lower flat crease")
        if not _folds_at(self.circuit, self.crease):
            raise _no_folding(self.circuit, self.crease)

    @staticmethod
    def from_notation(text: str) -> Folding:
        """Read the notation that `notation` writes, such as `hex:0234550132:4`.

        The circuit may be in any position, order or direction; the crease, or its opposite, is numbered in its
        canonical order.

        Raises
        ------
        NotationError
            For a text that is no folding.
        SizeError
            For more panels than an array has cells.
        """
        expect_kind("the notation of a folding", text, str, "a text, such as 'hex:0234550132:4'")
        design, crease = split_crease(text)
        if crease is None:
            raise NotationError(f"{text!r} names no crease: write a circuit notation and a crease, as hex:0234550132:4")
        return folding_of(Circuit.from_notation(design).canonical(), crease)

    @property
    def opposite(self) -> int:
        """The other flat crease, half a circuit after the first."""
        return self.crease + self.circuit.n // 2

    @property
    def notation(self) -> str:
        """The circuit's notation, a colon and the crease, numbered as in the canonical circuit."""
        return f"{self.circuit.notation}:{self.circuit.canonical_crease(self.crease) % (self.circuit.n // 2)}"

    def __str__(self) -> str:
        return self.notation

    def __repr__(self) -> str:
        if self.circuit == self.circuit.canonical() and self.circuit.start is None:
            return f"Folding.from_notation({self.notation!r})"
        return f"Folding({self.circuit!r}, {self.crease})"

    def _repr_html_(self) -> str | None:
        return notebook_view(self)

    def _repr_svg_(self) -> str:
        circuit = self.circuit
        return draw_circuit(circuit.grid, circuit.cells, self.assignment, numbers=True, title=self.notation)

    @cached_property
    def stacks(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """The panels of both stacks, from the lowest layer to the highest; the first stack begins after `crease`."""
        n, j = self.circuit.n, self.crease
        layers = range(n // 2)
        return tuple((j + 1 + t) % n for t in layers), tuple((j - t) % n for t in layers)

    @cached_property
    def layers(self) -> tuple[int, ...]:
        """The layer of each panel in its stack, counted from 0 at the bottom."""
        layer = [0] * self.circuit.n
        for stack in self.stacks:
            for t, panel in enumerate(stack):
                layer[panel] = t
        return tuple(layer)

    @cached_property
    def frames(self) -> tuple[tuple[int, int], ...]:
        """The orientation of each panel in the stacks, (sign, offset): its direction i points to sign * i + offset."""
        directions, n, m = self.circuit.directions, self.circuit.n, self.circuit.grid.directions
        frames = [(1, 0)] * n
        for stack, crease_after in ((self.stacks[0], 0), (self.stacks[1], -1)):
            for below, panel in pairwise(stack):
                d = directions[(below + crease_after) % n]
                sign, offset = frames[below]
                # reflect the panel's direction i in the crease first (2 d + m/2 - i), then fold as the panel below
                frames[panel] = -sign, (sign * (2 * d + m // 2) + offset) % m
        return tuple(frames)

    @cached_property
    def assignment(self) -> tuple[Assignment, ...]:
        """`mountain`, `valley` or `flat` for each crease.

        The lowest panels have their top face up, so the crease to the next layer closes top on top: a valley; from
        there on mountains and valleys alternate.
        """
        return tuple(
            "flat" if crease % (self.circuit.n // 2) == self.crease else "mountain" if face == "bottom" else "valley"
            for crease, face in enumerate(self.hinge_faces)
        )

    @cached_property
    def hinge_faces(self) -> tuple[CreaseFace, ...]:
        """The face, `top` or `bottom`, on which each hinge lies; on this face its panels meet when it closes.

        A flat crease does not fold; its entry is the face that continues the alternation, for an optional hinge.
        """
        n = self.circuit.n
        faces: list[CreaseFace] = ["top"] * n
        for t in range(-1, n // 2):
            face: CreaseFace = "bottom" if t % 2 else "top"
            faces[(self.crease + 1 + t) % n] = faces[(self.crease - 1 - t) % n] = face
        return tuple(faces)

    @cached_property
    def mirror_pairs(self) -> tuple[tuple[int, int], ...]:
        """Pairs of panels that share an edge on the mirror axis through both flat creases, if the circuit has one.

        They share it flat and folded, so that a pair can be merged into one panel (thesis 3.2.1 and 4.1.1). Empty where
        there is no such axis. The panels of the lowest layer come first. The compiled form, which only counts pairs,
        is in `kernels.linkage.lines`; tests compare the two.
        """
        directions, grid, m = self.circuit.directions, self.circuit.grid, self.circuit.grid.directions
        across = directions[self.crease]
        inwards = (across + m // 2) % m  # from the first stack to the second
        # the mirror takes direction d to 2 across + m/2 - d, and turns the walk around
        if any((directions[a] + directions[b - 1] - 2 * across) % m for a, b in zip(*self.stacks, strict=True)):
            return ()
        points = self.circuit.points
        pairs = []
        for a, b in zip(*self.stacks, strict=True):
            turn, offset = self.frames[a]
            inside = any(
                to == points[b] and grid.step_directions[step] == inwards for step, to in grid.neighbours(points[a])
            )
            if inside and (turn * inwards + offset - inwards) % m == 0:
                pairs.append((b, a))
        return tuple(pairs)

    def likeness(self, size: PanelSize) -> CongruentFolding | None:
        """The representative of all congruent foldings, with panels of a size (m); None if it is this one.

        It is a folding of the canonical circuit, whose symmetries map foldings onto each other: the one with the lowest
        crease. Either flat crease may be the lower one, as a symmetry may turn the stacks upside down.
        """
        circuit = self.circuit
        if size[0] != size[1] and circuit.grid.name == "square":  # the panels have the symmetries of rectangles only
            circuit = Circuit(grid_named("rectangle"), circuit.word)
        return _likeness(circuit, self.crease)

    def can_join(self, flat_pairs: Way) -> bool:
        """Whether the flat pairs can be joined in a given way: merged panels need mirror pairs."""
        return flat_pairs != "merged" or bool(self.mirror_pairs)

    def pattern(self, size: PanelSize, *, flat_pairs: Way = "rigid") -> Pattern:
        """The flat pattern of thick panels that folds in this way; facets are the panels in the order of the circuit.

        Parameters
        ----------
        size
            Length, width and thickness of a panel in metres; the side, twice, where cells are no rectangles.
        flat_pairs
            The joint of the panels at the two flat creases: `rigid`, `hinged` on the faces that continue the
            alternation, or `merged`, where all panels that meet on a mirror axis through the flat creases are one.
        """
        circuit, n = self.circuit, self.circuit.n
        length, width, thickness = size
        if length != width and not circuit.grid.is_rectangular:
            raise PatternError(f"panels of the {circuit.grid.name} grid have one size: give the same length and width")
        corners, faces = circuit.grid.mesh(circuit.cells)
        vertices = tuple((length * x, width * y) for x, y in corners)
        creases: dict[FacetPair, Crease] = {}
        for k, face in enumerate(self.hinge_faces):
            flat = k % (n // 2) == self.crease
            pair = (min(k, (k + 1) % n), max(k, (k + 1) % n))
            creases[pair] = Crease(face, closes=not flat) if flat_pairs == "hinged" or not flat else RIGID_CREASE
        if flat_pairs == "merged":
            creases |= {(min(pair), max(pair)): RIGID_CREASE for pair in self.mirror_pairs}
        return Pattern(vertices, tuple(faces), creases, thickness, of_circuit=True)

    def linkage(self, panel: PanelSize | str | None = None, *, flat_pairs: Way = "rigid") -> Linkage:
        """The folding as a linkage of thick panels, which stands on its lowest flat pair.

        Parameters
        ----------
        panel
            Length, width and thickness in metres, or a text in millimetres such as `50x6`; by default the panels of the
            scene `default`.
        flat_pairs
            The joint of each pair of panels at a flat crease: one `rigid` panel, `hinged`, or `merged`, where the two
            panels of each mirror pair are one panel, too.

        Examples
        --------
        >>> folding = Folding.from_notation("hex:0234550132:4")
        >>> folding.linkage().n_hinges, folding.linkage(flat_pairs="hinged").n_hinges
        (8, 10)
        """
        if flat_pairs not in WAYS:
            raise HcsearchError(wrong_kind_message("flat_pairs", flat_pairs, "'rigid', 'hinged' or 'merged'"))
        if isinstance(panel, str):
            panel = read_panel(panel, self.circuit.grid.name)
            if (doubt := panel_size_doubt(panel, self.circuit.grid.name)) is not None:
                warnings.warn(doubt, HcsearchWarning, stacklevel=2)
        if panel is not None and not (isinstance(panel, tuple) and len(panel) == 3):
            raise HcsearchError(
                wrong_kind_message("panel", panel, "a text in millimetres, such as '50x6', or three lengths in m")
            )
        return _linkage(self, panel, flat_pairs)


def foldings(circuit: Circuit) -> list[Folding]:
    """The two-stack foldings of a circuit, in the order of their creases; an empty list if it does not fold.

    Creases are numbered in the order of the given circuit.

    Parameters
    ----------
    circuit
        The circuit, which need not be canonical.

    Returns
    -------
    list of Folding
        The foldings, by crease.

    Examples
    --------
    >>> from hcsearch import Circuit, foldings
    >>> foldings(Circuit.from_notation("hex:0234550132"))
    [Folding.from_notation('hex:0234550132:3'), Folding.from_notation('hex:0234550132:4')]
    """
    expect_kind("the circuit to fold", circuit, Circuit, "a Circuit, such as Circuit.from_notation('hex:0234550132')")
    return [Folding(circuit, crease) for crease in range(circuit.n // 2) if _folds_at(circuit, crease)]


def folding_at(circuits: CircuitBatch, foldings: FoldingBatch, i: int) -> Folding:
    """The folding in row i of a batch."""
    word = tuple(circuits.words[foldings.row[i]].tolist())
    return Folding(Circuit(grid_named(circuits.grid), word), int(foldings.crease[i]))


def representatives(foldings: Sequence[Folding], rows: Sequence[int], size: PanelSize) -> list[int]:
    """The index of each folding's representative in the list, with panels of a size (m); its own index without one.

    rows : row of the circuit of each folding, equal for foldings of one circuit.
    """
    index = {(row, folding.crease): i for i, (row, folding) in enumerate(zip(rows, foldings, strict=True))}
    indices = []
    for i, (row, folding) in enumerate(zip(rows, foldings, strict=True)):
        congruent = folding.likeness(size)
        crease = (
            None
            if congruent is None or congruent.folding.circuit.word != folding.circuit.word
            else congruent.folding.crease
        )
        indices.append(i if crease is None else index.get((row, crease), i))
    return indices


def folding_of(circuit: Circuit, crease: int) -> Folding:
    """The folding with a given flat crease, or its opposite; NotationError when the circuit does not fold there."""
    expect_kind("the crease of a folding", crease, Integral, "the number of one of its flat creases")
    half = circuit.n // 2
    lower = crease - half if half <= crease < circuit.n and circuit.n % 2 == 0 else crease
    if not _folds_at(circuit, lower):
        raise _no_folding(circuit, crease)  # the message names the given crease
    return Folding(circuit, lower)


def no_folding_reason(n: int) -> str:
    """The reason, in words, why a circuit of n panels does not fold into two stacks."""
    if n % 2:
        return f"an odd number of panels, {n}, makes no two equal stacks"
    return "no two opposite creases can stay flat while all others fold"


def _no_folding(circuit: Circuit, crease: int) -> NotationError:
    """The error for a crease that is flat in no folding."""
    creases = ", ".join(str(folding.crease) for folding in foldings(circuit))
    reason = f", as {no_folding_reason(circuit.n)}" if circuit.n % 2 else ""
    others = f": its creases are {creases}" if creases else f" or any other{reason}: choose a circuit that folds"
    return NotationError(f"{circuit.notation} has no two-stack folding at crease {crease}{others}")


def split_crease(text: str) -> tuple[str, int | None]:
    """Split DESIGN[:CREASE] into a design, given by its notation or id, and a crease or None; NotationError else."""
    parts = text.split(":")
    notation = not parts[0].isdigit()
    form = "[^:]*(:[b-l]?[0-9]+(:[0-9]+)?)?" if notation else "[0-9]+(:[0-9]+)?"
    if not re.fullmatch(form, text, re.ASCII):
        raise NotationError(f"malformed design {text!r}: write an id or a circuit notation, then :CREASE if wanted")
    # nine digits suffice: longer numbers exceed every crease, and Python reads no more than 4300 digits
    crease = int(parts[1 + notation].lstrip("0")[:9] or "0") if len(parts) > 1 + notation else None
    return ":".join(parts[: 1 + notation]), crease


@lru_cache(maxsize=16)
def _linkage(folding: Folding, panel: PanelSize | None, flat_pairs: Way) -> Linkage:
    """As `Folding.linkage`, cached for repeated analyses of one folding."""
    from hcsearch.shape.linkage import CongruentLinkage, Linkage  # noqa: PLC0415 - loads kernels that listing and showing do without

    size = panel or default_panel(folding.circuit.grid.name)
    pattern = folding.pattern(size, flat_pairs=flat_pairs)
    arguments = ["" if panel is None else repr(panel), "" if flat_pairs == "rigid" else f"flat_pairs={flat_pairs!r}"]
    argument_list = ", ".join(word for word in arguments if word)
    congruent, lowest, twin = folding.likeness(size), folding.crease, None
    if congruent is not None:
        # one panel of a hinged pair is the base: the one that corresponds to the base of the congruent folding
        lowest = congruent.panels.index(congruent.folding.crease)
        congruent_linkage = congruent.folding.linkage(size, flat_pairs=flat_pairs)
        twin = CongruentLinkage.of(pattern, congruent_linkage, congruent.panels, np.array(congruent.turn))
    return Linkage(pattern, pattern.panel_of[lowest], f"{folding!r}.linkage({argument_list})", twin)


@lru_cache(maxsize=1024)
def _likeness(circuit: Circuit, crease: int) -> CongruentFolding | None:
    """As `Folding.likeness`, for panels with all symmetries of the circuit's grid."""
    canonical, half = circuit.canonical(), circuit.n // 2
    renumberings = circuit.renumberings()
    # prefer a renumbering that keeps the lower crease below
    renumbering = min(renumberings, key=lambda renumbering: (renumbering(crease) % half, renumbering(crease)))
    lowest, upside_down = renumbering(crease) % half, renumbering(crease) >= half
    if circuit.word == canonical.word and lowest == crease:
        return None
    # turned upside down, mountains become valleys where the number of layers is odd
    upright = -1.0 if upside_down and half % 2 else 1.0
    (a, b), (c, d) = _direction_map(circuit, canonical, renumbering)
    turn = ((a, b, 0.0), (c, d, 0.0), (0.0, 0.0, upright))
    return CongruentFolding(Folding(canonical, lowest), tuple(map(renumbering.panel, range(circuit.n))), turn)


def _direction_map(circuit: Circuit, canonical: Circuit, renumbering: Renumbering) -> NDArray[np.float64]:
    """The matrix, shape (2, 2), that maps directions of a circuit's drawing to the canonical circuit's drawing."""
    grid = circuit.grid
    word = [grid.backwards[step] for step in circuit.word] if renumbering.backwards else circuit.word
    isometry = next(
        candidate
        for candidate in grid.point_group
        if all(candidate.steps[step] == canonical.word[renumbering(k)] for k, step in enumerate(word))
    )
    basis = np.array([grid.position((1, 0)), grid.position((0, 1))]).T
    turned: NDArray[np.float64] = basis @ np.reshape(isometry.matrix, (2, 2)) @ np.linalg.inv(basis)
    return turned.round(15)  # zeros and ones are exact


def _folds_at(circuit: Circuit, crease: int) -> bool:
    """Whether a crease and its opposite are flat in a folding, by alternating sums of turns (theory.md, 4)."""
    n, m = circuit.n, circuit.grid.directions
    half = n // 2
    if n % 2 or not 0 <= crease < half:
        return False
    directions = circuit.directions
    signed = [(-1) ** k * (directions[k] - directions[k - 1]) for k in range(n)]
    return bool(sum(signed) % m == 0 and (sum(signed[crease + 1 : crease + half + 1]) - m // 2 * half) % m == 0)
