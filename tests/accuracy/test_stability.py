"""Stability: judgements follow from errors, swept values are those of scenes, and the map shows the user's point."""

import json
import math
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hcsearch import stability
from hcsearch.basics.errors import HcsearchError
from hcsearch.scenes import Scene
from hcsearch.scenes.setup import setup_of_scene
from hcsearch.springs.accuracy.stability_points import (
    ACCURATE_TOLERANCES,
    ANGLE_FLOOR,
    BOUND_FACTOR,
    all_finite,
    distance_from,
    judge_deployment,
    judged_point,
    stress_cases,
    sweep_cases,
)
from hcsearch.springs.accuracy.swept_values import SWEPT_VALUES, ScenePoint, resized_linkage, sweep_points
from hcsearch.springs.deployment.compiled_scene import compile_scene
from hcsearch.springs.deployment.simulated_deployment import simulate_compiled
from hcsearch_bench.stability.strips import StabilitySubject
from tests.accuracy.subjects import FOLDING, linkage_named
from tests.commands import run_here, without_progress

PAIR = StabilitySubject("strip").linkage
TOLERANCE = 1e-6
ALLOWED = ACCURATE_TOLERANCES * TOLERANCE + ANGLE_FLOOR


def point_of(name=FOLDING, **values):
    linkage = linkage_named(name)
    return ScenePoint(linkage, setup_of_scene(Scene(**values), linkage))


@pytest.fixture(scope="module")
def opened():
    return simulate_compiled(compile_scene(PAIR, Scene()), tolerance=TOLERANCE, certified=False)


@given(error=st.floats(0.0, 1.0), rough=st.none() | st.floats(0.0, 1.0))
def test_judgements_follow_from_the_error_and_its_bound(opened, error, rough):
    judged = judge_deployment(opened, TOLERANCE, error, lambda: rough)
    if error <= ALLOWED:
        assert judged.judgement == "accurate"
    elif rough is not None and error <= ALLOWED + BOUND_FACTOR * rough:
        assert judged.judgement == "degraded"
        assert judged.bound >= error
    else:
        assert judged.judgement == "wrong"


def test_without_a_truth_nothing_is_wrong(opened):
    assert judge_deployment(opened, TOLERANCE, None, lambda: None)[::3] == ("degraded", math.pi)
    assert judge_deployment(opened, TOLERANCE, None, lambda: 0.5).bound == pytest.approx(ALLOWED + 0.5 * BOUND_FACTOR)


def test_what_has_no_answer_is_refused_and_numbers_that_are_not_finite_are_wrong(opened):
    early = replace(opened, outcome="out of steps")
    assert judge_deployment(early, TOLERANCE, 0.0, lambda: 0.0).judgement == "refused"
    broken = replace(opened, angles=np.full_like(opened.angles, np.nan))
    assert not all_finite(broken)
    assert judge_deployment(broken, TOLERANCE, 0.0, lambda: 0.0).judgement == "wrong"


def test_distances_are_those_of_angles():
    compiled = compile_scene(PAIR, Scene(seconds=0.01))
    fine, rough = (simulate_compiled(compiled, tolerance=at, certified=False) for at in (1e-10, 1e-3))
    times = fine.motion.times
    brute = np.abs(fine.angles - rough.angles_at(times)).max()
    assert distance_from(fine, rough) == pytest.approx(brute, rel=1e-6)


def test_swept_values_are_those_of_the_scene():
    point = point_of()
    assert SWEPT_VALUES["damping"].own(point) == pytest.approx(0.0043)
    assert SWEPT_VALUES["thickness"].own(point) == pytest.approx(6.0)
    assert SWEPT_VALUES["density"].own(point) == 547.0
    damped = SWEPT_VALUES["damping"].changed(point, 0.1)
    assert set(damped.setup.dampings) == {0.1}
    assert damped.setup.seconds == pytest.approx(point.setup.seconds * 0.1 / 0.0043, rel=0.01)
    stiff = SWEPT_VALUES["stiffness"].changed(point, 4.0)
    assert [law.mean_stiffness for law in stiff.setup.laws] == pytest.approx([0.4] * 8)
    rough = SWEPT_VALUES["friction"].changed(point, 0.01)
    assert set(rough.setup.resistance) == {0.01}
    assert SWEPT_VALUES["density"].changed(point, 100.0).setup.density == 100.0


