"""The page of one linkage that is no design: its motions, its properties, and the commands that give more."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import version
from typing import Any

from markupsafe import Markup

from hcsearch.basics.vocabulary import counted
from hcsearch.shape.pattern_drawing import draw_pattern
from hcsearch.springs.deployment.deployment_facts import Deployed
from hcsearch.subjects.case import Case, PageFacts
from hcsearch.subjects.replay import Replay
from hcsearch.subjects.replay_sources import replay_of_deployment
from hcsearch.web.player import payload_of, player_script
from hcsearch.web.player.player_page import as_script, digest_of
from hcsearch.web.report.design_data import ShownMotion, spring_motion_title
from hcsearch.web.report.headline import opened_sentence
from hcsearch.web.report.motion_plots import plots_of
from hcsearch.web.report.plots import curve_swatch
from hcsearch.web.report.templating import joined_script, page_style, template_environment


@dataclass(frozen=True)
class LinkageData:
    """The content of the page.

    Parameters
    ----------
    about
        The description of the case.
    sentence
        What it is, and whether springs open it.
    meta
        What the results depend on.
    picture
        Its flat pattern as SVG, of integers, fixed words and an escaped title.
    motions
        To play.
    links
        The words and the address of neighbouring pages.
    """

    about: PageFacts
    sentence: str
    meta: Sequence[tuple[str, str]]
    picture: str
    motions: Sequence[ShownMotion]
    links: Sequence[tuple[str, str]] = ()

    @property
    def title(self) -> str:
        """The name of the linkage."""
        return self.about.title


def fetch_linkage_data(case: Case, subject: str) -> LinkageData:
    """Return the data of a case whose linkage has a page; subject : how commands name this case, with its options."""
    deployed = case.deployed()
    about = case.page_facts(deployed, subject)
    springs = replay_of_deployment(deployed.deployment, case.title, reason=deployed.reason)
    title = spring_motion_title(deployed.deployment)
    return LinkageData(
        about,
        sentence=_lead_sentence(about.facts, deployed),
        meta=[
            ("scene", case.setup.name),
            ("hcsearch", version("hcsearch")),
            ("made", datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")),
        ],
        picture=draw_pattern(case.linkage.pattern, about.title, standalone=False),
        motions=[
            _shown_motion(title, springs, f"hcsearch deploy {subject}", deployed),
            *(_shown_motion(*motion) for motion in about.motions),
        ],
    )


def _lead_sentence(facts: Mapping[str, Any], deployed: Deployed) -> str:
    """Return what a linkage is, and what springs or drives do with it.

    facts : its panels, hinges, dof and kutzbach.
    """
    dof, kutzbach = facts["dof"], f"Kutzbach's formula gives {facts['kutzbach']}"
    freedom = "an undecided number of degrees" if dof is None else counted(dof, "degree")
    size = f"{counted(facts['panels'], 'panel')} and {counted(facts['hinges'], 'hinge')}"
    parts = f"{size} with {freedom} of freedom, where {kutzbach}."
    driven = deployed.deployment.driven is not None
    if deployed.verdict == "deploys":
        return f"{parts} {opened_sentence(deployed.flat_time, driven=driven)}"
    scene = deployed.deployment.compiled.setup.name
    return f"{parts} {'Drives' if driven else 'Springs'} in the scene {scene}: {deployed.reason}."


def _shown_motion(title: str, replay: Replay, command: str, deployed: Deployed | None = None) -> ShownMotion:
    """Return a motion for a page; deployed : the deployment that it replays."""
    payload = payload_of(replay)
    deployment, flat_time = (None, None) if deployed is None else (deployed.deployment, deployed.flat_time)
    plots = plots_of(replay, payload, deployment, flat_time)
    return ShownMotion(title, payload["source"], command, payload, plots)


def render_linkage(data: LinkageData) -> str:
    """Return the HTML page of a linkage; all text is escaped, and its policy admits only its own scripts."""
    scripts = [player_script(), joined_script(("copy", "address", "design"))]
    return (
        template_environment()
        .get_template("linkage.html")
        .render(
            data=data,
            # Trusted: integers and fixed words, and a title that `draw_pattern` escapes.
            picture=Markup(f'<div class="picture">{data.picture}</div>'),
            swatch=lambda k: Markup(curve_swatch(k)),
            payload=Markup(as_script([motion.payload for motion in data.motions])),
            style=Markup(page_style("style.css", "plots.css", "design.css")),
            scripts=[Markup(script) for script in scripts],
            digests=[digest_of(script) for script in scripts],
        )
    )
