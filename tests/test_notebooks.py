"""The notebooks of the documentation; the site, whose build runs them, is tested in `test_documentation_site`."""

import ast
import json

import pytest

import hcsearch
from tests.documents import ROOT, links

FOLDER = ROOT / "docs" / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))


def named(path):
    return path.stem


def code_cells(path):
    return [cell for cell in json.loads(path.read_text(encoding="utf-8"))["cells"] if cell["cell_type"] == "code"]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=named)
def test_notebooks_are_kept_without_outputs(path):
    assert all(not cell["outputs"] and cell["execution_count"] is None for cell in code_cells(path))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=named)
def test_notebooks_use_public_names_alone(path):
    nodes = [node for cell in code_cells(path) for node in ast.walk(ast.parse("".join(cell["source"])))]
    imports = [node for node in nodes if isinstance(node, ast.ImportFrom)]
    used = {name.name for node in imports if node.module == "hcsearch" for name in node.names}
    assert used
    assert used <= set(dir(hcsearch))
    assert not [node.module for node in imports if node.module.startswith("hcsearch.")]
    assert not [node.attr for node in nodes if isinstance(node, ast.Attribute) and node.attr.startswith("_")]


def test_the_contents_list_all_notebooks():
    linked = set(links(ROOT / "docs" / "README.md"))
    assert {f"notebooks/{path.name}" for path in NOTEBOOKS} <= linked
    assert len(NOTEBOOKS) == 5
