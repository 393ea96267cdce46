"""The sweeps of the bench `stability`: scenes over many decades of one quantity, and what errors are measured from.

What does not vary is as in the scene `default`, but stops do not bounce.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.vocabulary import INTEGRATORS, Formulation
from hcsearch.scenes import Scene
from hcsearch_bench.stability.strips import THICK, StabilitySubject
from hcsearch_bench.stability.truths import MANY, Oscillator, Strip, Truth, analytic, energy_of_impacts, finer
from hcsearch_bench.subjects.squares import SIDE

STIFFNESS = 0.1
"""Of hinges (N m/rad)."""
SCENE = Scene(restitution=0.0)
LOOP, FOLDING = "thesis-4x4", "hex:023435551131:5"
"""An array of one loop, and a folding that deploys to flat."""
BOTH = ("dormand-prince", "implicit")
FINEST = (("dormand-prince-8", 1e-12), ("dormand-prince", 1e-11))
STIFF = (("dormand-prince-8", 1e-11), ("implicit", 1e-9), ("implicit", 1e-8))
RIGID = 3e3
"""A hinge whose spring is so many times stiffer is compared to one that does not turn: both are off by one over it."""
FEW = 20_000
"""Most steps of a simulation: seconds."""


@dataclass(frozen=True)
class SweepCase:
    """One simulation: where it stands in its sweep, how it is made, and what it is compared to.

    rough : the scene of the simulation that bounds the error; the same scene, at ten times the tolerance, unless given.
    whole : whether nothing is left out by symmetry.
    """

    sweep: str
    value: float
    subject: StabilitySubject
    scene: Scene
    truth: Truth
    formulation: Formulation = "constrained"
    method: str = "dormand-prince"
    tolerance: float = 1e-6
    rough: Scene | None = None
    whole: bool = False

    @property
    def rougher(self) -> SweepCase:
        """A rougher simulation, whose distance bounds the error."""
        if self.rough is not None:
            return replace(self, scene=self.rough)
        return replace(self, tolerance=min(10.0 * self.tolerance, 0.1))

    @property
    def stiffer(self) -> SweepCase | None:
        """The same with ten times the stiffness of springs that close loops, where a tenth of it is too little."""
        if self.rough is None:
            return None
        return replace(self, scene=replace(self.scene, cut_stiffness=10.0 * self.scene.cut_stiffness))


def cases(*, quick: bool) -> Iterator[SweepCase]:
    """All sweeps; quick: every third value, and few subjects."""
    yield from _stiffness_ratios(quick)
    yield from _closure_stiffnesses(quick)
    yield from _dampings(quick)
    yield from _thicknesses(quick)
    yield from _masses(quick)
    yield from _numbers(quick)
    yield from _starts(quick)
    yield from _singular()
    yield from _tolerances(quick)
    yield from _restitutions(quick)


def _decades(first: int, last: int, quick: bool) -> list[float]:
    """Powers of ten; quick: every third, with the last."""
    steps = list(range(first, last + 1, 3 if quick else 1))
    return [10.0**k for k in dict.fromkeys([*steps, last])]


def _beside_finer(
    sweep: str, value: float, scene: Scene, *subjects: StabilitySubject, **options: Any
) -> Iterator[SweepCase]:
    """Subjects in a scene are compared with finer simulations of the same."""
    for subject in subjects:
        yield SweepCase(sweep, value, subject, scene, finer(subject, scene, *FINEST), **options)


def _some(values: Sequence[float], quick: bool) -> Sequence[float]:
    """All values; quick: every third."""
    return values[::3] if quick else values


def panel_mass(scene: Scene, ratio: float = THICK) -> float:
    """Mass of a square panel, kg."""
    return scene.density * SIDE**3 * ratio


def hinge_inertia(scene: Scene, ratio: float = THICK) -> float:
    """Inertia of a square panel about a hinge on one of its edges, kg m^2."""
    return panel_mass(scene, ratio) * SIDE**2 * (1.0 + ratio**2) / 3.0


def two_panels(scene: Scene, *, rest: float = 0.0, start: float | None = None, ratio: float = THICK) -> Oscillator:
    """Two square panels as an oscillator, with a linear spring about an angle."""
    damping = scene.damping_time * STIFFNESS if scene.damping is None else scene.damping
    begin = math.pi * scene.start if start is None else start
    return Oscillator(hinge_inertia(scene, ratio), damping, STIFFNESS, rest, begin)


def _opening(scene: Scene, ratio: float = THICK) -> Truth:
    """Two panels that open until they are flat."""
    return analytic("closed form", lambda times: np.maximum(two_panels(scene, ratio=ratio).angles(times), 0.0))


def spring(stiffness: float, rest: float = 0.0) -> str:
    """Notation of a linear law about an angle."""
    return f"linear:{stiffness!r}" + (f"-{stiffness * rest!r}" if rest else "")


def strip_truth(scene: Scene, panels: int, stiffness: Reals | None = None, rest: Reals | None = None) -> Truth:
    """A strip by its own equations, from a share of its folded angles; without the hinge of an enormous spring."""
    stiffnesses = np.full(panels - 1, STIFFNESS) if stiffness is None else stiffness
    rigid = int(stiffnesses.argmax()) if stiffnesses.max() > RIGID * STIFFNESS else None
    strip = Strip(
        *(panels, SIDE, THICK * SIDE, scene.density, stiffnesses, np.zeros(panels - 1) if rest is None else rest),
        damping=stiffnesses * scene.damping_time,
        base=(scene.base_mass, scene.base_inertia[1]) if scene.held == "free" else None,
        rigid=rigid,
    )
    name = "own equations, SciPy" + (", hinge rigid" if rigid is not None else "")
    start = np.full(panels - 1, math.pi * scene.start)
    motion = cache(lambda end: strip.motion(start, end))
    return analytic(name, lambda times: motion(float(times[-1]))(times))


def _stiffness_ratios(quick: bool) -> Iterator[SweepCase]:
    """Of one hinge over the others: the middle one of a strip, unloaded at the start; the first of the loop, wound."""
    for ratio in _decades(0, 12, quick):
        begin = 0.5 * math.pi
        springs = (("1", spring(STIFFNESS * ratio, begin)),)
        scene = replace(SCENE, start=0.5, spring=spring(STIFFNESS, 1.0), springs=springs, seconds=0.1)
        truth = strip_truth(scene, 4, STIFFNESS * np.array([1.0, ratio, 1.0]), np.array([1.0, begin, 1.0]))
        loop = replace(SCENE, springs=(("0", spring(STIFFNESS * ratio)),), seconds=0.1)
        for method in BOTH:
            yield SweepCase("stiffness ratio", ratio, StabilitySubject("strip", 4), scene, truth, method=method)
            subject = StabilitySubject(LOOP)
            yield SweepCase("stiffness ratio", ratio, subject, loop, finer(subject, loop, *STIFF), method=method)


def _closure_stiffnesses(quick: bool) -> Iterator[SweepCase]:
    """Springs that hold cut hinges, against closed loops: the error goes with one over the stiffness."""
    for stiffness in _decades(2, 12, quick):
        for subject in (StabilitySubject(LOOP), StabilitySubject(FOLDING)):
            exact = replace(SCENE, seconds=0.02)
            scene = replace(exact, cut_stiffness=stiffness)
            yield SweepCase(
                *("closure stiffness", stiffness, subject, scene, finer(subject, exact, *FINEST, name="closed loops")),
                formulation="penalty",
                rough=replace(exact, cut_stiffness=0.1 * stiffness),
            )


def _dampings(quick: bool) -> Iterator[SweepCase]:
    """Damping over what is critical for two panels; far beyond, the loop is compared to motion without inertia."""
    critical = 2.0 * math.sqrt(STIFFNESS * hinge_inertia(SCENE))
    for share in (0.0, *_decades(-3, 6, quick)):
        damping = share * critical
        late = damping / STIFFNESS
        pair = replace(SCENE, damping=damping, seconds=max(0.02, 3.0 * late))
        scene = replace(SCENE, damping=damping, seconds=max(0.1, 2.0 * late))
        subject = StabilitySubject(LOOP)
        truth = (
            finer(subject, scene, *STIFF)
            if share < 1e3
            else finer(subject, scene, *FINEST, formulation="quasistatic", name="without inertia")
        )
        for method in BOTH:
            yield SweepCase("damping / critical", share, StabilitySubject("strip"), pair, _opening(pair), method=method)
            yield SweepCase("damping / critical", share, subject, scene, truth, method=method)


def _thicknesses(quick: bool) -> Iterator[SweepCase]:
    """Thickness over width, with the mass of a panel unchanged."""
    for ratio in _decades(-6, 0, quick):
        scene = replace(SCENE, density=SCENE.density * THICK / ratio, seconds=0.1)
        pair = StabilitySubject("strip", ratio=ratio)
        yield SweepCase("thickness / width", ratio, pair, scene, _opening(scene, ratio))
        subjects = (StabilitySubject(name, ratio=ratio) for name in (LOOP, FOLDING))
        yield from _beside_finer("thickness / width", ratio, scene, *subjects)


def _masses(quick: bool) -> Iterator[SweepCase]:
    """Mass of a floating cube of 0.1 m over that of a panel."""
    for ratio in _decades(0, 6, quick):
        mass = ratio * panel_mass(SCENE)
        inertia = mass * 0.1**2 / 6.0
        scene = replace(SCENE, held="free", base_mass=mass, base_inertia=(inertia, inertia, inertia), seconds=0.1)
        yield SweepCase("base mass / panel mass", ratio, StabilitySubject("strip", 3), scene, strip_truth(scene, 3))
        yield from _beside_finer("base mass / panel mass", ratio, scene, StabilitySubject(LOOP))


def _numbers(quick: bool) -> Iterator[SweepCase]:
    """A ring moves as a strip of half its panels does: both rows move alike."""
    for panels in (2, 10, 100) if quick else (2, 3, 4, 6, 10, 30, 100, 300, 1000):
        scene = replace(SCENE, seconds=0.02 if panels < MANY else 0.005)
        yield SweepCase("panels", panels, StabilitySubject("strip", panels), scene, strip_truth(scene, panels))
    for panels in (10, 100) if quick else (6, 10, 30, 100, 300, 1000):
        scene = replace(SCENE, seconds=0.02 if panels < MANY else 0.005)
        subject = StabilitySubject("ring", panels)
        yield SweepCase("panels", panels, subject, scene, ring_truth(scene, subject), whole=True)


def ring_truth(scene: Scene, subject: StabilitySubject) -> Truth:
    """A strip of half the panels of a ring, whose first panel is held too."""
    half = subject.panels // 2
    strip = Strip(
        *(half, SIDE, THICK * SIDE, scene.density, np.full(half - 1, STIFFNESS), np.zeros(half - 1)),
        np.full(half - 1, STIFFNESS * scene.damping_time),
    )

    def way(times: Reals) -> Reals:
        linkage = subject.linkage
        ends = np.array([hinge.start[0] for hinge in linkage.pattern.hinges])
        held = np.mean([x for facet in linkage.pattern.panels[linkage.base] for x, _ in linkage.pattern.facets[facet]])
        place = np.round((np.abs(ends - held) / SIDE) - 0.5).astype(int)
        return strip.angles(np.full(half - 1, math.pi * scene.start), times)[:, place]

    return analytic("own equations of a strip, SciPy", way)


def _starts(quick: bool) -> Iterator[SweepCase]:
    for share in _some((0.9, 0.99, 0.999, 0.9999, 0.99999, 0.999999), quick):
        scene = replace(SCENE, start=share, seconds=0.1)
        yield SweepCase("start / folded", share, StabilitySubject("strip"), scene, _opening(scene))
        yield from _beside_finer("start / folded", share, scene, StabilitySubject(LOOP), StabilitySubject(FOLDING))


def _singular() -> Iterator[SweepCase]:
    """Exactly folded; exactly flat with springs that fold, as no deployment but a simulation may start."""
    sweep = "singular start"
    scene = replace(SCENE, start=1.0, seconds=0.1)
    yield SweepCase(sweep, 1.0, StabilitySubject("strip"), scene, _opening(scene))
    names = (LOOP, FOLDING, "element-8r", "unit-i")
    yield from _beside_finer(sweep, 1.0, scene, *map(StabilitySubject, names))
    folding = replace(SCENE, spring=spring(STIFFNESS, 1.0), seconds=0.1)
    oscillator = two_panels(folding, rest=1.0, start=0.0)
    yield SweepCase(
        sweep, 0.0, StabilitySubject("strip", flat=True), folding, analytic("closed form", oscillator.angles)
    )
    yield from _beside_finer(sweep, 0.0, folding, *(StabilitySubject(name, flat=True) for name in names))
    refused = replace(folding, start=0.0)
    yield from _beside_finer(sweep, 0.0, refused, StabilitySubject(LOOP), StabilitySubject(FOLDING))


def _tolerances(quick: bool) -> Iterator[SweepCase]:
    for tolerance in reversed(_decades(-13, -2, quick)):
        for method in INTEGRATORS:
            pair = replace(SCENE, damping=0.0, seconds=0.02)
            scene = replace(SCENE, seconds=0.05)
            options: dict[str, Any] = {"method": method, "tolerance": tolerance}
            yield SweepCase("tolerance", tolerance, StabilitySubject("strip"), pair, _opening(pair), **options)
            subjects = map(StabilitySubject, (LOOP,) if quick else (LOOP, FOLDING))
            yield from _beside_finer("tolerance", tolerance, scene, *subjects, **options)


def _restitutions(quick: bool) -> Iterator[SweepCase]:
    """Two panels that springs drive against their folded stop; loops by their energy balance."""
    for restitution in _some((0.0, 0.1, 0.5, 0.9, 0.99, 0.999, 1.0), quick):
        springs = {"spring": spring(STIFFNESS, 5.0), "start": 0.9, "damping": 0.0}
        pair = replace(SCENE, restitution=restitution, seconds=0.3, **springs)  # type: ignore[arg-type]
        oscillator = two_panels(pair, rest=5.0)

        def bouncing(times: Reals, oscillator: Oscillator = oscillator, restitution: float = restitution) -> Reals:
            return oscillator.bounces(math.pi, restitution, times)

        yield SweepCase("restitution", restitution, StabilitySubject("strip"), pair, analytic("closed form", bouncing))
        for name in (LOOP, FOLDING):
            scene = replace(SCENE, restitution=restitution, seconds=0.5)
            yield SweepCase(
                "restitution", restitution, StabilitySubject(name), scene, Truth("energy", energy_of_impacts)
            )
