from hypothesis import settings

from tests.faults.summary import pytest_terminal_summary

__all__ = ["pytest_terminal_summary"]

# the first example of a test may compile a kernel
settings.register_profile("hcsearch", deadline=None)
settings.load_profile("hcsearch")
