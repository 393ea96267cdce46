"""A file is written whole under its name, or not at all; long results take little memory and end when told to."""

import os
import signal
import sqlite3
import subprocess
import sys
import time

import pytest
from store_samples import as_rows, begin, circuits, record

from hcsearch.basics.errors import OutputError, QueryError
from hcsearch.store import (
    Result,
    format_rows,
    open_database,
    open_readonly,
    save_rows,
    select,
    select_sql,
    stream,
    stream_sql,
)
from hcsearch.store.schema import design
from tests.commands import without_progress

RESULT = Result(("id", "circuit"), ((1, "hex:0"), (2, None), (3, "é")))
ENDLESS = "WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c) SELECT count(*) FROM c"

ENDLESS_ROWS = "WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c) SELECT x FROM c"


def saved(path, style="csv"):
    save_rows(as_rows(RESULT), style, path)


@pytest.mark.parametrize("style", ["csv", "json", "table", "markdown"])
def test_a_file_holds_what_is_printed(tmp_path, style):
    saved(tmp_path / "out", style)
    assert (tmp_path / "out").read_bytes().decode() == "".join(format_rows(as_rows(RESULT), style))
    saved(tmp_path / "out", style)  # an older one gives way
    assert [file.name for file in tmp_path.iterdir()] == ["out"]


def failing():
    yield RESULT.rows
    raise QueryError("no more")


@pytest.mark.parametrize("style", ["csv", "json", "table"])
def test_a_failure_leaves_the_older_file_alone(tmp_path, style):
    (tmp_path / "out").write_text("older")
    rows = as_rows(RESULT)
    with pytest.raises(QueryError, match="no more"):
        save_rows(type(rows)(rows.columns, rows.kinds, failing()), style, tmp_path / "out")
    assert (tmp_path / "out").read_text() == "older"
    assert [file.name for file in tmp_path.iterdir()] == ["out"]


def test_places_that_cannot_be_written(tmp_path, path):
    open_database(str(path), create=True).close()
    before = path.read_bytes()
    (tmp_path / "file").touch()
    for place, part in (
        (tmp_path, "is a folder: name a file"),
        (tmp_path / "none" / "out", "there is no folder .*: make it, or write to another"),
        (tmp_path / "file" / "out", "there is no folder .*: make it, or write to another"),
        (path, "it is a database: make room, or name another file"),
        ("/dev/null", "it is not a file: make room, or name another file"),
    ):
        with pytest.raises(OutputError, match=part):
            saved(type(tmp_path)(place))
    assert path.read_bytes() == before


def test_through_a_link(tmp_path):
    (tmp_path / "real").write_text("older")
    (tmp_path / "link").symlink_to("real")
    saved(tmp_path / "link")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_text().startswith("id,circuit")


