"""What a name stands for, as a format takes it."""

from __future__ import annotations

from dataclasses import replace
from typing import get_args

from hcsearch.errors import HcsearchError
from hcsearch.export.exported import Exported
from hcsearch.export.formats import Format
from hcsearch.export.settings import State
from hcsearch.folding import Folding, split_crease
from hcsearch.replays.sources import By, replay_named
from hcsearch.scenes import DEFAULT, Scene
from hcsearch.store import best_creases, find_design, open_readonly
from hcsearch.subjects.designs import design_named, is_id
from hcsearch.subjects.reading import Request, read_subject
from hcsearch.subjects.scenes import scene_asked_for


def exported_named(request: Request, wanted: Format, by: By | None = None, state: State = "flat") -> Exported:
    """What a name stands for, as a format takes it.

    by : where the motion comes from (`replay_named`). state : a share of the motion needs a motion that ends flat.
    A design named by its id in a database stands for its best folding there, in the scene that is asked for.
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
        crease = _best_crease(request)
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


def _best_crease(request: Request) -> int | None:
    """The crease of the best folding of a design named by its id; None where no stage has compared them."""
    with open_readonly(request.db) as database:
        number = int(find_design(database, request.name)["id"])
        scene = DEFAULT
        if not isinstance(request.scene, Scene):
            scene = scene_asked_for(database, request.scene, request.panel, request.across)
        return best_creases(database, [number], scene).get(number)
