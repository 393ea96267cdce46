"""How much each omission of a compiled scene saved, measured: the same scene is simulated with it kept."""

from __future__ import annotations

from typing import Any

from hcsearch.deployment.compiling import OMISSIONS, Compiled, compile_scene
from hcsearch.deployment.deploying import Deployment, run


def savings(deployment: Deployment, *, method: str | None, tolerance: float) -> list[dict[str, Any]]:
    """What each omission saved: the same scene with it kept, in joints, closure equations, evaluations and time."""
    rows = []
    for omission in deployment.compiled.omissions:
        if omission.name not in OMISSIONS:
            continue
        compiled = deployment.compiled
        full = compile_scene(compiled.linkage, compiled.setup, compiled.formulation, keep=frozenset({omission.name}))
        other = run(full, method=method, tolerance=tolerance, certified=False)
        again = run(compiled, method=method, tolerance=tolerance, certified=False)
        rows.append(
            {
                "name": omission.name,
                "joints": [full.system.n_joints, compiled.system.n_joints],
                "closure_equations": [_rows(full), _rows(compiled)],
                "evaluations": [other.motion.evaluations, again.motion.evaluations],
                "milliseconds": [1e3 * other.seconds, 1e3 * again.seconds],
                "outcomes": [other.outcome, again.outcome],
            }
        )
    return rows


def _rows(compiled: Compiled) -> int:
    return sum(len(weld.kinds) for weld in compiled.system.welds)
