"""Pages of patterns of files: what they say and play, and what `show` prints of them."""

from dataclasses import replace

import pytest
from click.testing import CliRunner

from hcsearch import save
from hcsearch.basics.errors import HcsearchError
from hcsearch.cli.show import show
from hcsearch.subjects.resolve import resolve
from hcsearch.web.report.linkage_page import fetch_linkage_data, render_linkage
from tests.export.test_any_panels import strip, written
from tests.report.pages import Page, data_of


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return written(tmp_path_factory.mktemp("pattern"), strip([2.0, 1.5, 1.8], "MV"))


@pytest.fixture(scope="module")
def data(path):
    return fetch_linkage_data(resolve(path, "none.sqlite"), f"{path} --scene x.toml")


def _printed(*words):
    return CliRunner().invoke(show, words, catch_exceptions=False).stdout


def test_the_page_of_a_pattern_plays_its_motions_and_holds_its_properties(path, data):
    text = render_linkage(data)
    texts = {text.strip() for _, text in Page(text).texts}
    assert data.sentence.startswith(
        "3 panels and 2 hinges with 2 degrees of freedom, where Kutzbach's formula gives 2."
    )
    assert {value for _, value in data.about.rows} <= texts
    assert any("a path from packed to flat is proved" in value for _, value in data.about.rows)
    assert data_of(text) == [motion.payload for motion in data.motions]
    assert [motion.command for motion in data.motions] == [
        f"hcsearch deploy {path} --scene x.toml",
        f"hcsearch drive {path} --scene x.toml",
    ]


def test_a_hostile_name_stays_text(data):
    hostile = "</script><script>alert(1)</script>"
    about = data.about._replace(title=hostile, rows=[(hostile, hostile)], commands=[(hostile, hostile)])
    text = render_linkage(replace(data, about=about))
    assert Page(text).count("script") == 3
    assert "<script>alert" not in text


def test_show_prints_the_freedoms_of_a_pattern(path, tmp_path):
    lines = _printed(path).splitlines()
    assert [line.split() for line in lines if line.startswith("dof")] == [
        ["dof", "in", "motion", "2"],
        ["dof", "packed", "2"],
        ["dof", "flat", "2"],
    ]
    without = written(tmp_path, strip([2.0, 2.0, 2.0, 2.0], "VVV"))
    assert "share a layer" in _printed(without)
    with pytest.raises(HcsearchError, match="depend on no scene"):
        _printed(path, "--scene", "earth")
    with pytest.raises(HcsearchError, match="no packed state is known"):
        _printed(without, "--html", "--output", str(tmp_path / "a.html"))


def test_a_page_overwrites_no_pattern_and_each_result_has_a_name(tmp_path, data):
    own = written(tmp_path, strip([2.0, 1.5], "M"))
    with pytest.raises(HcsearchError, match="is the file that is shown: write the page to another one"):
        _printed(own, "--html", "--output", own)
    assert all(name for name, _ in data.about.rows)


def test_a_file_that_draws_a_design_is_shown_as_this_design(tmp_path):
    name = "hex:0234550132:4"
    (path,) = save(name, tmp_path / "a.fold", db="none.sqlite")
    assert _printed(str(path)) == _printed(name)
