"""The page of a pattern of a file that is no design: its motions, its mobility and its locks."""

from __future__ import annotations

from pathlib import Path

from hcsearch.basics.errors import SceneError
from hcsearch.motion.planning.motion_search import PlannedMotion, plan_linkage_motion, reason_of
from hcsearch.search.own_patterns.checked_patterns import pattern_mobility
from hcsearch.shape.pattern_drawing import draw_pattern
from hcsearch.springs.deployment.deployment_facts import Deployed, deploy_linkage
from hcsearch.subjects.case import Case
from hcsearch.subjects.pattern_files import DrawnPattern
from hcsearch.subjects.replay_sources import replay_of_path
from hcsearch.system.outputs import write_output
from hcsearch.web.report.design_data import ShownMotion
from hcsearch.web.report.linkage_page import (
    LinkageData,
    lead_sentence,
    motion_by_springs,
    page_meta,
    render_linkage,
    shown_motion,
)


def fetch_pattern_data(case: Case, subject: str) -> LinkageData:
    """Return the data of a pattern with a packed state.

    case : the pattern in a scene. subject : how commands name this case, with its options.
    """
    assert isinstance(case.what, DrawnPattern)
    name = case.title
    checked = pattern_mobility(name, case.what.packed, case.scene)
    is_planned = not checked.locks and _moves_along_paths(case)
    motion = None if not is_planned else plan_linkage_motion(case.linkage, case.scene.margin)
    deployed = deploy_linkage(name, case.linkage, case.setup, case.formulation or "constrained", drives=case.drives)
    planned = [] if motion is None else [("planned path", reason_of(motion, joined=False))]
    return LinkageData(
        title=name,
        sentence=lead_sentence(checked.facts(), deployed),
        meta=page_meta(case),
        picture=draw_pattern(case.linkage.pattern, name, standalone=False),
        motions=_motions(name, case, deployed, motion, subject),
        facts=[*checked.rows(), *planned],
        commands=[
            *([(f"hcsearch check {subject}", "takes it through all stages")] if _moves_along_paths(case) else []),
            (f"hcsearch motion {subject}", "follows its motion: branches and singular states"),
            (f"hcsearch export {subject} --output pattern.glb", "writes it for other programs"),
        ],
    )


def _moves_along_paths(case: Case) -> bool:
    """Whether paths are planned for a case: it has no drive and no formulation that excludes them."""
    try:
        case.check_moved()
    except SceneError:
        return False
    return True


def _motions(
    name: str, case: Case, deployed: Deployed, motion: PlannedMotion | None, subject: str
) -> list[ShownMotion]:
    """Return the motion by springs, and the planned path if there is one."""
    motions = [motion_by_springs(name, deployed, f"hcsearch deploy {subject}")]
    if motion is None or motion.states is None:
        return motions
    replay = replay_of_path(case.linkage, motion.states, name, margin=motion.margin, design=False)
    return [*motions, shown_motion("Planned path", replay, f"hcsearch drive {subject}")]


def write_pattern(case: Case, path: Path | str, subject: str) -> Path:
    """Write the page of a pattern in the scene of a case, and return its path.

    subject : as in `fetch_pattern_data`. OutputError: the file cannot be written.
    """
    write_output(path, render_linkage(fetch_pattern_data(case, subject)))
    return Path(path)
