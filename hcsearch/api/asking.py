"""What the functions of Python are asked for: subjects and their scenes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from hcsearch.circuit import Circuit
from hcsearch.deployment.naming import numbered
from hcsearch.deployment.scene_files import checked_scene, given_by_user, scene_with
from hcsearch.errors import HcsearchError
from hcsearch.folding import Folding, foldings
from hcsearch.linkage import Linkage
from hcsearch.scenes import SCENES, FlatPairs, Scene
from hcsearch.subjects.reading import Subject, read_subject
from hcsearch.subjects.requests import Request, announced, known_of, settled
from hcsearch.subjects.scenes import read_scene

Named = str | Folding | Circuit | Linkage
"""What can be deployed or tuned: DESIGN:CREASE, an assembly, a file .toml, or a value."""


@dataclass(frozen=True)
class Setting:
    """How something is to be tried, beside its name: as the options of `hcsearch deploy`.

    scene : a value, its name, or a file. panel, across : sizes as texts in millimetres. values : more of the scene.
    """

    scene: Scene | str | None
    db: str
    panel: str | None = None
    across: str | None = None
    flat_pairs: FlatPairs | None = None
    merge: bool = False
    values: Mapping[str, Any] | None = None

    def request(self, what: str | Folding | Circuit) -> Request:
        """The request for something that has a name, or is a design; a circuit stands for its only or best folding."""
        values = {} if self.values is None else dict(self.values)
        request = Request(str(what), self.db, self.scene, self.panel, self.across, self.flat_pairs, self.merge, values)
        if isinstance(what, Folding):
            return replace(request, folding=what)
        if isinstance(what, Circuit):
            return _numbered_as(what, replace(request, name=what.notation))
        return request

    def subject(self, what: Named) -> Subject:
        """What is meant, in its scene."""
        if not isinstance(what, Linkage):
            return read_subject(announced(self.request(what)))
        if self.panel is not None or self.across is not None or self.flat_pairs is not None or self.merge:
            raise HcsearchError("a Linkage has panels and flat pairs: leave out panel, across, flat_pairs and merge")
        given = SCENES["default"] if self.scene is None else self.scene
        scene = read_scene(given, self.db) if isinstance(given, str) else checked_scene(given)
        scene = scene_with(scene, given_by_user(self.values or {}))
        return Subject(what, replace(numbered(scene, what), panel=None), None, {"linkage": repr(what)})


def _numbered_as(circuit: Circuit, request: Request) -> Request:
    """The request for a circuit whose folding has the numbers of this circuit, which need not be canonical."""
    folds = foldings(circuit)
    if len(folds) == 1:
        return replace(request, folding=folds[0])
    request = settled(request)
    known = known_of(request)
    own = next((own for own in folds if known.folding is not None and own.notation == known.folding.notation), None)
    return replace(request, known=replace(known, folding=own))
