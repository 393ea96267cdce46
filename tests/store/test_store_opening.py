import errno
import fcntl
import os
import sqlite3
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from store_samples import begin, record

from hcsearch.basics.errors import DatabaseError, QueryError
from hcsearch.store import database as database_module
from hcsearch.store import location, migrate, open_database, open_readonly, select, sqlite
from hcsearch.store.schema import APPLICATION_ID


def refusal(opener, *args, **options):
    """The message of a refusal: one line, and a remedy after the colon."""
    with pytest.raises(DatabaseError) as caught:
        opener(*args, **options)
    message = str(caught.value)
    assert "\n" not in message
    assert ": " in message
    return message


def every_way(place):
    """The refusals of all three ways to open a database."""
    return [
        refusal(open_database, str(place), create=True),
        refusal(open_database, str(place), create=False),
        refusal(open_readonly, str(place)),
    ]


def files(folder):
    return {file.name: file.read_bytes() for file in folder.iterdir() if file.is_file()}


@pytest.mark.parametrize("name", ["plain", "a b", "a?mode=memory", "a#b", "100%25", "é", "a'b", "-x", "a&b=c"])
def test_any_file_name_works(tmp_path, name):
    place = tmp_path / name
    with open_database(str(place), create=True) as database:
        begin(database)
    with open_database(str(place), create=False) as database, open_readonly(str(place)) as reader:
        begin(database)
        assert len(select(reader, view="runs").rows) == 2
    assert {file for file in files(tmp_path) if not file.endswith(("-wal", "-shm"))} == {name}


def test_name_that_is_not_utf8(tmp_path):
    place = os.fsdecode(os.fsencode(tmp_path) + b"/\xff.sqlite")
    with open_database(place, create=True) as database:
        begin(database)
        database.location.encode()
    with open_readonly(place) as reader:
        assert len(select(reader, view="runs").rows) == 1


def test_sqlite_url_names_the_same_file(path):
    with open_database(f"sqlite:///{path}", create=True) as database:
        assert database.location == str(path)
        begin(database)
    with open_readonly(str(path)) as reader:
        assert len(select(reader, view="runs").rows) == 1


def test_settings_of_a_new_file(path):
    with open_database(str(path), create=True) as database, database.reading() as connection:

        def pragma(name):
            return connection.exec_driver_sql(f"PRAGMA {name}").scalar()

        assert pragma("journal_mode") == "wal"
        assert pragma("foreign_keys") == 1
        assert pragma("busy_timeout") == 60_000
        assert pragma("application_id") == APPLICATION_ID
    assert path.read_bytes()[68:72] == APPLICATION_ID.to_bytes(4, "big")


def test_pieces_of_seconds_are_on_disk_once_they_are_committed(path):
    with open_database(str(path), create=True) as database:
        for durable, setting in ((True, 2), (False, 1), (True, 2)):
            with database.writing(durable=durable) as connection:
                assert connection.exec_driver_sql("PRAGMA synchronous").scalar() == setting


def test_what_another_user_writes_is_read_where_sqlite_cannot_lock(path, monkeypatch):
    def write():
        with open_database(str(path), create=True) as database:
            begin(database)

    write()
    allowed = os.access
    monkeypatch.setattr(os, "access", lambda place, mode: mode != os.W_OK)
    with open_readonly(path) as reader:
        assert len(select(reader, view="runs").rows) == 1
        for count in (2, 3):
            monkeypatch.setattr(os, "access", allowed)
            write()
            monkeypatch.setattr(os, "access", lambda place, mode: mode != os.W_OK)
            assert len(select(reader, view="runs").rows) == count


def test_what_is_read_while_the_file_changes_is_read_again(path, monkeypatch):
    with open_database(str(path), create=True) as database:
        begin(database)
    changes = iter([True, True, False])
    monkeypatch.setattr(database_module.Database, "_has_changed", lambda *_: next(changes, True))
    with open_readonly(path) as reader:
        assert len(select(reader, view="runs").rows) == 1
        with pytest.raises(DatabaseError, match=r"is being written to.*give the command again"):
            select(reader, view="runs")


