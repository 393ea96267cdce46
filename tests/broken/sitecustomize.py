"""Breaks a part of the program in each process that has this folder on its path: loaded by Python as it starts.

BROKEN names a module that cannot be loaded, or MODULE:FUNCTION, which fails. BROKEN_IN=workers breaks it in worker
processes alone; with BROKEN_BY=interrupt a function fails as one in which Ctrl-C came.
"""

import importlib.util
import os
import sys
from importlib.abc import MetaPathFinder

MODULE, _, FUNCTION = os.environ.get("BROKEN", "").partition(":")


def fail(*_, **__):
    raise RuntimeError("broken on purpose") from CAUSE


class Breaker(MetaPathFinder):
    def find_spec(self, name, path, target=None):
        if name != MODULE:
            return None
        if not FUNCTION:
            raise ImportError("broken on purpose", name=name)
        sys.meta_path.remove(self)
        spec = importlib.util.find_spec(name)
        load = spec.loader.exec_module

        def load_broken(module):
            load(module)
            setattr(module, FUNCTION, fail)

        spec.loader.exec_module = load_broken
        return spec


CAUSE = KeyboardInterrupt() if os.environ.get("BROKEN_BY") == "interrupt" else None
in_worker = "--multiprocessing-fork" in sys.orig_argv
if MODULE and (in_worker or os.environ.get("BROKEN_IN") != "workers"):
    sys.meta_path.insert(0, Breaker())
