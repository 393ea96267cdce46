"""The full run of the builder of attacks: `python -m tests.certificates.attack_run COUNT FILE ...`.

The files hold certificates of paths. For each folding it builds false certificates, so many at random, and has them
verified under its name, and as certificates of a pattern where their array is another one. It prints how many were
built, of how many kinds, and which were accepted.
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

PATTERN, SECONDS = "a pattern", 2.0
"""A name of a pattern, and the time for a certificate (s): what is not decided then is not accepted."""


def faults(data: dict[str, Any], attack: Attack, seconds: float = SECONDS) -> tuple[list[str], int]:
    """What is wrong with the refusals of an attack, and how many were not decided in the time.

    Nothing is wrong where it is refused for the right kind of reason.
    """
    subjects = [(data["of"], data["panel_mm"])] + ([] if attack.named else [(PATTERN, None)])
    found, undecided = [], 0
    for of, panel_mm in subjects:
        said = refusal([attack.claim], of, panel_mm, seconds)
        reason = attack.reason if attack.named else "any"
        undecided += said is not None and said.startswith("not decided")
        if said is None:
            found.append(f"{attack.kind}: accepted of {of!r}")
        elif not said.startswith("not decided") and not re.search(REASONS[reason], said):
            found.append(f"{attack.kind}: refused, but not for its {reason}: {said}")
    return found, undecided


def faults_of_names(data: dict[str, Any], other: str, seed: int) -> tuple[int, list[str]]:
    """How many names were tried for the claim of a certificate, and which of them were accepted."""
    names = list(renamed(data, other, random.Random(seed)))
    accepted = [own for own in names if refusal(*own[1:], SECONDS) is None]
    return len(names), [f"{kind}: accepted of {of!r}, {panel!r}" for kind, _, of, panel in accepted]


def main(count: int, files: list[str]) -> int:
    """Attack the foldings of certificates; return the number of faults."""
    kinds, built, wrong, undecided, start = Counter[str](), 0, list[str](), 0, time.process_time()
    for number, file in enumerate(files):
        data = json.loads(Path(file).read_text(encoding="utf-8"))
        for attack in attacks_on(data, number, count):
            kinds[attack.kind] += 1
            built += 1 if attack.named else 2
            own, waited = faults(data, attack)
            wrong += [f"{data['of']}: {fault}" for fault in own]
            undecided += waited
        print(f"{number + 1} of {len(files)}: {data['of']}, {built} built, {len(wrong)} faults", flush=True)
    print(
        f"{len(files)} foldings, {built} false certificates of {len(kinds)} kinds, {time.process_time() - start:.0f} s"
    )
    print(f"accepted, or refused for another reason: {len(wrong)}; not decided in {SECONDS:g} s: {undecided}")
    print(*wrong, sep="\n")
    return len(wrong)


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]), sys.argv[2:]) > 0)
