"""Run a command in a process of its own: bounded in time, measured in time and memory."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

_POLL = 0.005  # seconds
_MAXRSS = 1 if sys.platform == "darwin" else 1024  # bytes


@dataclass(frozen=True)
class Finished:
    """How a process ended.

    status : its exit code; None when it ran past the limit and was ended.
    wall, cpu : seconds, start of the interpreter included. peak_mib : most memory it held.
    """

    status: int | None
    output: str
    error: str
    wall: float
    cpu: float
    peak_mib: float


def run_measured(command: list[str], limit: float, environment: dict[str, str] | None = None) -> Finished:
    """Run a command for at most `limit` seconds, with these environment variables beside our own."""
    with tempfile.TemporaryFile("w+") as output, tempfile.TemporaryFile("w+") as error:
        begin = time.perf_counter()
        variables = os.environ | (environment or {})
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=output, stderr=error, env=variables)
        peak = 0.0
        late = False
        try:
            while True:
                peak = max(peak, peak_memory(process.pid))
                pid, status, usage = os.wait4(process.pid, os.WNOHANG)
                if pid:
                    break
                if not late and time.perf_counter() - begin > limit:
                    late = True
                    process.kill()
                time.sleep(_POLL)
        except BaseException:
            process.kill()
            process.wait()
            raise
        wall = time.perf_counter() - begin
        process.returncode = os.waitstatus_to_exitcode(status)
        texts = [(file.seek(0), file.read())[1] for file in (output, error)]
    # the child's own maximum begins with its parent's size at the fork, so it serves only where there is no other
    peak = peak or usage.ru_maxrss * _MAXRSS / 2**20
    return Finished(
        status=None if late else process.returncode,
        output=texts[0],
        error=texts[1],
        wall=wall,
        cpu=usage.ru_utime + usage.ru_stime,
        peak_mib=peak,
    )


def peak_memory(pid: int | str = "self") -> float:
    """Most memory that a running process has held so far, in MiB; 0 where the system does not report it."""
    try:
        text = Path(f"/proc/{pid}/status").read_text(encoding="utf-8")
    except OSError:
        return 0.0
    match = re.search(r"VmHWM:\s+(\d+) kB", text)
    return int(match[1]) / 1024 if match else 0.0
