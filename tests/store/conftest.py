import pytest

from hcsearch.store import open_database
from tests.postgresql import running_server


@pytest.fixture
def path(tmp_path):
    return tmp_path / "designs.sqlite"


@pytest.fixture
def database(path):
    with open_database(str(path), create=True) as opened:
        yield opened


@pytest.fixture(scope="session")
def server():
    """A PostgreSQL server of these tests alone."""
    with running_server() as running:
        yield running


@pytest.fixture
def name(server):
    """A new, empty database on the server."""
    name = server.create_database()
    yield name
    server.drop_database(name)


@pytest.fixture
def url(server, name):
    """Where that database is, with its password."""
    return server.url(name)
