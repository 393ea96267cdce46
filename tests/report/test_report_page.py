import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from hcsearch.report import FunnelStage, ReportData, render

VOID = {"meta", "input", "path", "circle"}


class Page(HTMLParser):
    """The elements and texts of a page; fails on tags that do not match."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.texts: list[tuple[str, str]] = []
        self.open: list[str] = []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if data.strip():
            self.texts.append((self.open[-1], data.strip()))

    def with_class(self, name: str) -> list[dict[str, str | None]]:
        return [attrs for _, attrs in self.elements if name in (attrs.get("class") or "").split()]

    def count(self, tag: str) -> int:
        return sum(element == tag for element, _ in self.elements)


def test_every_design_and_folding_is_on_the_page(hex_ten):
    page = Page(render(hex_ten))
    assert len(page.with_class("card")) == 120
    assert len(page.with_class("thumb")) == 120
    assert page.count("svg") == 120 + 7  # the legend has seven lines
    assert len(page.with_class("fold")) == sum(map(len, hex_ten.foldings.values()))
    codes = {text for tag, text in page.texts if tag == "code"}
    assert {design["circuit"] for design in hex_ten.designs} <= codes
    assert {design["array"] for design in hex_ten.designs} <= codes
    titles = {text for tag, text in page.texts if tag == "title"}
    assert {design["circuit"] for design in hex_ten.designs} <= titles


def test_filters_find_the_classes_of_the_cards(hex_ten):
    cards = [attrs["class"].split() for attrs in Page(render(hex_ten)).with_class("card")]
    assert sum("two-stack" in names for names in cards) == 32
    assert sum("untwisted" in names for names in cards) == 25


def test_the_best_folding_is_shown(hex_ten):
    page = Page(render(hex_ten))
    shown = [attrs for attrs in page.with_class("fold") if attrs["aria-pressed"] == "true"]
    assert len(shown) == 32
    assert sum("good" in attrs["class"].split() for attrs in shown) == 25
    for attrs in page.with_class("fold"):
        crease, opposite = map(int, re.findall(r"\d+", attrs["title"]))
        assert [k for k, fold in enumerate(attrs["data-letters"]) if fold == "f"] == [crease, opposite]


def test_sort_keys_match_the_buttons_and_null_is_empty(hex_ten):
    page = Page(render(hex_ten))
    names = [text for tag, text in page.texts if tag == "button"]
    columns = [attrs for _, attrs in page.elements if "data-column" in attrs]
    assert [attrs["data-column"] for attrs in columns] == [str(k) for k in range(len(columns))]
    order = names[: len(columns)]
    assert order[0] == "id"
    assert "n" not in order  # all alike
    for attrs, design in zip(page.with_class("card"), hex_ten.designs, strict=True):
        keys = attrs["data-keys"].split(",")
        assert keys == ["" if design[name] is None else str(design[name]) for name in order]


def test_the_funnel_has_numbers_shares_and_gaps(hex_ten):
    texts = [text for _, text in Page(render(hex_ten)).texts]
    assert {"1,212", "32", "26.7 %", "not known yet"} <= set(texts)


def test_columns_of_later_stages_appear_when_known(hex_ten):
    later = {"dof": 6, "min_clearance": 0.123456, "deploy_time": 0.38, "deployable": 1, "status": "deploys"}
    later |= {"needed_margin": 0.0123456, "least_gap": -0.00625}
    page = Page(render(replace(hex_ten, designs=[{**hex_ten.designs[0], **later}])))
    texts = [text for _, text in page.texts]
    assert {"dof", "6", "min_clearance", "0.1235 mm", "deploy_time", "0.38 s", "deploys"} <= set(texts)
    assert {"needed_margin", "0.01235 mm", "least_gap", "-0.00625 mm"} <= set(texts)
    titles = [attrs.get("title") for _, attrs in page.elements]
    assert "smallest gap to which panels come back, at most a panel's size, mm, higher is better" in titles
    assert "time from folded to flat, in the digits that tolerances agree on, s, lower is better" in titles
    assert "deployable" in [attrs.get("value") for _, attrs in page.elements]


def test_nothing_comes_from_outside_the_file(hex_ten):
    page = render(hex_ten)
    assert not re.search(
        r"https?:|\bsrc\s*=|url\(|@import|\bhref\s*=|srcset|<(link|iframe|object|embed|base|img)\b", page
    )
    assert "default-src 'none'" in page


def test_a_limit_is_said_clearly(hex_ten):
    page = render(replace(hex_ten, designs=hex_ten.designs[:20], total=3120))
    assert "This page holds the first 20 of 3,120 designs" in page
    assert "This page holds" not in render(hex_ten)


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
    page, plain = Page(render(data)), Page(render(replace(hex_ten, designs=hex_ten.designs[:2])))
    assert page.count("script") == plain.count("script") == 1
    assert page.count("img") == 0
    assert not [name for _, attrs in page.elements for name in attrs if name.startswith("on")]
    joined = "".join(text for _, text in page.texts)
    assert joined.count(hostile) >= 9


def test_a_report_without_designs_is_a_page():
    page = Page(render(ReportData(title="Nothing")))
    assert not page.with_class("card")
    assert "No design fits." in [text for _, text in page.texts]


def test_a_report_without_foldings_draws_plain_circuits(hex_ten):
    unknown = dict.fromkeys(("n_foldings", "two_stack", "n_untwisted", "untwisted", "min_twist", "status"))
    designs = [{**design, **unknown} for design in hex_ten.designs[:3]]
    page = Page(render(replace(hex_ten, designs=designs, foldings={}, census=[(None, None, 3)])))
    assert len(page.with_class("hinge")) == 3 + 1  # and the legend's
    assert not page.with_class("census")
    assert not page.with_class("chips")
