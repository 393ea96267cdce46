"""Deploy a folding, an assembly or the subject of a file."""

from __future__ import annotations

from typing import Any

from hcsearch.api.kinds import check_kinds
from hcsearch.basics.vocabulary import Formulation, Way
from hcsearch.scenes import Scene
from hcsearch.springs.deployment.deployment_facts import Deployed
from hcsearch.subjects.case import Case, CaseSubject
from hcsearch.subjects.names import Place
from hcsearch.subjects.resolve import resolve
from hcsearch.system.terminal import write_notice


def deploy(
    what: CaseSubject | Case,
    scene: Scene | str | None = None,
    *,
    formulation: Formulation | None = None,
    method: str | None = None,
    tolerance: float = 1e-6,
    panel: str | None = None,
    flat_pairs: Way | None = None,
    db: Place | None = None,
    **values: Any,
) -> Deployed:
    """Simulate how springs open a folding or assembly, and check it for collisions, as `hcsearch deploy` does.

    Parameters
    ----------
    what
        A Folding, a Circuit with a single folding, or a Linkage; or a text: a notation such as `hex:0234550132:4`,
        `17:4` for a folding of design 17 in the database, an assembly such as `unit-ii`, or a file `NAME.toml`; or a
        Case.
    scene
        A Scene, the name of one, or a file `NAME.toml`; by default the scene `default`.
    formulation
        `constrained`, `compliant`, `penalty` or `quasistatic`.
    method
        The integrator, one of those of `hcsearch deploy --method`.
    tolerance
        The error of a step, relative and absolute.
    panel
        The size of panels in millimetres, such as `50x40x6`, or `across 1000x20` for the width across flats.
    flat_pairs
        `rigid`, `hinged`, or `merged`, where the two panels of each mirror pair are one.
    db
        The database in which ids and scenes are looked up.
    **values
        Other values of the scene by the names of a scene file, such as `gravity="0,0,-9.81"`, `held=3`, `springs={7:
        "linear:0.2"}` and `hinges={7: {"damping": 0.01}}`. Panels and hinges have the numbers shown in pictures.

    Returns
    -------
    Deployed
        The verdict, the reason for it, and the simulated motion.

    Examples
    --------
    >>> from hcsearch import Folding, deploy
    >>> folding = Folding.from_notation("hex:0234550132:4")
    >>> deploy(folding)
    <hex:0234550132:4: deploys, flat after 0.1410 s>
    >>> deploy(folding, springs={7: "linear:0.2"}).verdict
    'undecided'
    """
    check_kinds(deploy, locals())
    case = resolve(what, db, scene=scene, panel=panel, flat_pairs=flat_pairs, values=values)
    write_notice(case.sentence)
    return case.deployed(formulation, method=method, tolerance=tolerance)
