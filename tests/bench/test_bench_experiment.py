"""The bench `experiment`: its claims are those of its tables, and its rows of tunings say how these came out."""

from dataclasses import replace

from hcsearch.springs.deployment.outcomes import DeploymentCheck
from hcsearch.springs.tuning.choice import SpringSet
from hcsearch.springs.tuning.robustness import Robustness
from hcsearch_bench.experiment.experiment_rows import TunedRow, UniformRow, _row, claims

HIT = UniformRow("none", 0, "constrained", "moving", 1.0, "collides", 0.166, "0 and 7")
TUNED = TunedRow("none", 0, "tuned", "0.1 0.2", "flat, certified clear", 0.5, "3 of 64", "1% to 13%", 50.0)
GOOD = DeploymentCheck("flat", 0.4, True, None, 1e-3, 0.0, 0.001, 0.001, 0.01, 1e-6, 1e-7, 100, 1000, 500)


def test_claims_are_counted_from_the_rows():
    uniform = [
        HIT,
        replace(HIT, collision_s=0.2, panels="2 and 7"),
        replace(HIT, clearance="clear", collision_s=None, panels=""),
        replace(HIT, held=5, collision_s=0.01),
    ]
    tuned = [TUNED, replace(TUNED, gravity="+x", verdict="collides"), replace(TUNED, springs="catalogue")]
    here = {claim.thesis: claim.here for claim in claims(uniform, tuned)}
    assert here["equal springs collide"] == "in 2 of 3 simulations with panel 0 held"
    assert here["at 0.30 s, by eye from a film"] == "0.166 to 0.2 s"
    assert here["the large middle panel, with the back of the top one"] == "panels 0 and 7; 2 and 7"
    assert here["tuned springs do not"] == "certified clear for 1 of 2 gravities: none"
    assert here["catalogue springs do not"] == "certified clear for 1 of 1 gravities: none"


def test_a_set_has_its_verdict_and_its_chance():
    row = _row("none", "tuned", SpringSet((0.1,) * 12, GOOD, robustness=Robustness(64, 3, 5)), 10.0)
    assert (row.verdict, row.flat_s) == ("not certified", None)
    assert (row.collides, row.chance) == ("3 of 64", "1% to 13%")
    assert row.stiffness == " ".join(["0.1"] * 7)
    hit = replace(GOOD, clear=False, collision=(0.1, (0, 7)))
    assert _row("none", "start", SpringSet((0.1,) * 12, hit), 10.0).verdict == "collides"
