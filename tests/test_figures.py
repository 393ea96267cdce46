"""Pictures of curves are the same, whatever the machine, the folder or a notebook sets for matplotlib."""

import os
import re
import subprocess
import sys

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.image import imread

from hcsearch.basics.errors import HcsearchError
from hcsearch.shape.angle_curves import draw_angle_curves
from hcsearch.system import figures
from hcsearch_bench.run.work_precision import plot_work
from tests.commands import run_here, without_progress

SMALL = ("deploy", "hex:023350:1", "--seconds", "0.02", "--picture")
QUICK = ("drive", "hex:0234550132:4", "--rate", "4", "--acceleration", "40", "--period", "0.005", "--picture")

SETTINGS = """
text.usetex: True
savefig.dpi: 30
savefig.bbox: tight
savefig.transparent: True
backend: TkAgg
axes.prop_cycle: cycler("color", ["r", "k"])
axes.titlesize: 30
figure.facecolor: black
figure.constrained_layout.h_pad: 1.0
lines.marker: o
path.simplify: False
path.sketch: 1, 100, 2
nonsense: 1
no colon
"""
"""A file matplotlibrc that changes all that pictures show, and asks for TeX and a window, which a machine may lack."""


def in_shell(folder, *words, **environment):
    """Run a command in a folder and an environment of its own."""
    command = [sys.executable, "-m", "hcsearch", *words]
    return subprocess.run(
        command, cwd=folder, env=os.environ | environment, capture_output=True, text=True, check=False
    )


@pytest.mark.parametrize(
    ("words", "backend"), [(SMALL, "nonsense"), (QUICK, "module://matplotlib_inline.backend_inline")]
)
def test_commands_draw_as_ever_where_matplotlib_is_set_otherwise(words, backend, tmp_path, capfd):
    (tmp_path / "matplotlibrc").write_text(SETTINGS, encoding="utf-8")
    there = in_shell(tmp_path, *words, "there.png", MPLBACKEND=backend)
    here = run_here((*words, str(tmp_path / "here.png")), capfd)
    assert (there.returncode, there.stdout, without_progress(there.stderr)) == (here.returncode, here.stdout, "")
    assert np.array_equal(imread(tmp_path / "there.png"), imread(tmp_path / "here.png"))


@pytest.mark.parametrize("words", [SMALL, QUICK])
def test_settings_that_matplotlib_cannot_read_are_named_before_anything_is_computed(words, tmp_path):
    (tmp_path / "matplotlibrc").write_bytes(b"axes.titlesize: \xe9\n")
    # the subject is wrong, too: it is read after the picture was looked at
    ended = in_shell(tmp_path, words[0], "nothing", *words[2:], "a.png")
    assert (ended.returncode, ended.stdout) == (2, "")
    assert ended.stderr.startswith("hcsearch: matplotlib cannot be loaded (Cannot decode ")
    assert "mend or move its settings" in ended.stderr
    assert ended.stderr.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["matplotlibrc"]


def test_benches_draw_as_ever_in_a_program_that_set_matplotlib_otherwise(tmp_path):
    points = [(problem, "hcsearch", f"method {k}", 10.0**k, 10.0**-k) for problem in "ab" for k in range(3)]
    plot_work(points, "error", tmp_path / "plain.png")
    (tmp_path / "own").write_text(SETTINGS.partition("nonsense")[0].replace("backend: TkAgg\n", ""), encoding="utf-8")
    with mpl.rc_context(fname=tmp_path / "own"):
        before = dict(mpl.rcParams.copy())
        plot_work(points, "error", tmp_path / "changed.png")
        assert dict(mpl.rcParams.copy()) == before
    assert np.array_equal(imread(tmp_path / "plain.png"), imread(tmp_path / "changed.png"))


def test_tuning_starts_where_a_notebook_asks_for_a_window(tmp_path):
    """The search of springs loads matplotlib, though it draws nothing."""
    words = ("tune", "hex:0234550132:4", "--evaluations", "40", "--samples", "8")
    ended = in_shell(tmp_path, *words, MPLBACKEND="nonsense")
    assert (ended.returncode, without_progress(ended.stderr)) == (0, "")


