"""What `import hcsearch` gives: its names, and what each says of itself."""

import doctest
import inspect
import subprocess
import sys
from importlib import import_module
from importlib.metadata import version
from pkgutil import iter_modules

import pytest

import hcsearch
import hcsearch.api

DOCUMENTED = [
    "hcsearch.designs.circuit",
    "hcsearch.search.enumeration",
    "hcsearch.designs.folding",
    "hcsearch.shape.labels",
]
DOCUMENTED += [f"hcsearch.api.{module.name}" for module in iter_modules(hcsearch.api.__path__)]


def test_dir_lists_the_public_names_and_nothing_else():
    import hcsearch.designs.grid
    import hcsearch.store

    assert dir(hcsearch) == sorted(hcsearch.__all__)
    assert {name for name in dir(hcsearch) if name.startswith("_")} == {"__version__"}
    assert all(hasattr(hcsearch, name) for name in hcsearch.__all__)


def test_the_version_is_that_of_the_distribution():
    assert hcsearch.__version__ == version("hcsearch")


def test_nothing_is_loaded_before_it_is_asked_for():
    code = "import sys, hcsearch; dir(hcsearch); print(sum(name.startswith('hcsearch.') for name in sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert int(done.stdout) <= 2
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = hcsearch.nothing


@pytest.mark.parametrize("name", [name for name in hcsearch.__all__ if callable(getattr(hcsearch, name))])
def test_every_public_name_has_a_docstring_of_a_sentence_first(name):
    first, *rest = inspect.getdoc(getattr(hcsearch, name)).splitlines()
    assert first.endswith((".", ":"))
    assert not rest or rest[0] == ""


@pytest.mark.parametrize("name", DOCUMENTED)
def test_examples_of_docstrings(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("HCSEARCH_DB", raising=False)
    failed, _ = doctest.testmod(import_module(name), optionflags=doctest.NORMALIZE_WHITESPACE)
    assert failed == 0
