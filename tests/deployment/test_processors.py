"""Deployments have the same bits on all processors: with other OpenBLAS kernels, with NumPy's AVX-512 or without."""

import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from hcsearch.designs.folding import Folding
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.scenes import SCENES
from hcsearch.scenes.looks import SPREAD_SPRING_SETS, SPRING_SET_GRADES
from hcsearch.springs.deployment.compiled_scene import compile_scene
from hcsearch.springs.deployment.simulated_deployment import simulate_compiled
from hcsearch.springs.deployment.spring_sets import springs_of
from hcsearch_bench.stability.processors import PLAIN, Processor, kernels_for
from tests.linkages import linkage_named

ASSEMBLIES = ("array-6r", "element-8r", "unit-i", "unit-ii")
FOLDINGS = ("hex:0122334550:1", "hex:0233545012:2", "square:0122230301:3", "square:0122333011:1", "kite:23203030:3")
WAYWARD = "array-6r"
"""Rounding decides how it goes on: where its start differs by 1e-16 it becomes flat, or rests half open."""


def _digest(value):
    """The digest of all numbers in nested tuples of arrays."""
    if isinstance(value, tuple):
        return "".join(map(_digest, value))
    return hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()


def digests():
    """Digests of what simulations begin with, and of how one ends."""
    found, default = {}, SCENES["default"]
    for name in (*ASSEMBLIES, *FOLDINGS):
        linkage = linkage_named(name)
        compiled = compile_scene(linkage, default, keep=frozenset({"stops"}))
        found[name] = _digest((compiled.start, *compiled.system.mechanism))
        if name in FOLDINGS:
            folding = Folding.from_notation(name)
            panel = default_panel(folding.circuit.grid.name)
            for springs in (*SPRING_SET_GRADES, *SPREAD_SPRING_SETS):
                found[f"{name}, {springs}"] = _digest(springs_of(folding, panel, compiled, springs))
    motion = simulate_compiled(compile_scene(linkage_named(WAYWARD), default), certified=False).motion
    return found | {"the motion": _digest((motion.times, motion.q, motion.v))}


@pytest.mark.parametrize("processor", [PLAIN, Processor("Prescott"), Processor("SkylakeX")], ids=str)
def test_simulations_have_the_same_bits_as_on_this_processor(processor):
    if not kernels_for(processor):
        processor = PLAIN  # this machine lacks the instructions of the other one
    command = "from tests.deployment.test_processors import digests; import json; print(json.dumps(digests()))"
    done = subprocess.run(
        [sys.executable, "-c", command],
        env=os.environ | processor.environment,
        cwd=Path(__file__).parents[2],
        check=True,
        capture_output=True,
        text=True,
    )
    assert json.loads(done.stdout) == digests()
