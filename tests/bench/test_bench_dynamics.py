import json
import math
import sys
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from hcsearch.cli import hcsearch
from hcsearch.library.unit_search.elements import untwisted_foldings_of
from hcsearch.scenes.laws import linear_law
from hcsearch.springs.deployment.simulated_deployment import Arrival
from hcsearch.springs.dynamics.time_integration import simulate_system
from hcsearch_bench.dynamics.case_rows import LEVELS, CaseRow, gap_of, reference_of, seconds_at
from hcsearch_bench.dynamics.deployment_rows import (
    BOUNCE,
    DeploymentRow,
    QuickRow,
    arrivals_apart,
    deployment_rows,
    quick_row,
)
from hcsearch_bench.dynamics.evaluation_rows import EvaluationRow, slope_of, strip
from hcsearch_bench.dynamics.speed_goals import best_of, goals_of
from hcsearch_bench.iftomm.problems import bricard, governor
from hcsearch_bench.peers import pinocchio_system
from hcsearch_bench.peers.dense_system import Dense
from hcsearch_bench.peers.states import closure, depth_first
from hcsearch_bench.run.work_precision import OURS, UnableError, level_of
from hcsearch_bench.subjects import deployments
from hcsearch_bench.subjects.deployments import LOOP, WHOLE, subjects
from tests.dynamics.naive_dynamics import Twin, random_system

TABLES = {"work", "references", "best", "deployments", "scale", "quick", "goals"}
NAMES = ["thesis-4x4", LOOP, "12 hexagons", "10x6 squares", "unit-i"]


def subject(name):
    (match,) = [own for own in subjects() if own.name == name]
    return match


def read(folder):
    arguments = ["bench", "dynamics", "--quick", "--output", str(folder), "--json", str(folder / "all.json")]
    assert CliRunner().invoke(hcsearch, arguments, catch_exceptions=False).exit_code == 0
    names = {path.name for path in folder.iterdir()}
    assert names == {f"{name}.csv" for name in TABLES} | {"all.json", "dynamics.md", "machine.json", "work.png"}
    data = json.loads((folder / "all.json").read_text())
    assert set(data) == TABLES | {"machine"}
    return data


def test_the_command_without_other_engines(tmp_path, monkeypatch):
    short = replace(subject(LOOP), until=0.002)
    monkeypatch.setattr(deployments, "subjects", lambda: [short])
    for package in ("mujoco", "pinocchio", "exudyn"):
        monkeypatch.setitem(sys.modules, package, None)
    data = read(tmp_path)
    ours = [row for row in data["work"] if row["engine"] == OURS]
    assert {row["formulation"] for row in ours} == {"constrained", WHOLE, "penalty", "quasistatic"}
    assert all(row["error"] < 1e-5 for row in ours if row["formulation"].startswith("constrained"))
    assert all(row["gap"] < 1e-12 for row in ours if row["formulation"] != "penalty")
    assert all(0.0 < row["gap"] < 1e-4 for row in ours if row["formulation"] == "penalty")
    others = {row["engine"]: row["note"] for row in data["work"] if row["engine"] != OURS}
    assert others == {"SciPy": "", "MuJoCo": "not installed", "Pinocchio": "not installed", "Exudyn": "not installed"}
    (reference, slow) = data["references"]
    assert reference["apart"] < 1e-8
    assert reference["whole_apart"] < 1e-10
    assert slow["formulation"] == "quasistatic"
    assert {row["formulation"] for row in data["deployments"]} == {"constrained", "penalty"}
    assert {row["kind"] for row in data["scale"]} == {"loop", "chain"}
    assert data["quick"][0]["outcomes"]
    met = {row["goal"]: row["met"] for row in data["goals"]}
    assert [word for goal, word in met.items() if "MuJoCo" in goal or "Pinocchio" in goal] == ["not measured"] * 2


