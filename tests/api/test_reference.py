"""The reference of Python names is that of the docstrings."""

from pathlib import Path

import hcsearch
from hcsearch.api.reference import reference_page
from hcsearch.system.lazy import names_in_stub

ROOT = Path(__file__).parent.parent.parent


def test_the_reference_has_all_public_names_once():
    names = [name for group in names_in_stub("hcsearch").values() for name in group]
    assert sorted(names) == sorted(hcsearch.__all__)


def test_the_reference_in_docs_is_current():
    assert (ROOT / "docs" / "reference" / "api.md").read_text(encoding="utf-8") == reference_page(), "run make docs"


def test_the_reference_tells_how_each_function_is_called():
    text = reference_page()
    for name in ("deploy", "tune", "enumerate_into", "read", "rank", "save", "replay", "enumerate_circuits"):
        assert f"### `{name}`\n\n```python\n{name}(\n" in text
    assert "| `on(array)` | Move the circuit to the cells of an array" in text
