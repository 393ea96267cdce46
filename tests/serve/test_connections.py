"""Connections that are slow on purpose, on real sockets, with less patience than the server has."""

import socket
import threading
import time
from contextlib import contextmanager, suppress

import pytest

pytestmark = pytest.mark.extra

HEAD = b"GET / HTTP/1.1\r\nHost: localhost\r\n"
LARGE = 8_000_000
TOO_MANY = 30


def application(environ, start_response):
    body = b"x" * LARGE if environ["PATH_INFO"] == "/large" else environ["PATH_INFO"].encode()
    start_response("200 OK", [("Content-Length", str(len(body)))])
    return [body]


@contextmanager
def serving(**patience):
    from waitress.wasyncore import close_all

    from hcsearch.web.serve.server import ConnectionLimits, Server

    with socket.create_server(("127.0.0.1", 0)) as listening:
        server = Server(application, listening, ConnectionLimits(**patience), {"threads": 4})

        def run():
            with suppress(OSError, ValueError):  # as it is closed while it waits
                server.run()

        thread = threading.Thread(target=run, daemon=True)
        thread.start()
        try:
            yield listening.getsockname()
        finally:
            server.task_dispatcher.shutdown()
            server.close()
            for channel in list(server.active_channels.values()):
                channel.cut()  # the loop ends once all are closed
            thread.join(10)
            for channel in list(server.active_channels.values()):  # where the loop ended before they were closed
                channel.handle_close()  # with the files of answers that nobody took
            close_all(server._map, ignore_all=True)


@contextmanager
def connected(address, count):
    made = [socket.create_connection(address, timeout=10) for _ in range(count)]
    try:
        yield made
    finally:
        for connection in made:
            connection.close()


def is_open(connection):
    """Whether the other end has not hung up."""
    connection.settimeout(0)
    try:
        return connection.recv(1) != b""
    except BlockingIOError:
        return True
    except OSError:
        return False


def until_closed(connections, before_each=lambda connection: None, seconds=20.0):
    """Seconds until all have been closed."""
    begun = time.monotonic()
    left = list(connections)
    while left and time.monotonic() < begun + seconds:
        for connection in left:
            with suppress(OSError):
                before_each(connection)
        left = [connection for connection in left if is_open(connection)]
        time.sleep(0.05)
    assert not left
    return time.monotonic() - begun


def answer(address, path="/here"):
    with socket.create_connection(address, timeout=10) as connection:
        connection.sendall(f"GET {path} HTTP/1.0\r\n\r\n".encode())
        received = b""
        while piece := connection.recv(65536):
            received += piece
    return received.partition(b"\r\n\r\n")[2]


@pytest.mark.parametrize("begin", [b"", HEAD, b"POST / HTTP/1.1\r\nContent-Length: 900\r\n\r\n"])
def test_new_connections_find_room_among_more_than_may_be(begin):
    with serving(max_connections=20, request_seconds=60) as address, connected(address, TOO_MANY) as slow:
        for connection in slow:
            with suppress(OSError):  # those that had to make room by then
                connection.sendall(begin)
        for k in range(5):
            assert answer(address, f"/{k}") == f"/{k}".encode()
        assert sum(map(is_open, slow)) < 20


def test_who_waits_the_longest_goes_first():
    with serving(max_connections=3) as address, connected(address, 3) as (first, second, third):
        first.sendall(HEAD + b"\r\n")
        assert first.recv(1000)  # answered, and then idle for less time than the second
        with connected(address, 1) as (last,):
            until_closed([second])
            assert all(map(is_open, (first, third, last)))


def test_a_request_has_its_time_from_its_first_byte_to_its_last():
    def drip(connection):
        connection.sendall(b"a")

    with serving(request_seconds=1.0) as address, connected(address, 3) as (idle, *slow):
        for connection in slow:
            connection.sendall(HEAD + b"X-Slow: ")
        assert until_closed(slow, drip) < 10
        assert is_open(idle)
        idle.setblocking(True)
        idle.sendall(HEAD + b"\r\n")
        assert idle.recv(12) == b"HTTP/1.1 200"


def test_others_are_answered_beside_bytes_that_drip_and_answers_that_nobody_takes():
    with serving(max_connections=30, request_seconds=60, pace_seconds=60) as address, connected(address, 20) as slow:
        for connection in slow[:3]:
            connection.sendall(b"GET /large HTTP/1.0\r\n\r\n")
        for connection in slow[3:]:
            connection.sendall(HEAD)
        for k in range(20):
            for connection in slow[3:]:
                connection.sendall(b"X")
            assert answer(address, f"/{k}") == f"/{k}".encode()
        assert all(map(is_open, slow))


def test_dripped_bodies_have_the_time_of_a_request():
    def drip(connection):
        connection.sendall(b"a")

    with serving(request_seconds=1.0) as address, connected(address, 3) as slow:
        for connection in slow:
            connection.sendall(b"POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 900\r\n\r\n")
        assert until_closed(slow, drip) < 10


def test_an_answer_that_is_not_taken_is_ended():
    with serving(min_bytes_per_pace=100_000_000, pace_seconds=0.5) as address, connected(address, 1) as (slow,):
        slow.sendall(b"GET /large HTTP/1.0\r\n\r\n")
        time.sleep(2.5)
        slow.settimeout(10)
        received = 0
        with suppress(ConnectionError):
            while piece := slow.recv(1 << 20):
                received += len(piece)
        assert received < LARGE


def test_an_answer_that_is_taken_slowly_enough_is_whole():
    with serving(min_bytes_per_pace=1000, pace_seconds=0.5) as address, connected(address, 1) as (slow,):
        slow.sendall(b"GET /large HTTP/1.0\r\n\r\n")
        received = b""
        while piece := slow.recv(1 << 20):
            received += piece
            time.sleep(0.05)
        assert received.endswith(b"\r\n\r\n" + b"x" * LARGE)


def test_requests_that_come_at_once_are_answered_in_order():
    with serving() as address, connected(address, 1) as (connection,):
        connection.sendall(b"".join(f"GET /{k} HTTP/1.1\r\n\r\n".encode() for k in range(200)))
        connection.sendall(b"GET /last HTTP/1.1\r\nConnection: close\r\n\r\n")
        received = b""
        while piece := connection.recv(65536):
            received += piece
    bodies = [part.partition(b"\r\n\r\n")[2] for part in received.split(b"HTTP/1.1 200 OK\r\n")[1:]]
    assert bodies == [f"/{k}".encode() for k in range(200)] + [b"/last"]


@pytest.mark.parametrize("address", ["http://[::1", "http://[x", "http://[x]y/here"])
def test_addresses_that_cannot_be_split_are_bad_requests(address, capfd, caplog):
    with serving() as server, socket.create_connection(server, timeout=10) as connection:
        connection.sendall(f"GET {address} HTTP/1.1\r\nHost: here\r\n\r\n".encode())
        assert connection.recv(4096).startswith(b"HTTP/1.1 400 ")
        assert answer(server)
    faults = [record for record in caplog.records if record.name != "waitress.queue"]  # requests that wait are none
    assert (capfd.readouterr(), faults) == (("", ""), [])