@given(st.floats(1.0, 1e6))
def test_a_spread_is_the_ratio_of_the_stiffest_spring_to_the_softest(ratio):
    point = point_of()
    stiffnesses = [law.mean_stiffness for law in SWEPT_VALUES["spread"].changed(point, ratio).setup.laws]
    assert max(stiffnesses) / min(stiffnesses) == pytest.approx(ratio, rel=1e-6)
    assert np.exp(np.mean(np.log(stiffnesses))) == pytest.approx(0.1, rel=1e-6)


def test_a_resized_folding_is_the_folding_of_other_panels():
    from hcsearch.designs.folding import Folding

    ours = resized_linkage(linkage_named(FOLDING), 2.0, 0.004)
    theirs = Folding.from_notation(FOLDING).linkage((0.1, 0.1, 0.004))
    assert np.allclose(ours.pattern.vertices, theirs.pattern.vertices)
    assert np.allclose(ours.points, theirs.points)
    assert ours.pattern.thickness == theirs.pattern.thickness
    point = point_of()
    larger = SWEPT_VALUES["size"].changed(point, 2.0)
    assert larger.setup.margin == pytest.approx(2.0 * point.setup.margin)


@given(st.floats(1e-6, 1e3), st.floats(1.5, 1e9), st.floats(1e-6, 1e6))
def test_a_sweep_has_its_ends_and_the_own_value(low, ratio, own):
    values = sweep_points(low, low * ratio, own, per_decade=2.0, most=13)
    assert values == sorted(values)
    assert own in values or any(math.isclose(own, value, rel_tol=1e-9) for value in values)
    others = [value for value in values if value != own] if own not in (low, low * ratio) else values
    assert 3 <= len(values) <= 14
    assert min(others) == pytest.approx(low, rel=6e-3) or own in values
    assert max(others) == pytest.approx(low * ratio, rel=6e-3) or own in values


def test_two_values_make_a_grid_with_one_own_point():
    cases = sweep_cases(point_of(), {"damping": (1e-3, 1.0), "thickness": (1.0, 10.0)}, "constrained")
    assert len(cases) == 5 * 4
    (own,) = [case for case in cases if case.own]
    assert own.values == (pytest.approx(0.0043), pytest.approx(6.0))
    assert own.point == point_of()


@pytest.mark.parametrize(
    ("ranges", "message"),
    [
        ({}, "one value or of two"),
        ({"damping": (1, 2), "size": (1, 2), "density": (1, 2)}, "one value or of two"),
        ({"colour": (1, 2)}, "cannot be swept: choose from damping"),
        ({"damping": (0.0, 1.0)}, "positive value"),
        ({"damping": (2.0, 1.0)}, "greater one"),
        ({"spread": (0.1, 10.0)}, "stiffest is at least"),
    ],
)
def test_sweeps_that_cannot_be_are_refused(ranges, message):
    with pytest.raises(HcsearchError, match=message):
        sweep_cases(point_of(), ranges, "constrained")


def test_the_standard_set_has_all_values_and_extremes():
    labels = [case.label for case in stress_cases(point_of(), "constrained")]
    assert labels[0] == "as it is"
    for name in ("damping", "stiffness", "thickness", "density", "size"):
        assert {f"{name} x 10", f"{name} / 10"} <= set(labels)
    assert {"start 0.999999", "redundant closure", "stiff stops", "clashing stops"} <= set(labels)
    assert "friction x 10" not in labels  # the scene has none
    assert "friction x 10" in [case.label for case in stress_cases(point_of(friction=0.001), "constrained")]


