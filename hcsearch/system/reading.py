"""Input files of bounded size: bytes, UTF-8 text and TOML."""

from __future__ import annotations

import re
import stat
import tomllib
from pathlib import Path
from typing import Any

from hcsearch.basics.errors import InputFileError

MAX_INPUT_BYTES = 4 * 2**20
"""Default limit of a file's size: ten times what the largest array takes."""
_MOST_PARTS = 32
"""Limit of the parts of a dotted TOML key, whose memory grows with the square of their number."""
_STRING = re.compile(
    r""""{3}(?:\\.|[^\\])*?(?:"{3}|\Z)|'{3}.*?(?:'{3}|\Z)|"(?:\\.|[^"\\\n])*"?|'[^'\n]*'?|\#[^\n]*""", re.DOTALL
)
_LONG_KEY = re.compile(rf"(?:\.[^][{{}}=,.\n]*){{{_MOST_PARTS}}}")


def read_text_file(path: str | Path, what: str = "", max_bytes: int = MAX_INPUT_BYTES) -> str:
    """Return the text of a UTF-8 file, without a byte order mark.

    what, max_bytes : as of `read_binary_file`. Errors: InputFileError as of that, and for a file that is no UTF-8 text.
    """
    content = read_binary_file(path, what, max_bytes)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        named = f"{what} {path}".strip()
        raise InputFileError(f"cannot read {named}: it is no text file; save it as UTF-8 text") from error


def read_binary_file(path: str | Path, what: str = "", max_bytes: int = MAX_INPUT_BYTES) -> bytes:
    """Return the content of a file.

    what : expected content for messages, such as "the table". max_bytes : limit of the size. Errors: InputFileError for
    a missing file, a folder, a pipe or a device (reading might never end), and a file above the limit.
    """
    named = f"{what} {path}".strip()
    try:
        kind = Path(path).stat().st_mode
        if not stat.S_ISREG(kind) and not stat.S_ISDIR(kind):
            raise InputFileError(f"cannot read {named}: it is a pipe or a device; write its content to a file first")
        with Path(path).open("rb") as file:
            content = file.read(max_bytes + 1)
    except OSError as error:
        raise InputFileError(f"cannot read {named}: {error.strerror}; name a file that is there") from error
    except ValueError as error:  # a name with a zero byte, or with half of a character
        if isinstance(error, InputFileError):
            raise
        raise InputFileError(f"cannot read {named}: no file has such a name; name a file that is there") from error
    if len(content) > max_bytes:
        raise InputFileError(f"cannot read {named}: it is larger than {_size(max_bytes)}; leave out what is not needed")
    return content


def read_toml(path: str | Path) -> dict[str, Any]:
    """Parse a TOML file; InputFileError as of `read_text_file`, and for a syntax error."""
    text = read_text_file(path)
    try:
        return parse_toml(text)
    except ValueError as error:
        raise InputFileError(f"{path} is no TOML: {error}") from error


def parse_toml(text: str) -> dict[str, Any]:
    """Parse a TOML text of bounded size in bounded memory; ValueError, with the remedy, for a syntax error."""
    if len(text) > MAX_INPUT_BYTES:
        raise ValueError(f"it is larger than {_size(MAX_INPUT_BYTES)}; leave out what is not needed")
    if _LONG_KEY.search(_STRING.sub("''", text)):
        raise ValueError(f"a key has more than {_MOST_PARTS} parts; write fewer points in it")
    try:
        table = tomllib.loads(text)
    except RecursionError:
        raise ValueError("its brackets are nested too deep; write fewer") from None
    except ValueError as error:  # mistakes, and numbers with more digits than Python reads
        raise ValueError(f"{error}; write lines such as key = 'value'") from error
    if _has_long_integer(table):  # no float, and with thousands of digits no text either
        raise ValueError("it has an integer of more than 64 bits, which TOML does not allow; write a smaller number")
    return table


def _has_long_integer(table: dict[str, Any]) -> bool:
    values: list[Any] = [table]
    for value in values:  # which grows meanwhile
        if isinstance(value, dict | list):
            values += value.values() if isinstance(value, dict) else value
        elif isinstance(value, int) and not -(2**63) <= value < 2**63:
            return True
    return False


def _size(size: int) -> str:
    return f"{size >> 20} MiB" if size >= 2**20 else f"{size} bytes"
