"""The recipes of CONTRIBUTING.md: their patches apply to the package, and their commands show what the page says."""

import os
import re
import shlex
import shutil
import subprocess
import sys

import pytest

from hcsearch.store.schema import SCHEMA_REVISION
from tests.documents import ROOT, agrees, blocks, examples_in

_, _, PAGE = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").partition("\n## Recipes\n")
RECIPES = dict(re.findall(r"^### (.*?)\n(.*?)(?=^### |\Z)", PAGE, re.MULTILINE | re.DOTALL))
MOST_FILES = {"Add a tiling": 1, "Add a column": 2, "Add a stage": 4, "Add a value of a scene": 2}
"""How many files the patch of a recipe may touch, where an addition is one fact in one place."""
NEXT = f"{int(SCHEMA_REVISION) + 1:04d}"


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    """A copy of the sources to which patches are applied."""
    folder = tmp_path_factory.mktemp("package")
    shutil.copytree(ROOT / "hcsearch", folder / "hcsearch")
    shutil.copytree(ROOT / "docs" / "reference", folder / "docs" / "reference")
    return folder


def patch_of(recipe):
    """The patches of a recipe, with the next number of a schema in place of that of the page."""
    patch = "".join(text for kind, text in blocks(recipe) if kind == "diff")
    for older in re.findall(r'^\+down_revision = "(\d+)"', patch, re.MULTILINE):
        newer = f"{int(older) + 1:04d}"
        patch = patch.replace(newer, NEXT).replace(older, SCHEMA_REVISION)
    return patch


def apply_patch(package, patch, *options):
    subprocess.run(["git", "apply", *options, "-"], cwd=package, input=patch, text=True, check=True)


def test_there_is_a_recipe_for_each_kind_of_addition():
    assert [name.rpartition(" ")[2] for name in RECIPES] == ["command", "format", "tiling", "column", "stage", "scene"]


@pytest.mark.parametrize("name", MOST_FILES)
def test_a_recipe_touches_few_files(name):
    files = re.findall(r"^\+\+\+ b/(.+)$", patch_of(RECIPES[name]), re.MULTILINE)
    assert 0 < len(files) == len(set(files)) <= MOST_FILES[name]


@pytest.mark.parametrize("name", RECIPES)
def test_a_recipe_works(package, tmp_path, name):
    patch = patch_of(RECIPES[name])
    apply_patch(package, patch)
    try:
        for command, expected, numbers in examples_in(RECIPES[name]):
            done = subprocess.run(
                [sys.executable, "-m", *shlex.split(command)],
                cwd=tmp_path,
                env=os.environ | {"PYTHONPATH": str(package)},
                capture_output=True,
                text=True,
                check=False,
            )
            assert agrees(done.stdout, expected, numbers), f"{command}\n{done.stdout}\n{done.stderr}"
    finally:
        apply_patch(package, patch, "--reverse")
