"""The gallery shows what its generator lists, and its pictures are those of their commands."""

import re

import pytest

from hcsearch.basics.vocabulary import DESIGN_STATUSES
from hcsearch.designs.grid import GRIDS
from hcsearch.library.assemblies import ASSEMBLIES
from hcsearch_bench.gallery.__main__ import export_picture
from hcsearch_bench.gallery.drawings import drawings
from hcsearch_bench.gallery.page import gallery_page
from hcsearch_bench.gallery.screenshots import SCREENSHOTS
from hcsearch_bench.gallery.shown import OTHER_PICTURES, SECTIONS
from tests.documents import ROOT

FOLDER = ROOT / "docs" / "gallery"
SHOWN = [picture for section in SECTIONS for picture in section.pictures]


@pytest.fixture(scope="module")
def drawn():
    return dict(drawings())


def test_the_page_is_that_of_the_generator():
    assert (ROOT / "docs" / "gallery.md").read_text(encoding="utf-8") == gallery_page(FOLDER), "make gallery"


def test_the_folder_holds_the_listed_pictures_and_no_others(drawn):
    listed = {picture.file for picture in [*SHOWN, *OTHER_PICTURES, *SCREENSHOTS]} | set(drawn)
    assert {path.name for path in FOLDER.iterdir()} == listed


def test_every_grid_status_and_assembly_is_shown():
    titles = {picture.title for picture in SHOWN}
    assert {f"moving-{grid}.svg" for grid in GRIDS} <= {picture.file for picture in SHOWN}
    assert {status.replace("_", " ") for status in DESIGN_STATUSES} <= titles
    assert set(ASSEMBLIES) <= titles


def test_drawings_are_remade_as_they_are(drawn):
    assert {name: (FOLDER / name).read_text(encoding="utf-8") for name in drawn} == drawn


@pytest.mark.parametrize("title", ["element-6r", "twisted"])
def test_moving_pictures_are_remade_as_they_are(title, tmp_path):
    (picture,) = [picture for picture in SHOWN if picture.title == title]
    export_picture(picture, tmp_path)
    new, old = ((folder / picture.file).read_text(encoding="utf-8") for folder in (tmp_path, FOLDER))
    number = re.compile(r"\s*(-?\d+(?:\.\d+)?)")  # a sign needs no blank before it
    assert number.sub("#", new) == number.sub("#", old)
    # whole units of a picture 960 wide; last bits of other processors may round them otherwise
    assert [float(x) for x in number.findall(new)] == pytest.approx([float(x) for x in number.findall(old)], abs=3)


def test_the_pictures_are_small():
    assert max(path.stat().st_size for path in FOLDER.iterdir()) < 500_000
