"""Rows of the bench `experiment`: deployments with equal springs, tunings, and what the thesis says of both."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

from hcsearch.basics.vocabulary import Formulation
from hcsearch.scenes import Scene
from hcsearch.scenes.scene import SceneVector
from hcsearch.springs.deployment.simulated_deployment import Deployment, simulate_deployment
from hcsearch.springs.tuning.choice import SpringSet
from hcsearch.springs.tuning.spring_tuning import Tuning, tune_springs
from hcsearch.springs.tuning.tuning_options import TuningOptions
from hcsearch_bench.run.bench import Say
from hcsearch_bench.subjects.deployments import assembly

G = 9.81
GRAVITIES: dict[str, SceneVector] = {
    "none": (0.0, 0.0, 0.0),
    "+x": (G, 0.0, 0.0),
    "-x": (-G, 0.0, 0.0),
    "+y": (0.0, G, 0.0),
    "-y": (0.0, -G, 0.0),
    "+z": (0.0, 0.0, G),
    "-z": (0.0, 0.0, -G),
}
"""Directions in axes of the flat state: x along the rows, across the mirror; z up from the drawing."""
CATALOGUE = (0.07, 0.10)
"""Springs that the thesis had, N m/rad."""
TUNED = ("none", "+y", "-y", "+x")
"""Gravities in which springs are tuned; with the quick bench the first alone."""


@dataclass(frozen=True)
class UniformRow:
    """The deployment with springs of 0.10 N m/rad everywhere.

    held : panel. outcome, end_s : of the simulation. collision_s, panels : the first collision; empty without one.
    """

    gravity: str
    held: int
    formulation: str
    outcome: str
    end_s: float
    clearance: str
    collision_s: float | None
    panels: str


@dataclass(frozen=True)
class TunedRow:
    """Springs of one tuning, and how the array deploys with them.

    springs : `uniform`, `tuned` or `catalogue`. stiffness : of hinges 0 to 6 (the others are their mirror images),
    N m/rad. verdict : of the precise simulation; of the quick check where there was none. collides : of the samples
    within 5 % of stiffness, damping and mass; chance : its interval at 95 %. seconds : of the whole tuning.
    """

    gravity: str
    held: int
    springs: str
    stiffness: str
    verdict: str
    flat_s: float | None
    collides: str
    chance: str
    seconds: float


@dataclass(frozen=True)
class Claim:
    """A statement of the thesis, and the result here."""

    thesis: str
    here: str


def uniform_rows(*, quick: bool, say: Say) -> list[UniformRow]:
    """A row a gravity, held panel and formulation; quick: exact closure alone."""
    linkage = assembly("thesis-4x4")
    formulations: tuple[Formulation, ...] = ("constrained",) if quick else ("constrained", "compliant")
    rows = []
    for held in (0, 5, 7):
        for gravity, vector in GRAVITIES.items():
            say(f"equal springs, gravity {gravity}, panel {held} held")
            for formulation in formulations:
                scene = Scene(gravity=vector, held=str(held))
                rows.append(_uniform_row(gravity, held, simulate_deployment(linkage, scene, formulation)))
    return rows


def _uniform_row(gravity: str, held: int, deployment: Deployment) -> UniformRow:
    clearance = deployment.clearance
    assert clearance is not None
    panels = "" if clearance.panels is None else "{} and {}".format(*clearance.panels)
    end = float(deployment.motion.times[-1])
    return UniformRow(
        gravity,
        held,
        deployment.compiled.formulation,
        deployment.outcome,
        end,
        clearance.kind,
        clearance.time,
        panels,
    )


def tuned_rows(*, quick: bool, say: Say) -> list[TunedRow]:
    """A row a gravity and set of springs; quick: one tuning, without samples."""
    linkage, tuned = assembly("thesis-4x4"), []
    for gravity in TUNED[:1] if quick else TUNED:
        say(f"tuning, gravity {gravity}")
        began = time.perf_counter()
        scene = Scene(gravity=GRAVITIES[gravity])
        options = TuningOptions(CATALOGUE, 100, 0) if quick else TuningOptions(CATALOGUE)
        tuning = tune_springs(linkage, scene, options, "compliant")
        tuned += _rows(gravity, tuning, time.perf_counter() - began)
    return tuned


def _rows(gravity: str, tuning: Tuning, seconds: float) -> list[TunedRow]:
    sets: dict[str, SpringSet | None] = {"uniform": tuning.start, "tuned": tuning.best, "catalogue": tuning.rounded}
    return [_row(gravity, name, one, seconds) for name, one in sets.items() if one is not None]


def _row(gravity: str, name: str, one: SpringSet, seconds: float) -> TunedRow:
    check, precise, chance = one.check, one.deployment, one.robustness
    verdict = "flat, certified clear" if one.confirmed else "collides" if check.clear is False else "not certified"
    return TunedRow(
        gravity,
        0,
        name,
        " ".join(f"{stiffness:.3g}" for stiffness in one.stiffnesses[:7]),
        verdict if precise is None or precise.deploys else f"{precise.outcome}, not certified clear",
        None if precise is None else precise.flat_time,
        "" if chance is None else f"{chance.collisions} of {chance.samples}",
        "" if chance is None else "{:.0%} to {:.0%}".format(*chance.interval),
        seconds,
    )


def claims(uniform: Sequence[UniformRow], tuned: Sequence[TunedRow]) -> list[Claim]:
    """The thesis's statements beside the numbers of the tables."""
    held = [row for row in uniform if row.held == 0]
    hits = [row for row in held if row.clearance != "clear"]
    times = [row.collision_s for row in hits if row.collision_s is not None]
    met = sorted({row.panels for row in hits})
    when = f"{min(times):.3g} to {max(times):.3g} s" if times else "-"
    return [
        Claim("equal springs collide", f"in {len(hits)} of {len(held)} simulations with panel 0 held"),
        Claim("at 0.30 s, by eye from a film", when),
        Claim("the large middle panel, with the back of the top one", "panels " + "; ".join(met)),
        *(
            Claim(f"{name} springs do not", _summary([row for row in tuned if row.springs == name]))
            for name in ("tuned", "catalogue")
        ),
    ]


def _summary(rows: Sequence[TunedRow]) -> str:
    clear = [row.gravity for row in rows if row.verdict == "flat, certified clear"]
    return f"certified clear for {len(clear)} of {len(rows)} gravities" + (f": {', '.join(clear)}" if clear else "")
