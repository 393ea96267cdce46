"""The exceptions users meet. Each message is one line that names the remedy; the command line prints it and exits 2."""


class HcsearchError(ValueError):
    """Wrong input or an unusable resource; the message says what to do instead."""


class NotationError(HcsearchError):
    """A text notation or array specification that cannot be read."""


class ArrayError(HcsearchError):
    """Cells that are no array: empty, repeated or not connected."""


class PatternError(HcsearchError):
    """A flat pattern that cannot be made: facets that overlap, creases without an edge, hinges within a panel."""


class SizeError(HcsearchError):
    """A request beyond what the chosen representation holds."""


class StageError(HcsearchError):
    """An unknown pipeline stage, or one that is not built yet."""


class DatabaseError(HcsearchError):
    """A database that cannot be opened, is not ours, or is newer than this program."""


class QueryError(HcsearchError):
    """A query that cannot be read, or that would change the database."""


class OutputError(HcsearchError):
    """A file that cannot be written, or must not be: a folder, a database."""


class ClusterError(HcsearchError):
    """Worker processes, or a cluster of them, that cannot be reached or have failed."""