def test_scenes_are_accurate_however_stiff_they_are():
    cases = {case.label: case for case in sweep_cases(point_of(), {"damping": (1e-3, 10.0)}, "constrained")}
    for case in (next(case for case in cases.values() if case.own), cases["damping 10"]):
        judged = judged_point(case, TOLERANCE, 1.0)
        assert judged.judgement == "accurate", judged
        assert judged.error < ALLOWED


def test_what_runs_out_of_time_is_refused_with_the_reason():
    case = next(case for case in stress_cases(point_of(), "constrained") if case.label == "stiff stops")
    judged = judged_point(case, TOLERANCE, 0.01)
    assert judged.judgement == "refused"
    assert judged.reason == "takes more than 0.01 s: allow it more time"


def test_extremes_are_not_wrong():
    for case in stress_cases(point_of(seconds=0.05), "constrained"):
        if case.label in {"redundant closure", "clashing stops"}:
            assert judged_point(case, TOLERANCE, 0.5).judgement in {"accurate", "degraded"}


def test_a_start_at_the_singular_packed_state_that_the_tolerance_does_not_resolve_is_wrong():
    case = next(case for case in stress_cases(point_of(seconds=0.05), "constrained") if case.label == "start 0.999999")
    judged = judged_point(case, TOLERANCE, 0.5)
    assert judged.error > 0.01  # the start is 3e-6 rad from packed, and each step may be off by a third of that
    assert judged.judgement == "wrong"


def test_scenes_that_cannot_start_are_refused_with_the_reason():
    case = sweep_cases(point_of("hex:0234451512:0"), {"density": (100.0, 1000.0)}, "constrained")[0]
    setup = replace(case.point.setup, start=0.5)
    judged = judged_point(replace(case, point=replace(case.point, setup=setup)), TOLERANCE, 0.5)
    assert judged.judgement == "refused"
    assert "no closed state" in judged.reason


def test_the_command_prints_a_table_and_draws_a_map(capfd, tmp_path):
    table, picture = tmp_path / "points.csv", tmp_path / "map.svg"
    sweep = ("--sweep", "density=300..900", "--limit", "0.5")
    done = run_here(("accuracy", FOLDING, *sweep, "--output", str(table), "--picture", str(picture)), capfd)
    assert done.returncode == 0
    lines = done.stdout.splitlines()
    assert sum(line.startswith("> density 547 ") for line in lines) == 1
    assert lines[-1] == "4 accurate, 0 degraded, 0 refused, 0 wrong"
    assert len(pd.read_csv(table)) == 4
    assert picture.read_text(encoding="utf-8").count("<path") > 10
    facts = json.loads(run_here(("accuracy", FOLDING, *sweep, "--json"), capfd).stdout)
    assert facts["swept"] == [{"name": "density", "unit": "kg/m^3"}]
    assert [point["own"] for point in facts["points"]].count(True) == 1


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--sweep", "damping"), "cannot read 'damping'"),
        (("--sweep", "damping=1..x"), "cannot read"),
        (("--sweep", "damping=1..2", "--sweep", "damping=3..4"), "twice"),
        (("--sweep", "damping=1..2", "--stress"), "either --sweep or --stress"),
        (("--stress", "--error", "1e-3"), "--error is for a table"),
        (("--sweep", "mass=1..2"), "cannot be swept"),
    ],
)
def test_wrong_sweeps_are_one_line(words, said, capfd):
    done = run_here(("accuracy", FOLDING, *words), capfd)
    assert done.returncode == 2
    lines = without_progress(done.stderr).splitlines()
    assert len(lines) == 1
    assert said in lines[0]


def test_the_function_wants_two_numbers():
    with pytest.raises(HcsearchError, match="least and the greatest"):
        stability(FOLDING, sweep={"damping": (1.0, 2.0, 3.0)})
