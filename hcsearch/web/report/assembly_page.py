"""The page of an assembly of the thesis: its motion, and its figures beside those of the thesis."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hcsearch.basics.errors import HcsearchError
from hcsearch.library.assemblies import ASSEMBLIES
from hcsearch.library.assemblies.description import describe_assembly
from hcsearch.library.assemblies.fact_texts import fact_rows, published_rows
from hcsearch.motion.paths.branches import follow_branch
from hcsearch.motion.paths.linkage_motion import LinkageMotion, row_step
from hcsearch.motion.paths.start_states import resolve_start
from hcsearch.shape.pattern_drawing import draw_pattern
from hcsearch.springs.deployment.deployment_facts import Deployed, deploy_linkage
from hcsearch.subjects.case import Case, NamedAssembly
from hcsearch.subjects.names import parameters_of
from hcsearch.subjects.replay_sources import replay_of_motion
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


def fetch_assembly_data(case: Case, subject: str) -> LinkageData:
    """Return the data of an assembly in a scene; subject : how commands name this case, with its options."""
    assert isinstance(case.what, NamedAssembly)
    name, given = case.what.name, case.what.parameters
    assembly = ASSEMBLIES[name]
    facts = describe_assembly(assembly, parameters_of(assembly, given))
    deployed = deploy_linkage(name, case.linkage, case.setup, case.formulation or "constrained", drives=case.drives)
    commands = [
        (f"hcsearch assembly {name}{_parameter_words(given)}", "prints these properties, also of other sizes"),
        (f"hcsearch motion {subject}", "follows its motion: branches and singular states"),
        (
            f"hcsearch export {subject} --output {name}.glb",
            "writes it for other programs, here in three dimensions",
        ),
    ]
    return LinkageData(
        title=assembly.title,
        sentence=lead_sentence(facts, deployed),
        meta=page_meta(case),
        picture=draw_pattern(case.linkage.pattern, assembly.title, standalone=False),
        motions=_motions(name, case, deployed, subject),
        facts=list(fact_rows(facts)),
        commands=commands,
        notes=facts["notes"],
        published=list(published_rows(facts)),
    )


def _parameter_words(given: Mapping[str, Any]) -> str:
    """Return the parameters of an assembly as words of its command, with a space before each."""
    options = [f" --{name} {shlex.quote(str(value))}" for name, value in given.items() if name != "size"]
    return "".join([f" {shlex.quote(str(given['size']))}" if "size" in given else "", *options])


def _motions(name: str, case: Case, deployed: Deployed, subject: str) -> list[ShownMotion]:
    """Return the motion by springs; where they do not bring it flat, also the motion that is followed from packed."""
    motions = [motion_by_springs(name, deployed, f"hcsearch deploy {subject}")]
    if (deployed.agreement or deployed.deployment).outcome == "flat":
        return motions
    linkage, labels = case.linkage, case.labels
    angles, words = resolve_start(linkage, labels, "folded", stops=True)
    followed = follow_branch(linkage, angles, until="end", max_step=row_step(linkage))
    try:
        path = replay_of_motion(LinkageMotion(name, linkage, labels, words, "end", followed))
    except HcsearchError:  # it does not move
        return motions
    return [*motions, shown_motion("Motion that is followed", path, f"hcsearch motion {subject}")]


def write_assembly(case: Case, path: Path | str, subject: str) -> Path:
    """Write the page of an assembly in the scene of a case, and return its path.

    subject : as in `fetch_assembly_data`. OutputError: the file cannot be written.
    """
    write_output(path, render_linkage(fetch_assembly_data(case, subject)))
    return Path(path)
