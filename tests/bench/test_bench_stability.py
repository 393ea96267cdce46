import json
import math
import os
import signal
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from hcsearch.basics.errors import HcsearchError
from hcsearch.cli import hcsearch
from hcsearch.springs.accuracy.stability_points import JUDGEMENTS, judged_states
from hcsearch.springs.accuracy.stability_report import JUDGEMENT_COLOURS
from hcsearch.springs.dynamics.panels import panel_bodies
from hcsearch_bench.run.process import Finished
from hcsearch_bench.stability import heat_map, judging, processors
from hcsearch_bench.stability.heat_map import plot_heat
from hcsearch_bench.stability.judging import StabilityRow, judge, simulated, tally
from hcsearch_bench.stability.processors import (
    OWN,
    PLAIN,
    Processor,
    compared,
    kernels,
    kernels_for,
    measure_processors,
)
from hcsearch_bench.stability.strips import SIDE, THICK, StabilitySubject
from hcsearch_bench.stability.sweeps import (
    SCENE,
    STIFFNESS,
    SweepCase,
    cases,
    hinge_inertia,
    panel_mass,
    ring_truth,
    spring,
    strip_truth,
    two_panels,
)
from hcsearch_bench.stability.truths import Oscillator, Strip, Truth, energy_of_impacts, finer

SWEEPS = {
    *("stiffness ratio", "closure stiffness", "damping / critical", "thickness / width", "base mass / panel mass"),
    *("panels", "start / folded", "singular start", "tolerance", "restitution"),
}
TIMES = np.linspace(0.0, 0.04, 400)


@pytest.mark.parametrize("damping", [0.0, 0.01, 2.0, 2.0 + 1e-12, 5.0, 1e9])
def test_an_oscillator_keeps_its_equation(damping):
    swing = Oscillator(1.0, damping, 1.0, 0.5, 2.0)
    times = np.linspace(0.0, 5.0, 2001)
    angles, h = swing.angles(times), times[1]
    assert angles[0] == 2.0
    speeds, bends = (angles[2:] - angles[:-2]) / (2 * h), (angles[2:] - 2 * angles[1:-1] + angles[:-2]) / h**2
    assert np.abs(bends + damping * speeds + (angles[1:-1] - 0.5)).max() < 1e-4 * (1 + damping)
    assert abs(angles[1] - 2.0 + 0.75 * h**2) < 1e-5


@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
def test_bounces_keep_their_law(restitution):
    swing = Oscillator(1.0, 0.0, 1.0, 5.0, 2.0)
    times = np.linspace(0.0, 20.0, 200_001)
    angles = swing.bounces(3.0, restitution, times)
    assert angles.max() <= 3.0 + 1e-12
    speeds = np.diff(angles) / times[1]
    turns = np.flatnonzero((speeds[:-1] > 1e-2) & (speeds[1:] < 0.0))
    if restitution == 0.0:
        assert len(turns) == 0
        assert (angles[times > math.acos(2 / 3) + 1e-3] == 3.0).all()
    for k in turns:
        if speeds[k - 2] > 0.1:  # one point lies between both speeds
            assert -speeds[k + 2] == pytest.approx(restitution * speeds[k - 2], abs=2e-3)
    if restitution == 1.0:
        assert len(turns) > 5


def test_a_strip_of_two_panels_is_an_oscillator():
    scene = replace(SCENE, seconds=0.04)
    truth = two_panels(scene)
    strip = Strip(
        *(2, SIDE, THICK * SIDE, scene.density, np.array([STIFFNESS]), np.zeros(1), np.array([truth.damping]))
    )
    assert np.abs(strip.angles(np.array([truth.start]), TIMES)[:, 0] - truth.angles(TIMES)).max() < 1e-10
    body = panel_bodies(StabilitySubject("strip").linkage, scene.density)[1]
    assert body.mass == pytest.approx(panel_mass(scene))
    hinge = np.array([SIDE, 0.0, THICK * SIDE])
    assert body.about(hinge)[1, 1] == pytest.approx(hinge_inertia(scene))


