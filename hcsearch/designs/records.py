"""Results of the stages: frozen batches, each a struct of arrays with one row for each circuit or folding."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Generic, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import ByValue
from hcsearch.basics.simulation_summaries import TrialAccuracy
from hcsearch.basics.vocabulary import Way

CircuitWords = NDArray[np.int8]
Integers = NDArray[np.integer[Any]]

ResultT = TypeVar("ResultT")

NO_NUMBER = np.iinfo(np.int32).min
"""Missing number in a batch of integers."""


@dataclass(frozen=True, eq=False)
class CircuitBatch(ByValue):
    """Circuits in canonical order, one in each row.

    words : shape (n_circuits, n_panels), direction of the step from panel k to panel k + 1 (see `Grid.directions`).
    symmetry : shape (n_circuits,), order of the symmetry group of each circuit.
    """

    grid: str
    words: CircuitWords
    symmetry: Integers

    def __len__(self) -> int:
        return len(self.words)

    def take(self, rows: NDArray[np.intp] | NDArray[np.bool_]) -> CircuitBatch:
        """The batch of the circuits of some rows."""
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


Columns = Mapping[str, Any]
"""Columns of a table by name: arrays or lists with one entry a row, or one value for all rows."""


@dataclass(frozen=True, eq=False)
class DesignBatch(ByValue):
    """Rows of the store for a batch of designs; columns whose stage has not run are missing.

    designs : columns of the table `design`, among them `circuit`, a list. Notations are canonical, so equal for
        congruent circuits and arrays.
    foldings : columns of the table `folding`, and `row`, the index of the design in this batch. In either, `NO_NUMBER`
        stands for a missing number.
    """

    designs: Columns
    foldings: Columns = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.designs["circuit"])


@dataclass(frozen=True, eq=False)
class MobilityBatch(ByValue):
    """Degrees of freedom and locks of a batch of foldings, one entry each; `NO_NUMBER` where a number is missing.

    kutzbach : the same for all foldings. dof, locked : for untwisted foldings. kutzbach_merged, dof_merged : for
    foldings with panels to merge. locked, locked_hinged : whether one-sided hinges are proved to lock an end of the
    motion with rigid flat pairs, and whether they still do with hinged ones (empty where that was not tested). Merged
    foldings are locked where rigid ones are.
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
    """A deployment of one folding of a batch in one scene, and its result.

    folding : index in the batch. scene : its name, for `hcsearch deploy --scene`. values : the scene and the folding as
    a TOML file, which `hcsearch deploy` reads, too. status : deploys, collides, undecided. reason : a sentence.
    clearance : smallest gap at which panels approach each other again after they have parted, m; a panel's size where
    none do. first_contact, deploy_time : s; None where there is none.
    energy_error : greatest relative error of the energy balance. closure_error : greatest gap of the closed loop, m.
    method : the integrator. omitted : names of the omissions of the compiled scene. time_saved : the share of the work
    that these save, see `saved_share`.
    needed_margin, least_gap : m, None unless it deploys: the least margin at which it is certified clear, and
    the least gap of the panels as built. Where these overlap, `clearance` equals `least_gap`.
    error_angle, error_time : estimated errors of the fold angles (rad) and of `deploy_time` (s), if it deploys.
    as_crease : the crease of the congruent folding that was simulated in its place, or None.
    pairs : the joint of flat pairs. springs : the set of springs; empty for those of the scene.
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
    method: str
    omitted: tuple[str, ...]
    time_saved: float
    needed_margin: float | None = None
    least_gap: float | None = None
    error_angle: float | None = None
    error_time: float | None = None
    as_crease: int | None = None
    pairs: Way = "rigid"
    springs: str = ""


@dataclass(frozen=True)
class StoredLock:
    """A proof that closed loops and stops separate the packed and the flat state of a folding.

    way : the joint of flat pairs. decides : whether it implies the lock for every joint that the scene allows.
    end : packed or flat, the end that no motion leaves. cubes, faces : numbers of cubes of fold angles and of their
    faces in the proof. margin : the greatest margin (m) at which it holds for panels that do not pass through each
    other; None where it holds at every margin.
    """

    way: str
    decides: bool
    end: str
    cubes: int
    faces: int
    margin: float | None = None


@dataclass(frozen=True)
class Evidence:
    """Results of the search for a motion of a folding, apart from its path.

    efforts : number of efforts of `planning.schedule` that were made. lock : the widest proved lock. critical : the
    least play for each face at which a path is proved, also beyond the scene's margin; unmet : the greatest play below
    it, or of all that were tried, at which the search found no path; m, None where they were not searched.
    """

    efforts: int
    lock: StoredLock | None = None
    critical: float | None = None
    unmet: float | None = None


@dataclass(frozen=True, eq=False)
class MotionBatch(ByValue):
    """Motions of a batch of foldings in a scene, one entry each.

    flat_pairs : the joint of flat pairs where a path is proved: rigid, hinged or merged; None without one.
    margin : the least play for each face at which it is proved, m; gap : the least gap of the panels as built, m,
        negative where they overlap; slack : bound of the placement error of panels, m; NaN without a path. paths :
        states of that path, or of one that is not proved, (k, n_hinges). reason : a sentence; None where a folding was
        not searched.
    as_crease : the crease of the congruent folding that was searched instead; None where the folding itself was
        searched, and empty where all were. evidence : further results of the search; None where a folding was not
        searched, and empty where none was.
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
        """Flags of the foldings that are proved locked, kinematically, for every joint of flat pairs of the scene."""
        if not self.evidence:
            return np.zeros(len(self.margin), bool)
        return np.array(
            [found is not None and found.lock is not None and found.lock.decides for found in self.evidence], bool
        )

    @property
    def moves(self) -> NDArray[np.bool_]:
        """Flags of the foldings that have a proved path."""
        return ~np.isnan(self.margin)

    @property
    def met(self) -> NDArray[np.bool_]:
        """Flags of the foldings that have a path, proved or not."""
        return np.array([path is not None for path in self.paths], bool)


