"""What the stages return: frozen batches, each a struct of arrays with one row a circuit or a folding."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import ByValue
from hcsearch.basics.vocabulary import Way

CircuitWords = NDArray[np.int8]
Integers = NDArray[np.integer[Any]]

NO_NUMBER = np.iinfo(np.int32).min
"""In a batch of integers: there is no such number."""


@dataclass(frozen=True, eq=False)
class CircuitBatch(ByValue):
    """Circuits in canonical order, one a row.

    words : shape (n_circuits, n_panels), direction of the step from panel k to panel k + 1 (see `Grid.directions`).
    symmetry : shape (n_circuits,), order of the symmetry group of each circuit.
    """

    grid: str
    words: CircuitWords
    symmetry: Integers

    def __len__(self) -> int:
        return len(self.words)

    def take(self, rows: NDArray[np.intp] | NDArray[np.bool_]) -> CircuitBatch:
        """The circuits of some rows, as a batch of their own."""
        return CircuitBatch(self.grid, self.words[rows], self.symmetry[rows])


@dataclass(frozen=True, eq=False)
class FoldingBatch(ByValue):
    """The two-stack foldings of a batch of circuits, ordered by circuit, then by crease.

    row : index of the circuit in its batch.
    crease : the first of the two flat creases, 0 <= crease < n_panels / 2; the other is crease + n_panels / 2.
    """

    row: Integers
    crease: Integers

    def __len__(self) -> int:
        return len(self.row)


@dataclass(frozen=True, eq=False)
class DesignBatch(ByValue):
    """What the store keeps of a batch: one row a design, and one row a folding where that stage has run.

    circuit, array : text notations (canonical, so equal for congruent circuits and arrays).
    array_symmetry, symmetry, n_fixed : group orders and the number of fixed copies.
    n_foldings : None where the stage `foldings` has not run.
    folding_row, folding_crease : as in `FoldingBatch`.
    folding_twist, n_untwisted, min_twist : None where the stage `twist` has not run; min_twist is -1 without a folding.
    mobility, best_crease : None where the stage `mobility` has not run. `mobility` has a row a folding; best_crease is
        that of the untwisted folding with the lowest dof, then crease, or -1.
    folding_status : locked, for each folding, None where that is not proved; status : the best of each design's
        foldings, None without an untwisted one. None where the stage `mobility` has not run.
    """

    grid: str
    n: int
    circuit: list[str]
    array: list[str]
    array_symmetry: Integers
    symmetry: Integers
    n_fixed: Integers
    n_foldings: Integers | None = None
    folding_row: Integers | None = None
    folding_crease: Integers | None = None
    folding_twist: Integers | None = None
    n_untwisted: Integers | None = None
    min_twist: Integers | None = None
    mobility: MobilityBatch | None = None
    best_crease: Integers | None = None
    folding_status: Sequence[str | None] | None = None
    status: Sequence[str | None] | None = None

    def __len__(self) -> int:
        return len(self.circuit)


@dataclass(frozen=True, eq=False)
class MobilityBatch(ByValue):
    """Degrees of freedom and locks of a batch of foldings, one entry each; NONE where there is no such number.

    kutzbach : of all of them. dof, locked : of untwisted ones. kutzbach_merged, dof_merged : of those that have panels
    to merge. locked, locked_hinged : whether one-sided hinges are proved to lock an end of the motion with rigid flat
    pairs, and whether they still do with hinged ones (empty where that was not asked). Merged foldings are locked where
    rigid ones are.
    """

    kutzbach: int
    dof: Integers
    dof_folded: Integers
    dof_flat: Integers
    merged_panels: Integers
    kutzbach_merged: Integers
    dof_merged: Integers
    locked: NDArray[np.bool_]
    locked_hinged: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool))

    def take(self, kept: NDArray[np.bool_]) -> MobilityBatch:
        """The entries of some foldings."""
        columns = {name: value[kept] for name, value in vars(self).items() if name != "kutzbach" and len(value)}
        return replace(self, **columns)


@dataclass(frozen=True)
class Trial:
    """A deployment of one folding of a batch in one scene: what it was, and what became of it.

    folding : index in the batch. scene : its name, which `hcsearch deploy --scene` takes. values : the scene and the
    folding as a TOML file, which `hcsearch deploy` takes, too. status : deploys, collides, undecided. reason : a
    sentence. clearance : smallest gap to which panels come near again after they have parted, m; a panel's size where
    none do. first_contact, deploy_time : s; None where there is none.
    energy_error : greatest relative error of the energy balance. closure_error : greatest gap of the closed loop, m.
    needed_margin, least_gap : m, of one that deploys, else None: the least margin at which it is certified clear, and
    the least gap of the panels as built. Where they overlap, `clearance` is that, too.
    as_crease : the crease of the congruent folding that was simulated in its place, or None.
    pairs : how flat pairs were joined. springs : the set of springs; empty for those of the scene.
    """

    folding: int
    scene: str
    values: str
    formulation: str
    status: str
    reason: str
    clearance: float | None
    first_contact: float | None
    deploy_time: float | None
    energy_error: float
    closure_error: float
    needed_margin: float | None = None
    least_gap: float | None = None
    as_crease: int | None = None
    pairs: Way = "rigid"
    springs: str = ""


@dataclass(frozen=True)
class StoredLock:
    """A proof that closed loops and stops keep a folding from coming from its packed to its flat state.

    way : how flat pairs are joined. decides : whether that is proved with it for every way that the scene allows.
    end : packed or flat, the end that no motion leaves. cubes, faces : of fold angles, by which it is proved.
    margin : m, of panels that do not pass through each other, up to which it holds; None where it does at every margin.
    """

    way: str
    decides: bool
    end: str
    cubes: int
    faces: int
    margin: float | None = None


@dataclass(frozen=True)
class Evidence:
    """What a search for a motion of a folding came to, beside its path.

    efforts : of `planning.schedule` that were made. lock : the widest that is proved. critical : the least play for
    each face at which a path is proved, beyond the scene's margin, too; unmet : the greatest below it at which the
    search met none, or of all that were tried; m, None where they were not looked for.
    """

    efforts: int
    lock: StoredLock | None = None
    critical: float | None = None
    unmet: float | None = None


@dataclass(frozen=True, eq=False)
class MotionBatch(ByValue):
    """Motions of a batch of foldings in a scene, one entry each.

    flat_pairs : how flat pairs are joined where a path is proved: rigid, hinged or merged; None without one.
    margin : the least play for each face at which it is proved, m; gap : the least gap of the panels as they are, m,
        below 0 where they overlap; slack : what panels may be elsewhere, m; NaN without a path. paths : states of
        that, or of one that is not proved, (k, n_hinges). reason : a sentence; None where a folding was not looked at.
    as_crease : the crease of the congruent folding whose motion this is; None of what was looked at itself, and empty
        where all of them were. evidence : what else the search came to; None where a folding was not looked at, and
        empty where none was.
    """

    flat_pairs: list[str | None]
    margin: NDArray[np.float64]
    gap: NDArray[np.float64]
    slack: NDArray[np.float64]
    paths: tuple[NDArray[np.float64] | None, ...]
    reason: list[str | None]
    as_crease: Sequence[int | None] = ()
    evidence: Sequence[Evidence | None] = ()

    @property
    def locked(self) -> NDArray[np.bool_]:
        """Which foldings are proved locked, kinematically, in every way of joining flat pairs that the scene allows."""
        if not self.evidence:
            return np.zeros(len(self.margin), bool)
        return np.array([own is not None and own.lock is not None and own.lock.decides for own in self.evidence], bool)

    @property
    def moves(self) -> NDArray[np.bool_]:
        """Which foldings have a proved path."""
        return ~np.isnan(self.margin)

    @property
    def met(self) -> NDArray[np.bool_]:
        """Which foldings have a path, proved or not."""
        return np.array([path is not None for path in self.paths], bool)


@dataclass(frozen=True, eq=False)
class DeploymentBatch(ByValue):
    """What springs do with a batch of foldings in a scene, one entry each, and the deployments that say so.

    clearance (m), time (s) : of those that deploy, in the first scene in which they do; NaN else, the time also where
        tolerances disagree on it.
    margin, gap : m, of the same: the least play for each face at which they are certified clear, and the least gap of
        the panels as built, below 0 where they overlap.
    """

    clearance: NDArray[np.float64]
    time: NDArray[np.float64]
    margin: NDArray[np.float64]
    gap: NDArray[np.float64]
    trials: tuple[Trial, ...]

    @property
    def deploys(self) -> NDArray[np.bool_]:
        """Which foldings come flat, certified clear, in some deployment."""
        return ~np.isnan(self.clearance)


def play_of_batch(
    motion: MotionBatch, deployment: DeploymentBatch | None
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Needed margins and least gaps of the motions that give foldings their status, m; NaN without one.

    Those of the deployment where springs bring a folding flat, else those of its path.
    """
    if deployment is None:
        return motion.margin, motion.gap
    springs = deployment.deploys
    return np.where(springs, deployment.margin, motion.margin), np.where(springs, deployment.gap, motion.gap)