SWITCH = "import sqlite3, sys; sqlite3.connect(sys.argv[1], timeout=0).execute('PRAGMA journal_mode=DELETE')"


@pytest.mark.parametrize("written", [False, True])
def test_looks_at_a_file_give_up_no_lock_of_a_writer_in_the_same_process(path, written):
    """Closing any copy of a file gives up the locks of a process; then another program may take away the log."""
    open_database(str(path), create=True).close()
    with open_database(str(path), create=False) as database:
        if written:
            begin(database)
        with open_readonly(path) as reader:
            assert len(select(reader, view="runs").rows) == written
        open_database(str(path), create=False).close()
        other = subprocess.run([sys.executable, "-c", SWITCH, path], capture_output=True, text=True, check=False)
        assert "database is locked" in other.stderr


def test_a_disk_without_locks_is_named(path, monkeypatch):
    def refused(*_):
        raise OSError(errno.ENOLCK, "No locks available")

    message = r"is on a disk that does not lock files.*: name one on a local disk, or use PostgreSQL"
    with monkeypatch.context() as patched:
        patched.setattr(fcntl, "lockf", refused)
        with pytest.raises(DatabaseError, match=message):
            open_database(str(path), create=True)
    assert files(path.parent) == {}
    # such a disk looks to SQLite as if somebody had locked the file
    with open_database(str(path), create=True) as one, open_database(str(path), create=True, timeout=0) as other:
        monkeypatch.setattr(fcntl, "lockf", refused)
        with one.writing(), pytest.raises(DatabaseError, match=message), other.writing():
            pass


def test_an_old_sqlite_is_named_before_a_file_is_opened(path, monkeypatch):
    with open_database(str(path), create=True) as database:
        begin(database)
    before = files(path.parent)
    monkeypatch.setattr(sqlite3, "sqlite_version_info", (3, 34, 1))
    monkeypatch.setattr(sqlite3, "sqlite_version", "3.34.1")
    for place in (path, path.with_name("new.sqlite")):
        for message in every_way(place):
            assert message.startswith("the SQLite of this Python is 3.34.1, hcsearch needs 3.37 or newer: ")
    assert files(path.parent) == before


def test_paths_that_sqlite_does_not_take_are_named(tmp_path):
    folder = tmp_path
    while len(os.fsencode(folder)) < 480:
        folder /= "f" * 30
    folder.mkdir(parents=True)
    for message in every_way(folder / "designs.sqlite"):
        assert "designs.sqlite has" in message
        assert "SQLite takes 500" in message
    (tmp_path / "short").symlink_to(folder)
    for message in every_way(tmp_path / "short" / "designs.sqlite"):
        assert "designs.sqlite has" in message
    (tmp_path / "link.sqlite").symlink_to(folder / "designs.sqlite")
    for message in every_way(tmp_path / "link.sqlite"):
        assert "link.sqlite has" in message
    assert not any(folder.iterdir())
    longest = folder.parent / ("a" * (499 - len(os.fsencode(folder.parent))))
    with open_database(longest, create=True) as database:
        begin(database)


def test_a_path_that_is_no_text_of_this_system_is_refused():
    for message in every_way("a\ud800b.sqlite"):
        assert "a\\ud800b.sqlite is no path" in message


def test_databases_are_made_by_threads_at_once(tmp_path):
    with ThreadPoolExecutor(4) as pool:
        places = [tmp_path / f"{number}.sqlite" for number in range(4)]
        made = list(pool.map(lambda place: open_database(place, create=True), places))
    for database in made:
        with database:
            begin(database)


def test_opening_again_changes_nothing(path):
    open_database(str(path), create=True).close()
    before = files(path.parent)
    open_database(str(path), create=True).close()
    open_database(str(path), create=False).close()
    assert files(path.parent) == before


def test_empty_file_is_a_place_to_begin(path):
    path.touch()
    assert "make one with" in refusal(open_database, str(path), create=False)
    assert "make one with" in refusal(open_readonly, str(path))
    open_database(str(path), create=True).close()
    open_readonly(str(path)).close()


