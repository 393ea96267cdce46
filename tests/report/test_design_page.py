import json
import re
import shutil
from dataclasses import replace

import numpy as np
import pytest

from hcsearch import show_page
from hcsearch.basics.errors import OutputError, SceneError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding
from hcsearch.designs.grid import GRIDS
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.designs.records import Trial
from hcsearch.scenes import Scene
from hcsearch.search.enumeration import enumerate_circuits
from hcsearch.store import open_database, select
from hcsearch.subjects.design_cases import CircuitCase
from hcsearch.subjects.mechanisms import freedoms_of, lock_sentences
from hcsearch.subjects.resolve import resolve
from hcsearch.web.report.design_data import fetch_design_data
from hcsearch.web.report.headline import design_sentence
from hcsearch.web.report.page_files import Pages, render_design
from tests.judging import WORK, judge
from tests.report.pages import Page, computed_data, data_of

FOLDING = Folding.from_notation("hex:0234550132:4")


@pytest.fixture(scope="module")
def computed():
    """A folding that no database holds: its motions are planned and simulated."""
    return computed_data(FOLDING)


@pytest.fixture
def stored(database_file, tmp_path):
    """A database in which the folding of eight hexagons is movable and was simulated once; its place, id and crease."""
    path = str(shutil.copy(database_file, tmp_path))
    with open_database(path, create=False) as opened:
        number, name = select(opened, "grid=hex n=8 untwisted", columns="id,circuit").rows[0]
        (crease,) = select(opened, f"design_id={number} untwisted", columns="crease", view="foldings").rows[0]
        values = 'flat_pairs = "hinged"\n'
        trial = Trial(
            *(0, "default", values, "constrained", "collides", "panels 1 and 5 collide at 0.01 s"),
            *(None, 0.01, None, 1e-7, 1e-9, "dormand-prince", ("gravity", "base"), 0.4),
            pairs="hinged",
        )
        judge(opened, [(name, crease, "movable", None, None)], trials=[trial])
        judge(opened, [(name, crease, "undecided", None, None)], "solar", work=replace(WORK, target="solar"))
    return path, number, name, crease


def page_of(path: str, number: int, name: str, scene: str = "default"):
    design = resolve(str(number), path, scene=scene, extent="page")
    assert design.circuit == Circuit.from_notation(name)
    return fetch_design_data(design)


def page_without_foldings(circuit: Circuit) -> str:
    return Pages().design_page(CircuitCase(name=circuit.notation, scene=Scene(), given=circuit, foldings=[]))


def test_motions_are_planned_and_simulated_where_no_database_holds_the_design(computed):
    (shown,) = computed.foldings
    springs, path, mode = shown.motions  # springs give the status
    assert (mode.title, mode.shows, mode.plots) == ("First mode of the flat array", "", ())
    assert mode.command == "hcsearch sheet hex:0234550132:4"
    assert (shown.status, path.shows, springs.shows) == ("deploys", "movable", "deploys")
    assert "proved with" in path.source
    assert path.command == "hcsearch drive hex:0234550132:4"
    assert springs.command == "hcsearch deploy hex:0234550132:4"
    assert "flat after 0.1410 s" in springs.source
    assert [plot.title for plot in path.plots] == ["Nearest gap between panels", "Fold angles of the hinges"]
    assert [plot.title for plot in springs.plots][-1] == "Energies"
    assert computed.row == {}


def test_the_best_motion_by_springs_has_its_accuracy(computed):
    accuracy = computed.foldings[0].accuracy
    assert accuracy.command == "hcsearch accuracy hex:0234550132:4"
    assert re.fullmatch(r"fold angles within [1-9]e-0[67] rad, 39 % of the work left out", accuracy.summary)
    assert [omission.name for omission in accuracy.omissions] == ["gravity", "base", "pairs"]
    assert accuracy.plot.svg.count('class="curve"') == 1
    assert "default" in accuracy.plot.svg
    assert "One run at each tolerance from 1e-3 to 1e-8" in accuracy.plot.note
    text = render_design(computed)
    assert f"Accuracy: {accuracy.summary}" in text
    assert "six freedoms of a floating base" in text


