"""What the page of one design shows, as plain values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from hcsearch.cases.mechanisms import Freedoms
from hcsearch.designs.folding import Folding
from hcsearch.web.player import Payload
from hcsearch.web.report.data import Row
from hcsearch.web.report.envelopes import Room
from hcsearch.web.report.motion_plots import Plot


@dataclass(frozen=True)
class ShownMotion:
    """A motion that the page plays and plots; `command` reproduces it.

    shows : the status that it gives its folding: `movable`, `deploys`, or empty for none.
    """

    title: str
    source: str
    command: str
    payload: Payload
    plots: Sequence[Plot]
    shows: str = ""


@dataclass(frozen=True)
class ShownFolding:
    """A folding with everything known of it.

    row : of the view `foldings`, empty where no database holds it. status : a word, or `twisted`.
    why : the sentence behind it. tried : rows of `deployments`. locks : sentences on each end, more exact ones after.
    """

    folding: Folding
    row: Row
    twist: int
    status: str
    why: str
    room: Room
    tried: Sequence[Row] = ()
    freedoms: Sequence[Freedoms] = ()
    locks: Sequence[Sequence[str]] = ()
    motions: Sequence[ShownMotion] = ()


@dataclass(frozen=True)
class DesignData:
    """Everything on the page; row : of the view `designs`, empty where no database holds it. meta : what it depends on.

    links : (words, address) of what is around the page. exports : of files of a folding, by its crease, where a server
    has them.
    """

    title: str
    notation: str
    array: str
    row: Row
    meta: Sequence[tuple[str, str]]
    foldings: Sequence[ShownFolding]
    best: int | None
    size: tuple[float, float] | None = None
    links: Sequence[tuple[str, str]] = ()
    exports: Mapping[int, Sequence[tuple[str, str]]] = field(default_factory=dict)
