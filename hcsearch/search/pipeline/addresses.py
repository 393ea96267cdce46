"""Addresses of schedulers, and a quick check that one listens there: Dask itself waits for any server for minutes."""

from __future__ import annotations

import re
import socket
import struct
import threading

from hcsearch.basics.errors import ClusterError

PATIENCE = 8.0
"""How long to wait for a scheduler's greeting, its name looked up and the connection made, in seconds."""

_ADDRESS = re.compile(r"(?:tcp://)?([^\s/:\[\]]+|\[[0-9a-fA-F:]+\]):([0-9]{1,5})", re.ASCII)
_LONGEST = 1 << 20  # bytes of a greeting, which has some hundred


def host_and_port(address: str) -> tuple[str, int]:
    """Split an address such as tcp://HOST:8786; ClusterError when it is none."""
    match = _ADDRESS.fullmatch(address)
    try:
        if match and 0 < int(match[2]) < 1 << 16 and match[1].isprintable() and match[1].encode("idna"):
            return match[1].strip("[]"), int(match[2])
    except UnicodeError:  # a part of the name is empty or too long
        pass
    raise ClusterError(f"{address!r} is not the address of a scheduler: write it as tcp://HOST:8786, a port to 65535")


def greets_as_dask(host: str, port: int, patience: float = PATIENCE) -> bool:
    """Whether a server listens there that greets as Dask's schedulers do: at once, by a frame after its length.

    patience : in seconds, for all of it.
    """
    answers: list[bool] = []
    # In a thread: nothing else bounds the time in which a name is looked up.
    thread = threading.Thread(target=lambda: answers.append(_greets(host, port, patience)), daemon=True)
    thread.start()
    thread.join(patience)
    return answers == [True]


def _greets(host: str, port: int, patience: float) -> bool:
    try:
        with socket.create_connection((host, port), timeout=patience) as link, link.makefile("rb") as stream:
            length: int = struct.unpack("<Q", stream.read(8))[0]
            return 0 < length < _LONGEST and len(stream.read(length)) == length
    except (OSError, struct.error):
        return False
