"""Compiled kernels are code: those that others might have written are never run, and the program works all the same."""

import hashlib
import importlib
import os
import pickle
import subprocess
import sys
import tempfile
import textwrap
from itertools import count
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

import numba
import platformdirs
import pytest
from numba.core.caching import FunctionCache, NullCache
from platformdirs.unix import Unix

from hcsearch.kernels.compiling import cache_folder, numba_internals
from hcsearch.kernels.compiling.own_folders import check_own_folder, is_own_folder, make_own_folder

KERNEL = """
from hcsearch.kernels.compiling.compiled import compiled

@compiled
def doubled(x):
    return 2.0 * x
"""
MODULES = (f"kernels_to_plant_{number}" for number in count())


@pytest.fixture(autouse=True)
def _judged_anew():
    yield
    for judged in (cache_folder._writable, cache_folder._readable, cache_folder.warn_once, is_own_folder):
        judged.cache_clear()


@pytest.fixture
def give_away(monkeypatch):
    """Makes a file belong to another user, for the program: only root could do it."""
    owners, lstat = {}, Path.lstat

    def owned(path):
        status = lstat(path)
        return os.stat_result((*status[:4], owners.get(path, status.st_uid), *status[5:]))

    monkeypatch.setattr(Path, "lstat", owned)
    return lambda path, owner=54321: owners.update({path: owner})


def judged(folder):
    """Return why code in a folder is not run; an empty text where it is."""
    try:
        check_own_folder(folder)
    except OSError as error:
        return error.strerror
    return ""


@pytest.mark.parametrize(
    ("mode", "on_the_way", "at_the_end"),
    [
        (0o700, True, True),
        (0o755, True, True),
        (0o775, False, False),
        (0o757, False, False),
        (0o1777, True, False),
        (0o1770, True, False),
        (0o2775, False, False),
    ],
)
def test_nobody_else_may_write_to_a_folder_or_those_that_lead_to_it(tmp_path, mode, on_the_way, at_the_end):
    way = tmp_path / "way"
    (way / "between" / "end").mkdir(parents=True)
    way.chmod(mode)
    fault = f"others can write to {way}"
    assert judged(way / "between" / "end") == ("" if on_the_way else fault)
    assert judged(way) == ("" if at_the_end else fault)


@pytest.mark.parametrize("given", [".", "between", "between/end"])
def test_the_user_or_root_owns_a_folder_and_those_that_lead_to_it(tmp_path, give_away, given):
    end = tmp_path / "between" / "end"
    end.mkdir(parents=True)
    assert not judged(end)
    give_away(tmp_path / given, 0)
    assert not judged(end)
    give_away(tmp_path / given)
    assert judged(end) == f"{tmp_path / given} belongs to another user"


def test_links_are_followed_only_where_the_user_made_them(tmp_path, give_away):
    (tmp_path / "own").mkdir()
    (tmp_path / "open").mkdir()
    (tmp_path / "open").chmod(0o777)
    (tmp_path / "links").mkdir()
    links = {"inside": "../own", "absolute": tmp_path / "own", "chain": "inside", "open": "../open", "loop": "loop"}
    for name, target in links.items():
        (tmp_path / "links" / name).symlink_to(target)
    assert not any(judged(tmp_path / "links" / name) for name in ("inside", "absolute", "chain"))
    assert judged(tmp_path / "links" / "open") == f"others can write to {tmp_path}/links/../open"
    assert judged(tmp_path / "links" / "loop") == os.strerror(40)
    give_away(tmp_path / "links" / "inside")
    for name in ("inside", "chain"):  # to a folder of the user's, but as another user says
        assert judged(tmp_path / "links" / name) == f"{tmp_path}/links/inside belongs to another user"


def test_what_is_no_folder_is_refused(tmp_path):
    (tmp_path / "file").touch()
    assert judged(tmp_path / "file") == judged(tmp_path / "file" / "below") == "Not a directory"
    assert judged(tmp_path / "missing" / "below") == "No such file or directory"
    assert judged(Path("relative")) == "it depends on the current folder"


def test_folders_are_made_for_the_user_alone_to_write(tmp_path, give_away):
    umask = os.umask(0)
    try:
        make_own_folder(tmp_path / "one" / "two", 0o755)
    finally:
        os.umask(umask)
    assert [place.stat().st_mode & 0o777 for place in (tmp_path / "one", tmp_path / "one" / "two")] == [0o755, 0o755]
    give_away(tmp_path / "one")
    with pytest.raises(PermissionError, match="one belongs to another user"):
        make_own_folder(tmp_path / "one" / "three", 0o755)
    assert not (tmp_path / "one" / "three").exists()


