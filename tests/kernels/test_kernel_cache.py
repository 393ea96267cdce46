"""Compiled kernels are made once, read again anywhere, and made again exactly when what they run has changed."""

import importlib
import os
import pickle
import pkgutil
import shutil
import subprocess
import sys
import tempfile
import textwrap
import threading
import time
from functools import reduce
from itertools import count
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

import llvmlite.binding as llvm
import numba
import numpy as np
import platformdirs
import pytest
from click.testing import CliRunner
from numba.core.bytecode import FunctionIdentity
from numba.core.caching import FunctionCache, NullCache
from numba.core.codegen import CPUCodegen
from numba.core.cpu import CPUContext
from numba.core.dispatcher import Dispatcher
from numba.core.errors import TypingError
from platformdirs.macos import MacOS
from platformdirs.unix import Unix
from platformdirs.windows import Windows

import hcsearch.kernels
from hcsearch.cli.compile import compile_
from hcsearch.kernels.circuits.words import insert_fingerprints
from hcsearch.kernels.compiling import cache_folder, kernel_cache, numba_internals, under_way
from hcsearch.kernels.compiling.numba_internals import NUMBA_INTERNALS, has_internals
from hcsearch.kernels.compiling.stamps import kernel_stamp

NUMBERS = count()
LOW = '''
from typing import NamedTuple
import math
import numpy as np
from hcsearch.kernels.compiling.compiled import compiled

FACTOR = 2.0
TABLE = np.array([1.0, 2.0])

class Pair(NamedTuple):
    one: float
    two: float

@compiled
def scaled(x):
    """Once."""
    return FACTOR * x

@compiled
def other(x):
    return x + TABLE[1]

@compiled
def pair_of(x):
    return Pair(x, math.sqrt(x)), np.ones(2)

@compiled
def paired(x):
    return pair_of(x)[0].two
'''
HIGH = """
from PACKAGE import low
from PACKAGE.low import other, scaled
from hcsearch.kernels.compiling.compiled import compiled

@compiled
def between(x):
    return scaled(x)

@compiled
def through(x):
    return between(x) + 1.0

@compiled
def apart(x):
    return other(x)

@compiled
def qualified(x):
    return low.paired(x)

@compiled
def itself(n):
    return 1.0 if n < 1 else n * itself(n - 1)
"""


@pytest.fixture(autouse=True)
def _nothing_said_before():
    yield
    cache_folder._writable.cache_clear()
    cache_folder.warn_once.cache_clear()


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty cache."""
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache" / "hcsearch"


@pytest.fixture
def load(tmp_path, monkeypatch):
    """Imports kernels anew, edited, under the same name and from another place each time."""

    def load(*edits):
        place = tmp_path / f"copy-{next(NUMBERS)}"
        (place / "kernels_of_a_test").mkdir(parents=True)
        for name, text in (("__init__", ""), ("low", LOW), ("high", HIGH.replace("PACKAGE", "kernels_of_a_test"))):
            edited = reduce(lambda text, edit: text.replace(*edit), edits, text)
            (place / "kernels_of_a_test" / f"{name}.py").write_text(edited)
        for name in [name for name in sys.modules if name.startswith("kernels_of_a_test")]:
            monkeypatch.delitem(sys.modules, name)
        monkeypatch.syspath_prepend(place)
        return importlib.import_module("kernels_of_a_test.high")

    return load


KERNELS = ("scaled", "other", "paired", "through", "apart", "qualified", "itself")


def stamps(module):
    return {name: kernel_stamp(getattr(module, name, getattr(module.low, name, None))) for name in KERNELS}


def misses(kernel):
    return sum(kernel.stats.cache_misses.values())


@pytest.mark.parametrize(
    ("old", "new", "changed"),
    [
        ("FACTOR * x", "FACTOR * x + 1.0", {"scaled", "through"}),
        ("FACTOR = 2.0", "FACTOR = 2", {"scaled", "through"}),
        ("[1.0, 2.0]", "[1.0, 3.0]", {"other", "apart"}),
        ("two: float", "two: float\n    three: float = 0.0", {"paired", "qualified"}),
        ("math.sqrt", "np.sqrt", {"paired", "qualified"}),
        ("return scaled(x)", "return 3.0 * scaled(x)", {"through"}),
        ("n * itself", "2 * n * itself", {"itself"}),
        ('(x):\n    """Once.', '(x: float) -> float:\n    # why\n    """Many times.', set()),
        ("FACTOR = 2.0", "UNUSED = 1\nFACTOR = 2.0", set()),
    ],
)
def test_an_edit_changes_the_stamps_of_what_it_touches_and_of_what_calls_that(load, old, new, changed):
    before, after = stamps(load()), stamps(load((old, new)))
    assert {name for name in KERNELS if before[name] != after[name]} == changed


