"""A deployment with what simulations at tighter tolerances agree on: what `hcsearch deploy` reports."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from hcsearch.basics.vocabulary import Formulation, Verdict
from hcsearch.scenes import Scene
from hcsearch.scenes.setup import Setup
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.agreement import Agreement, confirm_deployment
from hcsearch.springs.deployment.deployment_facts import deployment_facts, deployment_table
from hcsearch.springs.deployment.drives import Drives
from hcsearch.springs.deployment.simulated_deployment import Deployment, simulate_deployment
from hcsearch.system.notebooks import notebook_view

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, repr=False)
class Deployed:
    """The result of `deploy`: the verdict, the reason for it, and the simulated motion.

    name : the name of the folding or assembly. deployment : the simulation, with its states.
    agreement : how simulations at tighter tolerances agree; None if the array does not become flat or is driven.
    """

    name: str
    deployment: Deployment
    agreement: Agreement | None

    @property
    def verdict(self) -> Verdict:
        """`deploys` (flat and certified free of collisions at all tolerances), `collides` or `undecided`."""
        return self.deployment.verdict if self.agreement is None else self.agreement.verdict

    @property
    def flat_time(self) -> float | None:
        """The time at which the array is flat, s, in the digits that all tolerances agree on; None if it never is."""
        return self.deployment.flat_time if self.agreement is None else self.agreement.flat_time

    @property
    def needed_margin(self) -> float | None:
        """The least margin on every face, m, at which it is certified clear at all tolerances; None unless it deploys.

        Two such margins are to be left between faces.
        """
        if self.verdict != "deploys" or self.deployment.play is None:
            return None
        return self.deployment.play.needed_margin if self.agreement is None else self.agreement.needed_margin

    @property
    def least_gap(self) -> float | None:
        """The least gap of the panels as built, m, below 0 where they overlap; None unless it deploys."""
        return None if self.needed_margin is None or self.deployment.play is None else self.deployment.play.least_gap

    @property
    def reason(self) -> str:
        """The reason for the verdict, in words that name panels and hinges."""
        return str(self.facts()["reason"])

    def facts(self) -> dict[str, Any]:
        """All results as plain data, as `hcsearch deploy --json` prints them; keys name their units."""
        return deployment_facts(self.deployment, self.agreement)

    def table(self) -> pd.DataFrame:
        """A pandas table of times, energies, fold angles and rates, as `hcsearch deploy --output` writes it."""
        return deployment_table(self.deployment)

    def picture(self, path: str) -> None:
        """Draw fold angles and energies over time into a file .svg, .png or .pdf."""
        from hcsearch.springs.deployment.deployment_pictures import draw_deployment  # noqa: PLC0415 - only where a picture is wanted

        draw_deployment(self.deployment, path, f"{self.name}: {self.verdict}, {self.reason}")

    def _repr_html_(self) -> str | None:
        return notebook_view(self)

    def __repr__(self) -> str:
        return f"<{self.name}: {self.verdict}, {self.reason}>"


def deploy_linkage(
    name: str,
    linkage: Linkage,
    scene: Scene | Setup,
    formulation: Formulation = "constrained",
    *,
    method: str | None = None,
    tolerance: float = 1e-6,
    drives: Drives | None = None,
) -> Deployed:
    """Deploy a linkage in a scene; what becomes flat by springs is simulated at tighter tolerances, too."""
    deployment = simulate_deployment(linkage, scene, formulation, method=method, tolerance=tolerance, drives=drives)
    agreement = None if drives is not None else confirm_deployment(deployment, method=method, tolerance=tolerance)
    return Deployed(name, deployment, agreement)
