"""Rows of the bench `flight` on frequencies of flat arrays, against MuJoCo's mass matrix and Jacobian."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.linalg import eigh, null_space

from hcsearch.basics.array_values import Reals
from hcsearch.designs.folding import folding_at
from hcsearch.scenes import SCENES, panel_of
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.compiled_scene import OMISSIONS, compile_scene
from hcsearch.springs.flight.deployed_modes import deployed_modes
from hcsearch_bench.peers import mujoco_system
from hcsearch_bench.peers.states import depth_first, installed
from hcsearch_bench.subjects.foldings import packed, search_of, untwisted

SUBJECTS = (("hex", "10", 20), ("square", "12", 15), ("triangle", "14", 5), ("kite", "8", 5), ("square", "5x4", 5))
QUICK = (("hex", "8", 1),)
DEPENDENT = 1e-7
"""Singular values of MuJoCo's Jacobian below this share of the greatest count as zero."""


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
    theirs = mujoco_frequencies(compiled, stiffness)
    modes = deployed_modes(linkage, stiffness, compiled.setup.density, compiled.setup.held)
    ratios = modes.frequencies / theirs - 1.0
    return FrequencyRow(
        name, len(theirs), float(modes.frequencies[0]), float(theirs[0]), float(ratios[0]), float(np.abs(ratios).max())
    )


def mujoco_frequencies(compiled: Any, stiffness: Reals) -> Reals:
    """Frequencies of a compiled scene when flat, with a stiffness at each hinge, Hz, from MuJoCo's own matrices."""
    mujoco = installed("mujoco")
    drives = tuple(replace(drive, lower=-math.inf, upper=math.inf) for drive in compiled.system.drives)
    model = mujoco.MjModel.from_xml_string(mujoco_system.text_of(replace(compiled.system, drives=drives), 1e-3))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    masses = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, masses)
    rows = np.array(data.efc_J, float).reshape(-1, model.nv)[: data.ne]
    of_joint = np.empty(model.nv)
    of_joint[compiled.joint_of] = stiffness
    closed = null_space(rows, rcond=DEPENDENT) if len(rows) else np.eye(model.nv)
    stiffnesses = closed.T @ (of_joint[depth_first(compiled.system)][:, None] * closed)
    squares = eigh(stiffnesses, closed.T @ masses @ closed, eigvals_only=True)
    frequencies: Reals = np.sqrt(squares) / (2.0 * math.pi)
    return frequencies