def test_every_kernel_has_a_stamp_of_its_own():
    stamps = {}
    for module in pkgutil.walk_packages(hcsearch.kernels.__path__, "hcsearch.kernels."):
        for kernel in vars(importlib.import_module(module.name)).values():
            if isinstance(kernel, Dispatcher) and kernel.__module__ == module.name:
                stamps[kernel] = kernel_stamp(kernel)
    assert len(stamps) > 200
    assert len(set(stamps.values())) == len(stamps)


def test_a_stamp_is_that_of_versions_and_settings_too(load, monkeypatch):
    module = load()
    before = stamps(module)
    monkeypatch.setenv("NUMBA_OPT", "2")
    monkeypatch.setattr(numba.config, "OPT", 2)
    assert not set(before.values()) & set(stamps(module).values())
    monkeypatch.undo()
    assert stamps(module) == before
    monkeypatch.setattr(numba, "__version__", "0.0")
    assert not set(before.values()) & set(stamps(module).values())


def test_our_settings_hold_for_our_kernels_alone(folder, load, monkeypatch):
    before = numba.config.OPT, numba.config.LOOP_VECTORIZE
    seen = []
    build = CPUCodegen._module_pass_manager

    def building(codegen, **options):
        seen.append((numba.config.OPT, numba.config.LOOP_VECTORIZE))
        return build(codegen, **options)

    monkeypatch.setattr(CPUCodegen, "_module_pass_manager", building)
    assert load().low.scaled(1.0) == 2.0
    assert set(seen) == {(1, 0)}
    seen.clear()
    assert numba.njit(lambda x: x + 1.0)(1.0) == 2.0
    assert set(seen) == {before}


def test_slices_are_part_of_a_stamp(load):
    """Code of Python 3.14 and newer has them as constants."""
    parts = ("slice(None)", "slice(1)", "slice(2)", "slice(1, None)", "slice(None, None, 1)")
    assert len({kernel_stamp(load(("FACTOR = 2.0", f"FACTOR = {part}")).scaled) for part in parts}) == len(parts)


def test_what_cannot_be_stamped_is_named(load):
    module = load(("FACTOR = 2.0", "FACTOR = object()"))
    with pytest.raises(TypeError, match=r"low\.scaled uses <object .*: give it a constant instead"):
        kernel_stamp(module.scaled)


def test_a_copy_compiles_nothing_and_an_edit_what_it_touches(folder, load):
    first = load()
    assert (first.through(1.0), first.apart(1.0)) == (3.0, 3.0)
    assert [misses(kernel) for kernel in (first.through, first.scaled, first.apart, first.other)] == [1, 1, 1, 1]
    copy = load()
    assert (copy.through(1.0), copy.apart(1.0)) == (3.0, 3.0)
    assert [misses(kernel) for kernel in (copy.through, copy.scaled, copy.apart, copy.other)] == [0, 0, 0, 0]
    edited = load(("FACTOR = 2.0", "FACTOR = 5.0"))
    assert (edited.through(1.0), edited.apart(1.0)) == (6.0, 3.0)
    assert [misses(kernel) for kernel in (edited.through, edited.scaled, edited.apart)] == [1, 1, 0]
    assert load().through(1.0) == 3.0  # both are kept
    assert len(list(folder.glob("*.kernel"))) == 8


def run(script, *arguments, **environment):
    """Start a Python process."""
    return subprocess.Popen(
        [sys.executable, "-P", "-c", textwrap.dedent(script), *map(str, arguments)],
        env=os.environ | {name: str(value) for name, value in environment.items()},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )


