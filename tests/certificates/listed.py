"""Certificates of all foldings of a list: `python -m tests.certificates.listed FOLDER GRID:N ...`, resumed if stopped.

Foldings without twist are proved, each with the search's default budget; congruent ones share a search, and each has
its own certificate. What is neither proved to move nor to be locked leaves a file with the reason.
"""

import json
import sys
from collections.abc import Iterator
from pathlib import Path

from hcsearch import enumerate_circuits
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import WAYS
from hcsearch.designs.folding import Folding, foldings
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.designs.twisting import twist
from hcsearch.motion.certificates.certifying import prove_folding
from hcsearch.motion.planning.schedule import DEFAULT_EFFORT_BUDGET


def foldings_without_twist(grid: str, n: int) -> Iterator[Folding]:
    """The foldings of all circuits of n cells that no twist locks."""
    for circuit in enumerate_circuits(grid, n=n):
        yield from (folding for folding in foldings(circuit) if not twist(folding))


def write_certificates(folder: Path, grid: str, n: int) -> None:
    """Write a certificate of each folding, or the reason why it has none."""
    for folding in foldings_without_twist(grid, n):
        file = folder / f"{folding.notation.replace(':', '_')}.json"
        if file.exists() or file.with_suffix(".none").exists():
            continue
        try:
            data, _ = prove_folding(folding, default_panel(grid), WAYS, None, budget=DEFAULT_EFFORT_BUDGET)
            file.write_text(json.dumps(data), encoding="utf-8")
            kinds = {claim["kind"] for claim in data["claims"]}
            print(folding.notation, *sorted(kinds), flush=True)
        except HcsearchError as refused:
            file.with_suffix(".none").write_text(f"{refused}\n", encoding="utf-8")
            print(folding.notation, "none", flush=True)


if __name__ == "__main__":
    for grid, _, n in (name.partition(":") for name in sys.argv[2:]):
        write_certificates(Path(sys.argv[1]), grid, int(n))