@pytest.mark.extra
def test_the_whole_bench(tmp_path):
    data = read(tmp_path)
    assert {row["subject"] for row in data["work"]} == set(NAMES[:2])
    for name in NAMES[:2]:
        mine = [row for row in data["work"] if row["subject"] == name]
        assert {row["engine"] for row in mine if row["error"] is not None} == {
            *(OURS, "SciPy", "MuJoCo", "Pinocchio", "Exudyn"),
        }
    assert all(row["error"] is not None or row["note"] for row in data["work"])
    assert all(row["apart"] < 1e-7 for row in data["references"] if row["formulation"] == "constrained")


def test_subjects_have_what_is_said_of_them():
    assert [own.name for own in subjects()] == NAMES
    sizes = {own.name: (own.linkage.n_panels, len(own.linkage.loops)) for own in subjects()}
    assert sizes == dict(zip(NAMES, [(12, 1), (14, 1), (10, 1), (58, 1), (21, 4)], strict=True))
    assert subject(LOOP).compiled("constrained").factor == 2.0  # symmetric
    assert subject(LOOP).compiled(WHOLE).factor == 1.0


@pytest.mark.parametrize("name", NAMES)
def test_nothing_comes_to_a_stop_before_the_end(name):
    own = subject(name)
    end = own.horizon("constrained")
    assert end <= own.until
    case = own.case("constrained", end)
    assert all(math.isinf(drive.lower) and math.isinf(drive.upper) for drive in case.system.drives)
    angles = case.angles(simulate_system(case.system, case.q, end=end, tolerance=1e-8).q)
    assert angles.min() > 0.0
    assert angles.max() <= math.pi + 1e-12
    assert np.abs(angles[-1] - angles[0]).max() > 0.3  # it does move


def test_a_subject_that_does_not_end_has_no_reference(monkeypatch):
    case = subject(LOOP).case("constrained", 0.01)
    monkeypatch.setattr("hcsearch_bench.dynamics.case_rows.MAX_STEPS", {"constrained": 3})
    with pytest.raises(UnableError, match="no reference: steps at"):
        reference_of(case)


def unstopped(seed):
    """A random system with linear laws, and a closed state of it; None where there is none."""
    system, rng = random_system(seed, struts=0)
    drives = tuple(replace(drive, law=linear_law(0.3, 0.1), lower=-math.inf, upper=math.inf) for drive in system.drives)
    twin = Twin(replace(system, drives=drives, stop_stiffness=0.0, stop_damping=0.0))
    q, v = twin.closed(0.1 * rng.normal(size=twin.n), rng.normal(size=twin.n))
    return (twin, q, v) if np.abs(twin.errors(q)).max(initial=0.0) < 1e-10 else None


def test_dense_accelerations_are_those_of_the_twin():
    checked = 0
    for seed in range(30):
        closed = unstopped(seed)
        # near singular states, and with two turns closed, the twin's rows are others
        if closed is None or any(sum(k < 3 for k in w.kinds) in (1, 2) for w in closed[0].system.welds):
            continue
        twin, q, v = closed
        sizes = np.linalg.svd(twin.rows(q), compute_uv=False)
        if np.any((sizes > 1e-9) & (sizes < 1e-2)):
            continue
        exact = twin.accelerations(q, v, np.zeros(twin.n, bool))[0]
        got = Dense(twin.system).accelerations(q, v)
        assert got == pytest.approx(exact, rel=1e-8, abs=1e-8 * max(1.0, np.abs(exact).max()))
        checked += 1
    assert checked > 10


def test_dense_matrices_have_no_struts():
    with pytest.raises(UnableError, match="struts"):
        Dense(governor().system)


