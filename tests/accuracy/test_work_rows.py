"""Errors of deployments beside references: closed forms, orders of methods, refusals, and the reports."""

import math
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import INTEGRATORS
from hcsearch.scenes import Scene
from hcsearch.scenes.setup import setup_of_scene
from hcsearch.springs.accuracy.measured_accuracy import reference_sentence, work_table
from hcsearch.springs.accuracy.reference_motions import reference_motion
from hcsearch.springs.accuracy.work_rows import Repeats, median_of_runs, processor_seconds, work_of_formulations
from hcsearch.springs.deployment.compiled_scene import compile_scene
from hcsearch.springs.deployment.simulated_deployment import simulate_compiled
from hcsearch.system.outputs import write_table
from hcsearch_bench.stability.strips import StabilitySubject
from hcsearch_bench.stability.sweeps import two_panels
from tests.accuracy.subjects import FOLDING, linkage_named

PAIR = StabilitySubject("strip").linkage
OPENING = Scene(restitution=0.0, seconds=0.012, damping=0.0)
"""Two panels, which do not come to a stop in this time."""


def pair_errors(tolerance, method="dormand-prince"):
    """The error by the references, and by the closed form of two panels at many times inside the steps."""
    compiled = compile_scene(PAIR, OPENING)
    reference = reference_motion(compiled, compiled, end=OPENING.seconds, seconds=2.0)
    deployment = simulate_compiled(compiled, method=method, tolerance=tolerance, certified=False)
    times = np.linspace(0.0, OPENING.seconds, 5000)
    exact = two_panels(OPENING).angles(times)
    return reference, reference.angle_error(deployment), np.abs(deployment.angles_at(times)[:, 0] - exact).max()


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-7, 1e-9])
def test_errors_are_those_of_the_closed_form(tolerance):
    reference, error, exact = pair_errors(tolerance)
    assert reference.angle_doubt < 1e-10
    assert error == pytest.approx(exact, rel=0.05, abs=2e-12)


def test_a_reference_without_a_second_one_has_no_doubt_and_does_not_confirm_a_flat_time():
    compiled = compile_scene(PAIR, OPENING)
    alone = reference_motion(compiled, compiled, end=OPENING.seconds, seconds=2.0, independent=False)
    assert alone.angle_doubt is None
    assert alone.flat_time is None


@pytest.fixture(scope="module")
def works():
    linkage = linkage_named(FOLDING)
    setup = setup_of_scene(Scene(), linkage)
    formulations = ("constrained", "quasistatic")
    return list(work_of_formulations(linkage, setup, formulations, tolerances=(1e-3, 1e-5, 1e-7), seconds=2.0))


def test_errors_fall_with_the_tolerance(works):
    for work in works:
        for method in {row.method for row in work.rows}:
            errors = [row.angle_error for row in work.rows if row.method == method]
            assert len(errors) == 3
            assert errors[0] > errors[2] > 0.0, (work.formulation, method, errors)
            assert all(row.seconds > 0.0 for row in work.rows)


def test_references_agree_and_the_default_is_marked(works):
    constrained = works[0]
    assert constrained.suffices
    assert constrained.reference.angle_doubt < 1e-9
    assert constrained.reference.parting is None
    assert constrained.reference.flat_time == pytest.approx(0.140986734886, abs=1e-11)
    assert "agrees to" in reference_sentence(constrained)
    compiled = constrained.reference.first.deployment.compiled
    usual = work_of_formulations(compiled.linkage, compiled.setup, ("constrained",), tolerances=(1e-6,))
    rows = next(usual).rows
    assert [row.method for row in rows if row.default] == ["dormand-prince"]


def test_the_model_of_another_formulation_is_no_error_of_its_own(works):
    quasistatic = works[1]
    assert quasistatic.model_angle > 0.1  # without inertia the array moves otherwise
    best = min(row.angle_error for row in quasistatic.rows)
    assert best < 1e-5


def test_the_cheapest_setting_has_the_wanted_error(works):
    constrained = works[0]
    row = constrained.cheapest(1e-4)
    assert row.angle_error <= 1e-4
    assert all(row.seconds <= other.seconds for other in constrained.rows if other.angle_error <= 1e-4)
    assert constrained.cheapest(1e-15) is None
    assert row.options == f"--formulation constrained --method {row.method} --tolerance {row.tolerance:.0e}".replace(
        "e-0", "e-"
    )


def test_a_table_has_a_row_a_simulation(works):
    table = work_table(works)
    assert len(table) == sum(len(work.rows) for work in works) == 2 * 3 * len(INTEGRATORS)
    assert table["angle_error_rad"].max() < math.pi


@pytest.mark.parametrize("ending", [".csv", ".npz"])
def test_tables_are_written_without_any_number_in_a_column(works, tmp_path, ending):
    rows = [replace(row, time_error=None) for row in works[0].rows]
    path = tmp_path / f"work{ending}"
    write_table(path, work_table([replace(works[0], rows=tuple(rows))]))
    read = pd.read_csv(path) if ending == ".csv" else dict(np.load(path, allow_pickle=False))
    assert np.isnan(read["time_error_s"]).all()
    assert list(read["method"][:3]) == ["bogacki-shampine"] * 3


def test_formulations_that_do_not_apply_say_why():
    setup = setup_of_scene(Scene(damping=0.0), PAIR)
    named = {work.formulation: work for work in work_of_formulations(PAIR, setup, ("penalty", "quasistatic"))}
    assert "no loops" in named["penalty"].refusal
    assert "damp" in named["quasistatic"].refusal
    assert not named["penalty"].rows
    assert named["quasistatic"].cheapest(1.0) is None


def test_simulations_that_would_take_too_long_are_not_tried():
    linkage = linkage_named(FOLDING)
    setup = setup_of_scene(Scene(), linkage)
    work = next(iter(work_of_formulations(linkage, setup, ("constrained",), tolerances=(1e-3, 1e-9), seconds=1e-4)))
    untried = [row for row in work.rows if row.outcome is None]
    assert 1e-9 in {row.tolerance for row in untried}
    assert all("would take more than 0.0001 s" in row.note and row.angle_error is None for row in untried)


def test_short_runs_are_repeated_more_often():
    assert processor_seconds(lambda: 7)[0] == 7
    assert processor_seconds(lambda: 7)[2] == 15
    repeats = Repeats(usual=2, short=5, short_seconds=0.1, enough_seconds=3.0)
    assert median_of_runs(lambda: 0.05, repeats) == (0.05, 5)
    assert median_of_runs(lambda: 0.5, repeats) == (0.5, 2)
    assert median_of_runs(lambda: 4.0, repeats) == (4.0, 1)


def test_where_nothing_moves_there_is_no_reference():
    compiled = compile_scene(PAIR, OPENING)
    with pytest.raises(HcsearchError, match="out of range"):
        simulate_compiled(compiled, tolerance=1.0)
