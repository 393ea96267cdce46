"""The release that is installed, looked up when it is asked for."""

from importlib.metadata import version

__version__ = version("hcsearch")
