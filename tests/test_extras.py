"""What extras install is loaded by the tests that need it, and by no other."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import EXTRAS

ROOT = Path(__file__).parents[1]


@pytest.mark.slow
def test_the_tests_are_read_where_no_extra_is_installed():
    collect = ["--collect-only", "--quiet", "-p", "no:cacheprovider", "-p", "no:xdist"]
    code = f"import pytest, sys; sys.modules.update(dict.fromkeys({EXTRAS})); sys.exit(pytest.main({collect}))"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-2000:]
