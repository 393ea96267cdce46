"""The accuracy of the deployment of one subject, measured: the result of `hcsearch accuracy`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from hcsearch.springs.accuracy.work_report import draw_work, work_facts, work_row_facts, work_table
from hcsearch.springs.accuracy.work_rows import FormulationWork, WorkRow

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, repr=False)
class MeasuredAccuracy:
    """The accuracy of a deployment by each method and formulation, beside references.

    Parameters
    ----------
    name
        The name of the folding or assembly.
    scene
        The name of the scene.
    works
        The simulations of each formulation, with their errors and processor time.
    wanted
        The greatest error of the fold angles for which the cheapest setting is wanted, rad; None without one.
    """

    name: str
    scene: str
    works: tuple[FormulationWork, ...]
    wanted: float | None = None

    @property
    def cheapest(self) -> WorkRow | None:
        """The cheapest setting for the wanted error in the first formulation; None where no setting has it."""
        return None if self.wanted is None or not self.works else self.works[0].cheapest(self.wanted)

    def facts(self) -> dict[str, Any]:
        """All results as plain data, as `hcsearch accuracy --json` prints them; keys name their units."""
        cheapest = self.cheapest
        return {
            "subject": self.name,
            "scene": self.scene,
            "wanted_error_rad": self.wanted,
            "cheapest": None if cheapest is None else work_row_facts(cheapest) | {"options": cheapest.options},
            "formulations": [work_facts(work) for work in self.works],
        }

    def table(self) -> pd.DataFrame:
        """A pandas table of all simulations, as `hcsearch accuracy --output` writes it."""
        return work_table(self.works)

    def picture(self, path: str) -> None:
        """Draw error against processor time into a file .svg, .png or .pdf."""
        draw_work(self.works, path, f"{self.name}, scene {self.scene}: error against processor time")

    def __repr__(self) -> str:
        return f"<accuracy of {self.name}, scene {self.scene}>"
