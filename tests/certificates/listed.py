"""Certificates of all foldings of lists: `python -m tests.certificates.listed BUDGET FOLDER GRID:N ...`.

Foldings without twist are proved, each by so many efforts. What is neither proved to move nor to be locked leaves a
file with the reason; what has a file is not searched again.
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


def foldings_without_twist(grid: str, n: int) -> Iterator[Folding]:
    """The foldings of all circuits of n cells that no twist locks."""
    for circuit in enumerate_circuits(grid, n=n):
        yield from (folding for folding in foldings(circuit) if not twist(folding))


def write_certificates(budget: int, folder: Path, grid: str, n: int) -> None:
    """Write a certificate of each folding, or the reason why it has none."""
    for folding in foldings_without_twist(grid, n):
        file = folder / f"{folding.notation.replace(':', '_')}.json"
        if file.exists() or file.with_suffix(".none").exists():
            continue
        try:
            data, _ = prove_folding(folding, default_panel(grid), WAYS, None, budget=budget)
            file.write_text(json.dumps(data), encoding="utf-8")
            kinds = {claim["kind"] for claim in data["claims"]}
            print(folding.notation, *sorted(kinds), flush=True)
        except HcsearchError as refused:
            file.with_suffix(".none").write_text(f"{refused}\n", encoding="utf-8")
            print(folding.notation, "none", flush=True)


if __name__ == "__main__":
    for grid, _, n in (name.partition(":") for name in sys.argv[3:]):
        write_certificates(int(sys.argv[1]), Path(sys.argv[2]), grid, int(n))
