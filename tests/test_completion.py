"""Completion in the shell, as docs/reference/commands.md describes it."""

import os
import re
import shutil
import subprocess
import sys

import pytest

from tests.documents import ROOT

PAGE = (ROOT / "docs" / "reference" / "commands.md").read_text(encoding="utf-8")
ASKED = re.findall(r"_HCSEARCH_COMPLETE=((?:bash|zsh|fish)_source) hcsearch", PAGE)


def answer(**surroundings):
    """What the command `hcsearch` prints in an environment."""
    code = "import sys; sys.argv = ['hcsearch']; from hcsearch.__main__ import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", code], env=os.environ | surroundings, capture_output=True, text=True, check=True
    )
    return done.stdout


def test_the_page_names_each_shell():
    assert {"bash_source", "zsh_source", "fish_source"} == set(ASKED)


@pytest.mark.parametrize("asked", sorted(set(ASKED)))
def test_a_script_is_printed_that_the_shell_reads(asked, tmp_path):
    script = answer(_HCSEARCH_COMPLETE=asked)
    shell = asked.removesuffix("_source")
    assert f"_HCSEARCH_COMPLETE={shell}_complete" in script
    if shutil.which(shell):
        (tmp_path / "script").write_text(script, encoding="utf-8")
        subprocess.run([shell, "-n", "script"], cwd=tmp_path, check=True)


@pytest.mark.parametrize(
    ("words", "completed"),
    [("hcsearch enumerate --gr", {"plain,--grid"}), ("hcsearch enumerate --grid rh", {"plain,rhombus"})],
)
def test_options_and_their_words_are_completed(words, completed):
    asked = {"COMP_WORDS": words, "COMP_CWORD": str(words.count(" "))}
    assert set(answer(_HCSEARCH_COMPLETE="bash_complete", **asked).split()) == completed
