"""The page of an assembly of the thesis: its motion, and its figures beside those of the thesis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

from markupsafe import Markup

from hcsearch.basics.errors import HcsearchError
from hcsearch.cases.case import Case
from hcsearch.cases.names import parameters_of
from hcsearch.cases.replay import Replay
from hcsearch.cases.replay_sources import replay_of_deployment, replay_of_motion
from hcsearch.library.assemblies import ASSEMBLIES
from hcsearch.library.assemblies.description import AssemblyFacts, describe_assembly
from hcsearch.library.assemblies.fact_texts import fact_rows, published_rows
from hcsearch.motion.paths.branch_following import follow_branch
from hcsearch.motion.paths.linkage_motion import LinkageMotion, row_step
from hcsearch.motion.paths.start_states import resolve_start
from hcsearch.shape.pattern_drawing import draw_pattern
from hcsearch.springs.deployment.deployment_facts import Deployed, deploy_linkage
from hcsearch.system.outputs import write_output
from hcsearch.web.player import payload_of, player_script
from hcsearch.web.player.player_page import as_script, digest_of
from hcsearch.web.report.design_data import ShownMotion
from hcsearch.web.report.motion_plots import plots_of
from hcsearch.web.report.plots import curve_swatch
from hcsearch.web.report.templating import joined_script, page_style, template_environment


@dataclass(frozen=True)
class AssemblyData:
    """The content of the page. meta : what the results depend on. sentence : what it is, and whether springs open it.

    picture : its flat pattern as SVG. commands : that print or draw more, each with what it does.
    links : (words, address) of neighbouring pages.
    """

    title: str
    sentence: str
    meta: Sequence[tuple[str, str]]
    picture: str
    motions: Sequence[ShownMotion]
    facts: AssemblyFacts
    commands: Sequence[tuple[str, str]]
    links: Sequence[tuple[str, str]] = ()


def fetch_assembly_data(name: str, case: Case, option: str = "") -> AssemblyData:
    """Return the data of an assembly with its default sizes.

    case : the assembly in a scene. option : of commands, for this scene, with a space before it.
    """
    assembly = ASSEMBLIES[name]
    facts = describe_assembly(assembly, parameters_of(assembly, {}))
    deployed = deploy_linkage(name, case.linkage, case.setup, case.formulation or "constrained", drives=case.drives)
    commands = [
        (f"hcsearch assembly {name}", "prints these properties, also of other sizes"),
        (f"hcsearch motion {name}{option}", "follows its motion: branches and singular states"),
        (
            f"hcsearch export {name}{option} --output {name}.glb",
            "writes it for other programs, here in three dimensions",
        ),
    ]
    return AssemblyData(
        title=assembly.title,
        sentence=_sentence(facts, deployed),
        meta=[
            ("scene", case.setup.name),
            ("hcsearch", version("hcsearch")),
            ("made", datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")),
        ],
        picture=draw_pattern(case.linkage.pattern, assembly.title, standalone=False),
        motions=_motions(name, case, deployed, option),
        facts=facts,
        commands=commands,
    )


def _sentence(facts: AssemblyFacts, deployed: Deployed) -> str:
    """Return what an assembly is, and what springs do with it."""
    dof = facts["dof"]
    freedom = "an undecided number of degrees" if dof is None else f"{dof} degree{'' if dof == 1 else 's'}"
    kutzbach = f"Kutzbach's formula gives {facts['kutzbach']}"
    parts = f"{facts['panels']} panels and {facts['hinges']} hinges with {freedom} of freedom, where {kutzbach}."
    if deployed.verdict == "deploys":
        time = "" if deployed.flat_time is None else f" in {deployed.flat_time:.3g} s"
        return f"{parts} Springs alone open it{time}, and its panels are certified not to collide."
    return f"{parts} Springs in the scene {deployed.deployment.compiled.setup.name}: {deployed.reason}."


def _motions(name: str, case: Case, deployed: Deployed, option: str) -> list[ShownMotion]:
    """Return the motion by springs; where they do not bring it flat, also the motion that is followed from packed."""
    replay = replay_of_deployment(deployed.deployment, name, reason=deployed.reason)
    motions = [_shown("Motion by springs", replay, f"hcsearch deploy {name}{option}", deployed)]
    if deployed.deployment.outcome == "flat":
        return motions
    linkage, labels = case.linkage, case.labels
    angles, words = resolve_start(linkage, labels, "folded", stops=True)
    followed = follow_branch(linkage, angles, until="end", max_step=row_step(linkage))
    try:
        path = replay_of_motion(LinkageMotion(name, linkage, labels, words, "end", followed))
    except HcsearchError:  # it does not move
        return motions
    return [*motions, _shown("Motion that is followed", path, f"hcsearch motion {name}{option}", None)]


def _shown(title: str, replay: Replay, command: str, deployed: Deployed | None) -> ShownMotion:
    payload = payload_of(replay)
    plots = plots_of(replay, payload, None if deployed is None else deployed.deployment)
    return ShownMotion(title, payload["source"], command, payload, plots)


def render_assembly(data: AssemblyData) -> str:
    """Return the HTML page of an assembly; all text is escaped, and its policy admits only its own scripts."""
    scripts = [player_script(), joined_script(("copy", "design"))]
    return (
        template_environment()
        .get_template("assembly.html")
        .render(
            data=data,
            # Trusted: integers and fixed words, and a title that `draw_pattern` escapes.
            picture=Markup(f'<div class="picture">{data.picture}</div>'),
            facts=list(fact_rows(data.facts)),
            published=list(published_rows(data.facts)),
            swatch=lambda k: Markup(curve_swatch(k)),
            payload=Markup(as_script([motion.payload for motion in data.motions])),
            style=Markup(page_style("style.css", "design.css")),
            scripts=[Markup(script) for script in scripts],
            digests=[digest_of(script) for script in scripts],
        )
    )


def write_assembly(name: str, case: Case, path: Path | str, option: str = "") -> Path:
    """Write the page of an assembly in the scene of a case, and return its path.

    option : as in `fetch_assembly_data`. OutputError: the file cannot be written.
    """
    write_output(path, render_assembly(fetch_assembly_data(name, case, option)))
    return Path(path)