@pytest.mark.extra
@pytest.mark.parametrize("name", ["thesis-4x4", LOOP])
def test_pinocchio_has_the_accelerations_of_a_tree_with_branches(name):
    import pinocchio as pin

    case = subject(name).case(WHOLE, 0.05)
    motion = simulate_system(case.system, case.q, end=case.end, tolerance=1e-9)
    forces = pinocchio_system._Forces(pin, case.system)
    q, v = np.empty(len(case.q)), np.empty(len(case.q))
    q[forces.order], v[forces.order] = motion.q[-1], motion.v[-1]
    got = forces.accelerations(q, v)[forces.order]
    assert got == pytest.approx(motion.a[-1], abs=1e-6 * np.abs(motion.a[-1]).max())
    assert depth_first(case.system) != list(range(len(q)))  # branches, numbered breadth first


def work(engine, method, error, seconds, formulation="constrained"):
    how = {"subject": LOOP, "formulation": formulation, "seconds": seconds}
    return CaseRow(engine, method, 1e-6, None, level_of(error, LEVELS), error, **how)


def test_seconds_at_an_error_are_between_two_runs():
    rows = [work(OURS, "m", 1e-3, 1.0), work(OURS, "m", 1e-5, 4.0), work(OURS, "m", 1e-7, 9.0)]
    assert seconds_at(rows, 1e-4) == pytest.approx(2.0)
    assert seconds_at(rows, 1e-5) == 4.0
    assert seconds_at(rows, 1e-2) == 1.0
    assert seconds_at(rows, 1e-8) is None
    assert seconds_at([*rows, work(OURS, "m", 1e-9, 0.5)], 1e-5) == 0.5  # finer and faster


def test_verdicts():
    assert [level_of(error, LEVELS) for error in (1e-9, 1e-5, 1e-3, 1.0)] == ["precise", "high", "low", "wrong"]


def test_the_fastest_of_each_method():
    rows = [
        work(OURS, "a", 1e-6, 1.0),
        work(OURS, "a", 1e-9, 2.0),
        work("E", "b", 1e-9, 8.0, WHOLE),
        work("E", "b", 1e-5, 3.0, WHOLE),
        work(OURS, "a", 1e-12, 0.1, "quasistatic"),
        work(OURS, "c", 1e-3, 0.1),
    ]
    assert [(row.level, row.engine, row.seconds, row.times_ours) for row in best_of(rows)] == [
        ("high", OURS, 1.0, 1.0),
        ("high", "E", 3.0, 3.0),
        ("precise", OURS, 2.0, 1.0),
        ("precise", "E", 8.0, 4.0),
    ]


def deployment(formulation, end, seconds, outcome="flat", *, restitution=None, apart=None):
    cut = None if formulation == "constrained" else 1e8
    how = (LOOP, formulation, "m", 1e-6, restitution, cut)
    return DeploymentRow(*how, outcome, end, "3@100", apart, 1, 0.0, 0.0, 1, seconds)


def test_goals():
    rows = [
        work(OURS, "a", 2e-5, 1e-2),
        work(OURS, "a", 2e-5, 2e-2, WHOLE),
        work(OURS, "bogacki-shampine", 1e-3, 3.0, "penalty"),
        work("MuJoCo", "RK4", 2e-5, 9e-2, WHOLE),
        work("Pinocchio", "SciPy DOP853", 2e-5, 3e-1, WHOLE),
    ]
    scale = [EvaluationRow("loop", 10, 1, 1.0, 0.1, 1.3, 1.2)]
    quick = [QuickRow("hex n = 12", 1, 30.0, 40.0, 50.0, 20.0, 10.0, "1 flat")]
    ours = [
        deployment("constrained", 0.2, 1.0, restitution=0.0),
        deployment("constrained", 0.3, 0.1, restitution=BOUNCE),
    ]
    deployments = [*ours, deployment("penalty", 0.33, 20.0, apart=1e-4)]
    goals = goals_of(rows, deployments, scale, quick)
    assert [row.measured for row in goals] == pytest.approx([300.0, 9.0, 30.0, 200.0, 1e-4, 0.1, 1.2, 30.0])
    assert [row.met for row in goals] == ["yes", "no", "yes", "yes", "yes", "no", "no", "yes"]
    assert goals[0].note == "it never comes to 2e-05: 0.001 rad in 3 s; nothing left out: 150"
    jammed = goals_of(rows, [*ours, deployment("penalty", 0.33, 20.0, "jammed", apart=2e-3)], scale, quick)
    assert [row.met for row in jammed][3:6] == ["yes", "no", "not measured"]
    assert {row.met for row in goals_of([], [], [], [])} == {"not measured"}


