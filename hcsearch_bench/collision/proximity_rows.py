"""Distances in whole deployments: time of a pair, beside the dynamics of the same deployment and beside coal."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.motion.collision.distances import Proximity, proximal_distances
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.compiled_scene import compile_scene
from hcsearch.springs.deployment.simulated_deployment import simulate_compiled
from hcsearch_bench.collision.proofs import search, settle
from hcsearch_bench.peers import coal_distances
from hcsearch_bench.run.timing import Stopwatch, median_time
from hcsearch_bench.subjects.deployments import SCENE, assembly, design

DEPLOYMENTS = (
    "thesis-4x4",
    "hex:023224350400:4",
    "hex:023454401022:0",
    "hex:023344400120:0",
    "hex:023224534000:4",
    "hex:022244345010:3",
    "square:0121222323030001:5",
)
QUICK_DEPLOYMENTS = DEPLOYMENTS[:2]
FAR = 1e-9
"""Distances that differ by no more (m) agree."""


@dataclass(frozen=True)
class ProximityRow:
    """A deployment, and the distances at its states.

    pairs : of panels; facet_pairs : of their facets. dynamics_ms, distances_ms : the simulation, and all distances.
    others : see the table.
    """

    deployment: str
    outcome: str
    panels: int
    pairs: int
    facet_pairs: int
    states: int
    touch: float
    collide: float
    dynamics_ms: float
    distances_ms: float
    pair_us: float
    facet_us: float
    near_us: float
    coal_facet_us: float | None
    difference: float | None
    beyond: int | None
    ours: int | None
    theirs: int | None
    runs: int


def proximity_row(name: str, repeats: int) -> ProximityRow:
    """Deploy with uniform springs until flat or 1 s, and compute the distances of all pairs that no hinge joins."""
    linkage = design(name) if ":" in name else assembly(name)
    compiled = compile_scene(linkage, SCENE)
    deployment = simulate_compiled(compiled, certified=False)
    dynamics, _ = median_time(_watched(lambda: simulate_compiled(compiled, certified=False)), repeats)
    motion = deployment.motion
    times = np.append(np.linspace(motion.times[:-1], motion.times[1:], 3, endpoint=False).T.ravel(), motion.times[-1])
    states, _ = compiled.of_hinges(motion.at(times), np.zeros((len(times), motion.q.shape[1])))
    proximity = proximal_distances(linkage, states)
    seconds, runs = median_time(_watched(lambda: proximal_distances(linkage, states)), repeats)
    reach = linkage.pattern.thickness
    near, _ = median_time(_watched(lambda: proximal_distances(linkage, states, reach=reach)), repeats)
    facets = facet_pairs(linkage, proximity.pairs)
    size = proximity.gaps.size
    beside = dict.fromkeys(("coal_facet_us", "difference", "beyond", "ours", "theirs"))
    if coal_distances.installed():
        beside |= _beside_coal(linkage, states, proximity, facets, repeats)
    return ProximityRow(
        deployment=name,
        outcome=deployment.outcome,
        panels=linkage.n_panels,
        pairs=len(proximity.pairs),
        facet_pairs=len(facets),
        states=len(states),
        touch=float((proximity.gaps == 0.0).mean()),
        collide=float((proximity.gaps < 0.0).mean()),
        dynamics_ms=1e3 * dynamics,
        distances_ms=1e3 * seconds,
        pair_us=1e6 * seconds / size,
        facet_us=1e6 * seconds / (len(facets) * len(states)),
        near_us=1e6 * near / size,
        runs=runs,
        **beside,
    )


def _watched(call: Callable[[], object]) -> Callable[[], float]:
    """A call, as one that returns its processor seconds."""

    def run() -> float:
        watch = Stopwatch()
        with watch:
            call()
        return watch.cpu

    return run


def facet_pairs(linkage: Linkage, pairs: WholeNumbers) -> WholeNumbers:
    """The pairs of facets of pairs of panels, (q, 3): the facets, and the number of the pair of panels."""
    panels = np.array(linkage.pattern.panel_of)
    numbered = [
        (one, two, number)
        for number, (i, j) in enumerate(pairs)
        for one in np.flatnonzero(panels == i)
        for two in np.flatnonzero(panels == j)
    ]
    return np.array(numbered, np.int64)


def _beside_coal(
    linkage: Linkage, states: Reals, proximity: Proximity, facets: WholeNumbers, repeats: int
) -> dict[str, float | int]:
    """Its time of a pair of facets and state, how far its distances are from ours, and who is right."""
    solids = [solid.reshape(-1, 3) for solid in linkage.solids(linkage.flat)]
    panels = np.array(linkage.pattern.panel_of)
    poses = [linkage.poses(angles)[panels] for angles in states]
    scene = coal_distances.CoalScene(solids, facets[:, :2], moving=True)
    placed = [scene.coordinates(pose[:, :, :3], pose[:, :, 3]) for pose in poses]
    seconds, _ = median_time(lambda: scene.follow(placed), repeats)
    worst = 0.0
    hulls, ours, theirs = [], [], []
    for k, state in enumerate(placed):
        scene.follow([state])
        distances = scene.distances()
        least = np.full(len(proximity.pairs), np.inf)
        np.minimum.at(least, facets[:, 2], distances)
        apart = np.abs(least - proximity.distances[:, k])
        worst = max(worst, float(apart.max()))
        for p in np.flatnonzero(apart > FAR):
            # the facets that coal, or we, take for the nearest
            of_pair = np.flatnonzero(facets[:, 2] == p)
            now = [solid.reshape(-1, 3) for solid in linkage.solids(states[k])]
            gaps = [max(search(now[one], now[two])[0], 0.0) for one, two, _ in facets[of_pair]]
            q = int(np.argmin(gaps if min(gaps) < least[p] else distances[of_pair]))
            one, two, _ = facets[of_pair[q]]
            hulls.append((now[one], now[two]))
            ours.append(gaps[q])
            theirs.append(distances[of_pair[q]])
    right = settle(hulls, np.array(ours), np.array(theirs), linkage.pattern.size)
    return {"coal_facet_us": 1e6 * seconds / (len(facets) * len(states)), "difference": worst, **asdict(right)}