def test_a_copy_of_the_package_compiles_nothing(tmp_path):
    assert insert_fingerprints(np.ones((1, 2), np.uint64), np.zeros((4, 2), np.uint64)) == 1
    package = Path(hcsearch.__file__).parent
    for name in ("basics", "kernels"):
        shutil.copytree(package / name, tmp_path / "hcsearch" / name, ignore=shutil.ignore_patterns("*pycache*"))
    shutil.copy(package / "__init__.py", tmp_path / "hcsearch")
    script = """
        import numpy as np
        from hcsearch.kernels.circuits.words import __file__, insert_fingerprints as insert
        insert(np.ones((1, 2), np.uint64), np.zeros((4, 2), np.uint64))
        print(__file__, sum(insert.stats.cache_hits.values()), sum(insert.stats.cache_misses.values()))
    """
    other = run(script, PYTHONPATH=tmp_path)
    assert other.communicate()[0] == f"{tmp_path}/hcsearch/kernels/circuits/words.py 1 0\n"


def test_two_processes_compile_each_kernel_once(folder, load):
    place = Path(load().__file__).parents[1]
    script = """
        import sys
        from kernels_of_a_test.high import other, scaled, through, apart
        print("ready", flush=True)
        sys.stdin.readline()
        assert (through(1.0), apart(1.0)) == (3.0, 3.0)
        print(*(sum(kernel.stats.cache_misses.values()) for kernel in (other, scaled, through, apart)))
    """
    others = [run(script, PYTHONPATH=f"{place}:{Path.cwd()}", NUMBA_CACHE_DIR=folder.parent) for _ in range(2)]
    for other in others:
        assert other.stdout.readline() == "ready\n"
    counts = np.array([other.communicate("go\n")[0].split() for other in others], int)
    assert counts.sum(axis=0).tolist() == [1, 1, 1, 1]


def has_waited(folder, name):
    """Claim a name and give it back: whether another process held it."""
    with mock.patch("time.sleep", wraps=time.sleep) as sleep:
        cache_folder.release_kernel(cache_folder.claim_kernel(folder, name))
    return sleep.called


def test_a_claim_ends_with_the_process_that_holds_it(tmp_path):
    script = """
        import sys, time
        from pathlib import Path
        from hcsearch.kernels.compiling.cache_folder import claim_kernel
        held = claim_kernel(Path(sys.argv[1]), "0123456789abcdef")
        print("held", flush=True)
        time.sleep(60)
    """
    holder = run(script, tmp_path)
    assert holder.stdout.readline() == "held\n"
    assert not has_waited(tmp_path, "fedcba9876543210")  # another kernel
    killer = threading.Timer(0.2, holder.kill)
    begin = time.monotonic()
    killer.start()
    assert has_waited(tmp_path, "0123456789abcdef")
    assert time.monotonic() - begin >= 0.2
    killer.join()
    assert not list(tmp_path.iterdir())
    assert holder.wait() == -9
    holder.communicate()


def test_a_claim_that_is_held_for_too_long_is_passed_over(tmp_path, monkeypatch):
    script = """
        import sys
        from pathlib import Path
        from hcsearch.kernels.compiling.cache_folder import claim_kernel
        held = claim_kernel(Path(sys.argv[1]), "0123456789abcdef")
        print("held", flush=True)
        sys.stdin.read()
    """
    holder = run(script, tmp_path)
    assert holder.stdout.readline() == "held\n"
    monkeypatch.setattr(cache_folder, "LOCK_TIMEOUT_SECONDS", 0.1)
    with pytest.raises(OSError, match="0123456789abcdef"):
        cache_folder.claim_kernel(tmp_path, "0123456789abcdef")
    holder.communicate("")


def test_a_kernel_that_does_not_compile_is_not_claimed_any_more(folder, load, monkeypatch):
    claim = mock.Mock(wraps=cache_folder.claim_kernel)
    monkeypatch.setattr(cache_folder, "claim_kernel", claim)
    module = load()
    with pytest.raises(TypingError):
        module.through("text")
    claimed = list(dict.fromkeys(call.args for call in claim.mock_calls))  # some versions of numba try twice
    assert len(claimed) == 3  # of itself, and of what it calls
    script = """
        import sys
        from pathlib import Path
        from hcsearch.kernels.compiling import cache_folder
        cache_folder.LOCK_TIMEOUT_SECONDS = 0.0
        for name in sys.argv[2:]:
            cache_folder.claim_kernel(Path(sys.argv[1]), name)
        print("claimed")
    """
    other = run(script, folder, *(name for _, name in claimed))
    assert other.communicate()[0] == "claimed\n"


