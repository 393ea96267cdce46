"""The documentation site, as `make docs` builds it. Needs the group `docs`, Chromium, and npm for axe-core."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from filelock import FileLock

import hcsearch
from hcsearch.api.kinds import describe_kind
from hcsearch.basics.vocabulary import Formulation, Keep, ReplaySource, Until, Way
from hcsearch.store import Database
from hcsearch.subjects.case import CaseSubject
from hcsearch.system.lazy import names_in_stub
from tests.axe import faults
from tests.documents import ROOT
from tests.player.browser import chromium

NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))
API = ROOT / "docs" / "reference" / "api.md"


def test_the_page_of_python_names_lists_them_in_their_groups():
    groups = re.split(r"^## (.*)\n", API.read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]
    listed = {
        group: re.findall(r"^(?:   |\.\. py:data:: hcsearch\.)(\w+)$", text, re.MULTILINE)
        for group, text in zip(groups[::2], groups[1::2], strict=True)
    }
    wanted = {group: sorted(names) for group, names in names_in_stub("hcsearch").items()}
    assert {group: sorted(names) for group, names in listed.items() if names} == wanted


def test_the_page_of_python_names_tells_what_the_kinds_in_signatures_are():
    kinds = {
        "CaseSubject": CaseSubject,
        "Formulation": Formulation,
        "Keep": Keep,
        "Place": str | Path | Database,
        "ReplaySource": ReplaySource,
        "Until": Until,
        "Way": Way,
    }
    text = API.read_text(encoding="utf-8")
    for name, kind in kinds.items():
        assert f"| `{name}` | {describe_kind(kind)} |" in text


@pytest.mark.extra
@pytest.mark.parametrize("name", [name for name in hcsearch.__all__ if callable(getattr(hcsearch, name))])
def test_docstrings_of_public_names_document_all_parameters_and_results(name):
    from numpydoc.validate import validate

    wrong = {"PR01", "PR02", "RT01", "YD01", "GL03", "GL07", "SS03"}  # parameters, results, order and form of sections
    assert not [error for error in validate(f"hcsearch.{name}")["errors"] if error[0] in wrong]


@pytest.fixture(scope="module")
def site():
    """The folder of the site, built by the tests' environment; warnings are errors."""
    own = [f"VENV={sys.prefix}", f"--old-file={sys.prefix}/documented", "--no-print-directory"]
    outer = {"MAKEFLAGS", "MAKELEVEL", "MFLAGS"}  # of the make that runs the tests
    surroundings = {name: value for name, value in os.environ.items() if name not in outer}
    build = ROOT / "docs" / "_build"
    build.mkdir(exist_ok=True)
    with FileLock(build / "tests.lock"):  # each worker that has one of these tests comes here
        words = ["make", *own, "docs"]
        done = subprocess.run(words, cwd=ROOT, env=surroundings, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-4000:]
    return build / "html"


@pytest.mark.extra
def test_the_site_has_all_public_names_its_version_and_outputs_of_notebooks(site):
    pages = site / "docs" / "reference" / "generated"
    for name in hcsearch.__all__:
        if callable(getattr(hcsearch, name)):
            assert f'id="hcsearch.{name}"' in (pages / f"hcsearch.{name}.html").read_text(encoding="utf-8")
    landing = (site / "docs" / "index.html").read_text(encoding="utf-8")
    assert f"hcsearch {hcsearch.__version__}" in landing
    assert re.search(r'<meta [^>]*name="description"[^>]*Hamiltonian', landing)
    for path in NOTEBOOKS:  # run by the build; outputs of their cells are shown
        page = (site / "docs" / "notebooks" / f"{path.stem}.html").read_text(encoding="utf-8")
        assert page.count('class="cell_output') >= 5


@pytest.mark.extra
def test_pages_of_the_site_are_accessible_and_fit_into_the_window(site, axe_script, tmp_path):
    pages = [site / "docs" / f"{name}.html" for name in ("index", "tutorial", "reference/generated/hcsearch.Folding")]
    with chromium(tmp_path / "profile") as tab:
        assert not faults(tab, dict.fromkeys((page.as_uri() for page in pages), "true"), axe_script)
