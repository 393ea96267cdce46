import json
import re
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hcsearch.web.player.player_page import as_script
from hcsearch.web.report.data import FunnelStage, ReportData
from hcsearch.web.report.page_files import census_table, render_report
from hcsearch.web.report.reasons import status_reason
from hcsearch.web.report.script_data import pack_column
from tests.report.pages import Page, column, data_of, unpacked


def test_every_design_and_folding_is_on_the_page(hex_ten):
    data = data_of(render_report(hex_ten))
    assert data["count"] == data["total"] == 120
    for name in ("id", "circuit", "array", "symmetry", "min_twist", "status"):
        assert column(data, "designs", name) == [design[name] for design in hex_ten.designs]
    rows = [(k, row) for k, design in enumerate(hex_ten.designs) for row in hex_ten.foldings[design["id"]]]
    assert column(data, "foldings", "design") == [k for k, _ in rows]
    assert column(data, "foldings", "crease") == [row["crease"] for _, row in rows]
    assert column(data, "foldings", "twist") == [row["twist"] for _, row in rows]


def test_a_page_holds_the_tables_of_its_own_grids_alone(hex_ten):
    kite = {**hex_ten.designs[0], "id": 121, "grid": "kite", "circuit": "kite:1202103030"}
    assert set(data_of(render_report(hex_ten))["grids"]) == {"hex"}
    assert set(data_of(render_report(replace(hex_ten, designs=[*hex_ten.designs, kite])))["grids"]) == {"hex", "kite"}
    assert data_of(render_report(ReportData(title="Nothing")))["grids"] == {}


def test_the_folding_that_the_database_names_is_drawn(hex_ten):
    named = {design["id"]: rows[-1]["crease"] for design in hex_ten.designs if (rows := hex_ten.foldings[design["id"]])}
    assert len(named) == 32
    data = data_of(render_report(replace(hex_ten, best=named)))
    assert unpacked(data["best"], 120) == [named.get(design["id"]) for design in hex_ten.designs]


def test_without_a_named_folding_the_first_untwisted_one_is_drawn(hex_ten):
    for design, best in zip(hex_ten.designs, unpacked(data_of(render_report(hex_ten))["best"], 120), strict=True):
        rows = hex_ten.foldings[design["id"]]
        wanted = [row["crease"] for row in rows if row["untwisted"]] or [row["crease"] for row in rows] or [None]
        assert best == wanted[0]


@pytest.mark.parametrize(
    ("status", "twist", "motion", "tried", "text"),
    [
        (None, 2, None, [], "twist 2: the closed band of panels cannot reach the two stacks"),
        ("locked", 0, None, [], "proved locked at an end of the motion"),
        ("locked", 0, "they are kept apart", [], "they are kept apart"),
        (
            "deploys",
            0,
            "a path",
            ["default", "hinged, bottom first"],
            "flat after 1 s; springs: the stiffest 40 times the softest, bottom first",
        ),
        (
            "deploys",
            0,
            "a path",
            ["default", "spread 8"],
            "springs: set 8 of 8, spread over the scene's range",
        ),
        ("movable", 0, "a path", ["default"], "panels 1 and 5 collide; springs of the scene default"),
        ("movable", 0, "a path", ["default"], "flat pairs rigid; a path"),
        ("undecided", 0, "no path", [], "springs were not tried; no path"),
        ("undecided", 0, None, [], "no path was searched for and no springs were tried in this scene"),
    ],
)
def test_each_folding_says_why_it_has_its_status(status, twist, motion, tried, text):
    rows = [
        {
            "base": "default",
            "scene": scene,
            "status": "deploys" if scene != "default" else "collides",
            "reason": "flat after 1 s" if scene != "default" else "panels 1 and 5 collide",
            "pairs": "rigid",
            "springs": "" if scene == "default" else scene.split(", ")[-1],
        }
        for scene in tried
    ]
    assert text in status_reason({"status": status, "twist": twist}, motion, rows)


@given(st.lists(st.one_of(st.none(), st.integers(-3, 3), st.sampled_from(["deploys", "", "<x>"]))))
def test_a_packed_column_is_the_column(values):
    assert unpacked(json.loads(as_script(pack_column(values))), len(values)) == values


