import json
import sys
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from hcsearch.cli import hcsearch
from hcsearch.scenes.laws import Law, LawBranch, linear_law
from hcsearch.springs.dynamics.body_trees import GROUND, TreeJoint, Weld
from hcsearch.springs.dynamics.system import JointDrive, System
from hcsearch_bench.iftomm import problem_rows, problems
from hcsearch_bench.iftomm.iftomm import goals_of
from hcsearch_bench.iftomm.problem_rows import LEVELS, ProblemRow, best_of, problem_comparison
from hcsearch_bench.iftomm.problems import X, Y, Z, bricard, four_bars, pendulum, squeezer
from hcsearch_bench.peers.multibody import Peer, peers
from hcsearch_bench.peers.states import Trajectory, closure, common_points, line_of, lines_of, places
from hcsearch_bench.run.work_precision import OURS, UnableError, level_of

TABLES = {"work", "best", "goals"}
TIMES = np.linspace(0.0, 1.0, 11)


def test_the_command_without_other_engines(tmp_path, monkeypatch):
    monkeypatch.setattr(problems, "problems", lambda: [pendulum(), bricard(0.0)])
    for package in ("mujoco", "pinocchio", "exudyn"):
        monkeypatch.setitem(sys.modules, package, None)
    arguments = ["bench", "iftomm", "--quick", "--output", str(tmp_path), "--json", str(tmp_path / "all.json")]
    assert CliRunner().invoke(hcsearch, arguments, catch_exceptions=False).exit_code == 0
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {f"{name}.csv" for name in TABLES} | {"all.json", "iftomm.md", "machine.json", "work.png"}
    data = json.loads((tmp_path / "all.json").read_text())
    assert set(data) == TABLES | {"machine"}
    ours = [row for row in data["work"] if row["engine"] == OURS]
    assert len(ours) == 6
    assert all(row["verdict"] in {"precise", "high"} and row["error"] < 1e-4 and row["runs"] == 1 for row in ours)
    assert all(row["closure"] < 1e-8 and row["energy"] < 1e-4 and row["evaluations"] > 0 for row in ours)
    others = [row for row in data["work"] if row["engine"] != OURS]
    assert {(row["verdict"], row["note"]) for row in others} == {("none", "not installed")}
    assert {row["engine"] for row in others} == {"MuJoCo", "Pinocchio", "Exudyn"}
    goals = {(row["problem"], row["goal"]): row["met"] for row in data["goals"]}
    assert goals["A04 thin", "error"] == goals["A04 thin", "closure"] == goals["A04 thin", "energy"] == "yes"
    assert goals["A04 square", "error"] == "no"  # not measured


@pytest.mark.extra
def test_the_whole_bench(tmp_path):
    arguments = ["bench", "iftomm", "--quick", "--output", str(tmp_path), "--json", str(tmp_path / "all.json")]
    assert CliRunner().invoke(hcsearch, arguments, catch_exceptions=False).exit_code == 0
    data = json.loads((tmp_path / "all.json").read_text())
    rows = data["work"]
    assert len({row["problem"] for row in rows}) == 7
    assert all(row["verdict"] in {"precise", "high"} for row in rows if row["engine"] == OURS)
    for problem in {row["problem"] for row in rows}:
        mine = [row for row in rows if row["problem"] == problem]
        assert {row["engine"] for row in mine if row["error"] is not None} == {OURS, "MuJoCo", "Pinocchio", "Exudyn"}
    assert all(row["error"] is not None or row["note"] for row in rows)


def refused(*_, **__):
    raise UnableError("no")


def test_what_an_engine_cannot_do_is_reported():
    peer = Peer("some", "method", (0.1, 0.01), refused)
    rows = list(problem_comparison(pendulum(), TIMES).peer_rows(peer, 1, 15.0))
    assert [(row.verdict, row.note, row.step) for row in rows] == [("none", "no", 1.0), ("none", "no", 0.1)]


def test_what_would_take_too_long_is_not_tried():
    ran = []

    def run(system, q, v, times, *, step):
        ran.append(step)
        return Trajectory(times, np.zeros((len(times), 1)), np.zeros((len(times), 1)), 1.0, 1)

    peer = Peer("some", "method", (0.1, 0.01), run)
    rows = list(problem_comparison(pendulum(), TIMES).peer_rows(peer, 1, 5.0))
    assert ran == [1.0]
    assert [(row.verdict, row.note) for row in rows] == [("wrong", ""), ("none", "not tried: more than 5 s")]


def test_a_motion_that_stops_early_is_refused(monkeypatch):
    monkeypatch.setattr(problem_rows, "MAX_STEPS", 3)
    row = problem_comparison(pendulum(), TIMES).our_row("dormand-prince", 1e-8)
    assert (row.verdict, row.error) == ("none", None)
    assert row.note.startswith("refused: steps at ")


