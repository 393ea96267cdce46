import json
import os
import shutil
import stat
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from hcsearch.basics.errors import HcsearchError
from hcsearch.cli import hcsearch
from hcsearch_bench.run.process import Finished
from hcsearch_bench.scale import scale
from hcsearch_bench.scale.cluster import running_cluster
from hcsearch_bench.scale.databases import new_postgresql, new_sqlite
from tests import golden
from tests.postgresql import running_server

SMALL = scale.ScaleJob("hex", 10, "untwisted")


def silent(_):
    pass


def finished(output, error="", wall=2.0):
    return Finished(0 if output else 2, output, error, wall=wall, cpu=1.0, peak_mib=100.0)


def printed(designs):
    return f"  two-stack                {designs:>15,}\n  untwisted                {designs:>15,}\n"


def test_a_job_into_a_file_finds_the_designs():
    ways = [scale.RunWay("--jobs 1", ("--jobs", "1"), "SQLite", new_sqlite), *scale.ways_to_store(None)[-1:]]
    measured, left = scale.measure_job(SMALL, ways, repeats=1, say=silent)
    assert measured.designs == golden.FOLDABLE["hex", 10][3]
    assert (measured.speed_up, measured.runs, measured.note) == (1.0, 1, "")
    assert (left.into, left.designs, left.note) == ("PostgreSQL", None, "not measured: no --postgresql")


def test_speed_up_is_that_of_the_work_done(monkeypatch):
    walls = {"--jobs 1": 10.0, "--jobs 2": 5.0, "two commands": 12.5}

    def run(job, way):
        wall = 1.0 if job.n == 10 else walls[way.how]
        return [finished(printed(3000), wall=wall)] * way.at_once

    monkeypatch.setattr(scale, "_run", run)
    rows = scale.measure_job(scale.ScaleJob("hex", 20, "untwisted"), scale.ways_to_list(None), repeats=3, say=silent)
    assert [row.speed_up for row in rows] == [1.0, 2.0, None, 1.6]
    assert [row.net_speed_up for row in rows] == [1.0, 9 / 4, None, pytest.approx(2 * 9 / 11.5)]
    assert [row.designs_per_s for row in rows] == [300, 600, None, 480]
    assert [row.runs for row in rows] == [3, 3, None, 6]
    assert rows[2].note == "distributed not installed"


@pytest.mark.parametrize(
    ("runs", "message"),
    [
        ([finished(printed(5)), finished(printed(6))], r"found \[5, 6\] designs; report this"),
        ([finished("", "hcsearch: no room\n")], "failed: hcsearch: no room"),
        ([finished("")], "failed: it took too long"),
    ],
)
def test_failed_commands_and_different_numbers_are_errors(monkeypatch, runs, message):
    monkeypatch.setattr(scale, "_run", lambda *_: runs)
    with pytest.raises(HcsearchError, match=message):
        scale.measure_job(SMALL, [scale.RunWay("--jobs 1", ())], repeats=1, say=silent)


def test_a_file_is_new_each_time_and_gone_afterwards():
    with new_sqlite() as one, new_sqlite() as other:
        paths = [Path(variables["HCSEARCH_DB"]) for variables in (one, other)]
        assert paths[0] != paths[1]
        assert all(path.parent.is_dir() and not path.exists() for path in paths)
    assert not any(path.parent.exists() for path in paths)


@pytest.fixture
def client_programs(tmp_path, monkeypatch):
    """Stand-ins for PostgreSQL's client programs that write down how they are called."""
    for name in ("createdb", "dropdb"):
        program = tmp_path / name
        program.write_text(f"#!/bin/sh\necho {name} $PGPASSWORD \"$@\" >> '{tmp_path}/calls'\n")
        program.chmod(program.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    return tmp_path / "calls"


def test_databases_of_a_server_are_made_and_dropped_and_passwords_not_shown(client_programs):
    make = new_postgresql("postgresql+psycopg://me:a%2Fb@host:5433/mine?sslmode=require")
    with make() as one:
        pass
    with make() as other:
        pass
    assert one["PGPASSWORD"] == "a/b"
    first, second = (
        variables["HCSEARCH_DB"].rpartition("/")[2].removesuffix("?sslmode=require") for variables in (one, other)
    )
    assert first != second
    assert one["HCSEARCH_DB"] == f"postgresql://me@host:5433/{first}?sslmode=require"
    server = "--maintenance-db postgresql://me@host:5433/mine?sslmode=require"
    calls = [f"{program} a/b {server} {name}" for name in (first, second) for program in ("createdb", "dropdb")]
    assert client_programs.read_text().splitlines() == calls


@pytest.mark.parametrize("url", ["mysql://me@host/x", "postgresql://[me:secret", "designs.sqlite", ""])
def test_what_is_no_server_is_refused_in_one_line(url, tmp_path):
    arguments = ["bench", "scale", "--quick", "--output", str(tmp_path), "--postgresql", url]
    error = CliRunner().invoke(hcsearch, arguments).exception
    assert isinstance(error, HcsearchError)
    assert str(error) == "the URL of the server cannot be read: give postgresql://USER@HOST/NAME"


def test_a_server_without_client_programs_is_refused(monkeypatch):
    monkeypatch.setenv("PATH", "")
    with (
        pytest.raises(HcsearchError, match="client program createdb is not found"),
        new_postgresql("postgresql://x/y")(),
    ):
        pass


def test_a_cluster_that_does_not_start_is_one_line(monkeypatch):
    monkeypatch.setattr(sys, "executable", shutil.which("false"))
    with pytest.raises(HcsearchError, match="a Dask scheduler does not start: no answer"), running_cluster(1):
        pass


@pytest.mark.extra
def test_the_whole_bench(tmp_path):
    with running_server() as server:
        arguments = ["--quick", "--postgresql", server.url("postgres"), "--json", str(tmp_path / "all.json")]
        result = CliRunner().invoke(hcsearch, ["bench", "scale", *arguments, "--output", str(tmp_path / "out")])
        assert result.exit_code == 0, result.output
        assert server.run("SELECT count(*) FROM pg_database WHERE datname LIKE 'hcsearch%'") == [(0,)]
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"machine.json", "scale.csv", "scale.md"}
    rows = json.loads((tmp_path / "all.json").read_text())["scale"]
    assert [row["how"] for row in rows[:4]] == ["--jobs 1", "--jobs 2", "cluster of 2", "two commands"]
    assert [row["into"] for row in rows] == ["-"] * 4 + ["SQLite"] * 2 + ["PostgreSQL"] * 2
    assert [row["designs"] for row in rows] == [1175] * 4 + [88] * 4
    assert server.url("x").partition("@")[0].rpartition(":")[2] not in (tmp_path / "all.json").read_text()
