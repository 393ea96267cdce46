"""The full run of the builder of attacks: `python -m tests.certificates.attack_run FILE ...`, certificates of paths.

For each folding it builds all false certificates, and has them verified under its name, and as certificates of a
pattern where their array is another one. It prints how many were built, of how many kinds, and which were accepted.
"""

import json
import random
import re
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any

from tests.certificates.attacks import REASONS, Attack, attacks_on, refusal, renamed

PATTERN = "a pattern"


def faults(data: dict[str, Any], attack: Attack) -> list[str]:
    """What is wrong with the refusals of an attack: nothing where it is refused, and for the right kind of reason."""
    subjects = [(data["of"], data["panel_mm"])] + ([] if attack.named else [(PATTERN, None)])
    found = []
    for of, panel_mm in subjects:
        said = refusal([attack.claim], of, panel_mm)
        reason = attack.reason if attack.named else "any" if panel_mm is None else "name"
        if said is None:
            found.append(f"{attack.kind}: accepted of {of!r}")
        elif reason != "any" and not re.search(REASONS[reason], said):
            found.append(f"{attack.kind}: refused, but not for its {reason}: {said}")
    return found


def faults_of_names(data: dict[str, Any], other: str, seed: int) -> tuple[int, list[str]]:
    """How many names were tried for the claim of a certificate, and which of them were accepted."""
    names = list(renamed(data, other, random.Random(seed)))
    found = [f"{kind}: accepted of {of!r}, {panel!r}" for kind, claims, of, panel in names if not refusal(claims, of, panel)]
    return len(names), found


def main(files: list[str]) -> int:
    """Attack the foldings of certificates; return the number of faults."""
    kinds, built, wrong, refused_honest, start = Counter[str](), 0, list[str](), 0, time.process_time()
    for number, file in enumerate(files):
        data = json.loads(Path(file).read_text(encoding="utf-8"))
        refused_honest += refusal(data["claims"], data["of"], data["panel_mm"]) is not None
        for attack in attacks_on(data, number):
            kinds[attack.kind] += 1
            built += 1 if attack.named else 2
            wrong += [f"{data['of']}: {fault}" for fault in faults(data, attack)]
        count, own = faults_of_names(data, "hex:0234550132:4" if number % 2 else "square:01222300:0", number)
        built, wrong = built + count, wrong + own
        kinds["name"] += count
        print(f"{number + 1} of {len(files)}: {data['of']}, {built} built, {len(wrong)} faults", flush=True)
    print(f"{len(files)} foldings, {built} false certificates of {len(kinds)} kinds, {time.process_time() - start:.0f} s")
    print(f"accepted or refused for another reason: {len(wrong)}; honest ones refused: {refused_honest}")
    print(*wrong, sep="\n")
    return len(wrong) + refused_honest


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]) > 0)
