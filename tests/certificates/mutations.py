"""Mutated certificates under limits: `python -m tests.certificates.mutations COUNT SEED FILE ...` verifies so many.

Each certificate is one of the files with up to three changes of numbers, texts, sizes, types or order, mostly with a
checksum that fits. `hcsearch verify` runs in a process of its own, which may take a gigabyte more than it has at the
start, and a minute. What is printed at the end are the exit codes, and the greatest time and memory.
"""

from __future__ import annotations

import copy
import json
import math
import os
import random
import resource
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from click.testing import CliRunner

from hcsearch.cli import hcsearch
from hcsearch.motion.certificates.certificate_data import checksum

MAX_SECONDS, MAX_BYTES = 60, 2**30
ODD_NUMBERS: tuple[Any, ...] = (
    0, 1, -1, 2, 3, 7, 10**6, 10**9, 10**18, 10**30, 10**400, 0.0, -0.0, 0.5, 1e-9, 1e-300, 5e-324, 1e300, math.nan,
    math.inf, -math.inf, math.pi, math.nextafter(math.pi, 4.0), 3.1999, True, False, None,
)  # fmt: skip
ODD_TEXTS = (
    "", "0", "1", "-1", "1e-999999999", "1e999999999", "9" * 5000, "1/0", "1/3", "nan", "inf", " 2e-05\n", "\u001b[2J",
    "\ud800", "\u0661", "top", "bottom", "flat", "packed", "lock", "path", "collision", "cubics", "equal", "hinged",
    "rigid",
)  # fmt: skip
ODD_VALUES: tuple[Any, ...] = (None, [], {}, [[]], [None], {"kind": "path"}, [0] * 1000, "x")


class Outcome(NamedTuple):
    """How `hcsearch verify` ended: code is negative where a limit was met; seconds of processor, and bytes."""

    code: int
    seconds: float
    growth: int
    said: str


def places(data: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Where the values of a certificate stand."""
    if path:
        yield path
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in items:
        yield from places(value, (*path, key))


def changed(value: Any, rng: random.Random) -> Any:
    """Another value in place of one: a number, a text, a list or an object."""
    if rng.random() < 0.1:
        return copy.deepcopy(rng.choice(ODD_VALUES + ODD_NUMBERS + ODD_TEXTS))
    if isinstance(value, bool):
        return rng.choice([not value, int(value), None, "true"])
    if isinstance(value, int | float):
        near = [
            value + 1,
            value - 1,
            -value,
            2 * value,
            value * 1000,
            float(value) if abs(value) < 1e300 else 0,
            str(value),
        ]
        near += [math.nextafter(value, side) for side in (-4.0, 4.0)] if abs(value) < 1e300 else []
        return rng.choice([*near, *ODD_NUMBERS])
    if isinstance(value, str):
        return rng.choice([value + "\n", value + "0", value[:-1], value * 2, value.upper(), *ODD_TEXTS])
    if isinstance(value, list):
        own, k = list(value), rng.randrange(len(value) + 1)
        shuffled = rng.sample(own, len(own))
        ways: list[Any] = [
            own[:k],
            own[k:],
            own[:k] + own[k + 1 :],
            own[::-1],
            shuffled,
            [own],
            own * 2,
            own * rng.choice([10, 200]),
        ]
        return copy.deepcopy(rng.choice(ways))
    keys = sorted(value) if isinstance(value, dict) else []
    dropped = rng.choice(keys) if keys else None
    return {key: own for key, own in value.items() if key != dropped} if keys else rng.choice(ODD_VALUES)


def mutated(data: Any, rng: random.Random) -> str:
    """A changed certificate as text."""
    data = copy.deepcopy(data)
    for _ in range(rng.randint(1, 3)):
        every = list(places(data))
        if not every:
            break
        depth = rng.choice(sorted({len(path) for path in every}))  # else nearly all are numbers of lists
        path = rng.choice([path for path in every if len(path) == depth])
        place = data
        for key in path[:-1]:
            place = place[key]
        if rng.random() < 0.2:  # what stands at another place
            other: Any = data
            for key in rng.choice(every):
                other = other[key]
            place[path[-1]] = copy.deepcopy(other)
        else:
            place[path[-1]] = changed(place[path[-1]], rng)
    if isinstance(data, dict) and rng.random() < 0.95:
        data["sha256"] = checksum({key: value for key, value in data.items() if key != "sha256"})
    text = json.dumps(data)
    if rng.random() < 0.05:
        k = rng.randrange(len(text))
        text = rng.choice([text[:k], text[:k] + rng.choice('[]{}",:0\n\u00e9') + text[k:], text[k:], text + text])
    return text


def used_bytes() -> int:
    """The address space of this process."""
    return int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()


def verified(file: Path, *options: str) -> Outcome:
    """Run `hcsearch verify` in a process of its own, under limits of time and memory."""
    reader, writer = os.pipe()
    child = os.fork()
    if not child:
        try:
            os.close(reader)
            resource.setrlimit(resource.RLIMIT_AS, (used_bytes() + MAX_BYTES,) * 2)
            resource.setrlimit(resource.RLIMIT_CPU, (MAX_SECONDS, MAX_SECONDS))
            signal.alarm(4 * MAX_SECONDS)
            before = resource.getrusage(resource.RUSAGE_SELF)
            start = time.process_time()
            result = CliRunner().invoke(hcsearch, ["verify", str(file), *options])
            after = resource.getrusage(resource.RUSAGE_SELF)
            said = (result.stdout + result.stderr)[-300:]
            told = [result.exit_code, time.process_time() - start, (after.ru_maxrss - before.ru_maxrss) * 1024, said]
            os.write(writer, json.dumps(told).encode())
        finally:
            os._exit(0)
    os.close(writer)
    with os.fdopen(reader, "rb") as stream:
        told = stream.read()
    _, status = os.waitpid(child, 0)
    if not told:
        return Outcome(-os.waitstatus_to_exitcode(status) or -1, float(MAX_SECONDS), MAX_BYTES, "ended by a limit")
    return Outcome(*json.loads(told))


def main(count: int, seed: int, files: list[str]) -> None:
    """Verify mutated certificates, and print what happened."""
    rng, codes, seconds, growth = random.Random(seed), Counter[int](), 0.0, 0
    texts = [Path(file).read_text(encoding="utf-8") for file in files]
    sources = []
    for text in texts:
        try:
            sources.append(json.loads(text))
        except (ValueError, RecursionError):
            sources.append(text)
    CliRunner().invoke(hcsearch, ["verify", files[0]])  # what it imports is there when processes begin
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "mutated.json"
        for number in range(count):
            text = mutated(rng.choice(sources), rng)
            file.write_bytes(text.encode("utf-8", "surrogatepass"))
            own = verified(file)
            codes[own.code] += 1
            seconds, growth = max(seconds, own.seconds), max(growth, own.growth)
            if own.code not in (0, 1, 2) or own.seconds > 20 or own.growth > 2**28:
                kept = Path(tempfile.gettempdir()) / f"mutated-{seed}-{number}.json"
                kept.write_bytes(file.read_bytes())
                print(f"{kept}: {own}", flush=True)
            if number % 1000 == 999:
                print(f"{number + 1} of {count}: {dict(codes)}, {seconds:.1f} s, {growth / 2**20:.0f} MB", flush=True)
    print(f"{count} certificates: codes {dict(codes)}, at most {seconds:.1f} s and {growth / 2**20:.0f} MB more each")


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), sys.argv[3:])
