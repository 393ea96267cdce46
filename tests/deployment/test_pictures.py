"""Pictures of deployments: lines that can be told apart, names of hinges, the collision."""

import itertools
import re

import numpy as np
import pytest
from matplotlib.figure import Figure

from hcsearch import Folding
from hcsearch.scenes import SCENES
from hcsearch.springs.deployment.deployment_facts import deploy_linkage, mark_collision
from hcsearch.system.figures import add_legend, line_style, set_title


def test_lines_of_many_hinges_differ_in_colour_style_or_width():
    looks = [tuple(line_style(number).values()) for number in range(100)]
    assert len(set(looks)) == 100
    assert all(a[0] != b[0] and a[1] != b[1] for a, b in itertools.pairwise(looks))


@pytest.mark.parametrize(("lines", "columns"), [(1, 1), (20, 1), (21, 2), (80, 4)])
def test_the_legend_has_all_lines(lines, columns):
    axes = Figure().subplots()
    for number in range(lines):
        axes.plot([0.0, 1.0], [0.0, number], label=str(number), **line_style(number))
    add_legend(axes, "hinge", axes.get_lines())
    assert [text.get_text() for text in axes.get_legend().get_texts()] == [str(number) for number in range(lines)]
    assert axes.get_legend()._ncols == columns


@pytest.mark.parametrize("shift", range(8))
def test_legends_break_no_line_within_a_range(shift):
    axes = Figure().subplots()
    label = "x" * shift + ", ".join(f"{k} to {k + 9}" for k in range(0, 200, 11))
    axes.plot([0.0, 1.0], [0.0, 1.0], label=label)
    add_legend(axes, "hinge", axes.get_lines())
    (text,) = [text.get_text() for text in axes.get_legend().get_texts()]
    assert text.split() == label.split()
    assert all(re.search(r"^\w+ to \d+", line) and re.search(r"\d+ to \d+,?$", line) for line in text.splitlines())


def test_a_plot_without_lines_has_no_legend():
    axes = Figure().subplots()
    add_legend(axes, "hinge", [])
    assert axes.get_legend() is None


def test_long_titles_have_several_lines():
    axes = Figure().subplots()
    set_title(axes, "$x " * 100)
    assert axes.get_title().count("\n") >= 3
    set_title(axes, "word " * 17 + "a 0.25 s b")
    assert axes.get_title().splitlines()[1] == "0.25 s b"


@pytest.fixture(scope="module")
def colliding():
    return deploy_linkage("hex:02234400:1", Folding.from_notation("hex:02234400:1").linkage(), SCENES["default"])


def test_a_collision_is_named_in_the_title_and_at_its_time(colliding, tmp_path):
    colliding.picture(str(tmp_path / "a.svg"))
    text = (tmp_path / "a.svg").read_text(encoding="utf-8")
    comments = re.findall(r"<!-- (.*?) -->", text)
    assert any(
        one.startswith("hex:02234400:1: collides, panels 4 and 7 collide at 0.01282 s; flat") for one in comments
    )
    assert "panels 4 and 7 collide at 0.01282 s" in comments
    assert "fold angle, degrees" in comments


def test_what_is_clear_has_no_line_of_a_collision():
    clear = deploy_linkage("hex:0234550132:4", Folding.from_notation("hex:0234550132:4").linkage(), SCENES["default"])
    axes = Figure().subplots()
    mark_collision(axes, clear.deployment)
    assert not axes.lines
    assert np.size(axes.texts) == 0
