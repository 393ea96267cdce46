"""A private PostgreSQL server that lives as long as a test session: its own folder, socket, port, user and password."""

from __future__ import annotations

import contextlib
import itertools
import os
import pwd
import shutil
import signal
import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

USER = "tester"
PASSWORD = "not:to/be@shown"
_SYSTEM_USER = "postgres"
_SETTINGS = ("fsync=off", "full_page_writes=off", "max_connections=30", "shared_buffers=64MB", "lc_messages=C")


def find_binaries() -> Path:
    """The folder of initdb and postgres; a failed test, not a skipped one, where no server is installed."""
    folders = [*sorted(Path("/usr/lib/postgresql").glob("*/bin"), key=lambda path: -float(path.parent.name))]
    if program := shutil.which("initdb"):
        folders.insert(0, Path(program).resolve().parent)
    if asked := shutil.which("pg_config"):
        done = subprocess.run([asked, "--bindir"], capture_output=True, text=True, check=True)
        folders.insert(0, Path(done.stdout.strip()))
    for folder in folders:
        if all((folder / name).exists() for name in ("initdb", "postgres")):
            return folder
    raise AssertionError("these tests need a PostgreSQL server: apt-get install postgresql")


class Server:
    """A running server; `url` names its databases. Connections over TCP need the password, those by socket do not."""

    def __init__(self, folder: Path, port: int, process: subprocess.Popen[bytes]) -> None:
        self.folder, self.port, self.process = folder, port, process
        self._numbers = itertools.count(1)

    def url(self, name: str, *, user: str = USER, password: str = PASSWORD, port: int | None = None) -> str:
        """The URL of a database, for hcsearch."""
        return f"postgresql+psycopg://{user}:{quote(password, safe='')}@127.0.0.1:{port or self.port}/{name}"

    def socket_url(self, name: str) -> str:
        """The URL of a database by the Unix socket, without a password."""
        return f"postgresql+psycopg://{USER}@/{name}?host={self.folder}&port={self.port}"

    def run(self, sql: str, name: str = "postgres") -> list[tuple[object, ...]]:
        """Run a statement as the superuser, in a transaction of its own, and return its rows."""
        import psycopg

        with psycopg.connect(host=str(self.folder), port=self.port, user=USER, dbname=name, autocommit=True) as link:
            cursor = link.execute(sql.encode())
            return cursor.fetchall() if cursor.description else []

    def is_ready(self) -> bool:
        """Wait until the server takes connections; False when it has ended instead."""
        import psycopg

        deadline = time.monotonic() + 60
        while self.process.poll() is None and time.monotonic() < deadline:
            with contextlib.suppress(psycopg.OperationalError):
                self.run("SELECT 1")
                return True
            time.sleep(0.05)
        return False

    def create_database(self) -> str:
        """Make a new, empty database and return its name; its collation is that of a person, not of bytes."""
        name = f"designs{next(self._numbers)}"
        self.run(f"CREATE DATABASE {name} TEMPLATE template0 LOCALE_PROVIDER icu ICU_LOCALE 'en' ENCODING 'UTF8'")
        return name

    def drop_database(self, name: str) -> None:
        """Drop a database, also while someone is connected to it."""
        self.run(f"DROP DATABASE IF EXISTS {name} WITH (FORCE)")


@contextlib.contextmanager
def running_server(settings: Sequence[str] = _SETTINGS) -> Iterator[Server]:
    """Start a server in a folder of its own, and leave nothing of it in the end."""
    binaries = find_binaries()
    # Not below pytest's folder: the path of a socket has room for about 100 bytes.
    folder = Path(tempfile.mkdtemp(prefix="hcsearch-pg-"))
    try:
        # PostgreSQL does not run as root.
        account = pwd.getpwnam(_SYSTEM_USER) if os.geteuid() == 0 else pwd.getpwuid(os.geteuid())
        owner = {"user": account.pw_uid, "group": account.pw_gid, "extra_groups": ()} if os.geteuid() == 0 else {}
        secret = folder / "password"
        secret.write_text(PASSWORD)
        for path in (folder, secret):
            os.chown(path, account.pw_uid, account.pw_gid)
        command = [binaries / "initdb", "--pgdata", folder / "data", "--username", USER, "--pwfile", secret]
        command += ["--encoding=UTF8", "--locale=C", "--auth-local=trust", "--auth-host=scram-sha-256", "--no-sync"]
        made = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, **owner)
        assert made.returncode == 0, made.stdout + made.stderr
        server = _start(binaries, folder, settings, owner)
        try:
            yield server
        finally:
            server.process.send_signal(signal.SIGINT)  # end all sessions, then stop
            server.process.wait(60)
    finally:
        shutil.rmtree(folder)


def _start(binaries: Path, folder: Path, settings: Sequence[str], owner: dict[str, Any]) -> Server:
    for _ in range(5):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        command = [binaries / "postgres", "-D", folder / "data", "-k", folder, "-h", "127.0.0.1", "-p", str(port)]
        command += [part for setting in settings for part in ("-c", setting)]
        with (folder / "log").open("ab") as log:
            server = Server(folder, port, subprocess.Popen(command, cwd=folder, stdout=log, stderr=log, **owner))
        if server.is_ready():
            return server
    raise AssertionError((folder / "log").read_text())  # another program took the port five times, or worse