def test_the_funnel_has_numbers_shares_and_gaps(hex_ten):
    texts = [text for _, text in Page(render_report(hex_ten)).texts]
    assert {"1,212", "32", "26.7 %", "not known yet"} <= set(texts)


def test_columns_of_later_stages_appear_when_known(hex_ten):
    later = {"dof": 6, "min_clearance": 0.123456, "deploy_time": 0.38, "deployable": 1, "status": "deploys"}
    later |= {"needed_margin": 0.0123456, "least_gap": -0.00625}
    page = render_report(replace(hex_ten, designs=[{**hex_ten.designs[0], **later}]))
    data = data_of(page)
    assert {name: column(data, "designs", name) for name in later} == {name: [later[name]] for name in later}
    described = {
        quantity["name"]: (quantity["label"], quantity["unit"], quantity["note"]) for quantity in data["quantities"]
    }
    assert described["deploy_time"] == (
        "time to flat",
        "s",
        "time from folded to flat, in the digits on which tolerances agree; null if they differ by over a tenth, s, "
        "lower is better",
    )
    assert described["needed_margin"][:2] == ("needed margin", "mm")
    assert not [label for label, _, _ in described.values() if "_" in label]


def test_nothing_comes_from_outside_the_file(hex_ten):
    page = render_report(hex_ten)
    assert not re.search(
        r"https?:|\bsrc\s*=|url\(|@import|\bhref\s*=|srcset|<(link|iframe|object|embed|base|img)\b", page
    )
    assert "default-src 'none'" in page


def test_a_limit_is_said_clearly(hex_ten):
    page = render_report(replace(hex_ten, designs=hex_ten.designs[:20], total=3120))
    assert "This page holds the first 20 of 3,120 designs" in page
    assert "This page holds" not in render_report(hex_ten)


@pytest.mark.parametrize("hostile", ["</title><script>alert(1)</script>", "\"><img onerror='x'>", "{{ 7 * 7 }}&amp;"])
def test_hostile_text_stays_text(hex_ten, hostile):
    first = {**hex_ten.designs[0], "circuit": hostile, "array": hostile, "status": hostile}
    second = {**hex_ten.designs[1], "array": hostile}
    data = replace(
        hex_ten,
        title=hostile,
        meta=[(hostile, hostile)],
        funnel=[FunnelStage(hostile, 1), FunnelStage(hostile, 1, 2)],
        notes=[hostile],
        designs=[first, second],
    )
    page, plain = Page(render_report(data)), Page(render_report(replace(hex_ten, designs=hex_ten.designs[:2])))
    assert "first" in [attrs.get("id") for _, attrs in page.elements]  # without a picture
    assert page.count("script") == plain.count("script") == 2  # the data and the program
    assert page.count("img") == 0
    assert not [name for _, attrs in page.elements for name in attrs if name.startswith("on")]
    joined = "".join(text for tag, text in page.texts if tag != "script")
    assert joined.count(hostile) >= 5
    data = data_of(render_report(data))
    assert column(data, "designs", "circuit")[0] == column(data, "designs", "status")[0] == hostile
    assert unpacked(data["readable"], 2) == [False, True]


def test_a_report_without_designs_is_a_page():
    page = render_report(ReportData(title="Nothing"))
    assert data_of(page)["count"] == 0
    assert "No design fits." in [text for _, text in Page(page).texts]


def test_a_report_without_foldings_draws_plain_circuits(hex_ten):
    unknown = dict.fromkeys(("n_foldings", "two_stack", "n_untwisted", "untwisted", "min_twist", "status"))
    designs = [{**design, **unknown} for design in hex_ten.designs[:3]]
    text = render_report(replace(hex_ten, designs=designs, foldings={}, census=[(None, None, 3)]))
    data = data_of(text)
    assert (data["folding_count"], unpacked(data["best"], 3)) == (0, [None] * 3)
    assert not Page(text).with_class("census")


def test_designs_without_a_folding_are_not_called_untwisted(hex_ten):
    table = census_table(replace(hex_ten, census=[(0, None, 936), (1, 0, 59), (1, 2, 18), (2, 1, 68), (2, None, 1)]))
    assert table == (
        ["least twist 0", "least twist 1", "least twist 2", "twist not known", "no folding"],
        [(0, [0, 0, 0, 0, 936]), (1, [59, 0, 18, 0, 0]), (2, [0, 68, 0, 1, 0])],
    )