def linked_from(path):
    """Functions that the file of a kernel has for those that link it."""
    *_, ((_, _, (_, bitcode)), *_) = pickle.loads(path.read_bytes()[kernel_cache._CHECKED :])
    return list(llvm.parse_bitcode(bitcode).functions)


def test_a_small_kernel_is_linked_into_its_callers(folder, load):
    assert load().through(1.0) == 3.0
    (callee,) = folder.glob("*-scaled.bare.kernel")
    assert [function.name for function in linked_from(callee) if "scaled" in function.name]


def test_a_large_kernel_is_called_where_it_is(folder, load, monkeypatch):
    monkeypatch.setattr(kernel_cache, "_SIZE", 0)
    place = Path(load().__file__).parents[1]
    script = """
        from hcsearch.kernels.compiling import kernel_cache
        from kernels_of_a_test.high import scaled, through
        kernel_cache._SIZE = 0
        assert through(1.0) == 3.0
        print(*(sum(kernel.stats.cache_misses.values()) for kernel in (through, scaled)))
    """

    def compiled_by_another():
        other = run(script, PYTHONPATH=f"{place}:{Path.cwd()}", NUMBA_CACHE_DIR=folder.parent)
        return other.communicate()[0].split()

    assert load().through(1.0) == 3.0
    assert compiled_by_another() == ["0", "0"]
    (callee,) = folder.glob("*-scaled.bare.kernel")
    assert linked_from(callee) == []
    callee.unlink()
    assert compiled_by_another() == ["1", "1"]
    assert compiled_by_another() == ["0", "0"]
    callee.unlink()
    for _ in range(1000):  # symbols are numbered in the order in which a process compiles
        next(FunctionIdentity._unique_ids)
    assert load(("return scaled(x)", "return 2.0 * scaled(x)")).through(1.0) == 5.0  # made again, under another symbol
    assert callee.exists()
    assert compiled_by_another() == ["1", "0"]


def test_a_kernel_that_others_call_is_made_for_python_when_python_calls_it(folder, load):
    module = load()
    assert module.through(1.0) == 3.0
    assert misses(module.scaled) == 1
    assert module.scaled(1.0) == 2.0
    assert misses(module.scaled) == 1  # its code is there: only a wrapper is made
    assert len(list(folder.glob("*-scaled*.kernel"))) == 2
    assert module.scaled(2.0) == 4.0
    assert len(module.scaled.signatures) == 1
    again = load()
    assert again.scaled(1.0) == 2.0
    assert again.through(1.0) == 3.0
    assert misses(again.scaled) == misses(again.through) == 0


def test_a_wrapper_that_makes_objects_of_python_serves_a_process_that_has_read_the_kernel_without_it(
    folder, load, monkeypatch
):
    monkeypatch.setattr(kernel_cache, "_SIZE", 0)
    place = Path(load().__file__).parents[1]
    script = """
        from hcsearch.kernels.compiling import kernel_cache
        from kernels_of_a_test.low import paired, pair_of
        kernel_cache._SIZE = 0
        assert paired(4.0) == 2.0
        (pair, ones), again = pair_of(4.0), pair_of(9.0)
        print(*pair, *ones, again[0].two, *(sum(kernel.stats.cache_misses.values()) for kernel in (paired, pair_of)))
    """
    for compiled_kernels in ("1 1", "0 0"):
        other = run(script, PYTHONPATH=f"{place}:{Path.cwd()}", NUMBA_CACHE_DIR=folder.parent)
        assert other.communicate()[0] == f"4.0 2.0 1.0 1.0 3.0 {compiled_kernels}\n"


def test_what_is_under_way_counts_the_kernels_that_one_reaches(folder, load, monkeypatch):
    module = load()
    seen = []
    assert under_way.compilation_under_way() is None
    assert len(under_way.missing_stamps([module.through, module.apart])) == 5
    assert module.scaled(1.0) == 2.0
    assert under_way.is_ready(module.scaled)
    assert not under_way.is_ready(module.through)
    write = kernel_cache.write_atomically

    def writing(path, content):
        seen.append(under_way.compilation_under_way())
        write(path, content)

    monkeypatch.setattr(kernel_cache, "write_atomically", writing)
    assert module.through(1.0) == 3.0
    assert [(progress.done, progress.total) for progress in seen] == [(0, 2), (1, 2)]
    assert seen[0].name == "between"
    assert under_way.compilation_under_way() is None
    assert not under_way.missing_stamps([module.through])
    assert under_way.is_ready(module.through)


