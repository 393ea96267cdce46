"""Outputs of commands: whole or not there, never in the place of a database, refused before anything is computed."""

import os
import sqlite3
import stat
import subprocess
import sys
import textwrap
from contextlib import closing
from pathlib import Path

import pytest
from click.testing import CliRunner

from hcsearch.basics.errors import OutputError
from hcsearch.cli import hcsearch
from hcsearch.store import find_design, open_database
from hcsearch.system import outputs
from hcsearch.system.outputs import check_folder, check_output, make_folder, replacing_file, write_output
from tests.faults.small_disk import limited
from tests.judging import judge


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_a_file_takes_the_place_and_the_mode_of_the_older_one(folder):
    old = folder / "page.html"
    old.write_text("older")
    old.chmod(0o640)
    write_output(old, "newer")
    assert (old.read_text(), stat.S_IMODE(old.stat().st_mode)) == ("newer", 0o640)
    write_output("other", "x")
    (folder / "plain").touch()
    assert (folder / "other").stat().st_mode == (folder / "plain").stat().st_mode
    assert names(folder) == ["other", "page.html", "plain"]


def test_through_a_link_the_file_itself_is_replaced(folder):
    (folder / "real").write_text("older")
    (folder / "link.svg").symlink_to("real")
    with replacing_file("link.svg", (".svg",)) as part:
        assert part.suffix == ".svg"
        part.write_text("newer")
    assert (folder / "link.svg").is_symlink()
    assert (folder / "real").read_text() == "newer"


@pytest.mark.parametrize("error", [KeyboardInterrupt, OSError(28, "No space left on device"), OutputError("no more")])
def test_a_failure_leaves_the_older_file_and_nothing_else(folder, error):
    (folder / "page.html").write_text("older")

    def fail(place):
        with replacing_file(place) as part:
            part.write_text("half of it")
            raise error

    for place in ("page.html", "reports/deep/page.html"):
        with pytest.raises((KeyboardInterrupt, OutputError)):
            fail(place)
    assert names(folder) == ["page.html"]
    assert (folder / "page.html").read_text() == "older"


def test_files_of_a_killed_process_are_removed_and_those_of_a_running_one_kept(folder):
    script = """
        import sys
        from hcsearch.system.outputs import replacing_file
        with replacing_file("out.zip") as part:
            part.write_bytes(b"half of it")
            print(part, flush=True)
            sys.stdin.read()
    """
    words = [sys.executable, "-c", textwrap.dedent(script)]
    kept, killed = (subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) for _ in range(2))
    parts = [Path(writer.stdout.readline().strip()).name for writer in (kept, killed)]
    killed.kill()
    killed.communicate()
    others = [".part", ".0123456789abcdef.part.d", ".notes.part", "0123456789abcdef.part"]
    (folder / others[1]).mkdir()
    for name in (others[0], *others[2:]):
        (folder / name).touch()
    assert set(names(folder)) == {*parts, *others}
    write_output("page.html", "whole")
    assert set(names(folder)) == {parts[0], "page.html", *others}
    kept.communicate("")
    assert (folder / "out.zip").read_bytes() == b"half of it"
    assert set(names(folder)) == {"out.zip", "page.html", *others}


def test_a_disk_that_is_found_full_only_at_the_end_leaves_the_older_file(folder, monkeypatch):
    def full(_number):
        raise OSError(28, "No space left on device")

    write_output("page.html", "older")
    monkeypatch.setattr(outputs.os, "fsync", full)
    with pytest.raises(OutputError, match=r"cannot write 'page\.html', No space left on device: make room"):
        write_output("page.html", "newer")
    assert names(folder) == ["page.html"]
    assert (folder / "page.html").read_text() == "older"


def test_a_database_that_appears_meanwhile_is_not_replaced(folder):
    def write():
        with replacing_file("late.toml") as part:
            part.write_text("x")
            open_database("late.toml", create=True).close()

    with pytest.raises(OutputError, match="it is a database"):
        write()
    assert names(folder) == ["late.toml"]


