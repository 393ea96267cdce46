"""The spring sets of looks: graded over layers, faces and stacks, or spread over all that springs may be."""

from __future__ import annotations

from functools import cache

import numpy as np

from hcsearch.basics.arrays import Reals
from hcsearch.designs.folding import Folding
from hcsearch.designs.panel_sizes import PanelSize
from hcsearch.scenes.looks import GRADED_STIFFNESS_RATIO, OUTER_FIRST_SET, SPREAD_SPRING_SETS, SPRING_SET_GRADES
from hcsearch.springs.deployment.compiling import CompiledScene


def springs_of(folding: Folding, panel: PanelSize, compiled: CompiledScene, name: str) -> Reals:
    """Stiffnesses (N m/rad) of the joints of a folding in a set, shape (n_joints,), within the scene's range.

    Graded ones are geometric from the stiffest to a fortieth of it, those of `SPREAD_SPRING_SETS` between the bounds.
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
        towards = np.where(weights < 0.0, 1.0 - places, places)
        softness = towards @ np.abs(weights) / np.abs(weights).sum()
    softer = max(softest, stiffest / GRADED_STIFFNESS_RATIO)
    springs: Reals = stiffest * (softer / stiffest) ** softness
    return springs


def _places(folding: Folding, panel: PanelSize, compiled: CompiledScene) -> Reals:
    """Layer (0 lowest to 1), face (1 for a valley) and stack (1 for the second) of the hinge of each joint.

    As the folding has them that stands for all congruent ones: which stack is the first depends on how a circuit is
    written.
    """
    linkage, joint_of, twin = compiled.linkage, compiled.joint_of, compiled.linkage.twin
    if twin is not None:
        like = folding.likeness(panel)
        assert like is not None
        folding, linkage, joint_of = like.folding, twin.linkage, joint_of[np.argsort(twin.hinges)]
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


@cache
def spring_sets(n_joints: int, count: int, softest: float, stiffest: float) -> Reals:
    """Stiffnesses (N m/rad) spread evenly over the logarithms between two bounds, shape (count, n_joints).

    A scrambled Sobol sequence (scipy.stats.qmc), always the same: one array for all who ask, read-only.
    """
    from scipy.stats import qmc  # noqa: PLC0415 - takes longer to load than many deployments to compute

    points = qmc.Sobol(n_joints, seed=1).random(count)
    stiffness: Reals = softest * (stiffest / softest) ** points
    stiffness.flags.writeable = False
    return stiffness
