"""Choose springs."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from hcsearch.api.asking import Named, Setting
from hcsearch.api.kinds import check_kinds
from hcsearch.api.places import Place, located, writing
from hcsearch.errors import HcsearchError
from hcsearch.scenes import FlatPairs, Scene
from hcsearch.store import Database
from hcsearch.subjects.reading import Subject
from hcsearch.tuning.ledger import Ledger
from hcsearch.tuning.robustness import Spread
from hcsearch.tuning.search import Progress
from hcsearch.tuning.tuning import EVALUATIONS, SAMPLES, Tuning
from hcsearch.tuning.tuning import tune as tuned
from hcsearch.vocabulary import Formulation


def tune(
    what: Named,
    scene: Scene | str | None = None,
    *,
    formulation: Formulation | None = None,
    catalogue: Sequence[float] = (),
    evaluations: int = EVALUATIONS,
    samples: int = SAMPLES,
    spread: Spread | None = None,
    seed: int = 0,
    panel: str | None = None,
    across: str | None = None,
    flat_pairs: FlatPairs | None = None,
    merge: bool = False,
    db: str | Path | None = None,
    keep_in: Place | None = None,
    progress: Progress | None = None,
    **values: Any,
) -> Tuning:
    """Choose the stiffness of each hinge so that the array becomes flat without a collision, as `hcsearch tune` does.

    what, scene, panel, across, flat_pairs, merge, db, values : as in `deploy`.
    formulation : `constrained` or `compliant`; by default `compliant` only if no array becomes flat in `constrained`.
    catalogue : stiffnesses of springs that can be bought, N m/rad; each hinge gets none, one or two of them.
    evaluations : how many sets of springs are tried at most. samples : how many simulations within the tolerances are
    run for each set that may be chosen. spread : the tolerances, a `hcsearch.tuning.robustness.Spread`.
    seed : of the random numbers; equal arguments give equal springs.
    keep_in : a database that keeps every evaluation, so that the same call continues an interrupted search.
    progress : called with the numbers of evaluations that are done and of all, and a note.

    >>> from hcsearch import tune
    >>> tuning = tune("hex:0233340501:3", evaluations=8, samples=0)
    >>> list(tuning.springs)
    ['0', '1', '2', '4', '5', '6', '7', '9']
    """
    check_kinds(tune, locals())
    check_counts(evaluations, samples, seed)
    subject = Setting(scene, located(db), panel, across, flat_pairs, merge, values).subject(what)
    options = {"catalogue": catalogue, "evaluations": evaluations, "samples": samples, "spread": spread, "seed": seed}
    if keep_in is None:
        return tune_subject(subject, formulation, None, progress=progress, **options)
    with writing(keep_in, create=True) as database:
        return tune_subject(subject, formulation, database, progress=progress, **options)


def tune_subject(
    subject: Subject, formulation: Formulation | None, database: Database | None, **options: Any
) -> Tuning:
    """Tune a subject in the formulation that is given, or that its file names; database : keeps the evaluations."""
    refuse_drives(subject)
    memory = None if database is None else Ledger(database, json.dumps(subject.key, sort_keys=True))
    return tuned(subject.linkage, subject.scene, formulation or subject.formulation, memory=memory, **options)


def check_counts(evaluations: int, samples: int, seed: int) -> None:
    """Refuse a search without evaluations, and negative numbers."""
    for name, number, least in (("evaluations", evaluations, 1), ("samples", samples, 0), ("seed", seed, 0)):
        if number < least:
            raise HcsearchError(f"{name} cannot be {number}: give {least} or more")


def refuse_drives(subject: Subject) -> None:
    """Refuse what is driven, as springs alone are tuned."""
    if subject.drives is not None:
        raise HcsearchError(
            f"{subject.title} has drives, but hcsearch tune chooses springs alone: leave out its table [drive]"
        )
