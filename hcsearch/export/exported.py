"""What is exported: a design, or a case with its motion."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from hcsearch.basics.array_values import Reals
from hcsearch.designs.circuit import Circuit
from hcsearch.export.settings import ExportState
from hcsearch.shape.labels import Labels, labels_of
from hcsearch.shape.linkage import Linkage
from hcsearch.subjects.case import Case
from hcsearch.subjects.replay import Replay


@dataclass(frozen=True)
class Exported:
    """What a writer is given.

    name : notation of the design or folding, or name of the assembly. replay : its motion;
    None unless the format or the user wants one. sentence : what users should know of it.
    """

    name: str
    _case: Case | None = None
    replay: Replay | None = None
    sentence: str = ""

    @property
    def case(self) -> Case:
        """The case; a motion may be written without one."""
        assert self._case is not None
        return self._case

    @property
    def circuit(self) -> Circuit | None:
        """The circuit; None of an assembly."""
        return None if self._case is None else self._case.circuit

    @cached_property
    def linkage(self) -> Linkage:
        """The linkage of the motion, as a path may join flat pairs otherwise; the case's where there is none."""
        return self.case.linkage if self.replay is None else self.replay.linkage

    @cached_property
    def labels(self) -> Labels:
        """Names of the panels and hinges of `linkage`."""
        return labels_of(self.linkage) if self.replay is None else self.replay.labels

    @property
    def motion(self) -> Replay:
        """The motion, of formats that need one."""
        assert self.replay is not None
        return self.replay

    def angles(self, state: ExportState) -> Reals:
        """Return the fold angles of `linkage` in a state, (n_hinges,), rad; a share needs the motion."""
        if state == "flat":
            return self.linkage.flat
        if state == "folded":
            return self.linkage.folded
        first, last = self.motion.at[[0, -1]]
        angles: Reals = self.motion.at_time(first + float(state) * (last - first)[None])[0]
        return angles