def test_a_strip_keeps_its_energy_and_a_heavy_base_holds_it():
    n = 4
    springs, none = np.full(n - 1, STIFFNESS), np.zeros(n - 1)
    free = Strip(n, SIDE, THICK * SIDE, 547.0, springs, none, none, base=(1e6, 1e6))
    held = replace(free, base=None)
    start = np.array([1.0, 1.5, 2.0])
    assert np.abs(free.angles(start, TIMES) - held.angles(start, TIMES)).max() < 1e-6
    light = replace(free, base=(0.0, 0.0))
    assert np.abs(light.angles(start, TIMES) - held.angles(start, TIMES)).max() > 0.1
    rigid, stiff = (
        replace(held, rigid=1),
        replace(held, stiffness=springs * np.array([1, 1e4, 1]), rest=start * [0, 1, 0]),
    )
    times = TIMES[:100]
    away = np.abs(rigid.angles(start, times) - stiff.angles(start, times)).max()
    assert 1e-5 < away < 1e-2
    assert np.ptp(rigid.angles(start, times)[:, 1]) < 1e-12


@pytest.mark.parametrize("held", ["bottom", "free"])
def test_the_engine_moves_a_strip_as_its_own_equations_do(held):
    mass = panel_mass(SCENE)
    scene = replace(SCENE, seconds=0.02, held=held, base_mass=mass, base_inertia=(0.0, 1e-5, 0.0))
    row = judge(SweepCase("panels", 3, StabilitySubject("strip", 3), scene, strip_truth(scene, 3), tolerance=1e-9))
    assert (row.verdict, row.truth) == ("accurate", "own equations, SciPy")
    assert row.error < 1e-8


def test_a_ring_moves_as_a_strip():
    scene = replace(SCENE, seconds=0.02)
    subject = StabilitySubject("ring", 6)
    row = judge(SweepCase("panels", 6, subject, scene, ring_truth(scene, subject), whole=True))
    assert (row.verdict, row.subject) == ("accurate", "ring of 6")
    assert 0.0 < row.gap < 1e-12


def case(error=0.0, **changes):
    scene = replace(SCENE, seconds=0.01)
    given = {"scene": scene, "truth": Truth("given", lambda _: error)} | changes
    return SweepCase("some", 1.0, StabilitySubject("strip"), **given)


def test_verdicts():
    accurate = judge(case(1e-5))
    assert (accurate.verdict, accurate.error, accurate.bound, accurate.reason) == ("accurate", 1e-5, None, "")
    degraded = judge(case(1e-4 + 1e-10))
    assert degraded.verdict == "degraded"
    assert 1e-4 < degraded.bound < 2e-4
    assert degraded.reason == f"within {degraded.bound:.1e}"
    wrong = judge(case(1e-2))
    assert wrong.verdict == "wrong"
    assert wrong.bound < wrong.error
    assert judge(case(math.nan)).verdict == "wrong"


def test_refusals_have_their_reason():
    row = judge(case(tolerance=1e-20))
    assert (row.verdict, row.outcome, row.error) == ("refused", "-", None)
    assert row.reason == "a tolerance of 1e-20 is out of range: give one from 1e-13 to 0.1"
    long = judge(case(scene=replace(SCENE, damping=1e6, seconds=1.0)))
    assert (long.verdict, long.outcome) == ("refused", "out of steps")
    assert "take the implicit method" in long.reason


def test_numbers_that_are_not_finite_are_wrong(monkeypatch):
    real = simulated

    def broken(case):
        deployment = real(case)
        return replace(deployment, angles=np.full_like(deployment.angles, math.nan))

    monkeypatch.setattr(judging, "simulated", broken)
    row = judge(case())
    assert (row.verdict, row.reason, row.energy, row.gap) == ("wrong", "a number is not finite", None, None)


def test_without_a_truth_the_bound_is_from_rougher_simulations(monkeypatch):
    unknown = finer(StabilitySubject("strip"), replace(SCENE, seconds=0.01), ("dormand-prince", 1e-300))
    row = judge(case(truth=unknown))
    assert (row.verdict, row.error) == ("degraded", None)
    assert row.bound < 2e-4
    monkeypatch.setattr(judging, "rough_distance", lambda *_: None)
    assert judge(case(truth=unknown)).bound == math.pi
    assert judge(case(1e-3)).verdict == "wrong"