def test_missing_pyarrow(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(QueryError, match=r"needs pyarrow: pip install 'hcsearch\[parquet\]'"):
        saved(tmp_path / "out.parquet", "parquet")
    assert list(tmp_path.iterdir()) == []


def test_rows_come_in_chunks(path):
    with open_database(str(path), create=True) as database:
        record(database, circuits(1, 2500))
        with stream(database, columns="id") as rows:
            chunks = list(rows.chunks)
        assert [len(chunk) for chunk in chunks] == [1000, 1000, 500]
        assert tuple(row for chunk in chunks for row in chunk) == select(database, columns="id").rows


def test_reading_leaves_nothing_beside_a_file(path):
    with open_database(str(path), create=True) as database:
        record(database, circuits(1, 3))
    before = path.read_bytes()
    with open_readonly(str(path)) as reader, pytest.raises(QueryError):
        select_sql(reader, "DELETE FROM design")
    with open_readonly(str(path)) as reader:
        assert len(select(reader).rows) == 3
    assert [file.name for file in path.parent.iterdir()] == [path.name]
    assert path.read_bytes() == before


def fail_within(path, stream_of):
    with open_readonly(str(path)) as reader, stream_of(reader) as rows:
        raise QueryError(f"no {rows.columns}")


def test_a_result_that_is_not_read_to_its_end_leaves_nothing_beside_a_file(path):
    with open_database(str(path), create=True) as database:
        record(database, circuits(1, 3))
    for stream_of in (lambda reader: stream(reader, columns="id"), lambda reader: stream_sql(reader, ENDLESS_ROWS)):
        with pytest.raises(QueryError) as caught:
            fail_within(path, stream_of)
        assert caught.tb  # which keeps what is in its frames
        assert [file.name for file in path.parent.iterdir()] == [path.name]


def test_tidying_does_not_disturb_others(path):
    with open_database(str(path), create=True) as database, open_readonly(str(path)) as other:
        begin(database)
        assert len(select(other, view="runs").rows) == 1
        with open_readonly(str(path)) as reader:
            assert len(select(reader, view="runs").rows) == 1
        begin(database)
        assert len(select(other, view="runs").rows) == 2


def test_a_log_that_a_killed_writer_left_is_kept(path, tmp_path):
    with open_database(str(path), create=True) as database:
        begin(database)
        left = {suffix: path.with_name(path.name + suffix).read_bytes() for suffix in ("", "-wal")}
    place = tmp_path / "copy"
    place.mkdir()
    for suffix, content in left.items():
        (place / f"d.sqlite{suffix}").write_bytes(content)
    with open_readonly(str(place / "d.sqlite")) as reader:
        assert len(select(reader, view="runs").rows) == 1
    assert {suffix: (place / f"d.sqlite{suffix}").read_bytes() for suffix in left} == left


def hcsearch(*words, **options):
    return subprocess.Popen(
        [sys.executable, "-m", "hcsearch", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options
    )


@pytest.mark.parametrize("words", [["--sql", ENDLESS], ["--sql", ENDLESS, "--format", "csv", "--output", "out.csv"]])
def test_interrupt_ends_a_long_statement_at_once(path, tmp_path, words):
    open_database(str(path), create=True).close()
    process = hcsearch("query", "--db", str(path), *words, cwd=tmp_path)
    time.sleep(2.5)  # by then it runs the statement
    assert process.poll() is None
    clock = time.monotonic()
    process.send_signal(signal.SIGINT)
    out, error = process.communicate(timeout=10)
    assert time.monotonic() - clock < 1  # 0.2 s of it, and the end of the interpreter
    assert process.returncode == 130
    assert out == ""
    assert error.strip().count("\n") == 0
    assert [file.name for file in tmp_path.iterdir()] == [path.name]


def test_interrupt_within_this_process_takes_tenths_of_a_second(path):
    open_database(str(path), create=True).close()
    with open_readonly(str(path)) as reader:
        signal.setitimer(signal.ITIMER_REAL, 0.3)
        before = signal.signal(signal.SIGALRM, signal.default_int_handler)
        clock = time.monotonic()
        try:
            with pytest.raises(KeyboardInterrupt):
                select_sql(reader, ENDLESS)
        finally:
            signal.signal(signal.SIGALRM, before)
        assert time.monotonic() - clock < 0.5
        assert select_sql(reader, "SELECT 1").rows == ((1,),)


@pytest.fixture(scope="module")
def many(tmp_path_factory):
    """Half a million designs that nobody computed."""
    place = tmp_path_factory.mktemp("many") / "d.sqlite"
    open_database(str(place), create=True).close()
    with sqlite3.connect(place) as connection:
        names = [column.name for column in design.c if not column.nullable]
        sql = f"INSERT INTO design ({', '.join(names)}) VALUES ({', '.join('?' * len(names))})"
        rows = ((k, "hex", 20, f"hex:{k:019d}", f"hex:{k:025d}", 12, 1, 12) for k in range(1, 500_001))
        connection.executemany(sql, rows)
    connection.close()
    return place


def peak(place, *words):
    """Largest memory of a query in MiB, and its output."""
    code = (
        "import resource, sys\nfrom hcsearch.cli import hcsearch\nhcsearch.main(sys.argv[1:], standalone_mode=False)\n"
        "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024, file=sys.stderr)"
    )
    command = [sys.executable, "-c", code, "query", "--db", str(place), *words]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=os.environ)
    return int(without_progress(done.stderr)), done.stdout


@pytest.mark.slow
@pytest.mark.parametrize(("style", "lines"), [("csv", 500_001), ("json", 500_000)])
def test_memory_does_not_grow_with_the_result(many, style, lines):
    little, _ = peak(many, "--format", style, "--limit", "1")
    much, out = peak(many, "--format", style)
    assert out.count("\n") == lines
    assert much < little + 16, "MiB; gathered, half a million rows take hundreds"


@pytest.mark.extra
def test_memory_of_a_parquet_file_is_bounded(many, tmp_path):
    little, _ = peak(many, "--format", "parquet", "--output", str(tmp_path / "a"), "--limit", "1")
    for words in ([], ["--sql", "SELECT * FROM designs"]):
        much, _ = peak(many, "--format", "parquet", "--output", str(tmp_path / "b"), *words)
        assert much < little + 150, "MiB"


@pytest.mark.slow
def test_head_ends_a_long_result_quietly(many):
    process = hcsearch("query", "--db", str(many), "--format", "csv", "-c", "circuit")
    assert process.stdout.readline() == "circuit\n"
    process.stdout.close()
    assert process.stderr.read() == ""
    process.stderr.close()
    assert process.wait(10) == 141
