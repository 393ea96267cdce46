"""Extreme scenes for the kinematics: each result is right, has an error bound, or is refused."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.library.assemblies.eight_r import eight_r
from hcsearch.library.assemblies.named_assembly import Parameters
from hcsearch.motion.kinematics.closing import close_linkage
from hcsearch.motion.kinematics.numerical_rank import rank_at
from hcsearch.motion.paths.branches import find_branches
from hcsearch.motion.paths.following import PathLimits, Stepping, follow_path
from hcsearch.motion.paths.motions import MotionPath
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import Pattern
from hcsearch_bench.kinematics.path_methods import KnownUnit, ring
from hcsearch_bench.run.bench import Say
from hcsearch_bench.subjects.squares import chain

BASE = 0.030
"""Base of the triangles of the units (m)."""
ROUNDING = 1e-14
"""Closure is known no better than this."""
ACCURATE = 1e-6
"""A path is accurate when its angles are known to this (rad)."""
SHORT = 1e-8
"""Tolerance of paths with several degrees of freedom (rad), of which closure corrects no errors along them."""


@dataclass(frozen=True)
class ExtremeRow:
    """One scene: a path, and a verdict on it.

    rank : decided or not, at the start and on the way; nullity and gap : of the state in the middle.
    residual : greatest closure residual. bound : how far off angles can be (rad), closure over the least singular
        value on the way. error : how far off they are (rad), where the truth is known.
    verdict : `accurate`, `degraded` (with the bound), or `refused` (with the reason).
    """

    group: str
    scene: str
    panels: int
    rank: str
    nullity: int | None
    gap: float
    outcome: str
    steps: int
    residual: float
    bound: float | None
    error: float | None
    verdict: str
    reason: str
    seconds: float


@dataclass(frozen=True)
class ExtremeScene:
    """A path to follow, and its error where the truth is known.

    allowed : error that it may have by its tolerance, on top of what closure leaves (rad).
    """

    group: str
    name: str
    linkage: Linkage
    run: Callable[[], MotionPath]
    error: Callable[[MotionPath], float] | None = None
    allowed: float = 0.0


def measure_extremes(*, quick: bool, say: Say) -> list[ExtremeRow]:
    """One row a scene; HcsearchError where a number is not finite, or an error is greater than what is claimed."""
    rows = []
    for scene in scenes(quick=quick):
        say(f"extreme: {scene.group}, {scene.name}")
        rows.append(judge(scene))
    return rows


def judge(scene: ExtremeScene) -> ExtremeRow:
    """Follow a scene's path and give the verdict; HcsearchError when it claims more than is true."""
    begin = time.perf_counter()
    path = scene.run()
    seconds = time.perf_counter() - begin
    middle = rank_at(scene.linkage, path.angles[len(path.angles) // 2])
    residual = float(path.residuals.max())
    answered = path.success or path.outcome == "stopped"
    bound = scene.allowed + (residual + ROUNDING) / float(path.least_singular_values.min()) if answered else None
    error = scene.error(path) if scene.error is not None and path.success else None
    undecided = bool((path.nullities < 0).any())
    if bound is None:
        verdict, reason = "refused", f"{path.outcome}: {path.sentence}"
    elif undecided:
        verdict, reason = "degraded", f"within {bound:.1e} rad; the rank is undecided on the way"
    elif bound > ACCURATE:
        verdict, reason = "degraded", f"within {bound:.1e} rad"
    else:
        verdict, reason = "accurate", ""
    row = ExtremeRow(
        scene.group,
        scene.name,
        scene.linkage.n_panels,
        "undecided" if undecided else "decided",
        middle.nullity,
        middle.gap,
        path.outcome,
        path.steps,
        residual,
        bound,
        error,
        verdict,
        reason,
        seconds,
    )
    _check(row, path)
    return row


def _check(row: ExtremeRow, path: MotionPath) -> None:
    if not np.isfinite(path.angles).all() or not math.isfinite(row.residual):
        raise HcsearchError(f"{row.group}, {row.scene}: a number is not finite; report this")
    if row.error is not None and row.bound is not None and row.error > 10 * row.bound + ACCURATE:
        raise HcsearchError(
            f"{row.group}, {row.scene}: off by {row.error:.1e} rad where it claims {row.bound:.1e}; report this"
        )


def scenes(*, quick: bool) -> Iterator[ExtremeScene]:
    """All scenes, or some of every group."""
    yield from _shapes(quick)
    yield from _sizes(quick)
    yield from _starts()
    yield from _nearly(quick)
    yield from _scales()


def _shapes(quick: bool) -> Iterator[ExtremeScene]:
    for thickness in (1e-9, 1e-3, 1.0) if quick else (1e-9, 1e-6, 1e-3, 0.1, 1.0):
        unit = KnownUnit("II", thickness=thickness * BASE)
        yield _known("thickness", f"unit II, {thickness:g} of the base", unit)
    for degrees in (0.1, 45.0, 89.9) if quick else (0.1, 1.0, 44.9, 45.0, 89.0, 89.9):
        for name in ("II",) if quick else ("I", "II"):
            unit = KnownUnit(name, alpha=math.radians(degrees))
            yield _known("base angle", f"unit {name}, {degrees:g} degrees", unit)


def _known(group: str, name: str, unit: KnownUnit) -> ExtremeScene:
    """A unit that opens from its folded state."""
    return ExtremeScene(
        group,
        name,
        unit.linkage,
        partial(follow_path, unit.linkage, unit.linkage.folded, unit.opening()),
        unit.path_error,
    )


def _sizes(quick: bool) -> Iterator[ExtremeScene]:
    for panels in (2, 200) if quick else (2, 20, 200, 2000):
        linkage, name = chain(panels), f"{panels} squares in a row"
        yield ExtremeScene("open chains", name, linkage, partial(follow_path, linkage, linkage.folded), _straight)
    for panels in (6, 200) if quick else (6, 20, 200, 2000):
        yield _there_and_back(f"ring of {panels} squares, there and back", ring(panels // 2))


def _straight(path: MotionPath) -> float:
    """How far a path is from the straight line between its ends."""
    share = path.lengths / path.lengths[-1]
    return float(np.abs(path.angles - (path.angles[0] + share[:, None] * (path.end - path.angles[0]))).max())


def _there_and_back(name: str, linkage: Linkage) -> ExtremeScene:
    """A geodesic of 1 rad from a state in general position, and from its end back to it."""
    rng = np.random.default_rng(linkage.n_hinges)
    start = close_linkage(linkage, rng.uniform(0.2, 0.6, linkage.n_hinges)).angles
    direction = rng.standard_normal(linkage.n_hinges)

    def run() -> MotionPath:
        options = {"limits": PathLimits(goal="none", stops=False, length=1.0), "stepping": Stepping(tolerance=SHORT)}
        there = follow_path(linkage, start, direction, **options)  # type: ignore[arg-type]
        if not there.success or there.velocity is None:
            return there
        return follow_path(linkage, there.end, -there.velocity, **options)  # type: ignore[arg-type]

    # among many motions closure does not correct the direction: each step adds to the error
    return ExtremeScene("loops", name, linkage, run, lambda p: float(np.abs(p.end - start).max()), allowed=50 * SHORT)


def _starts() -> Iterator[ExtremeScene]:
    element = Linkage(eight_r(Parameters()))
    subjects: list[tuple[str, Linkage, Callable[[MotionPath], float] | None]] = [("8R", element, None)]
    for name in ("I", "II"):
        unit = KnownUnit(name)
        subjects.append((f"unit {name}", unit.linkage, unit.path_error))
    for name, linkage, error in subjects:
        for state in ("folded", "flat"):
            start = getattr(linkage, state)

            def along_branch(linkage: Linkage = linkage, start: Reals = start) -> MotionPath:
                ways = [b.direction for b in find_branches(linkage, start, stops=True).finite if b.within_stops]
                return follow_path(linkage, start, ways[0])

            def straight(linkage: Linkage = linkage, start: Reals = start, state: str = state) -> MotionPath:
                return follow_path(linkage, start, limits=PathLimits(goal="flat" if state == "folded" else "folded"))

            yield ExtremeScene("singular start", f"{name} {state}, direction found", linkage, along_branch, error)
            yield ExtremeScene("singular start", f"{name} {state}, no direction given", linkage, straight, error)


def _nearly(quick: bool) -> Iterator[ExtremeScene]:
    unit = KnownUnit("II")
    element = eight_r(Parameters())
    for share in (1e-12, 1e-6) if quick else (1e-12, 1e-10, 1e-8, 1e-6):
        for name, pattern in (("8R", element), ("unit II", unit.pattern)):
            linkage = Linkage(shaken(pattern, share * BASE))
            way = unit.folding() if name == "unit II" else _folding(linkage)
            yield ExtremeScene(
                "nearly parallel hinges",
                f"{name}, corners moved by {share:g} of the base",
                linkage,
                partial(follow_path, linkage, linkage.flat, way),
            )


def _folding(element: Linkage) -> Reals:
    """Velocity of the skew-symmetric motion at the flat state of an 8R element."""
    parts = np.arange(element.n_hinges) % 2
    velocity: Reals = np.where(parts == 1, math.cos(Parameters().alpha), 1.0)
    return velocity


def shaken(pattern: Pattern, distance: float) -> Pattern:
    """A pattern whose corners are moved at random by about a distance (m), each as one."""
    steps = distance * np.random.default_rng(1).standard_normal((len(pattern.vertices), 2))
    return replace(
        pattern,
        vertices=tuple((x + dx, y + dy) for (x, y), (dx, dy) in zip(pattern.vertices, steps.tolist(), strict=True)),
    )


def _scales() -> Iterator[ExtremeScene]:
    for scale in (1e-6, 1e6):
        unit = KnownUnit("II", base=scale * BASE, thickness=scale * 0.01)
        yield _known("units of length", f"unit II, times {scale:g}", unit)
