"""Measure the accuracy of the deployment of a folding, an assembly or the subject of a file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from hcsearch.api.kinds import check_kinds
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import FORMULATIONS, INTEGRATORS, Formulation, Way
from hcsearch.scenes import Scene
from hcsearch.springs.accuracy.measured_accuracy import MeasuredAccuracy, default_errors
from hcsearch.springs.accuracy.stability_points import judged_points, stress_cases, sweep_cases
from hcsearch.springs.accuracy.stability_report import MeasuredStability
from hcsearch.springs.accuracy.swept_values import ScenePoint
from hcsearch.springs.accuracy.work_rows import DEFAULT_TOLERANCE, TOLERANCES, work_of_formulations
from hcsearch.springs.deployment.compiled_scene import compile_scene
from hcsearch.springs.deployment.omission_savings import omission_savings
from hcsearch.subjects.case import Case, CaseSubject
from hcsearch.subjects.names import Place
from hcsearch.subjects.resolve import resolve
from hcsearch.system.terminal import write_notice
from hcsearch.system.work_steps import Progress


def accuracy(
    what: CaseSubject | Case,
    scene: Scene | str | None = None,
    *,
    formulation: Formulation | None = None,
    error: float | None = None,
    limit: float = 1.0,
    panel: str | None = None,
    flat_pairs: Way | None = None,
    db: Place | None = None,
    progress: Progress | None = None,
    **values: Any,
) -> MeasuredAccuracy:
    """Measure error against run time of a deployment by springs, as `hcsearch accuracy` does.

    Parameters
    ----------
    what, scene, panel, flat_pairs, db, **values
        As those of `deploy`.
    formulation
        The only formulation that is tried; by default all that apply.
    error
        The greatest error of the fold angles for which the cheapest setting is named, rad.
    limit
        The greatest time of one simulation, s, about. What would take longer is not tried.
    progress
        Called with the number of simulations done, that of all, and words on the one that begins.

    Returns
    -------
    MeasuredAccuracy
        Errors and processor time of all simulations.

    Examples
    --------
    >>> from hcsearch import Folding, accuracy
    >>> measured = accuracy(Folding.from_notation("hex:0234550132:4"), formulation="constrained", error=1e-3)
    >>> measured.works[0].suffices
    True
    >>> measured.cheapest.angle_error <= 1e-3
    True
    """
    check_kinds(accuracy, locals())
    _check_positive(error=error, limit=limit)
    case = _resolved(what, scene, panel, flat_pairs, db, values)
    chosen = formulation or case.formulation
    formulations = FORMULATIONS if chosen is None else (chosen,)
    total, done = len(formulations) * (1 + len(INTEGRATORS) * len(TOLERANCES)), 0

    def announce(words: str) -> None:
        nonlocal done
        done += 1
        if progress is not None:
            progress(done - 1, total, words)

    works = tuple(work_of_formulations(case.linkage, case.setup, formulations, seconds=limit, announce=announce))
    measured = next((work.formulation for work in works if work.rows), None)
    if measured is None:
        raise HcsearchError(f"nothing can be measured: {works[0].refusal}")
    compiled = compile_scene(case.linkage, case.setup, measured)
    errors = default_errors(compiled, DEFAULT_TOLERANCE)
    omitted = tuple(omission_savings(compiled, method=None, tolerance=DEFAULT_TOLERANCE, together=True))
    return MeasuredAccuracy(case.name, case.setup.name, works, errors, omitted, error)


def stability(
    what: CaseSubject | Case,
    scene: Scene | str | None = None,
    *,
    sweep: Mapping[str, Sequence[float]] | None = None,
    formulation: Formulation | None = None,
    limit: float = 1.0,
    panel: str | None = None,
    flat_pairs: Way | None = None,
    db: Place | None = None,
    progress: Progress | None = None,
    **values: Any,
) -> MeasuredStability:
    """Judge simulations of a deployment with other values, as `hcsearch accuracy --sweep` and `--stress` do.

    Parameters
    ----------
    what, scene, panel, flat_pairs, db, **values
        As those of `deploy`.
    sweep
        One value of the scene, or two, with the least and the greatest number: damping (N m s/rad), stiffness (a factor
        of all springs), thickness (mm), density (kg/m^3), friction (N m), spread (the stiffest spring over the softest)
        or size (a factor). By default the standard set: each value times 10 and over 10, and known extremes.
    formulation
        The formulation; `constrained` by default.
    limit
        The greatest time of one simulation, s, about.
    progress
        Called with the number of points done, that of all, and words on the one that begins.

    Returns
    -------
    MeasuredStability
        The judgement at each point: `accurate`, `degraded`, `refused` or `wrong`.

    Examples
    --------
    >>> from hcsearch import Folding, stability
    >>> stability(Folding.from_notation("hex:0234550132:4"), sweep={"density": (300, 900)}).counts["wrong"]
    0
    """
    check_kinds(stability, locals())
    _check_positive(limit=limit)
    case = _resolved(what, scene, panel, flat_pairs, db, values)
    chosen = formulation or case.formulation or "constrained"
    point = ScenePoint(case.linkage, case.setup)
    if sweep is None:
        cases = list(stress_cases(point, chosen))
    else:
        cases = sweep_cases(point, {name: _limits(name, numbers) for name, numbers in sweep.items()}, chosen)
    done = 0

    def announce(words: str) -> None:
        nonlocal done
        done += 1
        if progress is not None:
            progress(done - 1, len(cases), words)

    points = tuple(judged_points(cases, tolerance=DEFAULT_TOLERANCE, seconds=limit, announce=announce))
    return MeasuredStability(case.name, case.setup.name, tuple(sweep or ()), points)


def _limits(name: str, numbers: Sequence[float]) -> tuple[float, float]:
    if len(numbers) != 2:
        raise HcsearchError(f"the sweep of {name} has {len(numbers)} numbers: give the least and the greatest value")
    return float(numbers[0]), float(numbers[1])


def _check_positive(**numbers: float | None) -> None:
    for name, number in numbers.items():
        if number is not None and not 0.0 < number < float("inf"):
            raise HcsearchError(f"{name} must be a positive number, not {number:g}: give one such as 1e-4")


def _resolved(
    what: CaseSubject | Case,
    scene: Scene | str | None,
    panel: str | None,
    flat_pairs: Way | None,
    db: Place | None,
    values: dict[str, Any],
) -> Case:
    """Return the case that is measured; HcsearchError for one with drives."""
    case = resolve(what, db, scene=scene, panel=panel, flat_pairs=flat_pairs, values=values)
    if case.drive is not None:
        raise HcsearchError("the accuracy of drives is not measured: leave out the table [drive]")
    write_notice(case.sentence)
    return case
