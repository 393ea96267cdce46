"""Deploy a folding, an assembly or what a file describes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hcsearch.api.asking import Named, Setting
from hcsearch.api.places import located
from hcsearch.deployment.deployed import Deployed, deployed
from hcsearch.scenes import FlatPairs, Scene
from hcsearch.subjects.reading import Subject
from hcsearch.vocabulary import Formulation


def deploy(
    what: Named,
    scene: Scene | str | None = None,
    *,
    formulation: Formulation | None = None,
    method: str | None = None,
    tolerance: float = 1e-6,
    panel: str | None = None,
    across: str | None = None,
    flat_pairs: FlatPairs | None = None,
    merge: bool = False,
    db: str | Path | None = None,
    **values: Any,
) -> Deployed:
    """Simulate a deployment by springs, certified clear of collisions, as `hcsearch deploy` does.

    what : DESIGN:CREASE, an assembly, a file, a Folding, a Circuit with one folding, or a Linkage. scene : a Scene, its
    name, or a file. panel, across : millimetres, `50x40x6`. db : where ids and scenes are looked up. values : more of
    the scene, such as `gravity="0,0,-9.81"`, `held=3` and `springs={7: "linear:0.2"}`, with numbers as on pictures.

    >>> from hcsearch import Folding, deploy
    >>> folding = Folding.from_notation("hex:0234550132:4")
    >>> deploy(folding)
    <hex:0234550132:4: deploys, flat after 0.1410 s>
    >>> deploy(folding, springs={7: "linear:0.2"}).verdict
    'undecided'
    """
    setting = Setting(scene, located(db), panel, across, flat_pairs, merge, values)
    return deploy_subject(setting.subject(what), formulation=formulation, method=method, tolerance=tolerance)


def deploy_subject(
    subject: Subject,
    *,
    name: str | None = None,
    formulation: Formulation | None = None,
    method: str | None = None,
    tolerance: float = 1e-6,
) -> Deployed:
    """Deploy what was read, in the formulation that is asked for, or that its file names; name : to be shown."""
    return deployed(
        name or subject.title,
        subject.linkage,
        subject.scene,
        formulation or subject.formulation or "constrained",
        method=method,
        tolerance=tolerance,
        drives=subject.drives,
    )
