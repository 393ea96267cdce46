"""Addresses that are none, and strangers who listen where a scheduler should: refused at once, without Dask."""

import socket
import struct
import threading
import time
from contextlib import contextmanager

import pytest

from hcsearch.basics.errors import ClusterError
from hcsearch.search.pipeline import WorkerPool
from hcsearch.search.pipeline.workers import greets_as_dask, host_and_port


@contextmanager
def listening(greeting):
    """Someone who greets each that comes in this way, and then waits."""
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve():
            link, _ = server.accept()
            with link:
                link.sendall(greeting)
                link.recv(1)

        thread = threading.Thread(target=serve)
        thread.start()
        yield server.getsockname()[1]
        thread.join()


@pytest.mark.parametrize(
    ("greeting", "good"),
    [
        (struct.pack("<Q", 5) + b"hello", True),
        (b"", False),
        (b"SSH-2.0-OpenSSH_9.2\r\n", False),
        (bytes(64), False),
        (struct.pack("<Q", 50) + b"too short", False),
    ],
)
def test_only_a_whole_frame_is_a_greeting(greeting, good):
    with listening(greeting) as port:
        begin = time.monotonic()
        assert greets_as_dask("127.0.0.1", port, 0.2) is good
        assert time.monotonic() - begin < 5


def test_nobody_and_no_such_name():
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    assert not greets_as_dask("127.0.0.1", port)
    assert not greets_as_dask("no.such.host.invalid", 8786, 0.5)


@pytest.mark.parametrize(
    ("address", "expected"),
    [("tcp://host:8786", ("host", 8786)), ("10.0.0.1:1", ("10.0.0.1", 1)), ("tcp://[::1]:65535", ("::1", 65535))],
)
def test_addresses_are_split(address, expected):
    assert host_and_port(address) == expected


@pytest.mark.parametrize(
    "address",
    [
        "host",
        "host:port",
        "host:0",
        "host:65536",
        "tcp://host:99999999999999999999",
        "http://host:80",
        "tcp://a..b:80",
        f"tcp://{'h' * 300}:80",
        "tcp://\udcff:80",
        "tcp://h\x1b:80",
        "tcp://host:\u0661",
    ],
)
def test_what_is_no_address_is_one_line(address):
    with pytest.raises(ClusterError, match="is not the address of a scheduler: write it as tcp://HOST:8786") as caught:
        WorkerPool(scheduler=address)
    assert str(caught.value).isprintable()