NOTEBOOK = """
import os, sys
{first}
from hcsearch.system.figures import figure_for
with figure_for("a.svg", (1.0, 1.0)) as figure:
    figure.subplots().plot([0.0, 1.0])
import matplotlib
assert "matplotlib.pyplot" not in sys.modules
print(os.environ["MPLBACKEND"], dict.__getitem__(matplotlib.rcParams, "backend"))
"""


@pytest.mark.parametrize("first", ["", "import matplotlib"])
def test_plots_of_a_notebook_are_shown_by_its_own_backend(first, tmp_path):
    command = [sys.executable, "-c", NOTEBOOK.format(first=first)]
    environment = os.environ | {"MPLBACKEND": "svg"}
    ended = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert (ended.stdout, ended.stderr) == ("svg svg\n", "")
    assert "<svg" in (tmp_path / "a.svg").read_text(encoding="utf-8")


def test_a_picture_that_fails_leaves_no_file_and_no_settings(tmp_path):
    before = dict(mpl.rcParams.copy())
    with pytest.raises(ZeroDivisionError), figures.figure_for(tmp_path / "a.png", (1.0, 1.0)) as figure:
        figure.subplots().plot([1.0 / 0.0])
    with pytest.raises(HcsearchError, match="no known ending"), figures.figure_for(tmp_path / "a.gif", (1.0, 1.0)):
        pass
    assert list(tmp_path.iterdir()) == []
    assert dict(mpl.rcParams.copy()) == before


def test_labels_stand_on_curves_and_those_without_room_in_a_legend(tmp_path):
    with figures.figure_for(tmp_path / "a.png", (6.0, 4.0)) as figure:
        axes = figure.subplots()
        for label, height in (("alone", 0.0), ("near", 1.0), ("nearer", 1.01)):
            axes.plot([0.0, 1.0], [height, height], label=label)
        figures.label_curves({axes: "curve"})
        assert [text.get_text() for text in axes.texts] == ["alone"]
        assert [text.get_text() for text in axes.get_legend().get_texts()] == ["near", "nearer"]


@pytest.mark.parametrize("group_count", [3, 48])
def test_curves_of_many_hinges_are_named_and_leave_room_for_the_plots(tmp_path, group_count):
    names = [str(hinge) for hinge in range(96)]
    places = np.linspace(0.0, 1.0, 30)
    angles = np.array([places * (1.0 + hinge % group_count) for hinge in range(96)]).T
    with figures.figure_for(tmp_path / "a.png", (9.0, 7.0)) as figure:
        above, below = figure.subplots(2, 1, sharex=True)
        draw_angle_curves(above, places, angles, names)
        below.plot(places, places)
        figures.label_curves({above: "hinge"})
    texts = [*above.texts, *above.get_legend().get_texts()]
    assert sorted(re.findall(r"\d+", " ".join(text.get_text() for text in texts))) == sorted(names)
    assert all(axes.get_position().width > 0.3 for axes in (above, below))
    legend, frame = above.get_legend().get_window_extent(), figure.bbox
    assert legend.x1 <= frame.x1
    assert legend.y0 >= frame.y0


def test_labels_stand_within_plots_that_the_legend_of_another_plot_makes_narrow(tmp_path):
    places = np.linspace(0.0, 1.0, 50)
    with figures.figure_for(tmp_path / "a.png", (6.0, 4.0)) as figure:
        above, below = figure.subplots(2, 1, sharex=True)
        label = "a label that is nearly as wide as a plot without a legend"
        above.plot(places, 0.0 * places, label=label)
        above.plot(places, 1.0 + 0.0 * places, label="short")
        for number in range(30):
            below.plot(places, 1e-3 * number + places, label=f"curve {number}")
        figures.label_curves({above: "upper", below: "lower"})
    frame = above.get_window_extent()
    assert [text.get_text() for text in above.texts] == ["short"]
    assert all(frame.x0 <= x <= frame.x1 for box in [above.texts[0].get_window_extent()] for x in (box.x0, box.x1))
    assert [text.get_text().replace("\n", " ") for text in above.get_legend().get_texts()] == [label]
