"""Messages are one short printable line, whatever they echo; files that are read have an end."""

import os
import pickle
import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hcsearch.basics.errors import (
    MAX_MESSAGE_LINE_LENGTH,
    MAX_MESSAGE_WORD_LENGTH,
    HcsearchError,
    InputFileError,
    NotationError,
    one_line,
    printable,
)
from hcsearch.system.reading import parse_toml, read_text_file, read_toml


@given(st.text(st.characters(), max_size=3 * MAX_MESSAGE_WORD_LENGTH) | st.lists(st.text(), max_size=300).map(" ".join))
def test_any_message_is_one_short_printable_line(text):
    line = str(HcsearchError(text))
    assert line.isprintable()
    assert len(line) <= MAX_MESSAGE_LINE_LENGTH
    assert all(len(word) <= MAX_MESSAGE_WORD_LENGTH for word in line.split())
    assert one_line(line) == line


def test_messages_keep_the_input_s_beginning_and_the_remedy():
    message = str(NotationError(f"malformed array {'f' * 100_000!r}: write the grid"))
    assert message.startswith("malformed array 'ffff")
    assert message.endswith("ffff': write the grid")
    assert len(message) < 250
    lines = str(HcsearchError("word " * 10_000 + "give less"))
    assert lines.endswith("word give less")


def test_control_characters_become_escapes():
    assert str(HcsearchError("a\x1b[31mb\x07\0\u202e\ud800\x85c\nd")) == r"a\x1b[31mb\x07\x00\u202e\ud800 c d"
    assert printable("plain é 4-4-4") == "plain é 4-4-4"
    assert printable("line\n") == r"line\n"


def test_messages_travel_between_processes():
    error = NotationError("x" * 1000)
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is NotationError
    assert str(again) == str(error)


def test_text_files_are_read_without_their_mark(tmp_path):
    (tmp_path / "a.txt").write_bytes(b"\xef\xbb\xbfone\r\ntwo\n")
    assert read_text_file(tmp_path / "a.txt") == "one\r\ntwo\n"
    assert read_text_file(tmp_path / "a.txt", max_bytes=13) == "one\r\ntwo\n"


def test_files_that_have_no_end_or_are_no_text_are_refused(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "large").write_bytes(b"x" * 101)
    (tmp_path / "bytes").write_bytes(b"\xff\xfe")
    for name, most, reason in (
        ("pipe", 100, "it is a pipe or a device; write its content to a file first"),
        ("/dev/zero", 100, "it is a pipe or a device"),
        ("large", 100, "it is larger than 100 bytes; leave out what is not needed"),
        ("bytes", 100, "it is no text file; save it as UTF-8 text"),
        ("", 100, "Is a directory; name a file"),
        ("none", 100, "No such file or directory; name a file that is there"),
        ("a\0b", 100, "no file has such a name"),
        ("\ud800", 100, "no file has such a name"),
        ("n" * 5000, 100, "File name too long"),
    ):
        with pytest.raises(InputFileError, match=f"^cannot read the table .*{reason}"):
            read_text_file(tmp_path / name, "the table", most)


def test_a_pipe_is_refused_at_once_though_nobody_writes(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    answers = []
    reading = threading.Thread(target=lambda: answers.append(_refused(tmp_path / "pipe")), daemon=True)
    reading.start()
    reading.join(10)
    assert answers == [True]


def _refused(path):
    try:
        read_text_file(path)
    except InputFileError:
        return True
    return False


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("x = " + "[" * 2000 + "]" * 2000, "its brackets are nested too deep; write fewer"),
        ("x = 1" + "0" * 5000, "Exceeds the limit"),
        ("x = [{ y = 0x" + "f" * 5000 + " }]", "it has an integer of more than 64 bits"),
        (f"x = {2**63}", "it has an integer of more than 64 bits, which TOML does not allow; write a smaller number"),
        (f"x = {-(2**63) - 1}", "it has an integer of more than 64 bits"),
        ("x =", "Invalid value"),
        ("x = 1\nx = 2", "Cannot overwrite a value"),
        ("a" + ".a" * 50_000 + " = 1", "a key has more than 32 parts; write fewer points in it"),
        ("[" + "'[' . " * 50_000 + "a]", "a key has more than 32 parts"),
        ('x = { "\\"=" . ' + "'#' . " * 50_000 + "a = 1 }", "a key has more than 32 parts"),
    ],
)
def test_what_is_no_toml_is_refused(tmp_path, text, reason):
    (tmp_path / "a.toml").write_text(text)
    with pytest.raises(InputFileError, match=f"a.toml is no TOML: .*{reason}"):
        read_toml(tmp_path / "a.toml")


def test_points_in_texts_remarks_and_numbers_are_no_parts_of_a_key():
    points = "." * 100
    text = (
        f'# {points}\nx = \'{points}\' # \'{points}\ny = "\\"{points}"\nz = [{"0.1, " * 100}]\nt = """\n{points}\n"""\n'
    )
    assert len(parse_toml(text)) == 4


def test_integers_of_64_bits_are_read():
    assert parse_toml(f"x = {2**63 - 1}\ny = [{-(2**63)}]") == {"x": 2**63 - 1, "y": [-(2**63)]}


def test_toml_is_read(tmp_path):
    (tmp_path / "a.toml").write_text("design = 'hex:024'\n[scene]\nseconds = 1\n")
    assert read_toml(tmp_path / "a.toml") == {"design": "hex:024", "scene": {"seconds": 1}}
