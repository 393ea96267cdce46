"""The bench `mobility`: its numbers are those of the stage, and its bounds hold."""

import numpy as np
import pytest
from scipy.optimize import linprog

from hcsearch.designs.folding import Folding
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.shape.linkage import Linkage
from hcsearch_bench.mobility.lock_rows import _ends, _play, measure_mobility


@pytest.fixture(scope="module")
def tables():
    return measure_mobility({"hex": (10,), "triangle": (14, 16)}, repeats=1, say=lambda _: None)


def test_rows_are_those_of_the_stage(tables):
    speed, locks, tight = tables
    assert [(row.grid, row.n, row.designs, row.foldings) for row in speed] == [
        ("hex", 10, 25, 40),
        ("triangle", 14, 2, 5),
    ]
    assert min(min(row.freedom_us, row.folding_us, row.stage_s) for row in speed) > 0
    hexagons, triangles = locks
    assert (hexagons.locked, hexagons.folded_1, hexagons.folded_2, hexagons.flat_1, hexagons.flat_2) == (14, 5, 4, 7, 2)
    assert (hexagons.hinged, hexagons.thin, hexagons.thick) == (2, 14, 14)
    assert (hexagons.exact, hexagons.hair) == ("18 of 18", 1)
    assert hexagons.gives == pytest.approx(0.0345, rel=0.05)
    assert {row.pairs: row.proof for row in tight} == {"rigid": "exact", "hinged": "exact"}
    assert len(tight) == 21
    assert hexagons.held == sum(row.closed is None for row in tight[:20] if row.pairs == "rigid")
    assert (triangles.locked, triangles.merged) == (1, "1 -> 1 of 1")


def test_play_bounds_what_a_gap_at_the_stops_lets_a_hinge_turn():
    folding = Folding.from_notation("hex:0234550132:3")
    panel = default_panel("hex")
    play = _play(folding, panel, ("folded", _ends(folding, panel)["folded"]))
    linkage = Linkage(folding.pattern(panel))
    _, jacobian = linkage.closure(linkage.folded)
    turns = []
    for hinge in range(linkage.n_hinges):
        result = linprog(-np.eye(linkage.n_hinges)[hinge], A_eq=jacobian, b_eq=np.zeros(6), bounds=(-1.0, None))
        turns.append(-result.fun)
    assert 0 < max(turns) <= play * (1 + 1e-9)
