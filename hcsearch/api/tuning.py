"""Choose the springs of a deployment."""

from __future__ import annotations

import json
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from typing import Any

from hcsearch.api.kinds import check_kinds
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import Formulation, Way
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding
from hcsearch.scenes import Scene
from hcsearch.scenes.scene_file import scene_file_text
from hcsearch.scenes.setup import scene_of_setup
from hcsearch.shape.labels import labels_of
from hcsearch.springs.flight.rules import read_rules
from hcsearch.springs.flight.spring_choice import ChosenSprings, springs_that_pass
from hcsearch.springs.tuning.evaluation import DatabaseMemory
from hcsearch.springs.tuning.spring_search import catalogue_levels
from hcsearch.springs.tuning.spring_tuning import Tuning, tune_springs
from hcsearch.springs.tuning.tuning_options import Spread, TuningOptions, damper_bounds
from hcsearch.subjects.case import Case, CaseSubject
from hcsearch.subjects.names import Place, writing_database
from hcsearch.subjects.resolve import resolve
from hcsearch.system.terminal import write_notice
from hcsearch.system.work_steps import Progress


def tune(
    what: CaseSubject | Case,
    scene: Scene | str | None = None,
    *,
    formulation: Formulation | None = None,
    catalogue: Sequence[float] = (),
    evaluations: int = TuningOptions.evaluations,
    samples: int = TuningOptions.samples,
    spread: Spread | None = None,
    seed: int = TuningOptions.seed,
    panel: str | None = None,
    flat_pairs: Way | None = None,
    db: Place | None = None,
    most_damping: float = TuningOptions.most_damping,
    damper_range: Sequence[float] | None = None,
    damper_catalogue: Sequence[float] = (),
    keep_in: Place | None = None,
    progress: Progress | None = None,
    **values: Any,
) -> Tuning:
    """Choose the stiffness of each hinge so that the array becomes flat without a collision, as `hcsearch tune` does.

    Parameters
    ----------
    what, scene, panel, flat_pairs, db, **values
        As in `deploy`.
    formulation
        `constrained` or `compliant`; by default `compliant` only if no array becomes flat in `constrained`.
    catalogue
        Stiffnesses of springs that can be bought, N m/rad; each hinge gets none, one or two of them.
    evaluations
        Greatest number of spring sets tried.
    samples
        Number of simulations within the tolerances for each candidate set.
    spread
        The tolerances, a `hcsearch.springs.tuning.tuning_options.Spread`.
    seed
        The seed of the random numbers; equal arguments give equal springs.
    most_damping
        The greatest multiple of the scene's damping that is tried with its springs before other springs are searched, 1
        to 10; 1 tries none.
    damper_range
        The least and the greatest damping of a hinge, N m s/rad, to search dampers together with springs; without it
        dampers follow from springs and the scene.
    damper_catalogue
        The damping that a hinge has with each damper that can be bought, N m s/rad, besides a catalogue of springs;
        each hinge gets none or one.
    keep_in
        A database that keeps every evaluation, so that the same call continues an interrupted search.
    progress
        Called with the numbers of evaluations that are done and of all, and a note.

    Returns
    -------
    Tuning
        The springs to use, with their simulation.

    Examples
    --------
    >>> from hcsearch import tune
    >>> tuning = tune("hex:0233340501:3", evaluations=8, samples=0)
    >>> list(tuning.springs)
    ['0', '1', '2', '4', '5', '6', '7', '9']
    """
    check_kinds(tune, locals())
    options = TuningOptions(
        tuple(map(float, catalogue)),
        evaluations,
        samples,
        spread or Spread(),
        seed,
        most_damping,
        None if damper_range is None else damper_bounds(damper_range),
        tuple(map(float, damper_catalogue)),
    )
    case = resolve(what, db, scene=scene, panel=panel, flat_pairs=flat_pairs, values=values)
    write_notice(case.sentence)
    if case.drive is not None:
        raise HcsearchError(
            f"{case.title} has drives, but hcsearch tune chooses springs alone: leave out its table [drive]"
        )
    if options.catalogue:  # before a database is created
        softest, stiffest = case.setup.spring_range
        catalogue_levels(options.catalogue, stiffest, softest)
    with nullcontext() if keep_in is None else writing_database(keep_in, create=True) as database:
        return tune_springs(
            case.linkage,
            case.setup,
            options,
            formulation or case.formulation,
            memory=None if database is None else DatabaseMemory(database, json.dumps(case.key, sort_keys=True)),
            progress=progress,
        )


@dataclass(frozen=True)
class RuledSprings:
    """Springs that pass the motorisation of a standard.

    title : the folding. source : what moves it. file_text : a file with the folding and these springs, for `deploy`.
    """

    title: str
    source: str
    springs: ChosenSprings
    file_text: str

    def __repr__(self) -> str:
        return f"<{self.title}: torque margin {self.springs.margin:.4g}, required {self.springs.required:g}>"


def tune_to_rules(
    what: str | Folding | Circuit | Case,
    scene: Scene | str | None = None,
    *,
    rules: str = "ecss",
    measured: bool = False,
    offers: Sequence[str] = (),
    panel: str | None = None,
    flat_pairs: Way | None = None,
    db: Place | None = None,
    **values: Any,
) -> RuledSprings:
    """Choose springs with which a folding passes the motorisation of a standard, as `hcsearch tune --rule` does.

    Parameters
    ----------
    what, scene, rules, measured, panel, flat_pairs, db, **values
        As in `sheet`.
    offers
        Laws of springs that can be bought, of which each hinge gets one or none; without them the springs of the scene
        get the least preloads.

    Returns
    -------
    RuledSprings
        The springs, and the torque margin that they reach.

    Raises
    ------
    HcsearchError
        Where no such springs were found, and where nothing resists.
    """
    check_kinds(tune_to_rules, locals())
    standard = read_rules(rules)
    case = resolve(what, db, scene=scene, panel=panel, flat_pairs=flat_pairs, values=values, path=True)
    moved = case.travel()
    chosen = springs_that_pass(moved.travel, standard, measured=measured, offers=tuple(offers))
    scene = scene_of_setup(chosen.setup, moved.scene, labels_of(chosen.linkage))
    return RuledSprings(
        case.title, source=moved.source, springs=chosen, file_text=scene_file_text(case.entries, None, scene)
    )


def tuned_file_text(case: Case, tuning: Tuning) -> str:
    """Return the text of a file with a case and its tuned springs, for `deploy`, below a note on what to buy."""
    setup = tuning.chosen.setup_in(tuning.setup)
    scene = scene_of_setup(setup, case.joined_scene, tuning.labels)
    bought = "" if tuning.springs_to_buy is None else f"# buy: {tuning.purchase}\n"
    return bought + scene_file_text(case.entries, tuning.formulation, scene)