def test_missing_file_is_not_made(path):
    assert "make one with `hcsearch enumerate`" in refusal(open_database, str(path), create=False)
    assert "make one with `hcsearch enumerate`" in refusal(open_readonly, str(path))
    assert files(path.parent) == {}


def test_folder_and_device(tmp_path):
    assert all("is a folder: name a file" in message for message in every_way(tmp_path))
    assert all("is not a file" in message for message in every_way("/dev/null"))


def test_below_a_file_and_in_no_folder(tmp_path):
    (tmp_path / "file").write_text("x")
    assert all("Not a directory" in message for message in every_way(tmp_path / "file" / "a.sqlite"))
    messages = every_way(tmp_path / "none" / "a.sqlite")
    assert f"there is no folder {tmp_path / 'none'}: make it first" in messages[0]
    assert all("make one with" in message for message in messages[1:])
    assert not (tmp_path / "none").exists()


def test_folder_that_takes_no_files():
    assert "cannot be" in refusal(open_database, "/proc/hcsearch.sqlite", create=True)


@pytest.mark.parametrize("refused", ["designs.sqlite", "folder"])
def test_no_permission_to_write(tmp_path, monkeypatch, refused):
    place = tmp_path / "folder" / "designs.sqlite"
    place.parent.mkdir()
    open_database(str(place), create=True).close()
    before = files(place.parent)
    real = os.access
    # The superuser, whom tests may run as, is refused nothing; so the answer of the system is made up.
    monkeypatch.setattr(location.os, "access", lambda path, mode: real(path, mode) and Path(path).name != refused)
    assert f"{refused}, or name another" in refusal(open_database, str(place), create=True)
    assert files(place.parent) == before


def test_reading_where_nothing_can_be_written(path, monkeypatch):
    with open_database(str(path), create=True) as database:
        begin(database)
    monkeypatch.setattr(sqlite.os, "access", lambda *_: False)
    with open_readonly(str(path)) as reader:
        assert len(select(reader, view="runs").rows) == 1
    assert list(files(path.parent)) == [path.name]


@pytest.mark.parametrize("content", [b"id,grid\n1,hex\n", b"\0" * 5000, b"SQLite format 3\0" + b"\x07" * 5000])
def test_not_a_database(path, content):
    path.write_bytes(content)
    assert all("name another file" in message or "damaged" in message for message in every_way(path))
    assert files(path.parent) == {path.name: content}


