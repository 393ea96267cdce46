"""The machine that measures: processor, cores, memory, and versions of this program, its libraries and its peers."""

from __future__ import annotations

import os
import platform
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

_LIBRARIES = ("hcsearch", "numba", "numpy")
MISSING = "not installed"


@dataclass(frozen=True)
class Machine:
    """The machine at the start of a measurement.

    load : mean number of running processes in the minute before; above zero, others use the cores too.
    versions : by package, MISSING where there is none.
    """

    date: str
    processor: str
    cores: int
    memory_gib: float
    system: str
    load: float
    versions: dict[str, str]

    def __str__(self) -> str:
        versions = ", ".join(f"{name} {number}" for name, number in self.versions.items())
        return (
            f"{self.date}; {self.processor}, {self.cores} cores, {self.memory_gib:.0f} GiB, {self.system}; "
            f"load before the run {self.load:.2f}; {versions}"
        )


def this_machine(peers: tuple[str, ...] = ()) -> Machine:
    """Describe this machine, with the versions of the peers too."""
    return Machine(
        date=datetime.now(UTC).strftime("%Y-%m-%d"),
        processor=_processor(),
        cores=os.cpu_count() or 1,
        memory_gib=os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30,
        system=f"{platform.system()} {platform.machine()}",
        load=os.getloadavg()[0],
        versions={"python": platform.python_version()} | {name: _version(name) for name in (*_LIBRARIES, *peers)},
    )


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:  # no such file beside Linux
        return platform.processor() or platform.machine()
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(names, platform.machine())


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return MISSING