@pytest.mark.parametrize("n", [3, 10, 31])
def test_rings_are_closed(n):
    ring = strip(n, closed=True)
    assert closure(ring, np.zeros((1, n))) < 1e-15
    assert len(strip(n, closed=False).welds) == 0
    motion = simulate_system(ring, np.zeros(n), end=0.001, tolerance=1e-8)
    assert motion.ending == "time"
    assert motion.drift < 1e-9


def test_slopes_are_powers():
    assert slope_of([1, 10, 100], [2.0, 20.0, 200.0]) == pytest.approx(1.0)
    assert slope_of([1, 4], [1.0, 2.0]) == pytest.approx(0.5)


def test_arrivals_are_listed_for_both_formulations():
    own = subject("thesis-4x4")
    exact, bouncing, springs = deployment_rows(own, 0.13, stiffer=False)
    assert [row.formulation for row in (exact, bouncing, springs)] == ["constrained", "constrained", "penalty"]
    assert exact.arrivals == bouncing.arrivals == springs.arrivals == "1+10@129.58"
    assert [row.restitution for row in (exact, bouncing, springs)] == [0.0, BOUNCE, None]
    assert (exact.apart, bouncing.apart) == (None, None)
    assert 0.0 < springs.apart < 1e-4
    assert exact.events == 1 < springs.events  # half of the array; and bounces
    assert exact.gap < 1e-13 < springs.gap


def test_springs_that_give_way_less_come_nearer_to_exact_loops():
    *_, springs, stiffer = deployment_rows(subject("thesis-4x4"), 0.01, stiffer=True)
    assert (springs.cut, stiffer.cut) == (1e8, 1e10)
    assert 0.0 < stiffer.gap < 0.1 * springs.gap
    assert stiffer.apart is None  # nothing arrives so early


def test_arrivals_are_compared_by_hinges_and_stops():
    first, second = Arrival(0.1, "flat", (3,), 1.0), Arrival(0.2, "flat", (4, 5), 1.0)
    assert arrivals_apart([first, second], [first, second]) == 0.0
    early = Arrival(0.002, "folded", (3,), 1.0)  # a bounce at the start is no arrival of ours
    late = Arrival(0.22, "flat", (2, 4, 5), 1.0)
    assert arrivals_apart([first, second], [early, first, late]) == pytest.approx(0.1)
    assert arrivals_apart([first, second], [early, first]) is None
    assert arrivals_apart([], [first]) is None


def test_the_gap_of_cut_hinges_is_that_of_their_ends():
    case = subject(LOOP).case("penalty", 0.001)
    assert gap_of(case, case.q[None]) < 1e-9
    off = case.q.copy()
    off[0] += 1e-3
    assert gap_of(case, off[None]) > 1e-6


def test_the_quick_check_counts_outcomes():
    designs = list(untwisted_foldings_of("hex", 6))
    row = quick_row("hex n = 6", designs)
    assert row.foldings == len(designs) == 1
    assert row.median_ms == row.worst_ms >= row.simulation_ms > 0.0
    assert row.outcomes.startswith("1 ")


def test_bricard_by_dense_matrices():
    problem = bricard(0.0)
    state = np.zeros(problem.system.n_joints), problem.v
    motion = simulate_system(problem.system, *state, end=0.1, tolerance=1e-10)
    for k in (0, len(motion.q) // 2, -1):
        got = Dense(problem.system).accelerations(motion.q[k], motion.v[k])
        assert got == pytest.approx(motion.a[k], abs=1e-7 * np.abs(motion.a[k]).max())
