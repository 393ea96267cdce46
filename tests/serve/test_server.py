"""The command in a process of its own, on a real socket."""

import os
import re
import signal
import socket
import subprocess
import sys
import time
from contextlib import closing, contextmanager, suppress
from http.client import HTTPConnection

import pytest

from tests.commands import run_here


@contextmanager
def serving(database_file, *words):
    command = [sys.executable, "-m", "hcsearch", "serve", "--db", str(database_file), "--port", "0", *words]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    try:
        line = process.stdout.readline()
        yield process, int(re.match(r"http://[^ ]*:(\d+)/ shows .*designs.sqlite; Ctrl-C ends it$", line)[1])
    finally:
        if process.poll() is None:
            process.kill()
        process.communicate()


def get(port, address, **headers):
    with closing(HTTPConnection("127.0.0.1", port, timeout=60)) as connection:
        connection.request("GET", address, headers=headers)
        with connection.getresponse() as answer:
            return answer.status, answer.read()


def raw(port, sent):
    with socket.create_connection(("127.0.0.1", port), timeout=60) as connection:
        received = b""
        with suppress(OSError):  # as it may hang up before it has read everything
            connection.sendall(sent)
            connection.shutdown(socket.SHUT_WR)
            while piece := connection.recv(65536):
                received += piece
    return received


@pytest.mark.extra
def test_it_lives_through_what_sockets_bring_and_ends_at_ctrl_c(database_file, number):
    before = database_file.read_bytes()
    with serving(database_file) as (process, port):
        assert get(port, "/designs")[0] == 200
        for sent in (
            b"\x00\xff\x16\x03\x01\r\n\r\n",
            b"GET / HTTP/1.1\r\n\r\n",
            b"GET /designs HTTP/1.1\r\nHost: evil.example\r\n\r\n",
            b"GET /" + b"a" * 100_000 + b" HTTP/1.1\r\nHost: localhost\r\n\r\n",
            b"POST /designs HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99999999\r\n\r\n",
            b"POST /designs HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\nzz\r\n",
            b"CONNECT evil.example:443 HTTP/1.1\r\nHost: evil.example\r\n\r\n",
        ):
            assert not re.match(rb"HTTP/1.. 2", raw(port, sent)), sent
        raw(port, b"GET /designs.csv HTTP/1.1\r\nHost: localhost\r\n")
        # a design is computed, in the midst of which all ends
        asked = socket.create_connection(("127.0.0.1", port))
        asked.sendall(f"GET /designs/{number} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
        assert get(port, "/designs.json?limit=1")[0] == 200
        time.sleep(0.3)
        os.killpg(process.pid, signal.SIGINT)
        out, err = process.communicate(timeout=30)
        asked.close()
    assert (process.returncode, out) == (130, "")
    assert err.strip() == "hcsearch: the server has ended"
    assert database_file.read_bytes() == before


@pytest.fixture
def run(tmp_path, monkeypatch, capfd):
    def call(*words):
        monkeypatch.chdir(tmp_path)
        done = run_here(("serve", *words), capfd)
        assert done.returncode == 2
        assert done.stderr.count("\n") == 1
        return done.stdout + done.stderr

    return call


@pytest.mark.extra
def test_what_hinders_it_is_one_line(run, database_file):
    here = ("--db", str(database_file))
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        assert f"port {port} is in use: stop who uses it, or give another with --port" in run(*here, "--port", port)
    assert "there is no hcsearch database at hcsearch.sqlite" in run()
    assert "this machine has no address 'a..b'" in run(*here, "--port", "0", "--host", "a..b")
    assert "no verdicts of the scene 'lunar'" in run(*here, "--scene", "lunar")


@pytest.mark.extra
def test_other_machines_are_let_in_with_a_warning(database_file):
    with serving(database_file, "--host", "0.0.0.0") as (process, port):
        assert get(port, "/runs")[0] == 200
        os.killpg(process.pid, signal.SIGINT)
        _, err = process.communicate(timeout=30)
    assert "warning: whoever reaches 0.0.0.0 can read this database" in err


def test_the_extra_is_named_where_it_is_missing(run):
    assert "hcsearch serve needs werkzeug: pip install 'hcsearch[serve]'" in run()
