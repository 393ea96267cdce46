"""Proofs of large arrays and of thin panels: comb circuits, and margins that are bounded by the thickness."""

import pytest

from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, foldings
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.designs.twisting import twist
from hcsearch.motion.collision.panel_prisms import margin_of
from hcsearch.motion.planning.motion_search import plan_motion
from hcsearch.motion.planning.path_proofs import CERTIFIED_MARGINS, Prover
from hcsearch.motion.planning.planner import Planner
from hcsearch.motion.searching import Budget


def comb(width, height):
    """The circuit along one row of a rectangle of squares and back by columns, an even number of them."""
    cells = [(x, 0) for x in range(width)]
    for x in range(width)[::-1]:
        column = [(x, y) for y in range(1, height)]
        cells += column if (width - x) % 2 else column[::-1]
    steps = {(1, 0): "0", (0, 1): "1", (-1, 0): "2", (0, -1): "3"}
    follow = zip(cells, [*cells[1:], cells[0]], strict=True)
    word = "".join(steps[b[0] - a[0], b[1] - a[1]] for a, b in follow)
    return Circuit.from_notation(f"square:{word}").canonical()


@pytest.mark.parametrize(
    ("width", "height"),
    [(6, 6), (10, 8), pytest.param(12, 10, marks=pytest.mark.slow), pytest.param(16, 12, marks=pytest.mark.slow)],
)
def test_combs_are_proved(width, height):
    folding = next(own for own in foldings(comb(width, height)) if not twist(own))
    linkage = folding.linkage(default_panel("square"), flat_pairs="hinged")
    states = Planner(linkage, CERTIFIED_MARGINS[0]).plan(Budget(60)).states
    proof = Prover(linkage).prove(states, CERTIFIED_MARGINS)
    assert proof.margin is not None
    assert proof.margin <= CERTIFIED_MARGINS[-1]
    assert proof.exact
    assert proof.end_distances == (0.0, 0.0)


@pytest.mark.parametrize("thickness", [0.05e-3, 0.5e-3, 2e-3, 6e-3, 25e-3])
def test_the_default_margin_leaves_something_of_panels_of_any_thickness(thickness):
    edge, width, _ = default_panel("square")
    folding = Folding.from_notation("square:012233230011:4")
    linkage = folding.linkage((edge, width, thickness), flat_pairs="rigid")
    assert margin_of(linkage) == min(1e-4, 0.2 * thickness)
    motion = plan_motion(folding, (edge, width, thickness), ("rigid",))
    assert motion.margin is not None
    assert motion.margin <= margin_of(linkage)


def test_closed_states_may_wander_in_proportion_to_the_margin():
    prover = Prover(Folding.from_notation("hex:0234550132:4").linkage(default_panel("hex"), flat_pairs="hinged"))
    assert prover.limit(1e-4) == pytest.approx(10 * prover.limit(1e-5))
