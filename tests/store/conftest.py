import pytest

from hcsearch.store import open_database


@pytest.fixture
def path(tmp_path):
    return tmp_path / "designs.sqlite"


@pytest.fixture
def database(path):
    with open_database(str(path), create=True) as opened:
        yield opened
