"""What a name stands for, as a format takes it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, get_args

from hcsearch.errors import HcsearchError
from hcsearch.export.exported import Exported
from hcsearch.export.formats import Format
from hcsearch.export.settings import State
from hcsearch.folding import Folding, split_crease
from hcsearch.replays.sources import By, replay_named
from hcsearch.subjects.designs import design_named, is_id
from hcsearch.subjects.reading import Request, read_subject
from hcsearch.vocabulary import STATUSES


def exported_named(request: Request, wanted: Format, by: By | None = None, state: State = "flat") -> Exported:
    """What a name stands for, as a format takes it.

    by : where the motion comes from (`replay_named`). state : a share of the motion needs a motion that ends flat.
    A design named by its id in a database stands for its folding of the best status there, in the scene `default`.
    Errors: HcsearchError where there is no such motion, and where one is asked for that the format has no place for.
    """
    if by is not None and by not in get_args(By):
        raise HcsearchError(f"there is no motion {by!r}: choose {' or '.join(get_args(By))}")
    design = ":" in request.name or request.name[:1].isdigit()
    if wanted.of == "array" and by is None and design and not request.name.endswith(".toml"):
        name, crease = split_crease(request.name)
        if crease is None:
            circuit, _ = design_named(name, request.db)
            return Exported(circuit.notation, circuit, None, None, None)
    share = isinstance(state, float) and "state" in wanted.takes
    if by is not None and not (wanted.of == "motion" or wanted.frames or share):
        remedy = ", or give --state SHARE" if "state" in wanted.takes else ""
        raise HcsearchError(f"{wanted.name} holds no motion: leave out --motion{remedy}")
    if is_id(request.name):
        _, row = design_named(request.name, request.db)
        crease = best_crease(row["foldings"])
        request = request if crease is None else replace(request, name=f"{request.name}:{crease}")
    subject = read_subject(request)
    folding = request.folding
    if folding is None and "design" in subject.facts:
        folding = Folding.from_notation(subject.facts["design"])
    replay = replay_named(request, by) if wanted.of == "motion" or by is not None or share else None
    name = subject.title
    if share and replay is not None and not replay.ends_flat:
        raise HcsearchError(f"the motion of {name} does not end flat ({replay.source}): write --state flat or folded")
    return Exported(name, None if folding is None else folding.circuit, folding, subject, replay)


def best_crease(foldings: Sequence[Mapping[str, Any]]) -> int | None:
    """The crease of the best of some rows of the view `foldings`, by status, margin, dof, crease; None without one."""
    known = [row for row in foldings if row["status"] in STATUSES]

    def place(row: Mapping[str, Any]) -> tuple[float, ...]:
        values = (STATUSES.index(row["status"]), row["needed_margin"], row["dof"], row["crease"])
        return tuple(math.inf if value is None else value for value in values)

    return min(known, key=place)["crease"] if known else None