def test_curves_are_named_by_crease_and_each_hinge_has_one(computed):
    for motion in computed.foldings[0].motions[:2]:
        angles = motion.plots[1]
        drawn = re.findall(r'class="line" data-hinges="([^"]*)"', angles.svg)
        hinges = sorted(int(hinge) for group in drawn for hinge in group.split())
        assert hinges == list(range(len(motion.payload["labels"]["hinges"])))
        assert angles.svg.count('class="curve"') == len(drawn)
    rigid = computed.foldings[0].motions[0]
    assert len(rigid.payload["labels"]["hinges"]) == 8  # the flat creases 4 and 9 have no hinge
    titles = " ".join(re.findall(r"<title>(creases? [^<]*)</title>", rigid.plots[1].svg))
    assert "crease 3" in titles
    assert not {"4", "9"} & set(re.findall(r"\d+", titles))


def test_the_page_says_what_is_known_and_holds_the_motions(computed):
    text = render_design(computed)
    page = Page(text)
    joined = " ".join(text for _, text in page.texts)
    for known in ("hex:0234550132", "173.2 x 100 x 30 mm", "213.2 g", "hcsearch deploy hex:0234550132:4"):
        assert known in joined
    assert data_of(text) == [motion.payload for motion in computed.foldings[0].motions]
    assert page.count("script") == 3  # data, player, program
    assert "Springs alone open it in 0.141 s" in joined
    assert [attrs["data-motion"] for attrs in page.with_class("player") if "data-plays" in attrs] == ["0"]
    assert [attrs["data-motion"] for attrs in page.with_class("player")] == ["0", "1", "2"]
    (shown,) = computed.foldings
    for row in shown.sheet.rows:
        assert {row.rule, row.clause, row.verdict} <= {text for _, text in page.texts}
    for freedoms in freedoms_of(FOLDING, (0.05, 0.05, 0.006)):
        assert freedoms.sentence in joined
    for sentence, *_ in lock_sentences(FOLDING, (0.05, 0.05, 0.006)):
        assert sentence in joined


def test_a_stored_design_shows_its_verdicts_and_paths(stored):
    path, number, name, crease = stored
    data = page_of(path, number, name)
    first, *_ = data.foldings
    assert (data.best, first.folding.crease, first.status) == (crease, crease, "movable")
    assert first.reason == (
        "panels 1 and 5 collide at 0.01 s; springs of the scene default, flat pairs hinged; a reason for movable; "
        "leave 0.02 mm between faces: certified clear with panels 0.01 mm smaller on every face, and hinges where they "
        "are"
    )
    assert [motion.title for motion in first.motions] == [
        *("Planned path", "Motion by springs", "First mode of the flat array")
    ]
    assert "loops closed exactly: panels 1 and 5 collide at 0.01 s" in first.motions[1].source  # as it was stored
    assert np.isclose(first.room.packed.height, 0.024)
    assert all(shown.status == "twisted" for shown in data.foldings[1:])
    joined = " ".join(text for _, text in Page(render_design(data)).texts)
    assert "movable" in joined
    assert "needed margin" in joined


def test_verdicts_are_those_of_a_scene(stored):
    path, number, name, _ = stored
    data = page_of(path, number, name, "solar")
    assert data.foldings[0].status == "undecided"
    assert dict(data.meta)["scene"] == "solar"
    assert data.foldings[0].motions == []
    with pytest.raises(SceneError, match="moon"):
        page_of(path, number, name, "moon")


def test_a_design_without_foldings_has_a_page(tmp_path):
    path = show_page("hex:024", tmp_path / "none.html", db="none.sqlite")
    text = path.read_text(encoding="utf-8")
    assert "there is no folding into two stacks" in text
    assert text.count('<path class="hinge"') == 1
    assert data_of(text) == []
    with pytest.raises(OutputError, match="there is no folder"):
        show_page("hex:024", tmp_path / "new" / "none.html", db="none.sqlite")