class Code:
    """An object that makes a file when it is unpickled."""

    def __init__(self, evidence):
        self._evidence = evidence

    def __reduce__(self):
        return Path.touch, (self._evidence,)


def plant(folder, name, evidence):
    """Write code that runs when it is read, under the name of a kernel; return its file."""
    folder.mkdir(parents=True, exist_ok=True)
    content = pickle.dumps(Code(evidence))
    (folder / name).write_bytes(hashlib.blake2b(content, digest_size=16).digest() + content)
    return folder / name


@pytest.fixture
def planting(tmp_path, monkeypatch):
    """A kernel of a new module, the name of its file, and the folder where it is kept.

    Other kernels may be kept in a temporary folder only.
    """
    module = next(MODULES)
    (tmp_path / "modules").mkdir()
    (tmp_path / "modules" / f"{module}.py").write_text(KERNEL)
    monkeypatch.syspath_prepend(tmp_path / "modules")
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "own"))
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))

    def kernel():
        monkeypatch.delitem(sys.modules, module, raising=False)
        return importlib.import_module(module).doubled

    assert kernel()(1.0) == 2.0
    (file,) = (tmp_path / "own" / "hcsearch").glob("*.kernel")
    return SimpleNamespace(kernel=kernel, name=file.name, folder=file.parent, spare=tmp_path / "temporary")


def without_home(root, patch, give_away):
    patch.chdir(root)
    patch.setattr(numba.config, "CACHE_DIR", "")
    patch.setattr(platformdirs, "user_cache_path", mock.Mock(side_effect=RuntimeError("no home folder is known")))
    return root / "~" / ".cache" / "hcsearch" / "kernels"


def home_of_another(root, patch, give_away):
    give_away(root)
    patch.setattr(numba.config, "CACHE_DIR", "")
    patch.setattr(platformdirs, "PlatformDirs", Unix)
    patch.delenv("XDG_CACHE_HOME", raising=False)
    patch.setenv("HOME", str(root))
    return root / ".cache" / "hcsearch" / "kernels"


def cache_home_of_all(root, patch, give_away):
    root.chmod(0o1777)
    patch.setattr(numba.config, "CACHE_DIR", "")
    patch.setattr(platformdirs, "PlatformDirs", Unix)
    patch.setenv("XDG_CACHE_HOME", str(root))
    give_away(root / "hcsearch")
    return root / "hcsearch" / "kernels"


def folder_of_all(root, patch, give_away):
    (root / "hcsearch").mkdir()
    (root / "hcsearch").chmod(0o1777)
    patch.setattr(numba.config, "CACHE_DIR", str(root))
    return root / "hcsearch"


def folder_of_a_group(root, patch, give_away):
    root.chmod(0o775)
    patch.setattr(numba.config, "CACHE_DIR", str(root))
    return root / "hcsearch"


def link_to_a_folder_of_another(root, patch, give_away):
    (root / "hcsearch").symlink_to(root / "theirs")
    give_away(root / "theirs")
    patch.setattr(numba.config, "CACHE_DIR", str(root))
    return root / "theirs"


def link_of_another(root, patch, give_away):
    (root / "hcsearch").symlink_to(root / "downloads")
    give_away(root / "hcsearch")
    patch.setattr(numba.config, "CACHE_DIR", str(root))
    return root / "downloads"


def spare_folder(root, patch, give_away):
    root.chmod(0o1777)
    patch.setattr(numba.config, "CACHE_DIR", "/dev/null/cache")
    patch.setattr(tempfile, "tempdir", str(root))
    spare = root / f"hcsearch-{os.geteuid()}"
    give_away(spare)
    return spare


@pytest.mark.parametrize(
    "place",
    [
        without_home,
        home_of_another,
        cache_home_of_all,
        folder_of_all,
        folder_of_a_group,
        link_to_a_folder_of_another,
        link_of_another,
        spare_folder,
    ],
)
def test_planted_kernels_never_run(planting, tmp_path, monkeypatch, give_away, capsys, place):
    (tmp_path / "place").mkdir(mode=0o755)
    evidence = tmp_path / "ran"
    file = plant(place(tmp_path / "place", monkeypatch, give_away), planting.name, evidence)
    content = file.read_bytes()
    kernel = planting.kernel()
    assert (kernel(1.0), kernel(2), sum(kernel.stats.cache_misses.values())) == (2.0, 4.0, 2)
    assert not evidence.exists()
    assert file.read_bytes() == content  # in the folders of others nothing is touched
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("hcsearch: compiled kernels cannot be kept in ")
    assert line.endswith("; set NUMBA_CACHE_DIR to a folder that only you can write")
    assert len(list(planting.spare.glob("*/*.kernel"))) == (0 if place is spare_folder else 2)


