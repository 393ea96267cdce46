"""States at which rounding decides what stops allow: margins and bounds that contradict each other are not known."""

import numpy as np
import pytest

from hcsearch.designs.folding import Folding
from hcsearch.scenes.laws import law_named
from hcsearch.springs.dynamics.law_torques import law_torques
from hcsearch.springs.flight.torque_margin import (
    KNOWN_MARGIN_TOLERANCE,
    allowed_senses,
    closed_rates,
    torque_margins,
    torque_margins_failed,
)

# Two states of simulated deployments of 5x4 squares (as in test_margin_figures.py), by crease, at which rates that pass
# stops by 1e-10 of the fastest have up to 1.9 times the bound that wrenches prove; HiGHS finds either; 2026-11-29.
STATES = {
    0: "0.1381104811217377 0 0.0001001822893028297 1.15258882722393 0 1.0957395408178532 0 0.07995738275437567 "
    "0.07995738305509104 1.2108063336642425 0 0.31956510080177974 1.0744859381312194e-05 0 0.5584745774761919 0 "
    "1.0522221666034202 0 0.7547187668120346 0",
    4: "0.21428139625281648 4.60472213070503e-11 3.607528089495231e-05 0.00033373673237901996 0.0003503103414366904 "
    "5.31251722511299e-05 0 4.604720594090566e-11 0 0.00037905529281718087 0.004307971487251883 0.0075361849277190175 "
    "0.00025435207955591617 0 0.21571137024346665 0.012871003706356004 0.004584059773745585 0 0 0.0035045295705281214",
}


@pytest.mark.parametrize("crease", STATES)
def test_margins_above_their_bounds_are_not_known(crease):
    linkage = Folding.from_notation(f"square:01222233300001222100:{crease}").linkage("300x300x12", flat_pairs="hinged")
    state = np.array([[float(angle) for angle in STATES[crease].split()]])
    rates = closed_rates(np.array([linkage.closure(state[0])[1]]))
    torques, friction = law_torques([law_named("linear:0.5+0.1")] * 20, state), np.full(20, 0.03)
    cases = np.vstack([torques, torques * (1.0 - np.eye(20))])
    found = torque_margins(rates.take(np.zeros(21, int)), cases, friction, np.repeat(allowed_senses(state), 21, axis=0))
    assert (found.margins <= found.bounds).all()
    scale = np.maximum(found.bounds, cases.max(axis=1) / 0.03)
    assert (found.known == (found.bounds - found.margins <= KNOWN_MARGIN_TOLERANCE * scale)).all()
    assert not found.known.all()
    whole = torque_margins(rates, torques, friction, allowed_senses(state))
    failed = torque_margins_failed(rates, torques, friction, allowed_senses(state), whole)
    assert failed.margins[0] <= failed.bounds[0]
    assert failed.margins[0] <= found.margins[1:][torques[0] != 0.0].min() + 1e-3
