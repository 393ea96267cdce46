"""The second checker: `python -m tests.certificates.exact_checker FILE ...` decides the claims of certificates.

It is written from docs/explanation/certificates.md in whole numbers, and is slow.
"""

import json
import sys
import time
from pathlib import Path
from typing import Any

from tests.certificates.exact_arrays import Array, RefusedError, need
from tests.certificates.exact_locks import check_collisions, check_lock
from tests.certificates.exact_paths import check_path


def checked(claim: Any, limit: int | None = None) -> str:
    """Return what is proved; RefusedError for a claim that is not proved, or not of the documented form.

    limit : number of boxes that are tried in a lock, in place of some times the number that the claim states.
    """
    try:
        need(isinstance(claim, dict), "a claim is none")
        array, kind = Array(claim["array"]), claim["kind"]
        if kind == "path":
            return f"a path in {check_path(claim, array)} pieces"
        need(kind in ("lock", "collision"), "there is no such kind of claim")
        faces, tried = (check_lock if kind == "lock" else check_collisions)(claim, array, limit=limit)
    except (LookupError, TypeError, ValueError, AttributeError, ArithmeticError) as error:
        raise RefusedError(f"the claim is not of the documented form ({type(error).__name__}: {error})") from error
    return f"a {kind} of {faces} faces, by {tried} boxes"


def main(files: list[str]) -> int:
    """Print what is proved of each claim; return the number of claims that are not."""
    refused = 0
    for file in files:
        for claim in json.loads(Path(file).read_text(encoding="utf-8"))["claims"]:
            start = time.process_time()
            try:
                said = f"proved: {checked(claim)}"
            except RefusedError as error:
                said, refused = f"not proved: {error}", refused + 1
            print(f"{Path(file).stem}: {said}, {time.process_time() - start:.1f} s", flush=True)
    return refused


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]) > 0)
