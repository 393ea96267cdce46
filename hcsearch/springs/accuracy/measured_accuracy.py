"""The accuracy of the deployment of one subject, measured: the result of `hcsearch accuracy`."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from hcsearch.springs.accuracy.error_bars import DefaultErrors
from hcsearch.springs.accuracy.work_report import draw_work, work_facts, work_row_facts, work_table
from hcsearch.springs.accuracy.work_rows import FormulationWork, WorkRow
from hcsearch.springs.deployment.error_words import error_facts
from hcsearch.springs.deployment.omission_savings import OmissionSaving, saving_facts

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
    errors
        The deployment by the default setting of the first formulation, with estimates of its errors.
    omitted
        What the omissions of that scene save and change, each put back in turn, and all of them last.
    wanted
        The greatest error of the fold angles for which the cheapest setting is wanted, rad; None without one.
    """

    name: str
    scene: str
    works: tuple[FormulationWork, ...]
    errors: DefaultErrors
    omitted: tuple[OmissionSaving, ...] = ()
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
            "errors": self._error_facts(),
            "left_out": [asdict(saving.omission) | saving_facts(saving) for saving in self.omitted],
            "wanted_error_rad": self.wanted,
            "cheapest": None if cheapest is None else work_row_facts(cheapest) | {"options": cheapest.options},
            "formulations": [work_facts(work) for work in self.works],
        }

    def _error_facts(self) -> dict[str, Any] | None:
        """The estimates of errors as plain data, with what the reference says; None without estimates."""
        errors = self.errors
        if errors.estimates is None:
            return None
        row = next((row for work in self.works[:1] for row in work.rows if row.default), None)
        measured = {name: None if row is None else getattr(row, name) for name in ("angle_error", "time_error")}
        return error_facts(errors.estimates) | {
            "perturbed_until_s": errors.perturbed_until,
            "measured_angles_rad": measured["angle_error"],
            "measured_flat_time_s": measured["time_error"],
        }

    def table(self) -> pd.DataFrame:
        """A pandas table of all simulations, as `hcsearch accuracy --output` writes it."""
        return work_table(self.works)

    def picture(self, path: str) -> None:
        """Draw error against processor time into a file .svg, .png or .pdf."""
        draw_work(self.works, path, f"{self.name}, scene {self.scene}: error against processor time")

    def __repr__(self) -> str:
        return f"<accuracy of {self.name}, scene {self.scene}>"
