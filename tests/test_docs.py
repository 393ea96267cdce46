"""What the documents show is what the program does."""

import doctest
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

import hcsearch
from hcsearch.circuit import Circuit
from hcsearch.cli import hcsearch as command_line
from hcsearch.folding import folding_of
from hcsearch.grid import GRIDS

ROOT = Path(__file__).parent.parent
DOCUMENTS = sorted([ROOT / "README.md", *(ROOT / "docs").glob("*.md"), ROOT / "db" / "README.md"])


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_python_examples(document, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # some make a database
    monkeypatch.delenv("HCSEARCH_DB", raising=False)
    failed, _ = doctest.testfile(str(document), module_relative=False, optionflags=doctest.NORMALIZE_WHITESPACE)
    assert failed == 0


def test_examples_in_the_package_docstring():
    failed, tried = doctest.testmod(hcsearch)
    assert tried > 0
    assert failed == 0


def shell_examples(document):
    """(command, expected output) of every ```console block of a document, in order."""
    for block in re.findall(r"```console\n(.*?)```", document.read_text(encoding="utf-8"), re.DOTALL):
        for chunk in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]:
            command, _, output = chunk.partition("\n")
            yield command, output


def called(words):
    """A command as this environment runs it: `make` with its own, which is set up already."""
    if words[0] == "make":
        own = [f"VENV={sys.prefix}", f"--old-file={sys.prefix}/installed", "--no-print-directory"]
        return ["make", f"--file={ROOT / 'Makefile'}", *own, *words[1:]]
    assert words[0] == "hcsearch"
    return [sys.executable, "-m", *words]


@pytest.mark.long
def test_shell_examples_of_the_readme(tmp_path):
    examples = list(shell_examples(ROOT / "README.md"))
    assert examples[0][0] == "make run"
    outer = {"MAKEFLAGS", "MAKELEVEL", "MFLAGS"}  # of the make that runs the tests
    surroundings = {name: value for name, value in os.environ.items() if name not in outer}
    for command, expected in examples:
        done = subprocess.run(
            called(shlex.split(command)),
            cwd=tmp_path,
            env=surroundings,
            capture_output=True,
            text=True,
            timeout=900,
            check=True,
        )
        # times differ from run to run; everything else is as shown
        timeless = re.compile(r"\d+\.\d\d s")
        output = done.stdout.replace(f"{sys.prefix}/", ".venv/")
        assert timeless.sub("_", output) == timeless.sub("_", expected), command
    assert (tmp_path / "reports" / "hex-12.html").stat().st_size > 100_000


def commands_in_sentences(document):
    """Words of every `hcsearch ...` in the text between the blocks of a document."""
    text = re.sub(r"```.*?```", "", document.read_text(encoding="utf-8"), flags=re.DOTALL)
    return [shlex.split(words) for words in re.findall(r"`hcsearch ([^`]*)`", text)]


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_commands_in_sentences_have_the_words_that_there_are(document):
    for words in commands_in_sentences(document):
        command = command_line
        while isinstance(command, click.Group) and words and words[0] != "NAME":
            command = command.get_command(click.Context(command), words.pop(0))
        options = {option for parameter in command.params for option in parameter.opts}
        assert {word for word in words if word.startswith("--")} <= options, words
        for word in words:
            grid, colon, rest = word.partition(":")
            if colon and grid in GRIDS:
                circuit, _, crease = rest.partition(":")
                assert folding_of(Circuit.from_notation(f"{grid}:{circuit}"), int(crease))


def test_short_commands_in_sentences_of_the_readme_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    short = [words for words in commands_in_sentences(ROOT / "README.md") if words[0] in {"assembly", "deploy"}]
    short = [words for words in short if words[1:] and not words[1].endswith(".toml")]
    assert [words[0] for words in short] == ["assembly", "assembly", "deploy"]
    for words in short:
        result = CliRunner().invoke(command_line, words)
        assert result.exit_code == 0, result.output
    assert (tmp_path / "angles.svg").exists()


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
        assert re.search(rf"^\| {name} \|.+\|$", text, re.MULTILINE), name


def test_changelog_names_the_version():
    assert hcsearch_version() in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


def hcsearch_version():
    from importlib.metadata import version

    return version("hcsearch")
