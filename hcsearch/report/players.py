"""The motions that a page plays: stored paths of its foldings, as the player takes them."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

from hcsearch.circuit import Circuit
from hcsearch.errors import NotationError
from hcsearch.player import Payload, payload_of
from hcsearch.replays.sources import stored_replays
from hcsearch.report.data import FoldingKey, Row
from hcsearch.store import Database

PLAYED = 2000
"""Designs of a page whose motions it holds, the first of them: each takes some 5 kB a folding."""


def players_of(database: Database, designs: Sequence[Row], scene: str) -> dict[FoldingKey, Payload]:
    """What the player takes of the foldings whose path a database holds in a scene, proved or not."""
    circuits: dict[int, Circuit] = {}
    for design in designs:
        if len(circuits) == PLAYED:
            break
        if design.get("untwisted"):
            with suppress(NotationError):  # what cannot be read has no picture either
                circuits[int(str(design["id"]))] = Circuit.from_notation(str(design["circuit"]))
    if not circuits:
        return {}
    return {
        (path.design_id, path.crease): payload_of(replay) for path, replay in stored_replays(database, circuits, scene)
    }