def test_truncated_and_scrambled(path):
    with open_database(str(path), create=True) as database:
        record(database, [f"hex:{k}" for k in range(500)])
    whole = path.read_bytes()
    for damaged in (whole[: len(whole) // 2], whole[:100] + b"\xff" * 3000 + whole[3100:]):
        path.write_bytes(damaged)
        assert all("is damaged: restore a copy" in message for message in every_way(path))
        assert files(path.parent) == {path.name: damaged}


def test_damage_found_while_reading(path):
    with open_database(str(path), create=True) as database:
        empty = len(path.read_bytes())  # what opening reads
        record(database, [f"hex:{k}" for k in range(500)])
    content = bytearray(path.read_bytes())
    assert len(content) > empty + 4096
    content[empty:] = b"\xff" * (len(content) - empty)
    path.write_bytes(content)
    with open_readonly(str(path)) as reader, pytest.raises(DatabaseError, match="damaged"):
        [select(reader, view=view) for view in ("foldings", "designs")]


@pytest.mark.parametrize("journal", ["delete", "wal"])
def test_database_of_another_program(path, journal):
    connection = sqlite3.connect(path)
    connection.execute(f"PRAGMA journal_mode={journal}")
    connection.execute("CREATE TABLE designs (id)")
    connection.commit()
    connection.close()
    before = files(path.parent)
    assert all("tables of another program: name another database" in message for message in every_way(path))
    assert files(path.parent) == before


def test_database_of_another_program_in_use(path):
    connection = sqlite3.connect(path)
    connection.execute("PRAGMA journal_mode=wal")
    connection.execute("CREATE TABLE designs (id)")
    connection.commit()
    before = path.read_bytes()
    assert all("another program" in message for message in every_way(path))
    assert path.read_bytes() == before
    connection.close()


def test_database_that_another_program_left_in_a_crash(path, tmp_path):
    connection = sqlite3.connect(tmp_path / "in use")
    connection.execute("PRAGMA journal_mode=wal")
    connection.execute("CREATE TABLE designs (id)")
    connection.commit()
    left = {suffix: (tmp_path / f"in use{suffix}").read_bytes() for suffix in ("", "-wal")}
    connection.close()
    for suffix, content in left.items():
        path.with_name(path.name + suffix).write_bytes(content)
    assert all("another program" in message for message in every_way(path))
    # Opening it for writing would move its log into the file, looking into the log leave a -shm.
    assert files(path.parent) == {path.name + suffix: content for suffix, content in left.items()} | {
        name: content for name, content in files(path.parent).items() if name.startswith("in use")
    }


def test_half_written_transaction_is_undone(path, tmp_path):
    """A crash in a rollback journal, as when a database is made: nobody can read before it is undone."""
    source = tmp_path / "source"
    open_database(str(source), create=True).close()
    connection = sqlite3.connect(source, isolation_level=None)
    connection.execute("PRAGMA journal_mode=delete")
    connection.execute("PRAGMA cache_size=1")  # so that pages are written before the end
    connection.execute("BEGIN")
    connection.executemany(
        "INSERT INTO run (started, grid, n, target, keep, until, arguments, versions)"
        " VALUES (?, '', 1, '', '', '', '', '')",
        [("x" * 500,)] * 500,
    )
    for suffix in ("", "-journal"):
        content = (tmp_path / f"source{suffix}").read_bytes()
        path.with_name(path.name + suffix).write_bytes(content)
    connection.close()
    with open_database(str(path), create=False) as database:
        assert begin(database) == 1


def test_application_number_of_another_program(path):
    connection = sqlite3.connect(path)
    connection.executescript(f"PRAGMA application_id={APPLICATION_ID}; CREATE TABLE t (x);")
    connection.close()
    assert all("another program" in message for message in every_way(path))


def test_escapes_in_a_url_are_what_they_stand_for(tmp_path):
    with open_database(f"sqlite:///{tmp_path}/two%20words.sqlite", create=True) as database:
        assert database.path == tmp_path / "two words.sqlite"


@pytest.mark.parametrize(
    ("url", "part"),
    [
        ("", "names no database"),
        (":memory:", "names no database"),
        ("sqlite://", "names no database"),
        ("a\0b", "names no database"),
        ("nonsense://host/name", "kind 'nonsense'"),
        ("mysql+pymysql://host/name", "kind 'mysql+pymysql'"),
        ("sqlite+aiosqlite:///x", "kind 'sqlite+aiosqlite'"),
        ("postgresql+nonsense://host/name", "kind 'postgresql+nonsense'"),
        ("postgresql+psycopg_async://u:secret@host/name", "kind 'postgresql+psycopg_async'"),
        ("sqlite:///x?mode=ro", "options"),
        ("://", "cannot be read"),
        ("postgresql://u:secret@host:port/name", "cannot be read"),
        ("postgresql://u:begin@secret@host/name", "a password with @ as %40"),
        ("postgresql://u:begin@host/secret@host/name", "cannot be read"),
        ("postgresql://u/v:secret@host/name", "cannot be read"),
        ("postgresql://u/v:secret?x@host/name", "cannot be read"),
        ("postgresql://u%3Asecret@host/name", "cannot be read"),
        ("postgresql://u:secret@host/\udcff", "cannot be read"),
        ("postgresql://u\x1b:secret@host/name", "cannot be read"),
        ("postgresql:/u:secret@host/name", "cannot be read"),
        ("postgresql://host/name&password=secret", "cannot be read"),
        ("postgresql://host/name;password=secret", "cannot be read"),
        ("postgresql://host/name?port=1password=secret", "cannot be read"),
        ("postgresql://host/name?user=u%26password%3Dsecret", "cannot be read"),
        ("postgresql://u secret@host/name", "cannot be read"),
        ("postgresql://host/name?host=a,b&port=1", "cannot be read"),
        ("postgresql://host/name?host=a&host=b&port=x", "cannot be read"),
        ("postgresql:/host/name?user=u&password=secret", "cannot be read"),
        ("postgresql:u:secret@host/name", "cannot be read"),
        ("PostgreSQL//u:secret@host/name", "cannot be read"),
        ("host=h user=u password=secret dbname=d", "cannot be read"),
        ("host=h password = 'secret'", "cannot be read"),
        ("host/d?sslpassword%3Dsecret", "cannot be read"),
        ("jdbc:postgresql://host/d?user=u&password=secret", "cannot be read"),
        ("postgresql://u:secret@[::1/d", "cannot be read"),
        ("postgresql:\\\\u:secret@host\\d", "cannot be read"),
        ("postgres://u:secret@host/d", "kind 'postgres'"),
        ("https://u:secret@host/d", "kind 'https'"),
        ("PGPASSWORD=secret host=h", "cannot be read"),
        ("u:secret@host.sqlite\0", "names no database"),
        ("postgresql://h/d&password=secret", "cannot be read"),
        ("postgresql://h/d;password=secret", "cannot be read"),
        ("postgresql://h/user=u password=secret", "cannot be read"),
        ("postgresql://u secret@h/d", "cannot be read"),
        ("postgresql://h/d?user=u%26password%3Dsecret", "cannot be read"),
        ("postgresql://h/d?user=u:secret@x", "cannot be read"),
        ("postgresql://127.0.0.1:1/d?port=1password=secret", "cannot be read"),
        ("postgresql:///d?port=abc", "cannot be read"),
        ("postgresql:///d?host=a,b&port=1", "cannot be read"),
        ("postgresql:///d?port=1&port=2", "cannot be read"),
        ("postgresql:///d?host=a&host=b&port=x", "cannot be read"),
        ("user=u pass:secret", "cannot be read"),
        ("host=h user=u pw=secret", "cannot be read"),
        ("sqlite:///%00", "names no database that lasts"),
        ("postgresql://host/name%26password%3Dsecret", "cannot be read"),
        ("sqlite:///x?password=secret", "options"),
        ("sqlite://u:secret@host/x", "a host"),
    ],
)
def test_urls_that_cannot_be_used(url, part, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for message in every_way(url):
        assert part in message
        assert "secret" not in message
    assert files(tmp_path) == {}


@pytest.mark.parametrize(
    "url",
    [
        "postgresql://u:secret@host/name",
        "postgresql://u:%40secret%40@host/name",
        "postgresql://u:?secret#secret@host/name",
        "postgresql+psycopg://host/n?password=secret",
        "postgresql+psycopg://host/n?passwd=secret&PASSWORD=secret&options=-c%20x%3Dsecret",
        "postgresql+psycopg://host/n?dbname=postgresql://u:secret@host/name",
    ],
)
def test_missing_driver(monkeypatch, url):
    monkeypatch.setitem(sys.modules, "psycopg", None)
    for message in every_way(url):
        assert "pip install 'hcsearch[postgresql]'" in message
        assert "secret" not in message


def test_locked_too_long(path):
    open_database(str(path), create=True).close()
    holder = sqlite3.connect(path, isolation_level=None)
    holder.execute("BEGIN IMMEDIATE")
    with open_database(str(path), create=False, timeout=0.05) as database:
        with pytest.raises(DatabaseError, match="locked by another program: wait"):
            begin(database)
        holder.execute("ROLLBACK")
        assert begin(database) == 1
    holder.close()


def test_creation_waits_for_a_lock_only_so_long(path):
    holder = sqlite3.connect(path, isolation_level=None)
    holder.execute("BEGIN EXCLUSIVE")
    assert "locked by another program" in refusal(open_database, str(path), create=True, timeout=0.05)
    holder.execute("ROLLBACK")
    holder.close()
    open_database(str(path), create=True, timeout=0.05).close()


def test_failed_creation_leaves_no_file(path, monkeypatch):
    def fail(_connection):
        raise KeyboardInterrupt

    monkeypatch.setattr(migrate, "_run_migrations", fail)
    with pytest.raises(KeyboardInterrupt):
        open_database(str(path), create=True)
    assert files(path.parent) == {}


def refuse(path, meanwhile=lambda _database: None):
    """Refuse something after the database was opened."""

    def work():
        with open_database(str(path), create=True) as database:
            meanwhile(database)
            raise QueryError("no")

    with pytest.raises(QueryError):
        work()


def test_a_refusal_removes_the_file_that_was_made_for_it(path):
    refuse(path)
    assert files(path.parent) == {}
    path.touch()
    refuse(path)
    assert files(path.parent) == {}


def test_a_refusal_keeps_what_was_there_before_or_is_used(path):
    refuse(path, begin)
    with open_readonly(str(path)) as reader:
        assert len(select(reader, view="runs").rows) == 1
    open_database(str(path.with_name("old")), create=True).close()
    refuse(path.with_name("old"))
    others = []
    refuse(path.with_name("new"), lambda _: others.append(open_database(str(path.with_name("new")), create=False)))
    begin(others[0])
    others[0].close()
    assert sorted(files(path.parent)) == sorted([path.name, "new", "old"])


def test_an_interrupt_keeps_the_file_that_was_made(path):
    with pytest.raises(KeyboardInterrupt), open_database(str(path), create=True):
        raise KeyboardInterrupt
    assert list(files(path.parent)) == [path.name]


def test_file_removed_while_it_is_made(path, monkeypatch):
    real = database_module._upgrade_file
    calls = []

    def upgrade_and_lose(place, timeout):
        real(place, timeout)
        calls.append(place)
        if len(calls) == 1:
            path.unlink()

    monkeypatch.setattr(database_module, "_upgrade_file", upgrade_and_lose)
    with open_database(str(path), create=True) as database:
        begin(database)
    assert len(calls) == 2
    assert path.stat().st_size > 0


def test_readonly_refuses_to_write(path):
    open_database(str(path), create=True).close()
    with open_readonly(str(path)) as reader, pytest.raises(DatabaseError, match="read-only"):
        begin(reader)


def test_importing_costs_no_sqlalchemy_and_opening_no_alembic(path):
    open_database(str(path), create=True).close()
    code = (
        "import sys, hcsearch.store.columns\n"
        "assert 'sqlalchemy' not in sys.modules\n"
        "from hcsearch.store import open_database\n"
        "open_database(sys.argv[1], create=False).close()\n"
        "assert 'alembic' not in sys.modules and 'pandas' not in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", code, str(path)], check=True)


def test_unknown_name_of_the_package():
    import hcsearch.store

    with pytest.raises(AttributeError, match="nonsense"):
        hcsearch.store.nonsense  # noqa: B018 - the look-up is the test
    assert all(getattr(hcsearch.store, name) is not None for name in hcsearch.store.__all__)


INTERRUPTED_RETURN = """
import sys
from sqlalchemy import event
from hcsearch.store import open_database

def interrupt(*_):
    raise KeyboardInterrupt

with open_database(sys.argv[1], create=True) as database:
    event.listen(database.engine, "reset", interrupt)
    try:
        with database.reading():
            pass
    except KeyboardInterrupt:
        print("interrupted")
"""


def test_an_interrupt_while_a_connection_returns_to_its_pool_prints_no_traceback(path):
    command = [sys.executable, "-c", INTERRUPTED_RETURN, str(path)]
    ended = subprocess.run(command, capture_output=True, text=True, check=True)
    assert (ended.stdout, ended.stderr) == ("interrupted\n", "")


@pytest.mark.extra
@pytest.mark.parametrize("name", ["sslmode", "connect_timeout", "gssencmode", "service", "target_session_attrs"])
def test_values_of_options_are_not_repeated(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for message in every_way(f"postgresql://127.0.0.1:1/name?{name}=secret"):
        assert f"{name}=***" in message
        assert "secret" not in message
