"""The share of the work of a deployment that its omissions save, from counts of operations."""

from __future__ import annotations

import math

from hcsearch.springs.deployment.compiled_scene import CompiledScene

LOOK_WORK = 1.8
"""Work of a comparison of two panels, in units of one joint or closure equation of an evaluation of the accelerations;
measured on foldings of hexagons, squares and triangles (docs/explanation/accuracy.md)."""
BASE_FREEDOMS = 6
"""Joints of a base that is put back, and equations that lock it."""
LOOP_EQUATIONS = 6
"""Closure equations of a loop with nothing left out, or of an open chain of which a panel is put back in halves."""


def saved_share(compiled: CompiledScene, evaluations: int, looks: int) -> float:
    """Return the share of the work that a simulation would have with nothing left out, and does not have, 0 to 1.

    evaluations : of the accelerations; looks : pairs of panels that were compared. Both are taken to be as many per
    term with nothing left out. Processor time is saved in about this share; `hcsearch accuracy` measures it.
    """
    made = _work(evaluations, _terms(compiled), looks)
    whole = _work(evaluations, _all_terms(compiled), looks * _ratio_of_pairs(compiled))
    return 1.0 - made / whole if whole > 0.0 else 0.0


def _work(evaluations: int, terms: int, looks: float) -> float:
    return evaluations * terms + LOOK_WORK * looks


def _terms(compiled: CompiledScene) -> int:
    """Return the number of joints and closure equations."""
    return compiled.system.n_joints + compiled.system.n_equations


def _all_terms(compiled: CompiledScene) -> int:
    """Return the number of joints and closure equations with nothing left out.

    Panels in two halves close loops there, so that each hinge is a joint. Without inertia no base is put back.
    """
    n_loops, overdamped = len(compiled.linkage.loops), compiled.system.overdamped
    base = 0 if overdamped else BASE_FREEDOMS if compiled.setup.free else 2 * BASE_FREEDOMS
    if compiled.formulation == "penalty":  # springs close the loops
        return compiled.linkage.n_hinges - n_loops + base
    loops = n_loops or int(not overdamped)
    return compiled.linkage.n_hinges + LOOP_EQUATIONS * loops + base


def _ratio_of_pairs(compiled: CompiledScene) -> float:
    """Return the number of all pairs of panels over that of the pairs that are compared."""
    pairs = math.comb(compiled.linkage.n_panels, 2)
    return pairs / max(1, pairs - len(compiled.separated_pairs))
