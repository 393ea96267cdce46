"""What a report shows, as plain values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from hcsearch.scenes import DEFAULT_SCENE_NAME
from hcsearch.store.columns import DESIGNS, Quantity

Row = Mapping[str, object]
FoldingKey = tuple[int, int]
"""Id of a design and crease of its folding."""


@dataclass(frozen=True)
class FunnelStage:
    """One number of the funnel.

    count : None where the stage has not run.
    of : the number that this one is a share of; None for a number that stands alone (it has another unit).
    """

    label: str
    count: int | None
    of: int | None = None


@dataclass(frozen=True)
class ReportData:
    """Everything on the page, in the order it is read.

    meta : what was searched, with what and when, as (name, value).
    funnel : counts over all the selected designs, also those beyond the limit.
    census : (foldings, smallest twist, designs) over all the selected designs; None where not known.
    designs, foldings : rows as the SQL views of those names give them, foldings by the id of their design.
    best : crease of the folding that gave a design its status, by the id; without one `drawn_crease` chooses.
    motions : the sentence behind each motion that was planned. tried : rows of `deployments`, best first.
    players : what the 3D player takes of each folding with a path, or the address where a server has it.
    total : number of selected designs; `designs` holds the first of them.
    notes : sentences on what the numbers leave out.
    size : length and width of a panel on the square grids, None for the usual ones.
    columns : the quantities of a design, with their meaning.
    where : the option of commands that names the database, empty for the usual one.
    pages : address of the page of a design, with `{id}` in it; empty where there is none.
    """

    title: str
    meta: Sequence[tuple[str, str]] = ()
    funnel: Sequence[FunnelStage] = ()
    census: Sequence[tuple[int | None, int | None, int]] = ()
    designs: Sequence[Row] = ()
    foldings: Mapping[int, Sequence[Row]] = field(default_factory=dict)
    best: Mapping[int, int] = field(default_factory=dict)
    motions: Mapping[FoldingKey, str] = field(default_factory=dict)
    tried: Mapping[FoldingKey, Sequence[Row]] = field(default_factory=dict)
    players: Mapping[FoldingKey, Mapping[str, Any] | str] = field(default_factory=dict)
    total: int = 0
    notes: Sequence[str] = ()
    size: tuple[float, float] | None = None
    columns: Sequence[Quantity] = DESIGNS
    scene: str = DEFAULT_SCENE_NAME
    where: str = ""
    pages: str = ""
