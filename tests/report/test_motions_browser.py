"""Motions on the pages, in a real browser with the pages' own policies. Needs chromium."""

from dataclasses import replace

import pytest

from hcsearch.designs.folding import Folding
from hcsearch.web.player import payload_of
from hcsearch.web.report.page_files import render_design, render_report
from tests.player.browser import TWO_FRAMES, chromium
from tests.player.motions import replay_of
from tests.report.pages import computed_data

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
    shadow = f"document.querySelector('{place} > :not(.moves)')?.shadowRoot"
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


@pytest.fixture(scope="module")
def design_page():
    return render_design(computed_data(FOLDING))


@pytest.mark.parametrize("width", [1300, 390])
def test_the_page_of_a_design_plays_its_motions_and_asks_for_nothing(tab, design_page, tmp_path, width):
    path = show(tab, design_page, tmp_path, width)
    player = tab.value("document.querySelector('.player').getBoundingClientRect().top")
    assert 0 < player < 450  # on the first screen
    for k in (0, 1):
        tab.value(f"document.querySelector('[data-motion=\"{k}\"]').scrollIntoView()")
        tab.until(f"document.querySelector('[data-motion=\"{k}\"]').childElementCount === 1")
        tab.value(TWO_FRAMES)
        assert mounted(tab, f'[data-motion="{k}"]')
    assert tab.value("document.documentElement.scrollWidth") <= width
    assert tab.complaints == []
    assert tab.requests == [path.as_uri()]


SLIDER = "Number(document.querySelector('.player > :not(.moves)').shadowRoot.querySelector('input').value)"


def test_plots_move_with_the_player_and_a_click_in_a_plot_moves_it(tab, design_page, tmp_path):
    show(tab, design_page, tmp_path)
    tab.until(f"{SLIDER} > 20")  # it plays at once
    cursors = tab.value(
        "[...document.querySelectorAll('.first .cursor')].map((line) => line.getAttribute('transform'))"
    )
    assert len(cursors) == 3
    assert len(set(cursors)) == 1
    tab.value("document.querySelector('.first .plot').scrollIntoView({block: 'center'})")
    box = "(r => [r.left, r.top, r.width, r.height])(document.querySelector('.first .plot').getBoundingClientRect())"
    left, top, width, height = tab.value(box)
    place = left + (74 + 0.75 * (468 - 74)) / 480 * width
    tab.value("document.querySelector('.player > :not(.moves)').shadowRoot.querySelector('.go').click()")
    tab.mouse("mousePressed", place, top + 0.5 * height, button="left", clickCount=1)
    tab.mouse("mouseReleased", place, top + 0.5 * height, button="left", clickCount=1)
    tab.until(f"Math.abs({SLIDER} - 750) < 5")
    assert tab.complaints == []


def test_exploded_views_stay_in_the_address(tab, design_page, tmp_path):
    path = show(tab, design_page, tmp_path)
    labels = "document.querySelectorAll('.player > :not(.moves)')[{}]?.shadowRoot?.querySelectorAll('label') ?? []"
    box = f"[...{labels}].find((one) => one.textContent === 'Exploded view')?.firstElementChild"
    for k, told in ((1, "#exploded=1"), (0, "#exploded=1%2C0")):
        tab.value(f"document.querySelectorAll('.player')[{k}].scrollIntoView()")
        tab.until(f"Boolean({box.format(k)})")
        tab.value(f"{box.format(k)}.click()")
        assert tab.value("location.hash") == told
    tab.open("about:blank")  # else only the part after # would change
    tab.open(f"{path.as_uri()}#exploded=1")
    for k in (0, 1):
        tab.value(f"document.querySelectorAll('.player')[{k}].scrollIntoView()")
        tab.until(f"Boolean({box.format(k)})")
        assert tab.value(f"{box.format(k)}.checked") == (k == 1)
    tab.value(f"{box.format(1)}.click()")
    assert tab.value("location.hash") == ""
    assert tab.complaints == []


def test_a_hinge_is_pointed_out_in_picture_and_plots(tab, design_page, tmp_path):
    show(tab, design_page, tmp_path)
    tab.value(
        "(s => { s.value = 'hinge 3'; s.dispatchEvent(new Event('change')); })(document.querySelector('.pick select'))"
    )
    assert tab.value("[...document.querySelectorAll('.part.on')].map((part) => part.dataset.hinge)") == ["3"]
    shown = (
        "[...document.querySelectorAll('.first .line[data-hinges]:not(.off) title')].map((title) => title.textContent)"
    )
    assert tab.value(shown) == ["crease 3"]
    over = "dispatchEvent(new PointerEvent('pointerover', {bubbles: true}))"
    tab.value(f"document.querySelector('.part[data-panel=\"4\"]').{over}")
    assert tab.value("[...document.querySelectorAll('.part.on')].map((part) => part.dataset.panel)") == ["4"]
    # panels 4 and 5 are one here, with the creases 3 and 5
    assert {"crease 3", "crease 5"} <= set(tab.value(shown))
    tab.value("document.querySelector('.part').dispatchEvent(new PointerEvent('pointerout', {bubbles: true}))")
    assert tab.value("document.querySelectorAll('.part.on, .off').length") == 0
    assert tab.complaints == []


def test_motions_that_were_never_seen_are_printed_and_folded_parts_are_opened(tab, design_page, tmp_path):
    show(tab, design_page, tmp_path)
    closed = "document.querySelectorAll('details:not([open])').length"
    before = tab.value(closed)
    tab.value("dispatchEvent(new Event('beforeprint'))")
    assert (before, tab.value(closed)) == (3, 0)
    stills = "p.querySelector(':scope > :not(.moves)').shadowRoot.querySelectorAll('.stills canvas').length"
    assert tab.value(f"[...document.querySelectorAll('.player')].map((p) => {stills})") == [5, 5, 5]
    tab.value("dispatchEvent(new Event('afterprint'))")
    assert tab.value(closed) == before
    assert tab.complaints == []
