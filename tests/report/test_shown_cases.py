"""Files `.toml` that name what is shown: texts and pages are of it, with the sizes and springs of the file."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from hcsearch import deploy, describe, save, show, show_page
from hcsearch.basics.errors import HcsearchError, OutputError
from hcsearch.cli.drive import drive as drive_command
from hcsearch.cli.show import show as show_command
from tests.export.test_any_panels import strip, written
from tests.report.pages import Page

FOLDING = "hex:0234550132:4"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a case of each kind."""
    folder = tmp_path_factory.mktemp("cases")
    Path(written(folder, strip([2.0, 1.5, 1.8], "MV"))).rename(folder / "strip.fold")
    springs = "[scene]\nspring = 'linear:0.05'\n"
    (folder / "pattern.toml").write_text(f"pattern = 'strip.fold'\n{springs}")
    (folder / "design.toml").write_text(f"design = '{FOLDING}'\npanel_mm = '80x8'\n{springs}")
    (folder / "assembly.toml").write_text(f"assembly = 'unit-i'\n[parameters]\nalpha = 70\n{springs}")
    return folder


def _printed(*words):
    return CliRunner().invoke(show_command, [str(word) for word in words], catch_exceptions=False).stdout


def _texts(path):
    return {text for _, text in Page(path.read_text(encoding="utf-8")).texts}


def test_the_text_of_a_case_is_that_of_what_it_names(folder):
    assert _printed(folder / "pattern.toml") == _printed(folder / "strip.fold")
    assert _printed(folder / "design.toml") == _printed(FOLDING, "--panel", "80x8")
    assert show(str(folder / "assembly.toml")).facts == describe("unit-i", alpha=70)
    assert f"{'parameters':21}alpha 70 degrees" in _printed(folder / "assembly.toml")


@pytest.mark.parametrize("kind", ["pattern", "design", "assembly"])
def test_the_page_of_a_case_plays_its_motion_with_its_springs(folder, kind):
    case = str(folder / f"{kind}.toml")
    texts = _texts(show_page(case, folder / f"{kind}.html", db="none.sqlite"))
    seconds = deploy(case, db="none.sqlite").flat_time
    assert any(f"{seconds:.3g} s, and its panels are certified not to collide" in text for text in texts)
    assert f"hcsearch deploy {case}" in texts


def test_the_page_of_a_drawn_design_shows_its_panels(folder):
    (drawn,) = save(FOLDING, folder / "big.fold", panel="80x8", db="none.sqlite")
    texts = _texts(show_page(str(drawn), folder / "drawn.html", db="none.sqlite"))
    assert "10 of 80x80x8 mm" in texts
    named = _texts(show_page(FOLDING, folder / "named.html", panel="80x8", db="none.sqlite"))
    assert f"hcsearch drive {FOLDING} --panel 80x8" in named
    # run times, by which the plot of the accuracy is numbered, are those of each page
    times = {text for text in texts if text.replace(".", "").isdigit()}
    assert {text for text in texts - times if "hcsearch" not in text and ":" not in text} <= named


def test_no_page_overwrites_its_case_or_pattern(folder):
    for name in ("pattern.toml", "strip.fold"):
        with pytest.raises(OutputError, match="is the file that is shown"):
            show_page(str(folder / "pattern.toml"), folder / name)
    with pytest.raises(HcsearchError, match=r"lost\.toml"):
        show(str(folder / "lost.toml"))


def test_what_drives_open_is_not_said_to_be_opened_by_springs(folder):
    case = str(folder / "driven.toml")
    driven = CliRunner().invoke(drive_command, [str(folder / "strip.fold"), "--output", case], catch_exceptions=False)
    assert driven.exit_code == 0
    texts = _texts(show_page(case, folder / "driven.html"))
    assert any("Its drives open it in " in text for text in texts)
    assert {"Motion by drives", f"hcsearch deploy {case}"} <= texts
    assert not any("Springs alone" in text or text.startswith(("hcsearch drive", "hcsearch check")) for text in texts)
