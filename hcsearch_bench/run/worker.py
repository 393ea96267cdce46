"""The inside of a job's process: `python -m ... MODULE FUNCTION ARGUMENTS` prints a row as JSON."""

from __future__ import annotations

import json
import sys
from importlib import import_module

if __name__ == "__main__":
    job = getattr(import_module(sys.argv[1]), sys.argv[2])
    print(json.dumps(job(**json.loads(sys.argv[3]))))
