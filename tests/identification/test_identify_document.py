"""docs/explanation/identification.md shows what the program does."""

import re
import shlex
from pathlib import Path

from click.testing import CliRunner

from hcsearch.cli import hcsearch

DOCUMENT = Path(__file__).parent.parent.parent / "docs" / "explanation" / "identification.md"


def test_the_spring_of_the_document(tmp_path, monkeypatch):
    text = DOCUMENT.read_text(encoding="utf-8")
    (table,) = re.findall(r"```text\n(angle_deg.*?)```", text, re.DOTALL)
    ((command, expected),) = re.findall(r"```console\n\$ hcsearch (.*?)\n(.*?)```", text, re.DOTALL)
    monkeypatch.chdir(tmp_path)
    Path("moments.csv").write_text(table, encoding="utf-8")
    result = CliRunner().invoke(hcsearch, shlex.split(command))
    assert result.exception is None
    assert result.output == expected
