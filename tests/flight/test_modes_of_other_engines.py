"""First frequencies of flat arrays on latches against those of MuJoCo and Exudyn: never above them."""

from itertools import islice

import numpy as np
import pytest

from hcsearch.designs.folding import folding_at
from hcsearch_bench.peers import exudyn_system, mujoco_system
from hcsearch_bench.subjects.foldings import search_of, untwisted
from tests.flight.vibrating import closed_states_near_flat, coordinates, latched_system, own_frequencies

pytestmark = pytest.mark.extra

DESIGNS = [("hex", "12", 36), ("square", "12", 14)]
DISTANCE = 1e-5


def foldings(grid, cells, count):
    batches = untwisted(search_of(grid, cells))
    return islice((folding_at(circuits, batch, i) for circuits, batch in batches for i in range(len(batch))), count)


@pytest.mark.parametrize(("grid", "cells", "count"), DESIGNS)
def test_first_frequencies_of_fifty_designs_are_never_above_those_of_others(grid, cells, count):
    shares = []
    for folding in foldings(grid, cells, count):
        compiled, system = latched_system(folding.linkage(flat_pairs="rigid"))
        own, flat = own_frequencies(compiled), np.zeros(system.n_joints)
        for engine in (mujoco_system, exudyn_system):
            assert engine.frequencies(system, flat) == pytest.approx(own, rel=1e-10)
        # beside the flat state fewer rates close the loops, and belong to true motions
        beside = []
        for angles in closed_states_near_flat(compiled.linkage, 3, DISTANCE):
            theirs = mujoco_system.frequencies(system, coordinates(compiled, angles))
            assert len(theirs) < len(own)
            beside.append(theirs[0] / own[0])
        shares.append(min(beside))
    assert len(shares) == count
    assert min(shares) >= 1.0 - 10.0 * DISTANCE
    assert np.median(shares) <= 1.1
