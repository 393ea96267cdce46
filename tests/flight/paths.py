"""Paths of samples as arrays, with springs: shared by tests of margins along paths."""

from functools import cache

import numpy as np

from hcsearch.scenes.laws import linear_law
from hcsearch.springs.dynamics.law_torques import law_torques
from hcsearch.springs.flight.path_margins import path_rates
from tests.planned import planned

NAMES = ("hex:0234550132:4", "square:012233230011:4")


@cache
def rates_of(name):
    """The rates along the path of a sample."""
    sample = planned(name)
    return path_rates(sample.linkage, sample.states)


def springs_of(name, preload=0.05, seed=0):
    """Laws, torques at the states of the path, and friction, all different between hinges."""
    path, rng = rates_of(name), np.random.default_rng(seed)
    laws = [
        linear_law(0.1 * (1.0 + x), preload * (1.0 + y)) for x, y in rng.uniform(0.0, 1.0, (path.linkage.n_hinges, 2))
    ]
    return laws, law_torques(laws, path.angles), rng.uniform(0.005, 0.02, path.linkage.n_hinges)