def test_verdicts_are_seen_against_the_length():
    assert [level_of(error, LEVELS, pendulum().length) for error in (1e-7, 1e-5, 1e-2, 1.0)] == [
        "precise",
        "high",
        "low",
        "wrong",
    ]
    assert level_of(1e-7, LEVELS, squeezer().length) == "high"


def row(engine, error, seconds, **more):
    verdict = level_of(error, LEVELS, pendulum().length)
    return ProblemRow(engine, "m", 1e-6, None, verdict, error, problem="A04 thin", seconds=seconds, **more)


def test_the_fastest_of_each_engine():
    rows = [row(OURS, 1e-4, 1.0), row(OURS, 1e-7, 2.0), row("A", 1e-7, 4.0), row("A", 1e-8, 5.0), row("B", 0.5, 0.1)]
    fastest = [(best.level, best.engine, best.seconds, best.times_ours) for best in best_of(rows)]
    assert fastest == [
        ("high", OURS, 1.0, 1.0),
        ("high", "A", 4.0, 4.0),
        ("precise", OURS, 2.0, 1.0),
        ("precise", "A", 4.0, 2.0),
    ]


def test_goals_are_for_one_run():
    rows = [
        row(OURS, 1e-4, 1e-3, energy=1e-3, closure=1e-9),
        row(OURS, 1e-8, 2e-2, energy=1e-10, closure=1e-14),
    ]
    assert [goal.met for goal in goals_of(rows, 10.0)[:4]] == ["yes", "no", "yes", "yes"]
    assert [goal.met for goal in goals_of(rows[:1], 10.0)[:4]] == ["no", "yes", "no", "no"]


def test_stiff_methods_are_for_stiff_problems():
    fits = {(peer.method, peer.fits(pendulum())) for peer in peers(False, 400)}
    assert ("SciPy Radau", False) in fits
    assert {peer.method for peer in peers(True, 400) if not peer.fits(four_bars(2))} == {"SciPy Radau", "RK4"}


def chain(*welds, axes=(Z, Z), **options):
    joints = (TreeJoint(GROUND, axes[0], 0 * X), TreeJoint(0, axes[1], X))
    bodies = tuple(pendulum().system.bodies * 2)
    return System(joints, bodies, (JointDrive(), JointDrive()), welds, **options)


def test_points_that_close_a_weld():
    for kinds, count in (((3, 4), 1), ((3, 4, 5), 1), ((0, 1, 3, 4, 5), 2), ((0, 1, 2, 3, 4, 5), 3)):
        weld = Weld(GROUND, 1, 2 * X, kinds)
        assert len(common_points(chain(weld), weld)) == count
    hinge = Weld(GROUND, 1, 2 * X, (1, 2, 3, 4, 5))
    low, high = common_points(chain(hinge, size=0.5), hinge)
    assert (high - low).tolist() == [0.5, 0.0, 0.0]  # along the free turn
    for kinds, axes in (((3, 4), (Z, Y)), ((3, 5), (Z, Z)), ((0, 3, 4, 5), (Z, Z)), ((0, 1, 2), (Z, Z))):
        weld = Weld(GROUND, 1, 2 * X, kinds)
        with pytest.raises(UnableError, match="welds of other kinds"):
            common_points(chain(weld, axes=axes), weld)


def test_laws_that_other_engines_have():
    assert line_of(linear_law(3.0, 0.5)) == (0.5, 3.0)
    assert line_of(Law(LawBranch((1.0,), ((2.0, 3.0, 0.0, 0.0),)))) == (-1.0, 3.0)
    with pytest.raises(UnableError, match="not linear"):
        line_of(Law(LawBranch((0.0,), ((0.0, 0.0, 1.0, 0.0),))))
    system = replace(chain(), drives=(JointDrive(), JointDrive(lower=0.0)))
    with pytest.raises(UnableError, match="stops"):
        lines_of(system)
    with pytest.raises(UnableError, match="without inertia"):
        lines_of(chain(overdamped=True))


def test_closure_sees_gaps_and_turns():
    weld = Weld(GROUND, 1, 2 * X)
    system = chain(weld, size=2.0)
    assert closure(system, np.array([0.0, 0.0])) == 0.0
    assert closure(system, np.array([0.0, 1e-6])) == pytest.approx(2e-6)  # a turn, over the size
    assert closure(chain(replace(weld, kinds=(3, 4)), size=2.0), np.array([0.0, 1e-6])) == pytest.approx(1e-6)


def test_velocities_are_those_of_places():
    system = chain(axes=(Z, np.array([0.6, 0.0, 0.8])))
    q, v, h = np.array([0.3, -0.7]), np.array([1.1, 0.4]), 1e-6
    _, speed = places(system, q, v).point(1, 2 * X + Y)
    before, after = (places(system, q + way * h * v).point(1, 2 * X + Y)[0] for way in (-1, 1))
    assert (after - before) / (2 * h) == pytest.approx(speed, abs=1e-9)
