"""Pages of assemblies: what they say and play."""

from dataclasses import replace

import pytest
from click.testing import CliRunner

from hcsearch.api.deploying import deploy
from hcsearch.api.describing import describe
from hcsearch.basics.errors import HcsearchError
from hcsearch.cli.assembly import assembly
from hcsearch.cli.show import show
from hcsearch.designs.grid import GRIDS
from hcsearch.library.assemblies.description import fact_rows, published_rows
from hcsearch.subjects.replay_sources import replay_of_deployment
from hcsearch.subjects.resolve import resolve
from hcsearch.web.report.linkage_page import fetch_linkage_data, render_linkage
from hcsearch.web.report.motion_plots import marks_of_motion
from hcsearch.web.report.plots import DrawnPlot, PlotCurve
from tests.report.pages import Page, data_of

UNIT = "unit-ii"


@pytest.fixture(scope="module")
def data():
    return fetch_linkage_data(resolve(UNIT, "none.sqlite"), UNIT)


def test_the_page_of_an_assembly_plays_its_motion_and_holds_its_properties(data):
    text = render_linkage(data)
    page = Page(text)
    texts = {text.strip() for _, text in page.texts}
    assert data.sentence == (
        "21 panels and 24 hinges with 1 degree of freedom, where Kutzbach's formula gives 0. Springs alone open it in "
        "0.261 s, and its panels are certified not to collide."
    )
    assert data.sentence in texts
    facts = describe(UNIT)
    assert {value for _, value in fact_rows(facts)} <= texts
    assert {value for _, value, _ in published_rows(facts)} <= texts
    assert data_of(text) == [motion.payload for motion in data.motions]
    (motion,) = data.motions
    assert motion.command == "hcsearch deploy unit-ii"
    numbers = [attrs["data-hinge"] for attrs in page.with_class("part") if "data-hinge" in attrs]
    assert numbers == motion.payload["labels"]["hinges"]


def test_where_springs_do_not_open_an_assembly_its_motion_is_followed():
    data = fetch_linkage_data(resolve("array-6r", "none.sqlite"), "array-6r --scene x.toml")
    springs, followed = data.motions
    assert "Springs alone open it" not in data.sentence
    assert (springs.command, followed.command) == (
        "hcsearch deploy array-6r --scene x.toml",
        "hcsearch motion array-6r --scene x.toml",
    )
    assert "panels may pass through each other" in followed.source


def test_plots_name_the_flat_time_in_the_digits_on_which_tolerances_agree():
    name = "element-6r"
    deployed = deploy(name)
    data = fetch_linkage_data(resolve(name, "none.sqlite"), name)
    (motion,) = data.motions
    end = deployed.deployment.motion.times[-1]
    assert (deployed.flat_time, f"{end:.3g}") == (0.7, "0.652")
    assert "in 0.7 s" in data.sentence
    assert motion.source.endswith("flat after 0.7 s")
    assert all(">flat, about 0.7 s</text>" in plot.svg for plot in motion.plots)


@pytest.mark.parametrize(("flat_time", "text"), [(None, "flat"), (0.65, "flat, 0.65 s"), (0.7, "flat, about 0.7 s")])
def test_the_mark_of_the_flat_state_names_no_digits_that_are_in_doubt(flat_time, text):
    deployment = deploy("element-6r").deployment
    (mark,) = marks_of_motion(replay_of_deployment(deployment, "element"), deployment, flat_time)
    assert (mark.x, mark.text) == (deployment.motion.times[-1], text)


def test_the_legend_of_a_plot_breaks_no_line_within_a_range(data):
    curve = PlotCurve("hinges 0, 3 to 8, 10 to 12", [0, 1], [0, 1], "0", (0, 3))
    motion = replace(data.motions[0], plots=[DrawnPlot("angles", "<svg></svg>", ((0, curve),))])
    texts = [text for tag, text in Page(render_linkage(replace(data, motions=[motion]))).texts if tag == "button"]
    assert "hinges 0, 3\N{NO-BREAK SPACE}to\N{NO-BREAK SPACE}8, 10\N{NO-BREAK SPACE}to\N{NO-BREAK SPACE}12" in texts


def test_hostile_text_stays_text(data):
    hostile = "</script><script>alert(1)</script>"
    about = data.about._replace(title=hostile, commands=[(hostile, hostile)])
    text = render_linkage(replace(data, about=about, sentence=hostile))
    assert Page(text).count("script") == 3
    assert "<script>alert" not in text


def test_panels_of_each_grid_have_a_name():
    assert all(grid.exact_noun for grid in GRIDS.values())


def test_show_prints_what_assembly_prints_and_writes_the_page(tmp_path, data):
    described = CliRunner().invoke(assembly, [UNIT], catch_exceptions=False)
    shown = CliRunner().invoke(show, [UNIT], catch_exceptions=False)
    assert shown.stdout == described.stdout
    path = tmp_path / "unit.html"
    written = CliRunner().invoke(show, [UNIT, "--html", "--output", str(path)], catch_exceptions=False)
    assert written.stdout == f"{path}\n"
    assert data.about.title in path.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        ([UNIT, "--scene", "earth"], "depend on no scene: add --html"),
        ([UNIT, "--html", "--panel", "50x50x6"], "sizes of its own: leave out --panel"),
    ],
)
def test_options_that_an_assembly_does_not_have_are_refused(words, reason, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(show, words)
    assert isinstance(result.exception, HcsearchError)
    assert reason in str(result.exception)
    assert list(tmp_path.iterdir()) == []
