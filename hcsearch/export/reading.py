"""What a name stands for, as a format takes it."""

from __future__ import annotations

from typing import get_args

from hcsearch.errors import HcsearchError
from hcsearch.export.exported import Exported
from hcsearch.export.formats import Format
from hcsearch.export.settings import State
from hcsearch.folding import Folding, split_crease
from hcsearch.replays.sources import By, find_replay
from hcsearch.subjects.designs import design_named
from hcsearch.subjects.reading import read_subject
from hcsearch.subjects.requests import Request, known_of, settled


def exported_named(request: Request, wanted: Format, by: By | None = None, state: State = "flat") -> Exported:
    """What a name stands for, as a format takes it.

    by : where the motion comes from (`replay_named`). state : a share of the motion needs a motion that ends flat.
    A design stands for its best folding in the database, in the scene that is asked for, and flat pairs are joined in
    the way that gave it its status there (`requests`).
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
    request = settled(request)
    known = known_of(request)
    subject = read_subject(request)
    folding = known.folding
    if folding is None and "design" in subject.facts:
        folding = Folding.from_notation(subject.facts["design"])
    replay, said = None, known.sentence
    if wanted.of == "motion" or by is not None or share:
        replay, said = find_replay(request, by)
    name = subject.title
    if share and replay is not None and not replay.ends_flat:
        raise HcsearchError(f"the motion of {name} does not end flat ({replay.source}): write --state flat or folded")
    faults = "" if replay is None else replay.faults
    sentence = "; ".join(filter(None, (said, faults and f"the motion: {faults}")))
    return Exported(name, None if folding is None else folding.circuit, folding, subject, replay, sentence)