def test_hostile_text_stays_text(computed):
    hostile = "</script><script>alert(1)</script>"
    (shown,) = computed.foldings
    motion = replace(shown.motions[0], source=hostile, payload={**shown.motions[0].payload, "title": hostile})
    shown = replace(shown, reason=hostile, status=hostile, motions=[motion])
    data = replace(computed, title=hostile, notation=hostile, meta=[(hostile, hostile)], foldings=[shown])
    text = render_design(data)
    assert Page(text).count("script") == 3
    assert not re.search(r"<script>alert", text)
    assert json.loads(json.dumps(data_of(text)))[0]["title"] == hostile


@pytest.mark.parametrize("grid", GRIDS)
def test_a_page_draws_a_circuit_of_any_grid_with_smaller_numbers_on_triangles(grid):
    circuit = next(iter(enumerate_circuits(grid, n=12)))
    page = Page(page_without_foldings(circuit))
    assert len(page.with_class("picture")) == 1
    assert bool(page.with_class("triangles")) == (GRIDS[grid].edges_per_cell == 3)
    assert [text for tag, text in page.texts if tag == "text"] == list(map(str, range(12)))


def test_the_page_of_a_design_lists_its_parts(computed):
    (shown,) = computed.foldings
    page = Page(render_design(computed))
    texts = [text for tag, text in page.texts if tag == "caption"]
    assert texts == ["What the simulation leaves out", "Panels", "Hinges", "Springs"]
    assert any(tag == "summary" and "8 panels of 213.2 g together" in text for tag, text in page.texts)
    lengths = [text for tag, text in page.texts if tag == "td"]
    assert {"linear:0.1", "valley", "mountain", f"{1e3 * shown.bill.panels[0].mass:.4g}"} <= set(lengths)


@pytest.mark.parametrize(("seconds", "words"), [(0.9, "open it in 0.9 s,"), (None, "open it, and")])
def test_the_first_sentence_has_the_time_on_which_tolerances_agree(database_file, tmp_path, seconds, words):
    path = str(shutil.copy(database_file, tmp_path))
    trial = Trial(
        *(0, "default", "", "constrained", "deploys", "flat"),
        *(0.01, None, seconds, 0.0, 0.0, "dormand-prince", (), 0.0, 1e-5),
        pairs="hinged",
    )
    with open_database(path, create=False) as opened:
        number, name = select(opened, "grid=hex n=8 untwisted", columns="id,circuit").rows[0]
        (crease,) = select(opened, f"design_id={number} untwisted", columns="crease", view="foldings").rows[0]
        judge(opened, [(name, crease, "deploys", 10.0, seconds)], trials=[trial])
    data = page_of(path, number, name)
    assert data.foldings[0].motions[0].title == "Motion by springs"
    assert words in data.sentence


@pytest.mark.parametrize(
    ("status", "seconds", "end"),
    [
        ("deploys", 0.7323, "Springs alone open it in 0.732 s, and its panels are certified not to collide."),
        ("deploys", None, "Springs alone open it, and its panels are certified not to collide."),
        ("movable", 1.0, "A path on which its panels do not collide is proved: motors can open it."),
        ("locked", None, "It is proved locked: it cannot open."),
        ("not_judged", None, "Whether it opens has not been judged."),
    ],
)
def test_the_first_sentence_says_whether_a_design_opens(computed, status, seconds, end):
    panel = default_panel("hex")
    sentence = design_sentence(FOLDING.circuit, panel, status, computed.foldings[0].room, seconds)
    start = "10 regular hexagons of 50x50x6 mm form a closed loop, which folds into two stacks of 173.2 x 100 x 30 mm"
    assert sentence == f"{start} together. {end}"
    assert design_sentence(FOLDING.circuit, panel, "no_folding", None).endswith("does not fold into two stacks.")
