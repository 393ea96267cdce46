import pytest

from hcsearch.store import open_database
from tests.postgresql import running_server


@pytest.fixture
def path(tmp_path):
    return tmp_path / "designs.sqlite"


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


@pytest.fixture(params=["sqlite", pytest.param("postgresql", marks=pytest.mark.extra)])
def place(request):
    """Where a new database will be: in a file, and on a server."""
    return str(request.getfixturevalue("path")) if request.param == "sqlite" else request.getfixturevalue("url")


@pytest.fixture
def database(place):
    """An empty database of either kind, open for writing."""
    with open_database(place, create=True) as opened:
        yield opened
