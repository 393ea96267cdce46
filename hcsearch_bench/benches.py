"""All benches there are, none of which loads what it measures before it runs."""

from __future__ import annotations

from typing import Any

from hcsearch_bench.collision.collision import COLLISION
from hcsearch_bench.deployability.deployability import DEPLOYABILITY
from hcsearch_bench.dynamics.dynamics import DYNAMICS
from hcsearch_bench.enumeration.enumeration import ENUMERATION
from hcsearch_bench.experiment.experiment import EXPERIMENT
from hcsearch_bench.flight.flight import FLIGHT
from hcsearch_bench.folding import FOLDING
from hcsearch_bench.identification.identification import IDENTIFICATION
from hcsearch_bench.iftomm.iftomm import IFTOMM
from hcsearch_bench.kinematics.kinematics import KINEMATICS
from hcsearch_bench.mobility.mobility import MOBILITY
from hcsearch_bench.planning.planning import PLANNING
from hcsearch_bench.run.bench import Bench
from hcsearch_bench.scale.scale import SCALE
from hcsearch_bench.stability.stability import STABILITY
from hcsearch_bench.tables.tables import TABLES

BENCHES: dict[str, Bench[Any]] = {
    bench.name: bench
    for bench in (
        ENUMERATION,
        FOLDING,
        SCALE,
        KINEMATICS,
        MOBILITY,
        IFTOMM,
        DYNAMICS,
        COLLISION,
        STABILITY,
        PLANNING,
        EXPERIMENT,
        IDENTIFICATION,
        TABLES,
        DEPLOYABILITY,
        FLIGHT,
    )
}
