"""What the documents show is what the program does."""

import doctest
import os
import re
import shlex
import subprocess
import sys
from itertools import chain

import click
import pytest
from click.testing import CliRunner

import hcsearch
from hcsearch.cli import GROUPS
from hcsearch.cli import hcsearch as command_line
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import folding_of
from hcsearch.designs.grid import GRIDS
from hcsearch.scenes.scene_file import values_page
from hcsearch.store.generated import columns_page
from tests import forking
from tests.documents import (
    DOCUMENTS,
    ROOT,
    agrees,
    anchors,
    files_shown,
    levels,
    links,
    name_of,
    shell_examples,
    text_of,
)

of_documents = pytest.mark.parametrize("document", DOCUMENTS, ids=name_of)


@of_documents
def test_python_examples(document, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # some make a database
    monkeypatch.delenv("HCSEARCH_DB", raising=False)
    failed, _ = doctest.testfile(str(document), module_relative=False, optionflags=doctest.NORMALIZE_WHITESPACE)
    assert failed == 0


def test_examples_in_the_package_docstring():
    failed, tried = doctest.testmod(hcsearch)
    assert tried > 0
    assert failed == 0


def from_the_start(words, **place):
    """Run a command as a newcomer does: `make` with this environment, which is set up already."""
    if words[0] == "make":
        own = [f"VENV={sys.prefix}", f"--old-file={sys.prefix}/installed", "--no-print-directory"]
        line = ["make", f"--file={ROOT / 'Makefile'}", *own, *words[1:]]
    else:
        line = [sys.executable, "-m", *words]
    return subprocess.run(line, capture_output=True, text=True, timeout=900, check=False, **place)


def already_loaded(words, **place):
    """Run a command without the seconds that it takes to load."""
    assert words[0] == "hcsearch"
    return forking.run(words[1:], timeout=900, **place)


def run_examples(document, folder, run):
    """Run the commands of a document by a function, one after the other, and compare what they print."""
    outer = {"MAKEFLAGS", "MAKELEVEL", "MFLAGS"}  # of the make that runs the tests
    surroundings = {name: value for name, value in os.environ.items() if name not in outer}
    for name, content in files_shown(document):
        (folder / name).write_text(content, encoding="utf-8")
    for command, expected, numbers in shell_examples(document):
        done = run(shlex.split(command), cwd=folder, env=surroundings)
        output = done.stdout.replace(f"{sys.prefix}/", ".venv/")
        assert agrees(output, expected, numbers), f"{command}\n{output}\n{done.stderr}"


def test_shell_examples_of_the_readme(tmp_path):
    assert next(shell_examples(ROOT / "README.md"))[0] == "make run"
    run_examples(ROOT / "README.md", tmp_path, from_the_start)
    assert (tmp_path / "reports" / "hex-12.html").stat().st_size > 100_000


RUN_ELSEWHERE = {"README.md", "identification.md", "CONTRIBUTING.md"}
SHOWN = [path for path in DOCUMENTS if path.name not in RUN_ELSEWHERE and any(shell_examples(path))]


@pytest.mark.slow
@pytest.mark.parametrize(
    "document",
    SHOWN,
    ids=name_of,
)
def test_shell_examples_of_other_documents(document, tmp_path):
    run_examples(document, tmp_path, already_loaded)


def test_examples_agree_where_times_and_last_digits_differ():
    assert agrees("flat 0.57471  after 1.23 s\n", "flat 0.57472 after 4.56 s\n")
    assert agrees("one 1\ntwo 2\nthree 3\n", "one 1\n...\n")
    assert agrees("springs 0.1 0.2\n", "springs 0.3 0.4\n", numbers=False)
    assert not agrees("flat 0.575 m\n", "flat 0.565 m\n")
    assert not agrees("circuits 1,175\n", "circuits 1,174\n")
    assert not agrees("one 1\n", "two 1\n...\n")
    assert not agrees("one 1\ntwo 2\n", "one 1\n")


def commands_in_sentences(document):
    """Words of every `hcsearch ...` in the text between the blocks of a document."""
    return [shlex.split(words) for words in re.findall(r"`hcsearch ([^`]*)`", text_of(document))]


@of_documents
def test_commands_in_sentences_have_the_words_that_there_are(document):
    for words in commands_in_sentences(document):
        command = command_line
        while isinstance(command, click.Group) and words and words[0] not in {"NAME", "COMMAND", "--help"}:
            command = command.get_command(click.Context(command), words.pop(0))
        options = {option for parameter in command.params for option in parameter.opts}
        assert {word for word in words if word.startswith("--")} <= options | {"--help"}, words
        for word in words:
            grid, colon, rest = word.partition(":")
            if colon and grid in GRIDS:
                circuit, _, crease = rest.partition(":")
                circuit = Circuit.from_notation(f"{grid}:{circuit}")
                assert not crease or folding_of(circuit, int(crease))


def test_deployments_in_sentences_of_the_readme_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    deployments = [words for words in commands_in_sentences(ROOT / "README.md") if words[0] == "deploy"]
    assert deployments
    for words in deployments:
        result = CliRunner().invoke(command_line, words)
        assert result.exit_code == 0, result.output
    assert (tmp_path / "angles.svg").exists()


@of_documents
def test_links_lead_somewhere(document):
    for target in links(document):
        path, _, anchor = target.partition("#")
        there = (document.parent / path).resolve() if path else document
        assert there.exists(), target
        assert not anchor or anchor in anchors(there), target
        assert there.is_relative_to(ROOT), target


def test_addresses_are_encrypted_and_publications_have_lasting_ones():
    for document in DOCUMENTS:
        text = document.read_text(encoding="utf-8")
        assert re.findall(r"http://(?!127\.0\.0\.1|localhost)\S+|doi:\s*10\.\S+|\bdx\.doi\.org\S+", text) == [], (
            document
        )


@of_documents
def test_headings_go_down_one_level_at_a_time(document):
    assert all(below - above <= 1 for above, below in levels(document))


def test_the_contents_lead_to_every_document():
    contents = ROOT / "docs" / "README.md"
    named = {(contents.parent / target.partition("#")[0]).resolve() for target in links(contents)}
    pages = {path for path in DOCUMENTS if path.is_relative_to(ROOT / "docs") and path.name != "index.md"}
    assert pages <= named | {contents}  # index.md are the contents of the site


def test_documents_that_code_names_exist():
    kinds = ("*.py", "*.toml", "*.md", "Makefile")
    folders = (ROOT / "hcsearch", ROOT / "hcsearch_bench", ROOT / "tests")
    files = [path for kind in kinds for folder in folders for path in folder.rglob(kind)]
    for path in [*files, *(path for kind in kinds for path in ROOT.glob(kind))]:
        for name in re.findall(r"\bdocs/[\w/]+\.md", path.read_text(encoding="utf-8")):
            assert (ROOT / name).exists(), f"{path}: {name}"


def test_the_readme_is_short():
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= 150


@pytest.mark.parametrize(("name", "made"), [("columns", columns_page), ("scene_values", values_page)])
def test_generated_pages_are_made_of_their_tables(name, made):
    page = (ROOT / "docs" / "reference" / f"{name}.md").read_text(encoding="utf-8")
    assert page == made(), "make docs"


def test_the_page_of_commands_names_them_all():
    page = (ROOT / "docs" / "reference" / "commands.md").read_text(encoding="utf-8")
    for words in commands():
        if words and words[0] != "bench" and not isinstance(command_of(words), click.Group):
            assert f"`{' '.join(words)}`" in page, words


def test_the_page_of_commands_has_their_groups():
    page = (ROOT / "docs" / "reference" / "commands.md").read_text(encoding="utf-8")
    table = page.partition("\n## ")[0]
    rows = re.findall(r"^\| (.*?) ?\| `(.*?)` \| ", table, re.MULTILINE)
    listed, group = {}, ""
    for title, named in rows:
        group = title or group
        listed.setdefault(group, set()).update(word.split()[0] for word in named.split("`, `"))
    listed["machine"].remove("bench")
    assert listed == {
        group: {command.name for command in chain(first, further)} for group, (first, further) in GROUPS.items()
    }


def test_help_describes_at_most_16_commands_and_names_the_others():
    described = [command.name for first, _ in GROUPS.values() for command in first]
    assert len(described) <= 16
    result = CliRunner().invoke(command_line, ["--help"])
    first, _, further = result.output.partition("\nFurther commands:\n")
    assert all(re.search(rf"^  {name} +[A-Z]", first, re.MULTILINE) for name in described)
    rows = re.findall(rf"^  (?:{'|'.join(GROUPS)}) +(.*)$", further, re.MULTILINE)
    others = ", ".join(rows).split(", ")
    assert {*described, *others} == {words[0] for words in commands() if len(words) == 1}
    assert len(described) + len(others) == len({*described, *others})


def command_of(words):
    """The command of some words."""
    command = command_line
    for word in words:
        command = command.get_command(click.Context(command), word)
    return command


def commands(group=command_line, words=()):
    """Words of all commands, those below others too."""
    yield words
    if isinstance(group, click.Group):
        context = click.Context(group)
        for name in group.list_commands(context):
            yield from commands(group.get_command(context, name), (*words, name))


@pytest.mark.parametrize("words", list(commands()), ids=" ".join)
def test_every_command_has_help_with_an_example(words):
    result = CliRunner().invoke(command_line, [*words, "--help"])
    assert result.exit_code == 0
    assert "Example: hcsearch" in " ".join(result.output.split())
    assert "None" not in result.output


def test_every_runtime_dependency_is_in_the_readme_with_its_reason():
    text = (ROOT / "README.md").read_text(encoding="utf-8").lower()
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    listed = re.search(r"^dependencies = \[(.*?)\]", project, re.DOTALL | re.MULTILINE)
    names = re.findall(r'"([a-z0-9-]+)', listed.group(1))
    assert names
    for name in names:
        assert re.search(rf"\*\*{name}\*\*:\s[^;]+[;.]", text), name
