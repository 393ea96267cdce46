"""Rows of the bench `flight` on frequencies of flat arrays, against MuJoCo's mass matrix and Jacobian."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.designs.folding import folding_at
from hcsearch.scenes import SCENES, panel_of
from hcsearch.scenes.laws import linear_law
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.compiled_scene import OMISSIONS, compile_scene
from hcsearch.springs.dynamics.system import JointDrive
from hcsearch.springs.flight.deployed_modes import deployed_modes
from hcsearch_bench.peers import mujoco_system
from hcsearch_bench.subjects.foldings import packed, search_of, untwisted

SUBJECTS = (("hex", "10", 20), ("square", "12", 15), ("triangle", "14", 5), ("kite", "8", 5), ("square", "5x4", 5))
QUICK = (("hex", "8", 1),)


@dataclass(frozen=True)
class FrequencyRow:
    """First frequencies of a folding, Hz, and by how much they and all higher ones differ, as shares."""

    folding: str
    freedoms: int
    ours_hz: float
    mujoco_hz: float
    ratio: float
    others: float


def frequency_rows(*, quick: bool) -> list[FrequencyRow]:
    """A row for each of some foldings of each search, evenly over the list, with unequal latches."""
    rows, rng = [], np.random.default_rng(38)
    for grid, cells, number in QUICK if quick else SUBJECTS:
        for circuits, foldings in packed(untwisted(search_of(grid, cells))):
            for k in np.unique(np.linspace(0, len(foldings) - 1, number).round().astype(int)).tolist():
                folding = folding_at(circuits, foldings, k)
                linkage = folding.linkage(panel_of(SCENES["default"], grid), flat_pairs="hinged")
                rows.append(_row(folding.notation, linkage, rng.uniform(50.0, 100.0, linkage.n_hinges)))
    return rows


def _row(name: str, linkage: Linkage, stiffness: Reals) -> FrequencyRow:
    compiled = compile_scene(linkage, SCENES["default"], keep=frozenset(OMISSIONS))
    drives = [JointDrive() for _ in compiled.system.joints]
    for hinge, joint in enumerate(compiled.joint_of.tolist()):
        drives[joint] = JointDrive(linear_law(float(stiffness[hinge])))
    system = replace(compiled.system, drives=tuple(drives))
    theirs = mujoco_system.frequencies(system, np.zeros(system.n_joints))
    modes = deployed_modes(linkage, stiffness, compiled.setup.density, compiled.setup.held)
    ratios = modes.frequencies / theirs - 1.0
    return FrequencyRow(
        name, len(theirs), float(modes.frequencies[0]), float(theirs[0]), float(ratios[0]), float(np.abs(ratios).max())
    )