def test_the_bound_of_the_penalty_is_from_softer_springs():
    own = case(rough=replace(SCENE, cut_stiffness=1e3))
    assert own.rougher.scene.cut_stiffness == 1e3
    assert own.rougher.tolerance == own.tolerance
    assert case().rougher.tolerance == 10 * case().tolerance


def test_what_says_that_it_rests_is_compared_at_the_end():
    scene = replace(SCENE, spring=spring(STIFFNESS, 1.0), start=1.0 / math.pi, seconds=2.0)
    deployment = simulated(case(scene=scene))
    assert deployment.outcome == "at rest"
    times, angles = judged_states(deployment)
    assert times[-1] == 2.0
    assert (angles[-1] == deployment.angles[-1]).all()
    assert judged_states(deployment, 0.0)[0].tolist() == [0.0]


def test_gains_of_energy_are_errors():
    deployment = simulated(case())
    assert energy_of_impacts(deployment) < 1e-6
    motion = replace(deployment.motion, lost=-np.linspace(0.0, 0.1, len(deployment.motion.lost)))
    assert energy_of_impacts(replace(deployment, motion=motion)) > 0.1


def row(sweep, value, verdict, error=None):
    return StabilityRow(
        *(sweep, value, "strip of 2", "constrained", "implicit", 1e-6, verdict, error, None, "given", 0.0, 0.0),
        *("flat", 3, 0.5, ""),
    )


def test_counts_and_heat_map(tmp_path):
    rows = [row("a", 1.0, "accurate", 1e-7), row("a", 2.0, "degraded", 1e-3), row("b", 1.0, "refused")]
    rows += [row("b", 2.0, "wrong", 1.0)]
    assert len({heat_map._line(r) for r in rows}) == 2
    tallies = tally(rows)
    assert [(c.sweep, c.scenes, c.accurate, c.degraded, c.refused, c.wrong, c.worst) for c in tallies] == [
        ("a", 2, 1, 1, 0, 0, 1e-3),
        ("b", 2, 0, 0, 1, 1, None),
        ("all", 4, 1, 1, 1, 1, 1e-3),
    ]
    plot_heat(rows, tmp_path / "heat.png")
    assert (tmp_path / "heat.png").stat().st_size > 1000
    assert set(JUDGEMENT_COLOURS) == set(JUDGEMENTS)


def test_sweeps_cover_their_ranges():
    for quick in (False, True):
        every = list(cases(quick=quick))
        ranges = {s: [c.value for c in every if c.sweep == s] for s in SWEEPS}
        assert {c.sweep for c in every} == SWEEPS
        ends = {s: (min(v), max(v)) for s, v in ranges.items()}
        assert ends["stiffness ratio"] == (1.0, 1e12)
        assert ends["closure stiffness"] == (1e2, 1e12)
        assert ends["damping / critical"] == (0.0, 1e6)
        assert ends["thickness / width"] == (1e-6, 1.0)
        assert ends["base mass / panel mass"] == (1.0, 1e6)
        assert ends["tolerance"] == (1e-13, 1e-2)
        assert ends["restitution"] == (0.0, 1.0)
        assert ends["singular start"] == (0.0, 1.0)
    assert ends["panels"] == (2, 100)
    ends = [c.value for c in cases(quick=False) if c.sweep == "panels"]
    assert (min(ends), max(ends)) == (2, 1000)
    assert [c.value for c in cases(quick=False) if c.sweep == "start / folded"][::3][-1] == 0.999999


def test_answers_are_compared_row_by_row():
    first = [{"a": "deploys", "n": 3, "t": 1.0}, {"a": "locked", "n": 3, "t": None}]
    assert compared(first, first) == (0, 0.0)
    assert compared(first, [first[0] | {"t": 1.0 + 1e-9}, first[1]]) == (0, pytest.approx(1e-9))
    assert compared(first, [first[0], first[1] | {"a": "deploys"}]) == (1, 0.0)
    assert compared(first, [first[0] | {"n": 4}, first[1] | {"t": 2.0}]) == (2, 0.0)
    assert compared(first, first[:1]) == (1, 0.0)


def test_a_machine_without_openblas_has_nothing_to_compare(monkeypatch):
    monkeypatch.setattr(processors, "kernels_for", lambda _: "")
    (only,) = measure_processors(quick=True, say=lambda _: None)
    assert (only.rows, only.differ) == (None, None)
    assert only.note == "no OpenBLAS here whose kernels could be chosen: not tried"


