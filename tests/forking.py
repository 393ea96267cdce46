"""Commands that begin where one has loaded: processes forked from one in which the program has run already.

A command that starts from nothing spends more time on loading than most tests on what they are about. A forked one is
a process of its own all the same, with its own session, files and signals: it can be killed, interrupted and waited
for. What a user sees at the very start is tested with commands that are started as a user starts them.
"""

from __future__ import annotations

import atexit
import gc
import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import redirect_stderr, redirect_stdout, suppress
from functools import cache
from pathlib import Path

LONGEST = 1 << 20  # bytes of a request


class Forked:
    """A command on its way, as much of `subprocess.Popen` as tests use."""

    def __init__(self, words, stdin, stdout, stderr, cwd=None, env=None):
        here, there = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        place, variables = str(cwd or Path.cwd()), dict(os.environ) if env is None else env
        request = {"words": [str(word) for word in words], "cwd": place, "env": variables}
        socket.send_fds(_server(), [json.dumps(request).encode()], [stdin, stdout, stderr, there.fileno()])
        there.close()
        self._line = here
        self.returncode = None
        self.pid = int(here.recv(100))

    def poll(self):
        """The exit code, or None while it runs."""
        with suppress(TimeoutError, BlockingIOError):
            self._hear(0.0)
        return self.returncode

    def wait(self, timeout):
        """Wait for the exit code."""
        try:
            self._hear(timeout)
        except TimeoutError:
            raise subprocess.TimeoutExpired("hcsearch", timeout) from None
        return self.returncode

    def _hear(self, timeout):
        if self.returncode is None:
            self._line.settimeout(timeout)
            self.returncode = int(self._line.recv(100))
            self._line.close()


def run(words, *, cwd=None, env=None, timeout=300, **streams):
    """Run a command to its end: `subprocess.CompletedProcess` with its output as text."""
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err, Path(os.devnull).open("rb") as nothing:
        own = {"stdin": nothing, "stdout": out, "stderr": err}
        numbers = [_number(streams.get(name, file)) for name, file in own.items()]
        process = Forked(words, *numbers, cwd, env)
        try:
            code = process.wait(timeout)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            raise
        texts = [(file.seek(0), file.read().decode())[1] for file in (out, err)]
    return subprocess.CompletedProcess(words, code, *texts)


def _number(file):
    return file if isinstance(file, int) else file.fileno()


@cache
def _server():
    """The socket of the process that all are forked from; it ends with this process."""
    here, there = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    here.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, LONGEST)
    line = [sys.executable, "-m", "tests.forking", str(there.fileno())]
    root = Path(__file__).parent.parent
    process = subprocess.Popen(
        line, pass_fds=[there.fileno()], cwd=root, stdin=subprocess.DEVNULL, start_new_session=True
    )
    there.close()

    @atexit.register
    def end():
        here.close()
        process.wait(10)

    return here


def _load():
    """Load the program, and the kernels of its commands, by running them."""
    from tqdm import tqdm

    from hcsearch.cli import hcsearch

    interval, tqdm.monitor_interval = tqdm.monitor_interval, 0  # else it has a thread
    tqdm.set_lock(threading.RLock())  # its own is one for all that are forked, and stays locked by one that is killed
    with tempfile.TemporaryDirectory() as folder:
        db = ("--db", str(Path(folder) / "designs.sqlite"))
        for words in (
            ("enumerate", "--grid", "hex", "--n", "8", *db),
            ("enumerate", "--grid", "hex", "--n", "8", *db),
            ("query", "n=8", *db),
            ("rank", *db),
        ):
            hcsearch.main(words, standalone_mode=False)
    tqdm.monitor_interval = interval
    while threading.active_count() > 1:  # only this thread lives on in a forked process
        time.sleep(0.01)
    gc.freeze()  # else every process would copy what it has not even used


def _serve(place):
    """Fork a process for each request; return in it with what it was asked for."""
    with socket.socket(fileno=place) as server:
        while True:
            request, numbers, _, _ = socket.recv_fds(server, LONGEST, 4)
            if not request:
                os._exit(0)  # who asked has ended
            if not os.fork():
                break
            for number in numbers:
                os.close(number)
    *streams, line = numbers
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    # one more process, that waits for the command and passes its exit code on
    child = os.fork()
    if child:
        for stream in streams:
            os.close(stream)
        with socket.socket(fileno=line) as asker, suppress(OSError):
            _, status = os.waitpid(child, 0)
            asker.send(str(os.waitstatus_to_exitcode(status)).encode())
        os._exit(0)
    os.setsid()
    with socket.socket(fileno=line) as asker:  # who knows the number may signal the group at once: now there is one
        asker.send(str(os.getpid()).encode())
    for number, stream in enumerate(streams):
        os.dup2(stream, number)
        os.close(stream)
    return json.loads(request)


def _become(request):
    """Look like a process that was started with the words and nothing else."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    import hcsearch.__main__ as program

    os.chdir(request["cwd"])
    os.environ.clear()
    os.environ.update(request["env"])
    sys.path[0] = request["cwd"]
    sys.argv = [program.__file__, *request["words"]]
    sys.modules["__main__"] = program  # which spawned processes look for
    sys.stdin = open(0, closefd=False)  # noqa: SIM115
    sys.stdout = open(1, "w", buffering=1 if os.isatty(1) else -1, closefd=False)  # noqa: SIM115
    sys.stderr = open(2, "w", buffering=1, errors="backslashreplace", closefd=False)  # noqa: SIM115
    return program.main


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    with Path(os.devnull).open("w") as nowhere, redirect_stdout(nowhere), redirect_stderr(nowhere):
        _load()
    _become(_serve(int(sys.argv[1])))()
