"""What a release is made of: its version, the changelog and its fragments, the citation."""

import re
import tomllib
from datetime import date
from pathlib import Path

import pytest
import yaml
from packaging.version import Version

import hcsearch
from tests import package_size

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
CHANGELOG = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
CITATION = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
TYPES = [kind["directory"] for kind in PROJECT["tool"]["towncrier"]["type"]]


def fault_of_fragment(name, text):
    """What is wrong with a fragment of the changelog; empty if nothing is."""
    if not re.fullmatch(rf"\+[a-z0-9_-]+\.({'|'.join(TYPES)})\.md", name):
        return f"a fragment is named +SHORT-NAME.TYPE.md, with one of the types {', '.join(TYPES)}"
    if not re.fullmatch(r"\S.*\.\n", text):
        return "a fragment is one line that ends with a full stop"
    if re.search(r"[.!?] +[`A-Z]", text):
        return "a fragment is one sentence"
    return ""


def test_fragments_of_the_changelog_are_sentences():
    fragments = {path.name: path for path in (ROOT / "changelog.d").iterdir() if path.name != "README.md"}
    faults = {name: fault_of_fragment(name, path.read_text(encoding="utf-8")) for name, path in fragments.items()}
    assert not {name: fault for name, fault in faults.items() if fault}


@pytest.mark.parametrize(
    ("name", "text", "fault"),
    [
        ("+films.added.md", "`export` writes films, as `ring.gif`, of 1.5 s.\n", ""),
        ("films.added.md", "`export` writes films.\n", "named"),
        ("+films.new.md", "`export` writes films.\n", "types"),
        ("+films.added.md", "`export` writes films\n", "full stop"),
        ("+films.added.md", "- `export` writes\nfilms.\n", "one line"),
        ("+films.added.md", "`export` writes films. It also writes stills.\n", "one sentence"),
    ],
)
def test_faults_of_fragments_are_found(name, text, fault):
    found = fault_of_fragment(name, text)
    assert fault in found if fault else not found


def newest_release():
    """The version and the day of the uppermost section of the changelog."""
    return re.search(r"^## (\S+) \((\S+)\)$", CHANGELOG, re.MULTILINE).groups()


def test_the_changelog_begins_with_the_release_that_is_cited():
    cited = yaml.safe_load(CITATION)
    assert (cited["version"], cited["date-released"]) == newest_release()
    assert PROJECT["tool"]["towncrier"]["start_string"] in CHANGELOG.partition("\n## ")[0]


def test_the_version_is_stated_and_installed():
    assert hcsearch.__version__ == PROJECT["project"]["version"]


def test_the_version_is_that_of_the_newest_release_or_of_the_next_one():
    stated, newest = Version(PROJECT["project"]["version"]), Version(newest_release()[0])
    assert stated == newest or (stated.is_devrelease and stated > newest)


def test_the_size_of_the_package_is_told_beside_that_of_the_last_release():
    size = package_size.size_of(ROOT / "hcsearch")
    head, *rows = (re.split(r" {2,}", line) for line in package_size.table_of(size))
    assert (head[1], head[2], head[3]) == ("now", newest_release()[0], "ceiling")
    assert [row[1] for row in rows] == [f"{size[key]:,}" for key in ("modules", "lines", "code")]


@pytest.mark.parametrize("key", ["modules", "lines", "code"])
def test_a_size_above_its_ceiling_is_a_fault(key):
    allowed = {name: package_size.SIZES[name] for name in ("modules", "lines", "code")}
    assert package_size.faults_of(allowed) == []
    (fault,) = package_size.faults_of(allowed | {key: allowed[key] + 1})
    assert f"above the ceiling of {allowed[key]:,}" in fault


def test_comments_docstrings_and_blank_lines_are_no_code():
    told = '"""A module.\n\nOf two values.\n"""\n\n# why\n'
    source = told + 'A = (\n    1,  # one\n)\nB = """two\nlines"""\n"""Told."""\n'
    assert package_size.code_lines(source) == 5


REQUIRED = {"cff-version", "message", "title", "authors"}
KEYS = REQUIRED | {
    *("abstract", "commit", "contact", "date-released", "doi", "identifiers", "keywords", "license", "license-url"),
    *("preferred-citation", "references", "repository", "repository-artifact", "repository-code", "type", "url"),
    "version",
}
"""Keys of version 1.2.0 of the Citation File Format (doi:10.5281/zenodo.5171937): those required, and all."""
PERSON = {"family-names", "given-names", "name-particle", "name-suffix", "affiliation", "orcid", "email", "alias"}
ENTITY = {"name", "address", "city", "country", "email", "orcid", "website", "alias"}


def faults_of_citation(text):
    """What is wrong with a citation file, as sentences."""
    cited = yaml.safe_load(text)
    faults = [f"{key} is missing" for key in sorted(REQUIRED - cited.keys())]
    faults += [f"{key} is unknown" for key in sorted(cited.keys() - KEYS)]
    faults += [f"{key} must be a text" for key in ("version", "date-released") if not isinstance(cited.get(key), str)]
    works = [cited, *cited.get("references", ())]
    faults += [f"a reference has no {key}" for key in ("authors", "title", "type") for one in works if key not in one]
    for author in (author for one in works for author in one.get("authors", ())):
        if not (author.keys() <= PERSON or ("name" in author and author.keys() <= ENTITY)):
            faults.append(f"{author} is neither a person nor an entity")
    try:
        date.fromisoformat(str(cited.get("date-released")))
    except ValueError:
        faults.append("date-released is no date")
    return faults


def test_the_citation_file_is_one():
    assert faults_of_citation(CITATION) == []


@pytest.mark.parametrize(
    ("line", "planted", "fault"),
    [
        ("cff-version: 1.2.0", "cff: 1.2.0", "cff-version is missing"),
        ("  - name: The hcsearch founders", "  - nom: The hcsearch founders", "neither a person nor an entity"),
        ('date-released: "', 'date-released: "the ', "no date"),
    ],
)
def test_faults_of_the_citation_file_are_found(line, planted, fault):
    assert line in CITATION
    assert any(fault in found for found in faults_of_citation(CITATION.replace(line, planted)))
