"""Foldings and scenes drawn at random from stated ranges, by the number of a seed."""

from functools import cache

import numpy as np

from hcsearch.designs.folding import foldings
from hcsearch.designs.twisting import twist
from hcsearch.scenes import Scene
from hcsearch.search.enumeration import enumerate_circuits

SIZES = (("hex", 8), ("hex", 10), ("square", 8), ("square", 10), ("square", 12))
"""Grids and numbers of cells, drawn evenly; then one of their untwisted foldings, evenly."""
STIFFNESS, DAMPING_TIME, THICKNESS = (0.02, 0.5), (0.01, 0.1), (0.002, 0.008)
"""Ranges of the spring of each hinge (N m/rad), its damping over stiffness (s), drawn evenly on a logarithmic scale,
and the thickness of panels (m), drawn evenly."""
FRICTION, RESTITUTION, GRAVITY = 0.005, 0.6, 2.0
"""Greatest friction (N m), restitution and gravity (m/s^2, in any direction); each is 0 in half of the scenes."""
START = (1e-4, 1e-2)
"""Range of the distance of the start from the folded angles, as a share of them, on a logarithmic scale."""
SIDE = 0.05
"""Of panels, m."""


@cache
def untwisted_foldings(grid, n):
    """All untwisted foldings of n cells."""
    return [
        folding for circuit in enumerate_circuits(grid, n=n) for folding in foldings(circuit) if twist(folding) == 0
    ]


def random_scene(seed):
    """A linkage and a scene."""
    rng = np.random.default_rng(seed)
    grid, n = SIZES[rng.integers(len(SIZES))]
    several = untwisted_foldings(grid, n)
    folding = several[rng.integers(len(several))]

    def spread(low, high):
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    def sometimes(most):
        return float(rng.uniform(0.0, most)) if rng.random() < 0.5 else 0.0

    linkage = folding.linkage((SIDE, SIDE, float(rng.uniform(*THICKNESS))))
    direction = rng.normal(size=3)
    gravity = sometimes(GRAVITY) * direction / np.linalg.norm(direction)
    scene = Scene(
        f"random-{seed}",
        spring=f"linear:{spread(*STIFFNESS):.6g}",
        damping_time=spread(*DAMPING_TIME),
        friction=sometimes(FRICTION),
        restitution=sometimes(RESTITUTION),
        gravity=tuple(map(float, gravity)),
        start=1.0 - spread(*START),
    )
    return linkage, scene