def test_code_in_the_users_own_folder_runs(planting, tmp_path):
    """What the test above plants would run."""
    plant(planting.folder, planting.name, tmp_path / "ran")
    assert planting.kernel()(1.0) == 2.0
    assert (tmp_path / "ran").exists()


@pytest.mark.parametrize("way", ["owner", "mode", "link"])
def test_files_of_others_in_the_users_own_folder_are_compiled_anew(planting, tmp_path, give_away, capsys, way):
    file = plant(planting.folder, planting.name, tmp_path / "ran")
    if way == "owner":
        give_away(file)
    elif way == "mode":
        file.chmod(0o666)
    else:
        file.rename(tmp_path / "elsewhere")
        file.symlink_to(tmp_path / "elsewhere")
    assert planting.kernel()(1.0) == 2.0
    assert not (tmp_path / "ran").exists()
    assert capsys.readouterr().err == (
        f"hcsearch: {planting.folder} has kernels that others might have written: they are not run but compiled anew\n"
    )
    give_away(file, os.geteuid())
    kernel = planting.kernel()
    assert (kernel(1.0), sum(kernel.stats.cache_hits.values())) == (2.0, 1)


def test_files_of_kernels_are_for_the_user_alone_to_write(planting, tmp_path, monkeypatch):
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "others may write"))
    umask = os.umask(0)
    try:
        assert planting.kernel()(1.0) == 2.0
    finally:
        os.umask(umask)
    kernel = planting.kernel()
    assert (kernel(1.0), sum(kernel.stats.cache_hits.values())) == (2.0, 1)
    assert (tmp_path / "others may write" / "hcsearch" / planting.name).stat().st_mode & 0o777 == 0o644


@pytest.mark.parametrize("trouble", ["", "open folder", "file of another", "relative"])
def test_numba_keeps_kernels_only_where_nobody_else_can_write(
    planting, tmp_path, monkeypatch, give_away, capsys, trouble
):
    monkeypatch.setattr(numba_internals, "has_internals", lambda: False)
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "numba"))
    (tmp_path / "numba").mkdir(mode=0o755)
    kernel = planting.kernel()
    assert (kernel(1.0), type(kernel._cache)) == (2.0, FunctionCache)
    if trouble == "open folder":
        (tmp_path / "numba").chmod(0o777)
    elif trouble == "file of another":
        give_away(next((tmp_path / "numba").glob("*/*.nbi")))
    elif trouble == "relative":
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr(numba.config, "CACHE_DIR", "numba")
    is_own_folder.cache_clear()
    kernel = planting.kernel()
    assert (kernel(1.0), type(kernel._cache)) == (2.0, NullCache if trouble else FunctionCache)
    said = capsys.readouterr().err
    assert said.startswith("hcsearch: numba has no folder for compiled kernels that only you can write") == bool(
        trouble
    )
    assert said.count("\n") == bool(trouble)


def test_settings_are_the_same_before_and_after_the_import_of_numba():
    script = """
        import os, sys
        import numba
        from hcsearch.kernels.circuits.words import insert_fingerprints
        from hcsearch.kernels.compiling.numba_internals import use_compiler_settings
        from hcsearch.kernels.compiling.stamps import kernel_stamp
        for value in sys.argv[1:]:
            if value != "-":
                os.environ["NUMBA_OPT"] = value
            with use_compiler_settings():
                numba.config.reload_config()  # as numba does when it compiles
                print(kernel_stamp(insert_fingerprints), int(numba.config.OPT), numba.config.LOOP_VECTORIZE)
    """

    def settings(*values, **variables):
        variables = {name: text for name, text in os.environ.items() if name != "NUMBA_OPT"} | variables
        command = [sys.executable, "-c", textwrap.dedent(script), *values]
        return subprocess.check_output(command, env=variables, text=True).splitlines()

    default, same, other = settings("-", "1", "2")
    assert default == same  # ours
    assert settings("-", NUMBA_OPT="2") == [other]
    assert [line.split(" ", 1)[1] for line in (default, other)] == ["1 0", "2 0"]
    assert default.split()[0] != other.split()[0]