@pytest.mark.parametrize("damage", ["cut", "zeros", "garbage", "empty", "other"])
def test_a_damaged_file_is_made_again(folder, load, damage):
    assert load().apart(1.0) == 3.0
    (file,) = folder.glob("*-apart.kernel")
    good = file.read_bytes()
    file.write_bytes(
        {
            "cut": good[: len(good) // 2],
            "zeros": bytes(len(good)),
            "garbage": good[:-1] + bytes([good[-1] ^ 1]),
            "empty": b"",
            "other": pickle.dumps("what is this?"),
        }[damage]
    )
    again = load()
    assert again.apart(1.0) == 3.0
    assert misses(again.apart) == 1
    assert misses(load().apart) == 0
    assert not list(folder.glob("*.part"))


def test_where_nothing_can_be_written_kernels_are_kept_in_a_temporary_folder(load, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(numba.config, "CACHE_DIR", "/dev/null/cache")
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    module = load()
    assert (module.through(1.0), module.apart(1.0)) == (3.0, 3.0)
    (spare,) = tmp_path.glob("hcsearch-*")
    assert spare.stat().st_mode & 0o777 == 0o700
    assert capsys.readouterr().err == (
        "hcsearch: compiled kernels cannot be kept in /dev/null/cache/hcsearch (Not a directory)"
        f" but are in {spare}; set NUMBA_CACHE_DIR to a folder that only you can write\n"
    )
    assert load().apart(1.0) == 3.0
    assert misses(load().apart) == 0


@pytest.mark.parametrize("trouble", ["no folder", "another's"])
def test_without_any_folder_kernels_are_compiled_at_every_start(load, tmp_path, monkeypatch, capsys, trouble):
    monkeypatch.setattr(numba.config, "CACHE_DIR", "/dev/null/cache")
    monkeypatch.setattr(tempfile, "tempdir", "/dev/null" if trouble == "no folder" else str(tmp_path))
    if trouble == "another's":
        open_to_all = tmp_path / f"hcsearch-{os.getuid()}"
        open_to_all.mkdir()
        open_to_all.chmod(0o777)
    assert load().through(1.0) == 3.0
    assert load().through(1.0) == 3.0
    assert capsys.readouterr().err == (
        "hcsearch: compiled kernels cannot be kept in /dev/null/cache/hcsearch (Not a directory):"
        " they are compiled at every start; set NUMBA_CACHE_DIR to a folder that only you can write\n"
    )
    assert not list(tmp_path.glob("hcsearch-*/*"))


def test_a_folder_that_one_user_has_filled_serves_others(folder, load):
    before = os.umask(0o022)
    try:
        assert load().apart(1.0) == 3.0
    finally:
        os.umask(before)
    assert {path.stat().st_mode & 0o777 for path in folder.glob("*.kernel")} == {0o644}
    assert folder.stat().st_mode & 0o777 == 0o755


def test_a_full_disk_is_told_once(folder, load, monkeypatch, capsys):
    def full(path, content):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("hcsearch.kernels.compiling.kernel_cache.write_atomically", full)
    assert load().through(1.0) == 3.0
    assert capsys.readouterr().err == (
        f"hcsearch: compiled kernels cannot be kept in {folder} (No space left on device); make room there\n"
    )
    assert not list(folder.glob("*.kernel"))


def test_where_the_folder_is(monkeypatch, tmp_path):
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setattr(platformdirs.windows, "get_win_folder", lambda _: str(tmp_path / "local"))
    folders = {}
    for system in (Unix, MacOS, Windows):
        monkeypatch.setattr(platformdirs, "PlatformDirs", system)
        monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
        own = cache_folder.wanted_folder()
        monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
        folders[system] = [str(place.relative_to(tmp_path)) for place in (own, cache_folder.wanted_folder())]
    assert folders == {
        Unix: [".cache/hcsearch/kernels", "xdg/hcsearch/kernels"],
        MacOS: ["Library/Caches/hcsearch/kernels", "xdg/hcsearch/kernels"],
        Windows: ["local/hcsearch/kernels"] * 2,
    }
    monkeypatch.setattr(platformdirs, "PlatformDirs", Unix)
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")  # not to be followed, says its specification
    assert cache_folder.wanted_folder() == tmp_path / ".cache/hcsearch/kernels"
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "chosen"))
    assert cache_folder.wanted_folder() == tmp_path / "chosen/hcsearch"


