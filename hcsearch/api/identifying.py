"""Identify springs and dampers from measurements."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hcsearch.api.kinds import check_kinds
from hcsearch.basics.errors import HcsearchError, printable
from hcsearch.basics.vocabulary import MotionTerm, Way
from hcsearch.scenes import Scene
from hcsearch.shape.labels import labels_of
from hcsearch.springs.identification.identified_motion import DEFAULT_MOTION_TERMS, IdentifiedMotion, identify_films
from hcsearch.springs.identification.law_fitting import IdentifiedSpring, fit_spring
from hcsearch.springs.identification.measured_films import read_film
from hcsearch.springs.identification.measurements import read_accelerations, read_measured_moments
from hcsearch.springs.identification.vibration import (
    FreeVibration,
    HingeTest,
    hinge_damping,
    hinge_test,
    identify_modes,
)
from hcsearch.subjects.case import Case, CaseSubject
from hcsearch.subjects.names import Place
from hcsearch.subjects.resolve import resolve
from hcsearch.system.terminal import write_notice


@dataclass(frozen=True)
class HingeDamping:
    """The damping of a hinge from free vibrations, with a test and a modal analysis for each file."""

    tests: tuple[HingeTest, ...]
    vibrations: tuple[FreeVibration, ...]


def identify_spring(path: str | Path) -> IdentifiedSpring:
    """Identify the law of a spring from a table of angles and moments, as `hcsearch identify spring` does.

    Parameters
    ----------
    path
        A file .csv with a column `angle_rad` or `angle_deg` and a column `moment_N_m` or `moment_N_mm`.

    Returns
    -------
    IdentifiedSpring
        The fitted laws, the simplest first.
    """
    check_kinds(identify_spring, locals())
    measured = fit_spring(*read_measured_moments(str(path)))
    for doubt in measured.doubts:
        _note(f"{path}: {doubt}")
    return measured


def identify_damping(
    paths: Sequence[str], inertia: float, *, hinges: int = 1, rate: float | None = None, start: float | None = None
) -> HingeDamping:
    """Identify the damping of a hinge from free vibrations of a block, as `hcsearch identify damping` does.

    Parameters
    ----------
    paths
        Files .csv, one test each, with a column `time_s`, unless `rate` is given, and one for each accelerometer.
    inertia
        The moment of inertia of the block about the hinges, kg m^2.
    hinges
        How many equal hinges hold it.
    rate
        The rate of sampling, Hz.
    start
        Measurements before this time are left out, s.

    Returns
    -------
    HingeDamping
        The tests and the modal analysis of each file.
    """
    check_kinds(identify_damping, locals())
    hinge_damping(0.0, 0.0, inertia, hinges)  # raises for an invalid inertia before the work begins
    vibrations = [identify_modes(*read_accelerations(path, rate, start, _note)) for path in paths]
    for path, vibration in zip(paths, vibrations, strict=True):
        if not vibration.modes:
            raise HcsearchError(
                f"{path} holds no decaying vibration that is clear of its noise: begin after the stroke of the hammer, "
                "and leave out what does not move"
            )
    tests = tuple(hinge_test(vibration.modes[0], inertia, hinges) for vibration in vibrations)
    return HingeDamping(tests, tuple(vibrations))


def identify_motion(
    paths: Sequence[str | Path],
    what: CaseSubject | Case,
    scene: Scene | str | None = None,
    *,
    fit: Sequence[MotionTerm] = DEFAULT_MOTION_TERMS,
    held_out: Sequence[str | Path] = (),
    rate: float | None = None,
    panel: str | None = None,
    flat_pairs: Way | None = None,
    db: Place | None = None,
    **values: Any,
) -> IdentifiedMotion:
    """Fit springs, damping and other values of a scene to films of a deployment, as `hcsearch identify motion` does.

    Parameters
    ----------
    paths
        Files .csv, one film each, with a column `time_s`, unless `rate` is given, and one for each measured hinge,
        named by its number in pictures and unit, such as `7_deg` or `7_rad`. Cells may be empty.
    what, scene, panel, flat_pairs, db, **values
        As in `deploy`. Values that are not fitted are those of the scene.
    fit
        What is fitted: `stiffness` (one factor for all springs), `stiffness-by-law` or `stiffness-by-hinge`, `damping`,
        `friction`, `gravity` (its direction) and `drag`.
    held_out
        Further films, which are not fitted but predicted.
    rate
        The rate of the frames, Hz.

    Returns
    -------
    IdentifiedMotion
        The models tried, the chosen one with its parameters and intervals, and whether it explains the films.

    Raises
    ------
    HcsearchError
        For films that cannot be read, a scene with drives, and terms that cannot be fitted.
    """
    check_kinds(identify_motion, locals())
    case = resolve(what, db, scene=scene, panel=panel, flat_pairs=flat_pairs, values=values)
    write_notice(case.sentence)
    if case.drives is not None:
        raise HcsearchError("films are fitted by springs, and the scene has drives: leave out its table [drive]")
    if case.formulation not in (None, "constrained"):
        raise HcsearchError(f"films are fitted with exact closure, not in the {case.formulation} formulation")
    labels = labels_of(case.linkage)
    films, further = ([read_film(str(path), labels, rate, _note) for path in some] for some in (paths, held_out))
    identified = identify_films(case.name, case.linkage, case.setup, films, fit, further)
    for doubt in identified.doubts:
        _note(doubt)
    return identified


def _note(text: str) -> None:
    write_notice(f"hcsearch: {printable(text)}")