@dataclass(frozen=True, eq=False)
class StagedDesigns(ByValue):
    """Designs of a shard of the search, with the columns of the stages that have run; None where one has not.

    n_fixed : (n_circuits,), circuits that each stands for: fixed ones, or those of the one array searched.
    twists : |Lk|, (n_foldings,); mobility, motion and deployment have a row a folding, too. budget : efforts of the
    search for motions of each folding, None for the usual ones; searched : (n_foldings,), how many of these were made
    before, None where none were.
    """

    circuits: CircuitBatch
    n_fixed: Integers
    foldings: FoldingBatch | None = None
    twists: NDArray[np.int16] | None = None
    mobility: MobilityBatch | None = None
    motion: MotionBatch | None = None
    deployment: DeploymentBatch | None = None
    budget: int | None = None
    searched: Integers | None = None

    def __len__(self) -> int:
        return len(self.circuits)

    @property
    def folded(self) -> FoldingBatch:
        """Its foldings; the stage `foldings` must have run."""
        assert self.foldings is not None
        return self.foldings

    def with_folding(self, chosen: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Which designs have a folding that is among some, shape (n_circuits,); chosen : (n_foldings,)."""
        marked = np.zeros(len(self), bool)
        marked[self.folded.row[chosen]] = True
        return marked

    def take(self, kept: NDArray[np.bool_], chosen: NDArray[np.bool_] | None = None) -> StagedDesigns:
        """Some designs, with their foldings or only those that are chosen; before a motion is looked for."""
        assert self.motion is None
        circuits, n_fixed = self.circuits.take(kept), self.n_fixed[kept]
        if self.foldings is None:
            return StagedDesigns(circuits, n_fixed, budget=self.budget)
        stay = kept[self.foldings.row] if chosen is None else kept[self.foldings.row] & chosen
        number = np.cumsum(kept, dtype=np.int32) - 1
        return StagedDesigns(
            circuits,
            n_fixed,
            FoldingBatch(number[self.foldings.row[stay]], self.foldings.crease[stay]),
            None if self.twists is None else self.twists[stay],
            None if self.mobility is None else self.mobility.take(stay),
            budget=self.budget,
            searched=None if self.searched is None else self.searched[stay],
        )


@dataclass(frozen=True, eq=False)
class VerdictBatch(ByValue):
    """What the store keeps of verdicts on designs in a scene.

    circuit : notations. best_crease, status : of the best folding of each design. folding_row, folding_crease,
        folding_status : of the foldings that were looked at. motion, deployment : a row a folding; deployment is None
        where that stage has not run.
    """

    circuit: list[str]
    best_crease: list[int]
    status: list[str]
    folding_row: Integers
    folding_crease: Integers
    folding_status: list[str]
    motion: MotionBatch
    deployment: DeploymentBatch | None


@dataclass(frozen=True)
class Undecided:
    """A stored folding that is undecided in a scene: its design, and the efforts of the search that were made."""

    design_id: int
    circuit: str
    crease: int
    efforts: int


@dataclass(frozen=True)
class WorkKey:
    """What identifies finished work, beside the search prefix, the stage and its version.

    target : the canonical array notation for a run on one array, '' for a run over all arrays of n cells.
    keep : 'all', 'two-stack' or 'untwisted'.
    scene : name of the scene that a verdict depends on, '' for stages that need none.
    """

    grid: str
    n: int
    target: str
    keep: str
    scene: str = ""


@dataclass(frozen=True)
class StageResult:
    """What one stage did to one batch.

    passed : designs that passed (circuits: all of them; foldings: two-stack ones; twist: untwisted ones).
    n_fixed : circuits that these are up to symmetry: fixed ones, or those of the one array searched.
    """

    stage: str
    version: int
    passed: int
    n_fixed: int
    seconds: float
