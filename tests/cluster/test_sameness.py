"""Results of another program, or of one whose files change while it runs, are not used."""

import subprocess
import sys
from pathlib import Path
from shutil import copytree, ignore_patterns

import pytest

import hcsearch
from hcsearch.basics.errors import ClusterError
from hcsearch.search.pipeline import WorkerPool, sameness
from hcsearch.search.pipeline.sameness import (
    ProgramRefusal,
    packed_task,
    program_difference,
    run_packed_task,
    running_program,
    sources_digest,
)

SCRIPT = """
from pathlib import Path
import hcsearch
from hcsearch.basics.errors import ClusterError
from hcsearch.search.pipeline import WorkerPool

crew = WorkerPool({jobs})
work = crew.map_ordered(len, ["a", "bb"] * 20)
assert next(work) == ("a", 1)
with (Path(hcsearch.__file__).parent / "designs" / "circuit.py").open("a") as file:
    file.write("# changed")
if {jobs} == 1:
    import hcsearch.springs.tuning.spring_search  # which is loaded from other files than the rest
    rest = work
else:
    rest = crew.map_ordered(len, ["a", "bb"])  # by processes that start now
try:
    list(rest)
except ClusterError as error:
    print(error)
"""


@pytest.fixture
def copy(tmp_path):
    """A copy of the program that may be changed."""
    copytree(Path(hcsearch.__file__).parent, tmp_path / "hcsearch", ignore=ignore_patterns("__pycache__"))
    return tmp_path


def test_sources_are_known_by_what_is_in_them(copy, monkeypatch):
    own = sources_digest()
    monkeypatch.setattr(sameness, "_ROOT", copy / "hcsearch")
    assert sources_digest() == own
    path = copy / "hcsearch" / "designs" / "twisting.py"
    path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))  # as some systems check files out
    assert sources_digest() == own
    path.rename(path.with_name("twisted.py"))
    renamed = sources_digest()
    path.with_name("twisted.py").write_text("", encoding="utf-8")
    assert len({own, renamed, sources_digest()}) == 3


@pytest.mark.parametrize("name", sorted(running_program()))
def test_whatever_results_hang_on_is_compared_before_a_task_is_read(name):
    expected = running_program() | {name: "another"}
    assert run_packed_task(expected, b"nothing that could be read") == ProgramRefusal(running_program())
    assert program_difference(expected) == (
        f"other sources of hcsearch {running_program()['hcsearch']}"
        if name == "sources"
        else f"{name} another instead of {running_program()[name]}"
    )


def test_the_same_program_works(monkeypatch):
    assert program_difference(running_program()) == ""
    assert run_packed_task(running_program(), packed_task(len, ["a", "bb"])) == [1, 2]
    with pytest.raises(TypeError):
        run_packed_task(running_program(), packed_task(len, [1]))


def test_what_older_programs_do_not_say_is_a_difference():
    assert program_difference({"hcsearch": running_program()["hcsearch"]}).startswith("numpy None instead of")


def test_modules_that_were_loaded_after_a_change_are_noticed(monkeypatch):
    assert not sameness.are_sources_mixed()
    monkeypatch.setattr(sameness, "_file_states", list)
    monkeypatch.setattr(sameness, "sources_digest", lambda: "changed")
    assert not sameness.are_sources_mixed()  # nothing more was loaded since: all is as it was
    monkeypatch.setitem(sys.modules, "hcsearch.loaded_now", sys)
    assert sameness.are_sources_mixed()
    assert run_packed_task(running_program(), packed_task(len, ["a"])) == ProgramRefusal(None)
    assert run_packed_task(running_program(), packed_task(len, [1])) == ProgramRefusal(None)
    with pytest.raises(ClusterError, match="were changed while it ran"):
        list(WorkerPool(1).map_ordered(len, ["a", "bb"]))


def test_sources_are_not_read_again_where_no_file_has_changed(monkeypatch):
    assert not sameness.are_sources_changed()
    monkeypatch.setattr(sameness, "sources_digest", lambda: "of sources that were read again")
    assert not sameness.are_sources_changed()


def test_files_that_were_written_again_with_the_same_text_are_no_change(copy, monkeypatch):
    sources = sorted((copy / "hcsearch").rglob("*.py"))
    monkeypatch.setattr(sameness, "_ROOT", copy / "hcsearch")
    sources[0].write_bytes(sources[0].read_bytes())
    assert not sameness.are_sources_changed()
    sources[0].unlink()
    assert sameness.are_sources_changed()


@pytest.mark.parametrize("jobs", [1, 2])
def test_files_that_change_during_a_run_end_it(copy, jobs):
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT.format(jobs=jobs)], cwd=copy, capture_output=True, text=True, check=True
    )
    assert (done.stdout.count("\n"), done.stderr) == (1, "")
    assert "the sources of hcsearch were changed while it ran" in done.stdout