def test_places_that_cannot_be_written(folder):
    (folder / "file").touch()
    os.mkfifo("pipe")
    (folder / "loop").symlink_to("loop")
    (folder / "to-a-folder").symlink_to(".")
    before = names(folder)
    for place, reason in (
        ("/", "/ is a folder: name a file"),
        ("", ". is a folder: name a file"),
        ("to-a-folder", "is a folder: name a file"),
        ("nowhere/out", "there is no folder nowhere: make it, or write to another"),
        ("file/out", "there is no folder file: make it, or write to another"),
        ("no\x1bwhere/out", r"no\\x1bwhere"),
        ("pipe", "it is not a file"),
        ("/dev/full", "it is not a file"),
        ("loop", "it is not a file"),
        ("x" * 300, "File name too long"),
        ("bad\0name", "zero byte"),
        ("\ud800.html", "no file has such a name"),
    ):
        for attempt in (lambda place: write_output(place, "x"), check_output):
            with pytest.raises(OutputError, match=reason) as caught:
                attempt(place)
            assert str(caught.value).isprintable()
    assert names(folder) == before


def test_a_file_that_may_not_be_written_is_kept(folder, monkeypatch):
    (folder / "old").write_text("older")
    real = os.access
    # The superuser, whom tests may run as, is refused nothing; so the answer of the system is made up.
    monkeypatch.setattr(outputs.os, "access", lambda path, mode: real(path, mode) and path.name != "old")
    with pytest.raises(OutputError, match="old may not be written"):
        write_output("old", "newer")
    assert (folder / "old").read_text() == "older"


def test_only_the_default_folder_is_made(folder):
    write_output("reports/deep/page.html", "x")
    make_folder("reports/bench")
    make_folder("new")
    for refused in ("missing/new", "reports/deep/page.html", "reports/deep/page.html/x"):
        with pytest.raises(OutputError):
            make_folder(refused)
        with pytest.raises(OutputError):
            check_folder(refused)
    check_folder("other")
    assert names(folder) == ["new", "reports"]


@pytest.fixture
def databases(folder):
    """Databases of ours under names that commands write, one with its first bytes destroyed, and a stranger's."""
    open_database("ours.sqlite", create=True).close()
    content = (folder / "ours.sqlite").read_bytes()
    for name in ("ours.csv", "ours.svg", "ours.toml"):
        (folder / name).write_bytes(content)
    (folder / "damaged.sqlite").write_bytes(bytes(16) + content[16:])
    with closing(sqlite3.connect("foreign.sqlite")) as connection:
        connection.execute("CREATE TABLE mine (x)")
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        ("assembly unit-i --picture ours.sqlite", "it is a database"),
        ("bench identification --quick --json damaged.sqlite", "it is a database"),
        ("bench identification --quick --output ours.sqlite", "is not a folder"),
        ("query --db ours.sqlite --output foreign.sqlite", "it is a database"),
        ("report --db ours.sqlite --output ours.sqlite-wal", "it belongs to a database"),
        ("deploy unit-i --output ours.csv", "it is a database"),
        ("deploy unit-i --picture ours.svg", "it is a database"),
        ("tune unit-i --output ours.toml", "it is a database"),
    ],
)
def test_no_command_overwrites_a_database(folder, databases, words, reason):
    done = CliRunner().invoke(hcsearch, words.split())
    assert isinstance(done.exception, OutputError)
    assert reason in str(done.exception)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == databases


def test_a_full_disk_keeps_the_good_page(folder):
    open_database("d.sqlite", create=True).close()
    many = "WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c LIMIT 20000) SELECT x FROM c"
    words = [
        sys.executable,
        "-m",
        "hcsearch",
        "query",
        "--db",
        "d.sqlite",
        "--format",
        "csv",
        "--output",
        "page.html",
        "--sql",
        many,
    ]
    (folder / "page.html").write_text("good")
    # SQLite itself needs 32 KiB for its shared memory
    done = subprocess.run(limited(words, 40_000), capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith("hcsearch: cannot write 'page.html', File too large: make room")
    assert done.stderr.count("\n") == 1
    assert (folder / "page.html").read_text() == "good"
    assert names(folder) == ["d.sqlite", "page.html"]


def test_commands_that_show_names_hold_no_mark_that_terminals_lack(folder):
    enumerated = CliRunner().invoke(
        hcsearch, ["enumerate", "--grid", "hex", "--n", "10", "--until", "twist", "--db", "s.sqlite"]
    )
    assert enumerated.exit_code == 0
    (folder / "s.sqlite").rename("s\udce9.sqlite")
    with open_database("s\udce9.sqlite", create=False) as database:
        judge(database, [("hex:0234435011", 1, "movable", 0.5, 0.2)])
        number = find_design(database, "hex:0234435011")["id"]
    shown = CliRunner().invoke(hcsearch, ["show", str(number), "--db", "s\udce9.sqlite"])
    assert (shown.exit_code, shown.exception) == (0, None)
    assert "s\\udce9.sqlite" in shown.output
