"""The script is what its sources make. Needs npm: without it this test fails, it is not skipped."""

import shutil
import subprocess
from pathlib import Path

import pytest

PLAYER = Path(__file__).parents[2] / "hcsearch" / "web" / "player"


@pytest.mark.extra
def test_the_script_is_what_its_sources_make(tmp_path):
    assert shutil.which("npm"), "npm is not installed: apt-get install npm"
    shutil.copytree(PLAYER / "js", tmp_path / "js", ignore=shutil.ignore_patterns("node_modules"))
    for command in (["npm", "ci", "--no-audit", "--no-fund"], ["npm", "run", "build"]):
        subprocess.run(command, cwd=tmp_path / "js", capture_output=True, timeout=300, check=True)
    assert (tmp_path / "player.js").read_bytes() == (PLAYER / "player.js").read_bytes()