def test_kernels_that_are_not_taken_are_reported(monkeypatch):
    taken = {None: "SkylakeX", "Haswell": "Haswell", "Zen": "Zen", "SkylakeX": "SkylakeX", "Prescott": ""}
    monkeypatch.setattr(processors, "kernels_for", lambda processor: taken.get(processor.core, "SkylakeX"))
    monkeypatch.setattr(processors, "avx512_loops", lambda: ["X86_V4"])
    monkeypatch.setattr(processors, "_branches_for", lambda processor: [{"avx512": processor.avx512}])
    monkeypatch.setattr(
        processors, "_verdicts_for", lambda processor, grid, n: [{"n": n, "t": 2.0 if processor.core else 1.0}]
    )
    monkeypatch.setattr(processors, "ARRAYS", (("hex", 8),))
    rows = measure_processors(quick=False, say=lambda _: None)
    as_own = [(0, 0.0, ""), (0, 0.5, "")]
    without = [(1, 0.0, ""), (0, 0.5, "")]
    assert [(r.core, r.avx512, r.differ, r.off, r.note) for r in rows] == [
        *(("Haswell", True, *found) for found in as_own),
        *(("Haswell", False, *found) for found in without),
        *(("Zen", True, *found) for found in as_own),
        *(("Zen", False, *found) for found in without),
        *(("Sandybridge", avx512, None, None, "not taken on this machine") for avx512 in (True, False)),
        *(("Prescott", avx512, None, None, "instructions that this machine lacks") for avx512 in (True, False)),
        *(("SkylakeX", True, *found) for found in as_own),
        *(("SkylakeX", False, *found) for found in without),
    ]


def test_the_kernels_in_use_have_a_name():
    assert kernels_for(OWN) == kernels()


def test_numpy_takes_no_avx512_where_it_is_told_not_to():
    left = "import numpy; print(numpy.show_config('dicts')['SIMD Extensions'].get('found', []))"
    environment = os.environ | PLAIN.environment
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", left], env=environment, check=True, capture_output=True, text=True
    )
    assert "AVX512" not in done.stdout
    assert "X86_V4" not in done.stdout


def test_kernels_that_end_their_process_are_not_taken(monkeypatch):
    ended = {"Haswell": -signal.SIGILL, "Prescott": 1}
    monkeypatch.setattr(
        processors,
        "_process",
        lambda processor, *_: Finished(ended[processor.core], "SkylakeX", "no numpy", 1.0, 1.0, 1.0),
    )
    assert kernels_for(Processor("Haswell")) == ""
    with pytest.raises(HcsearchError, match="kernels for Prescott: no numpy"):
        kernels_for(Processor("Prescott"))


@pytest.mark.slow
def test_the_whole_bench(tmp_path):
    arguments = ["bench", "stability", "--quick", "--output", str(tmp_path), "--json", str(tmp_path / "all.json")]
    assert CliRunner().invoke(hcsearch, arguments, catch_exceptions=False).exit_code == 0
    names = {path.name for path in tmp_path.iterdir()}
    tables = {"counts.csv", "processors.csv", "stability.csv"}
    assert names == {"all.json", "heat.png", "machine.json", "stability.md"} | tables
    data = json.loads((tmp_path / "all.json").read_text())
    assert set(data) == {"machine", "counts", "stability", "processors"}
    assert all((r["rows"] is None) == bool(r["note"]) for r in data["processors"])
    rows = data["stability"]
    assert {r["sweep"] for r in rows} == SWEEPS
    assert [r for r in rows if r["verdict"] not in {"accurate", "degraded", "refused"}] == []
    assert all((r["verdict"] == "degraded") == (r["bound"] is not None) for r in rows)
    assert all(r["error"] is None or r["bound"] is None or r["error"] <= r["bound"] for r in rows)
    assert all(bool(r["reason"]) == (r["verdict"] != "accurate") for r in rows)
    assert {c["sweep"] for c in data["counts"]} == SWEEPS | {"all"}
    assert sum(r["verdict"] == "accurate" for r in rows) > len(rows) / 2
