import os

# The matrices here are small: more threads of BLAS would wait for each other, and take the cores of other tests.
os.environ.setdefault("OMP_NUM_THREADS", "1")

from hypothesis import settings

from tests.faults.summary import pytest_terminal_summary

__all__ = ["pytest_terminal_summary"]

# the first example of a test may compile a kernel
settings.register_profile("hcsearch", deadline=None)
settings.load_profile("hcsearch")


def pytest_collection_modifyitems(items):
    """Begin with what takes longest, so that no core is left alone with it at the end."""
    items.sort(key=lambda item: item.get_closest_marker("long") is None)
