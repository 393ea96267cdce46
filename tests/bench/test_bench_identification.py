"""The bench `identification`: its rig obeys its equation, its rows are those of the records."""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.integrate import solve_ivp

from hcsearch.cli import hcsearch
from hcsearch.springs.identification.vibration import identify_modes
from hcsearch_bench.identification import identification
from hcsearch_bench.identification.error_rows import measure_damping, measure_springs
from hcsearch_bench.identification.rig import Rig


def test_the_rig_swings_as_its_equation_says():
    rig = Rig()

    def swing(_, state):
        angle, speed = state
        return speed, -(rig.stiffness * angle + rig.hinges * rig.damping * speed) / rig.inertia

    time = np.arange(400) / rig.rate
    angle, speed = solve_ivp(swing, (0, 2), (0.3, 0.0), t_eval=time, rtol=1e-10, atol=1e-12).y
    (mode,) = identify_modes(swing(0, (angle, speed))[1], rig.rate).modes
    assert mode.frequency == pytest.approx(rig.frequency, rel=1e-6)
    assert mode.damping == pytest.approx(rig.ratio, rel=1e-6)
    assert rig.frequency == pytest.approx(2.5, abs=0.01)
    assert rig.ratio == pytest.approx(0.107, abs=0.001)


def test_its_records_are_theirs_alone():
    rig = Rig()
    assert (rig.record(0.1, 3) == rig.record(0.1, 3)).all()
    assert (rig.record(0.1, 3) != rig.record(0.1, 4)).any()
    assert np.std(rig.record(0.1, 3) - rig.record(0.0, 3)) == pytest.approx(0.1, rel=0.05)


def test_rows_of_damping():
    row = measure_damping(0.01, range(6), say=lambda _: None)
    assert (row.records, row.recognised, row.false_modes) == (6, 6, 0)
    assert 0.5 * row.reported_error < row.coefficient_error < 2.0 * row.reported_error < 0.02
    assert row.frequency_error < row.damping_error
    exact = measure_damping(0.0, range(2), say=lambda _: None)
    assert max(exact.frequency_error, exact.damping_error, exact.coefficient_error) < 1e-8
    assert exact.within_2 is None


def test_rows_of_springs():
    row = measure_springs("quadratic", "quadratic:0.02,0.03", 0.01, range(5))
    assert (row.records, row.recognised) == (5, 5)
    assert row.moment_error < 0.01
    assert measure_springs("linear", "quadratic:0.02,0.03", 0.01, range(2)).recognised == 0


def test_the_command_saves_tables_and_plot(tmp_path, monkeypatch):
    monkeypatch.setattr(identification, "NOISES", (0.0, 0.01))
    monkeypatch.setattr(identification, "QUICK", 2)
    words = [
        "bench",
        "identification",
        "--quick",
        "--output",
        str(tmp_path / "out"),
        "--json",
        str(tmp_path / "i.json"),
    ]
    result = CliRunner().invoke(hcsearch, words)
    assert result.exception is None
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        "identification-damping.csv",
        "identification-film-verdicts.csv",
        "identification-films.csv",
        "identification-springs.csv",
        "identification.md",
        "identification.png",
        "machine.json",
    ]
    data = json.loads((tmp_path / "i.json").read_text(encoding="utf-8"))
    assert [row["noise"] for row in data["identification-damping"]] == [0.0, 0.01]
    assert len(data["identification-springs"]) == 8
    assert [row["parameter"] for row in data["identification-films"]] == ["stiffness", "damping", "friction"]
    assert [row["films"] for row in data["identification-film-verdicts"]] == [1]