@dataclass(frozen=True, eq=False)
class DeploymentBatch(ByValue):
    """Results of deployments by springs of a batch of foldings in a scene, one entry each, and the deployments.

    clearance (m), time (s) : for foldings that deploy, in the first scene in which they do; else NaN. The time is NaN
        also where tolerances disagree on it.
    margin, gap : m, for the same foldings: the least play for each face at which they are certified clear, and the
        least gap of the panels as built, negative where they overlap.
    """

    clearance: NDArray[np.float64]
    time: NDArray[np.float64]
    margin: NDArray[np.float64]
    gap: NDArray[np.float64]
    trials: tuple[Trial, ...]

    @property
    def deploys(self) -> NDArray[np.bool_]:
        """Flags of the foldings that deploy flat, certified clear, in some deployment."""
        return ~np.isnan(self.clearance)


FlightValue = int | float | str | None
FlightNumbers = Mapping[str, FlightValue]
"""The figures of a folding in a scene by which an engineer of space mechanisms chooses, by the names of their columns.

Each is exact or a bound in the direction that docs/explanation/flight.md names and proves. SI units; None where one is
not known.
"""


def play_of_batch(
    motion: MotionBatch, deployment: DeploymentBatch | None
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Needed margins and least gaps of the motions that decide the status of foldings, m; NaN without one.

    These are the values of the deployment where springs unfold a folding, else of its path.
    """
    if deployment is None:
        return motion.margin, motion.gap
    springs = deployment.deploys
    return np.where(springs, deployment.margin, motion.margin), np.where(springs, deployment.gap, motion.gap)


class ResultNamed(Generic[ResultT]):
    """A named result of a stage on a batch of foldings; None where the stage has not run."""

    def __init__(self, name: str) -> None:
        self.name = name

    def __get__(self, batch: FoldingResults, _kind: type) -> ResultT | None:
        result: ResultT | None = batch.of_foldings.get(self.name)
        return result


@dataclass(frozen=True, eq=False)
class FoldingResults(ByValue):
    """Base class of dataclasses with results of stages on foldings.

    of_foldings : by name, with an entry for each folding: arrays, which are stored as the column of their name, and
        batches. twists : |Lk|. flight : None for foldings that are locked.
    """

    of_foldings: Columns = field(default_factory=dict, kw_only=True)

    twists = ResultNamed[NDArray[np.int16]]("twist")
    mobility = ResultNamed[MobilityBatch]("mobility")
    motion = ResultNamed[MotionBatch]("motion")
    deployment = ResultNamed[DeploymentBatch]("deployment")
    flight = ResultNamed[tuple[FlightNumbers | None, ...]]("flight")

    def with_folding_results(self, **results: Any) -> Self:
        """The same batch with further results, which have an entry for each folding."""
        return replace(self, of_foldings={**self.of_foldings, **results})


@dataclass(frozen=True, eq=False)
class StagedDesigns(FoldingResults):
    """Designs of a shard of the search, with the results of the stages that have run.

    n_fixed : (n_circuits,), number of circuits that each represents: fixed ones, or circuits of the one array searched.
    of_designs : results by name, arrays with an entry for each design. budget : efforts of the search for motions of
    each folding, None for the default; searched : (n_foldings,), number of efforts made before, None where none were.
    """

    circuits: CircuitBatch
    n_fixed: Integers
    foldings: FoldingBatch | None = None
    of_designs: Columns = field(default_factory=dict)
    budget: int | None = None
    searched: Integers | None = None

    def __len__(self) -> int:
        return len(self.circuits)

    @property
    def folded(self) -> FoldingBatch:
        """The foldings of the designs; the stage `foldings` must have run."""
        assert self.foldings is not None
        return self.foldings

    def with_folding(self, chosen: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Flags of the designs that have a chosen folding, shape (n_circuits,); chosen : (n_foldings,)."""
        marked = np.zeros(len(self), bool)
        marked[self.folded.row[chosen]] = True
        return marked

    def take(self, kept: NDArray[np.bool_], chosen: NDArray[np.bool_] | None = None) -> StagedDesigns:
        """Select designs, with all their foldings or only the chosen ones; before the stage of motions."""
        assert self.motion is None
        of_designs = {name: values[kept] for name, values in self.of_designs.items()}
        taken = replace(self, circuits=self.circuits.take(kept), n_fixed=self.n_fixed[kept], of_designs=of_designs)
        if self.foldings is None:
            return taken
        stay = kept[self.foldings.row] if chosen is None else kept[self.foldings.row] & chosen
        number = np.cumsum(kept, dtype=np.int32) - 1
        return replace(
            taken,
            foldings=FoldingBatch(number[self.foldings.row[stay]], self.foldings.crease[stay]),
            of_foldings={
                name: result[stay] if isinstance(result, np.ndarray) else result.take(stay)
                for name, result in self.of_foldings.items()
            },
            searched=None if self.searched is None else self.searched[stay],
        )


@dataclass(frozen=True, eq=False)
class VerdictBatch(FoldingResults):
    """Columns of the store for verdicts on designs in a scene.

    circuit : notations. best_crease, status : of the best folding of each design. folding_row, folding_crease,
        folding_status : of the foldings that were examined.
    """

    circuit: list[str]
    best_crease: list[int]
    status: list[str]
    folding_row: Integers
    folding_crease: Integers
    folding_status: list[str]

    def undecided_reasons(self) -> dict[int, str]:
        """Return the reason of the first undecided simulation of each folding that no springs deploy, by folding."""
        trials = () if self.deployment is None else self.deployment.trials
        undecided = [
            trial for trial in trials if trial.status == "undecided" and self.folding_status[trial.folding] != "deploys"
        ]
        return {trial.folding: trial.reason for trial in reversed(undecided)}

    def accuracies(self) -> list[TrialAccuracy]:
        """Return the accuracy of each deployment that was simulated, congruent foldings left out."""
        trials = () if self.deployment is None else self.deployment.trials
        return [
            TrialAccuracy(trial.time_saved, trial.status, trial.deploy_time, trial.error_time)
            for trial in trials
            if trial.as_crease is None
        ]


@dataclass(frozen=True)
class Undecided:
    """A stored folding that is undecided in a scene: its design, and the number of efforts of the search so far."""

    design_id: int
    circuit: str
    crease: int
    efforts: int


@dataclass(frozen=True)
class WorkKey:
    """Key of finished work, beside the search prefix, the stage and its version.

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
    """Counts of one stage for one batch.

    passed : number of designs that passed (circuits: all of them; foldings: two-stack ones; twist: untwisted ones).
    n_fixed : number of circuits that these represent: fixed ones, or circuits of the one array searched.
    """

    stage: str
    version: int
    passed: int
    n_fixed: int
    seconds: float
