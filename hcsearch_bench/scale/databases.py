"""New databases to store into, each removed when its run is measured: SQLite files, and PostgreSQL databases."""

from __future__ import annotations

import itertools
import os
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from urllib.parse import SplitResult, unquote, urlsplit

from hcsearch.basics.errors import HcsearchError

Variables = dict[str, str]
Maker = Callable[[], AbstractContextManager[Variables]]

_SCHEMES = ("postgresql", "postgresql+psycopg")
_numbers = itertools.count(1)


def nowhere() -> AbstractContextManager[Variables]:
    """The environment of a command that stores nothing."""
    return nullcontext({})


@contextmanager
def new_sqlite() -> Iterator[Variables]:
    """The environment of a command that stores into a new SQLite file, in the folder for temporary files."""
    with tempfile.TemporaryDirectory() as folder:
        yield {"HCSEARCH_DB": str(Path(folder) / "bench.sqlite")}


def new_postgresql(url: str) -> Maker:
    """Makes new databases on the server of a URL, by its `createdb` and `dropdb`; the URL's own stays as it is.

    HcsearchError when it is no such URL, and when the server refuses.
    """
    parts = _split(url)
    if parts.scheme not in _SCHEMES:
        raise HcsearchError("the URL of the server cannot be read: give postgresql://USER@HOST/NAME")
    # the environment has the password: other users of the machine see command lines
    secret = {"PGPASSWORD": unquote(parts.password)} if parts.password else {}
    parts = parts._replace(scheme="postgresql", netloc=_without_password(parts))

    @contextmanager
    def make() -> Iterator[Variables]:
        name = f"hcsearch_bench_{os.getpid()}_{next(_numbers)}"
        _client("createdb", parts, name, secret)
        try:
            yield secret | {"HCSEARCH_DB": parts._replace(path=f"/{name}").geturl()}
        finally:
            _client("dropdb", parts, name, secret)

    return make


def _split(url: str) -> SplitResult:
    try:
        return urlsplit(url)
    except ValueError:  # the message has the URL in it, which may hold a password
        return SplitResult("", "", "", "", "")


def _without_password(parts: SplitResult) -> str:
    user, at, host = parts.netloc.rpartition("@")
    return user.partition(":")[0] + at + host


def _client(program: str, server: SplitResult, name: str, secret: Variables) -> None:
    command = [program, "--maintenance-db", server.geturl(), name]
    try:
        done = subprocess.run(command, env=os.environ | secret, capture_output=True, text=True, check=False)
    except FileNotFoundError as error:
        raise HcsearchError(
            f"PostgreSQL's client program {program} is not found: install it, or leave it out"
        ) from error
    if done.returncode:
        raise HcsearchError(" ".join(done.stderr.split()) or f"{program} failed")
