"""Exceptions shown to users. Each message is one line that names the remedy; the command line prints it, exits 2."""

MAX_MESSAGE_WORD_LENGTH, MAX_MESSAGE_LINE_LENGTH = 200, 1200
"""Limits in characters: messages echo input, and an array specification may have 100 kB."""


def printable(text: str) -> str:
    """Return the text with control characters and undecodable bytes escaped, so that terminals do not act on them."""
    if text.isprintable():
        return text
    return "".join(
        character if character.isprintable() else character.encode("unicode_escape").decode() for character in text
    )


def one_line(text: str) -> str:
    """Return the text as a printable line, with the middle of long words and lines cut out."""
    # cut twice: escapes are longer than the characters that they replace
    words = (
        _shortened(printable(_shortened(word, MAX_MESSAGE_WORD_LENGTH)), MAX_MESSAGE_WORD_LENGTH)
        for word in text.split()
    )
    return _shortened(" ".join(words), MAX_MESSAGE_LINE_LENGTH)


def _shortened(text: str, max_length: int) -> str:
    """Return the text, cut in the middle if too long: messages begin with the input and end with the remedy."""
    end_length = max_length // 3
    return text if len(text) <= max_length else f"{text[: max_length - end_length - 3]}...{text[-end_length:]}"


class HcsearchError(ValueError):
    """Invalid input, or an unusable resource; the message is one line that says what to do instead.

    Parameters
    ----------
    message
        What is wrong, and what to do instead.
    """

    def __init__(self, message: str = "") -> None:
        super().__init__(one_line(message))


class HcsearchWarning(UserWarning):
    """Input that is accepted, but probably means something else; the message names the likely intention."""


def wrong_kind_message(name: str, value: object, wanted: str) -> str:
    """Return the error message for a value of the wrong type.

    wanted : valid input, in words.
    """
    text = repr(value)
    return f"{name} cannot be {text if len(text) <= 60 else text[:57] + '...'}: give {wanted}"


def expect_kind(name: str, value: object, kind: type, wanted: str) -> None:
    """Raise HcsearchError unless a value is of a given type.

    name : of the parameter. wanted : valid input, in words.
    """
    if not isinstance(value, kind):
        raise HcsearchError(wrong_kind_message(name, value, wanted))


class NotationError(HcsearchError):
    """A text notation or array specification that cannot be read."""


class ArrayError(HcsearchError):
    """Cells that do not form an array: none, repeated or not connected."""


class PatternError(HcsearchError):
    """An invalid flat pattern: overlapping facets, creases without an edge, or hinges within a panel."""


class InputFileError(HcsearchError):
    """A file that cannot be read: missing, a folder, a pipe or a device, too large, or not text."""


class SizeError(HcsearchError):
    """A request that exceeds the capacity of the chosen representation."""


class StageError(HcsearchError):
    """An unknown pipeline stage, or one that is not implemented yet."""


class DatabaseError(HcsearchError):
    """A database that cannot be opened, was not written by hcsearch, or is newer than this program."""


class NoDatabaseError(DatabaseError):
    """A database that does not exist."""


class QueryError(HcsearchError):
    """A query that cannot be read, or that would change the database."""


class OutputError(HcsearchError):
    """A file that cannot or must not be written: a folder, a database."""


class ClusterError(HcsearchError):
    """Worker processes, local or in a cluster, that cannot be reached or have failed."""


class SceneError(HcsearchError):
    """A scene that cannot be read, does not suit a grid, or was never run."""
