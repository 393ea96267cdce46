"""The exceptions users meet. Each message is one line that names the remedy; the command line prints it and exits 2."""

MAX_MESSAGE_WORD_LENGTH, MAX_MESSAGE_LINE_LENGTH = 200, 1200
"""Characters of a message, which echoes input: an array is 100 kB at most, and nobody reads that."""


def printable(text: str) -> str:
    """The text with control characters, and bytes that are no text, as escapes: no terminal acts on them."""
    if text.isprintable():
        return text
    return "".join(mark if mark.isprintable() else mark.encode("unicode_escape").decode() for mark in text)


def one_line(text: str) -> str:
    """The text as a message of one line: printable, and long words and lines without their middle."""
    # cut twice: escapes are longer than what they stand for
    words = (
        _shortened(printable(_shortened(word, MAX_MESSAGE_WORD_LENGTH)), MAX_MESSAGE_WORD_LENGTH)
        for word in text.split()
    )
    return _shortened(" ".join(words), MAX_MESSAGE_LINE_LENGTH)


def _shortened(text: str, longest: int) -> str:
    """The text, or what it begins and ends with: messages begin with the input and end with the remedy."""
    end = longest // 3
    return text if len(text) <= longest else f"{text[: longest - end - 3]}...{text[-end:]}"


class HcsearchError(ValueError):
    """Wrong input, or a resource that cannot be used; the message is one line that says what to do instead."""

    def __init__(self, message: str = "") -> None:
        super().__init__(one_line(message))


class HcsearchWarning(UserWarning):
    """Input that is taken as it is, and is probably not meant so; the message names the likely meaning."""


def wrong_kind_message(name: str, value: object, wanted: str) -> str:
    """The message on a value that is of another kind than is wanted; wanted : what to give instead, in words."""
    text = repr(value)
    return f"{name} cannot be {text if len(text) <= 60 else text[:57] + '...'}: give {wanted}"


def expect_kind(name: str, value: object, kind: type, wanted: str) -> None:
    """HcsearchError unless a value is of a kind; name : of what is given. wanted : what to give instead, in words."""
    if not isinstance(value, kind):
        raise HcsearchError(wrong_kind_message(name, value, wanted))


class NotationError(HcsearchError):
    """A text notation or array specification that cannot be read."""


class ArrayError(HcsearchError):
    """Cells that are no array: empty, repeated or not connected."""


class PatternError(HcsearchError):
    """A flat pattern that cannot be made: facets that overlap, creases without an edge, hinges within a panel."""


class InputFileError(HcsearchError):
    """A file that cannot be read: not there, a folder, a pipe or a device, too large, or no text."""


class SizeError(HcsearchError):
    """A request beyond what the chosen representation holds."""


class StageError(HcsearchError):
    """An unknown pipeline stage, or one that is not built yet."""


class DatabaseError(HcsearchError):
    """A database that cannot be opened, is not ours, or is newer than this program."""


class NoDatabaseError(DatabaseError):
    """A database that does not exist."""


class QueryError(HcsearchError):
    """A query that cannot be read, or that would change the database."""


class OutputError(HcsearchError):
    """A file that cannot be written, or must not be: a folder, a database."""


class ClusterError(HcsearchError):
    """Worker processes, or a cluster of them, that cannot be reached or have failed."""


class SceneError(HcsearchError):
    """A scene that cannot be read, that a grid cannot have, or that was never run."""