def test_kernels_are_read_without_what_compiles_them(folder, load, monkeypatch):
    """A refresh loads all that numba can compile, which takes longer than most commands."""
    expected = load().through(1.0), load().qualified(4.0)
    refresh = mock.Mock()
    monkeypatch.setattr(CPUContext, "refresh", refresh)
    module = load()
    assert (module.through(1.0), module.qualified(4.0)) == expected
    refresh.assert_not_called()
    assert load(("FACTOR = 2.0", "FACTOR = 4.0")).through(1.0) == 5.0
    refresh.assert_called()


def test_the_folder_is_pruned_of_what_has_not_been_used_for_longest(tmp_path):
    for age, name in enumerate(("new.kernel", "older.kernel", "left.part", "old.kernel")):
        (tmp_path / name).write_bytes(bytes(100))
        os.utime(tmp_path / name, (time.time() - 1000 * age,) * 2)
    (tmp_path / "others").touch()
    cache_folder.prune_folder(tmp_path, 250)
    assert {path.name for path in tmp_path.iterdir()} == {"new.kernel", "older.kernel", "others"}


def test_numba_has_what_the_cache_rests_on(folder, load):
    """Where this fails, numba has changed: see `hcsearch.kernels.compiling.numba_internals`."""
    assert has_internals()
    interface = {name for name in vars(NullCache) if not name.startswith("_")}
    assert interface == {"cache_path", "load_overload", "save_overload", "enable", "disable", "flush"}
    kernel = numba.njit(lambda x: x)
    assert isinstance(kernel._cache, NullCache)
    for door in (kernel.compile, kernel.add_overload, kernel._compiler._customize_flags):
        assert callable(door)
    assert kernel(1) == 1
    (result,) = kernel.overloads.values()
    assert {"_reduce", "_rebuild"} <= set(dir(result))
    assert {"_final_module", "_shared_module", "_get_module_for_linking"} <= set(dir(result.library))
    assert load().apart(1.0) == 3.0
    assert sorted(path.name.split("-")[2] for path in folder.glob("*.kernel")) == ["apart.kernel", "other.bare.kernel"]


@pytest.fixture
def broken(monkeypatch):
    """Takes a part of numba's private API away, or puts another one in its place."""

    def broken(internal, *other):
        owner, _, name = internal.name.partition(".")
        if name:
            monkeypatch.setattr(f"{internal.module}.{owner}", SimpleNamespace(**dict(zip([name], other, strict=False))))
        else:
            monkeypatch.delattr(f"{internal.module}.{owner}")
        has_internals.cache_clear()

    yield broken
    monkeypatch.undo()
    has_internals.cache_clear()


@pytest.mark.parametrize("internal", NUMBA_INTERNALS, ids=lambda internal: internal.name)
def test_numba_keeps_kernels_itself_where_it_lacks_a_part(internal, broken):
    broken(internal)
    assert not internal.is_present
    assert not has_internals()


@pytest.mark.parametrize(
    "internal",
    [own for own in NUMBA_INTERNALS if "." in own.name and (own.arguments or own.sets)],
    ids=lambda internal: internal.name,
)
def test_numba_keeps_kernels_itself_where_a_part_differs(internal, broken):
    broken(internal, lambda *, other: None)
    assert not has_internals()


def test_kernels_that_numba_keeps_itself_return_the_same(folder, load, monkeypatch):
    expected = load().through(1.0), load().apart(1.0), load().qualified(4.0), load().itself(4)
    kept = set(folder.glob("*"))
    monkeypatch.setattr(numba_internals, "has_internals", lambda: False)
    module = load()
    assert (module.through(1.0), module.apart(1.0), module.qualified(4.0), module.itself(4)) == expected
    assert isinstance(module.through._cache, FunctionCache)
    assert set(folder.glob("*")) == kept
    assert list(folder.parent.glob("*/high.through*.nbi"))


def test_nothing_is_compiled_beforehand_where_numba_keeps_kernels_itself(broken):
    broken(NUMBA_INTERNALS[0])
    assert under_way.is_ready(insert_fingerprints)
    result = CliRunner().invoke(compile_, [])
    assert (result.exit_code, result.stdout.partition(":")[0]) == (0, "nothing is compiled beforehand")
