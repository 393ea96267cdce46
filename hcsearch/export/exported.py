"""What is exported: a design or an assembly with its linkage, its names, and its motion where one is wanted."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from hcsearch.circuit import Circuit
from hcsearch.export.settings import State
from hcsearch.folding import Folding
from hcsearch.labels import Labels, labels_of
from hcsearch.linkage import Linkage
from hcsearch.replays.replay import Replay
from hcsearch.subjects.reading import Subject
from hcsearch.typing import Reals


@dataclass(frozen=True)
class Exported:
    """What a writer is given.

    name : notation of the design or folding, or name of the assembly. circuit, folding : None of an assembly; folding
        is None of a design without a crease, too, which only formats of the array are given.
    replay : its motion; None unless the format or the user wants one. sentence : what users should know of it.
    """

    name: str
    circuit: Circuit | None
    folding: Folding | None
    _subject: Subject | None
    replay: Replay | None
    sentence: str = ""

    @property
    def subject(self) -> Subject:
        """The linkage and its scene, as `hcsearch deploy` takes them."""
        assert self._subject is not None
        return self._subject

    @cached_property
    def linkage(self) -> Linkage:
        """The linkage of the motion, as a path may join flat pairs otherwise; the subject's where there is none."""
        return self.subject.linkage if self.replay is None else self.replay.linkage

    @cached_property
    def labels(self) -> Labels:
        """Names of the panels and hinges of `linkage`."""
        return labels_of(self.linkage, design=self.folding is not None)

    @property
    def motion(self) -> Replay:
        """The motion, of formats that need one."""
        assert self.replay is not None
        return self.replay

    def angles(self, state: State) -> Reals:
        """Fold angles of `linkage` in a state, (n_hinges,), rad; a share needs the motion."""
        if state == "flat":
            return self.linkage.flat
        if state == "folded":
            return self.linkage.folded
        first, last = self.motion.at[[0, -1]]
        angles: Reals = self.motion.at_time(first + float(state) * (last - first)[None])[0]
        return angles
