"""Motions on the pages, in a real browser with the pages' own policies. Needs chromium."""

from dataclasses import replace

import pytest

from hcsearch.designs.folding import Folding
from hcsearch.web.player import payload_of
from hcsearch.web.report.design_data import fetch_design_data
from hcsearch.web.report.page_files import render_design, render_report
from tests.player.browser import TWO_FRAMES, chromium
from tests.player.motions import replay_of

pytestmark = pytest.mark.extra

FOLDING = Folding.from_notation("hex:0234550132:4")


@pytest.fixture(scope="module")
def tab(tmp_path_factory):
    with chromium(tmp_path_factory.mktemp("browser") / "profile") as opened:
        yield opened


def show(tab, text: str, folder, width: int = 1300):
    tab.call("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=False)
    path = folder / "page.html"
    path.write_text(text, encoding="utf-8")
    tab.events.clear()
    tab.open(path.as_uri())
    tab.value(TWO_FRAMES)
    return path


def mounted(tab, place: str) -> bool:
    shadow = f"document.querySelector('{place}').firstElementChild?.shadowRoot"
    return tab.value(f"Boolean({shadow}?.querySelector('canvas'))")


def test_a_dialog_plays_the_path_of_the_folding_that_is_drawn(tab, hex_ten, tmp_path):
    (number,) = [design["id"] for design in hex_ten.designs if design["circuit"] == FOLDING.circuit.notation]
    payload = payload_of(replay_of("hex:0234550132:4"))
    data = replace(
        hex_ten, best={number: 4}, players={(number, 4): payload}, scene="solar", database_option=" --db x.db"
    )
    path = show(tab, render_report(data), tmp_path)
    tab.value(
        f"document.getElementById('find').value = '#{number}';"
        "document.getElementById('find').dispatchEvent(new Event('input', {bubbles: true}));"
        "document.querySelector('.gallery .thumb').click();"
    )
    tab.value(TWO_FRAMES)
    assert mounted(tab, "dialog .player")
    shown = tab.value("document.querySelector('dialog').textContent")
    assert f"hcsearch show {number} --html --scene 'solar' --db x.db" in shown
    other = "document.querySelector('dialog .fold[aria-pressed=false]').click()"
    tab.value(other)
    assert tab.value("document.querySelector('dialog .player').hidden")
    tab.value("document.querySelector('dialog .close').click()")
    assert tab.complaints == []
    assert tab.requests == [path.as_uri()]


@pytest.mark.parametrize("width", [1300, 390])
def test_the_page_of_a_design_plays_its_motions_and_asks_for_nothing(tab, tmp_path, width):
    text = render_design(fetch_design_data(FOLDING.circuit, [FOLDING], "none.sqlite", None, 0))
    path = show(tab, text, tmp_path, width)
    for k in (0, 1):
        tab.value(f"document.querySelector('[data-motion=\"{k}\"]').scrollIntoView()")
        tab.until(f"Boolean(document.querySelector('[data-motion=\"{k}\"]').dataset.mounted)")
        tab.value(TWO_FRAMES)
        assert mounted(tab, f'[data-motion="{k}"]')
    assert tab.value("document.documentElement.scrollWidth") <= width
    assert tab.complaints == []
    assert tab.requests == [path.as_uri()]


def test_motions_that_were_never_seen_are_printed(tab, tmp_path):
    text = render_design(fetch_design_data(FOLDING.circuit, [FOLDING], "none.sqlite", None, 0))
    show(tab, text, tmp_path)
    tab.value("dispatchEvent(new Event('beforeprint'))")
    stills = "p.firstElementChild.shadowRoot.querySelectorAll('.stills canvas').length"
    assert tab.value(f"[...document.querySelectorAll('.player')].map((p) => {stills})") == [5, 5, 5]
    assert tab.complaints == []
