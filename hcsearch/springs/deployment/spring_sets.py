"""Stiffnesses of single hinges, and the spring sets that the stage `deployment` tries."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.designs.folding import Folding
from hcsearch.designs.panel_sizes import PanelSize
from hcsearch.scenes.laws import Law, linear_law
from hcsearch.scenes.looks import GRADED_STIFFNESS_RATIO, OUTER_FIRST_SET, SPREAD_SPRING_SETS, SPRING_SET_GRADES
from hcsearch.scenes.setup import Setup
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.compiled_scene import CompiledScene
from hcsearch.springs.dynamics.panels import mirror_of

STIFFNESS_DIGITS = 12
"""Significant digits of the stiffnesses of spring sets."""


def tied_hinges(linkage: Linkage, held: int) -> tuple[tuple[int, ...], ...]:
    """Group mirror images of hinges, which get equal springs for a symmetric deployment (thesis 4.5.4).

    The mirror maps the held panel onto itself; without one every hinge is a group. Groups are ordered by their first
    hinge.
    """
    mirror = mirror_of(linkage, held)
    images = range(linkage.n_hinges) if mirror is None else mirror.hinges
    return tuple(sorted({tuple(sorted({hinge, image})) for hinge, image in enumerate(images)}))


def stiffnesses_of(setup: Setup) -> Reals:
    """Return the stiffness of each hinge, N m/rad; HcsearchError where a law is not linear, or has a preload."""
    return np.array([_stiffness(law) for law in setup.laws])


def _stiffness(law: Law) -> float:
    constant, slope, *rest = law.straight.cubics[0]
    if law.bent is not None or law.full or len(law.straight.cubics) > 1 or constant or any(rest):
        raise HcsearchError(
            f"springs that are tuned are linear, without a preload or a time: write linear:0.1, not {law.text}"
        )
    return slope


def with_springs(compiled: CompiledScene, stiffnesses: Reals) -> CompiledScene:
    """Return a scene with linear springs, of stiffnesses (N m/rad) by joint, shape (n_joints,).

    Damping stays proportional (thesis 4.4), but for hinges with a damping of their own. The scene must have been
    compiled without omitting its stops.
    """
    setup = compiled.setup
    drives = list(compiled.system.drives)
    laws = []
    for hinge, joint in enumerate(compiled.joint_of.tolist()):
        law = linear_law(float(stiffnesses[joint]))
        share = float(compiled.shares[joint])
        share_law = law if share == 1.0 else linear_law(share * float(stiffnesses[joint]))
        drives[joint] = replace(drives[joint], law=share_law, damping=share * setup.damping_of(hinge, law))
        laws.append(law)
    return replace(compiled, setup=replace(setup, laws=tuple(laws)), system=compiled.system.driven(tuple(drives)))


def springs_of(folding: Folding, panel: PanelSize, compiled: CompiledScene, name: str) -> Reals:
    """Return the stiffnesses (N m/rad) of the joints of a folding in a spring set, shape (n_joints,).

    Graded sets are geometric from the stiffest spring of the scene's range to a fortieth of it, or to the softest;
    the sets `SPREAD_SPRING_SETS` are spread over the whole range.
    """
    softest, stiffest = compiled.setup.spring_range
    if name in SPREAD_SPRING_SETS:
        sets: Reals = spring_sets(compiled.system.n_joints, len(SPREAD_SPRING_SETS), softest, stiffest)
        spread: Reals = sets[SPREAD_SPRING_SETS.index(name)]
        return spread
    places = _places(folding, panel, compiled)
    if name == OUTER_FIRST_SET:
        softness = 1.0 - np.abs(2.0 * places[:, 0] - 1.0)
    else:
        weights = np.array(SPRING_SET_GRADES[name])
        directed = np.where(weights < 0.0, 1.0 - places, places)
        softness = directed @ np.abs(weights) / np.abs(weights).sum()
    softer = max(softest, stiffest / GRADED_STIFFNESS_RATIO)
    return _rounded(stiffest * (softer / stiffest) ** softness)


def _places(folding: Folding, panel: PanelSize, compiled: CompiledScene) -> Reals:
    """Return layer (0 lowest to 1), face (1 for a valley) and stack (1 for the second) of the hinge of each joint.

    They belong to the congruent folding, if there is one, as the order of the stacks depends on the notation of the
    circuit.
    """
    linkage, joint_of, congruent = compiled.linkage, compiled.joint_of, compiled.linkage.twin
    if congruent is not None:
        likeness = folding.likeness(panel)
        assert likeness is not None
        folding, linkage = likeness.folding, congruent.linkage
        joint_of = joint_of[np.argsort(congruent.hinges)]
    pattern, half = linkage.pattern, folding.circuit.n // 2
    first = set(folding.stacks[0])
    places = np.zeros((compiled.system.n_joints, 3))
    for pair, crease in pattern.creases.items():
        if crease.face is None:
            continue
        layers = [folding.layers[panel] for panel in pair]
        layer = min(layers) / max(1, half - 2)
        joint = joint_of[pattern.hinge_of(pair)]
        places[joint] = min(layer, 1.0), crease.face == "top", pair[0] not in first
    return places


def _rounded(stiffnesses: Reals) -> Reals:
    """Round to `STIFFNESS_DIGITS`, as the last bits of powers depend on the processor."""
    rounded = [float(f"{stiffness:.{STIFFNESS_DIGITS}g}") for stiffness in stiffnesses.ravel()]
    return np.array(rounded).reshape(stiffnesses.shape)


@cache
def spring_sets(n_joints: int, count: int, softest: float, stiffest: float) -> Reals:
    """Return stiffnesses (N m/rad) spread evenly over the logarithms between two bounds, shape (count, n_joints).

    A scrambled Sobol sequence (scipy.stats.qmc) with a fixed seed; the cached array is read-only.
    """
    from scipy.stats import qmc  # noqa: PLC0415 - takes longer to load than many deployments to compute

    points = qmc.Sobol(n_joints, seed=1).random(count)
    stiffness = _rounded(softest * (stiffest / softest) ** points)
    stiffness.flags.writeable = False
    return stiffness
