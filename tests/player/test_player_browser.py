"""The player in a real browser. Needs chromium: without it these tests fail, they are not skipped."""

import base64
import io
import json
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.image import imread

from hcsearch.web.player import motion_json, payload_of, player_html, player_script
from hcsearch.web.player.player_page import NOTEBOOK_FRAME_HEIGHT
from tests.player.browser import TWO_FRAMES, chromium
from tests.player.motions import replay_of, twin_poses

pytestmark = pytest.mark.extra

FOLDING, COLLIDES = "hex:0234550132:4", "thesis-4x4"

# Counts contexts as pages ask for them, and stands before any script of a page.
COUNTING = """
window.contexts = [];
const ask = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
  if (kind.startsWith('webgl') && !window.contexts.includes(this)) window.contexts.push(this);
  return ask.call(this, kind, ...more);
};
"""
ROOT = "document.querySelector('#player > div').shadowRoot"


@pytest.fixture(scope="module")
def tab(tmp_path_factory):
    with chromium(tmp_path_factory.mktemp("browser") / "profile") as opened:
        opened.call("Page.addScriptToEvaluateOnNewDocument", source=COUNTING)
        yield opened


def show(tab, page: str, folder, *, width=1200, still=True, dark=False):
    """Open a page, in a window of some width, in light or dark; still : for a reader who prefers less motion."""
    features = {
        "prefers-reduced-motion": "reduce" if still else "no-preference",
        "prefers-color-scheme": "dark" if dark else "light",
    }
    media = [{"name": name, "value": value} for name, value in features.items()]
    tab.call("Emulation.setEmulatedMedia", features=media)
    tab.call("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=False)
    path = folder / "page.html"
    path.write_text(page, encoding="utf-8")
    tab.events.clear()
    tab.open(path.as_uri())
    tab.value(TWO_FRAMES)
    return path


def bare(name: str) -> str:
    """A page with the player's script and a motion, of which the test mounts what it wants."""
    return (
        '<!DOCTYPE html><meta charset="utf-8"><div id="player"></div><div id="other"></div>'
        f'<script type="application/json" id="motion">{motion_json(replay_of(name))}</script>'
        f"<script>{player_script()}</script>"
    )


MOUNT = (
    "window.handle = hcsearchPlayer.mount(document.getElementById('player'), "
    "document.getElementById('motion').textContent, %s)"
)


def picture(tab, query: str = ".stage canvas") -> np.ndarray:
    """What is on a canvas of the player."""
    return image(tab.value(f"{ROOT}.querySelector({json.dumps(query)}).toDataURL()"))


def image(url: str) -> np.ndarray:
    return imread(io.BytesIO(base64.b64decode(url.partition(",")[2])))


def differ(one: np.ndarray, two: np.ndarray) -> float:
    """The share of pixels that differ."""
    return float((np.abs(one - two).max(axis=2) > 0.05).mean())


def test_a_motion_plays_to_its_end_without_a_complaint_or_a_request(tab, tmp_path):
    path = show(tab, player_html(replay_of(FOLDING)), tmp_path, still=False)
    first = picture(tab)
    tab.value(f"(s => {{ s.value = '4'; s.dispatchEvent(new Event('change')); }})({ROOT}.querySelector('select'))")
    tab.until(f"Number({ROOT}.querySelector('input').value) > 300")
    middle = picture(tab)
    tab.until(f"{ROOT}.querySelector('.go').getAttribute('aria-label') === 'Play again'")
    last = picture(tab)
    assert min(differ(first, middle), differ(middle, last), differ(first, last)) > 0.03
    # valley blue is on the array that lies flat, and the packed stacks show none of it
    red, green, blue = last[..., 0], last[..., 1], last[..., 2]
    assert ((blue > 0.7) & (red < 0.35) & (green < 0.55)).sum() > 200
    assert tab.complaints == []
    assert tab.requests == [path.as_uri()]
    assert tab.value("window.contexts.length") == 1


def test_an_exploded_view_shows_what_lies_between_packed_panels_and_leaves_the_motion(tab, tmp_path):
    show(tab, player_html(replay_of(FOLDING)), tmp_path)
    box = f"[...{ROOT}.querySelectorAll('label')].find((one) => one.textContent === 'Exploded view').firstElementChild"
    told = f"[{ROOT}.querySelector('.place').textContent, {ROOT}.querySelector('.tag').textContent]"

    def toggled():
        tab.value(f"{box}.focus()")
        tab.press(" ", "Space", " ")
        tab.value(TWO_FRAMES)
        return picture(tab), tab.value(told)

    def hinges(shot):
        red, green, blue = (shot[..., k] for k in range(3))
        return ((red > 0.6) & (green < 0.35) & (blue < 0.4)).sum() + ((blue > 0.7) & (red < 0.4) & (green < 0.6)).sum()

    assert not tab.value(f"{box}.checked")
    packed, words = picture(tab), tab.value(told)
    apart, same_words = toggled()
    assert hinges(apart) > 2 * hinges(packed)
    assert same_words == words
    for edge in (apart[0], apart[-1], apart[:, 0], apart[:, -1]):  # all of it is in the picture
        assert not edge[..., 3].any()
    again, _ = toggled()
    assert differ(packed, again) == 0.0
    assert tab.complaints == []


def test_no_motion_begins_by_itself_for_who_prefers_less(tab, tmp_path):
    show(tab, player_html(replay_of(FOLDING)), tmp_path, still=True)
    before = picture(tab)
    tab.value("new Promise(done => setTimeout(() => done(1), 300))")
    assert differ(before, picture(tab)) == 0.0
    assert tab.value(f"{ROOT}.querySelector('.go').getAttribute('aria-label')") == "Play"


def test_keys_play_step_jump_and_zoom(tab, tmp_path):
    show(tab, player_html(replay_of(FOLDING)), tmp_path)
    slider = f"Number({ROOT}.querySelector('input').value)"
    tab.value(f"{ROOT}.querySelector('.stage').focus()")
    tab.press("End")
    tab.until(f"{slider} === 1000")
    far = picture(tab)
    tab.press("+", "Equal", "+")
    tab.value(TWO_FRAMES)
    assert (picture(tab)[..., 3] > 0.5).mean() > 1.1 * (far[..., 3] > 0.5).mean()
    tab.press("0", "Digit0", "0")
    tab.value(TWO_FRAMES)
    assert differ(far, picture(tab)) < 1e-3
    tab.press("Home")
    tab.until(f"{slider} === 0")
    tab.press("ArrowRight")
    tab.until(f"{slider} === 10")
    tab.press(" ", "Space", " ")
    tab.until(f"{slider} > 20")
    tab.press(" ", "Space", " ")
    assert tab.value(f"{ROOT}.querySelector('.go').getAttribute('aria-label')") in ("Play", "Pause")
    tab.value(TWO_FRAMES)
    assert tab.value(f"{ROOT}.querySelector('.go').getAttribute('aria-label')") == "Play"
    assert tab.complaints == []


def test_a_drag_turns_the_picture_and_all_of_it_stays_in_the_frame(tab, tmp_path):
    show(tab, player_html(replay_of(FOLDING)), tmp_path)
    before = picture(tab)
    tab.mouse("mousePressed", 600, 250, button="left", clickCount=1)
    for k in range(1, 9):
        tab.mouse("mouseMoved", 600 + 40 * k, 250 + 10 * k, button="left", buttons=1)
    tab.mouse("mouseReleased", 920, 330, button="left", clickCount=1)
    for share in range(0, 1001, 125):
        tab.value(
            f"(i => {{ i.value = {share}; i.dispatchEvent(new Event('input')); }})({ROOT}.querySelector('input'))"
        )
        tab.value(TWO_FRAMES)
        cover = picture(tab)[..., 3] > 0.5
        assert cover.sum() > 2000
        assert not np.concatenate([cover[0], cover[-1], cover[:, 0], cover[:, -1]]).any()
    tab.press("Home")
    tab.value(TWO_FRAMES)
    assert differ(before, picture(tab)) > 0.02


def test_the_panels_are_in_the_middle_of_the_picture_all_the_time(tab, tmp_path):
    show(tab, bare(FOLDING), tmp_path)
    tab.value(MOUNT % "{}")
    for share in (0, 0.3, 0.6, 1):
        cover = image(tab.value(f"handle.still({share}, 400, 300)"))[..., 3] > 0.5
        assert np.argwhere(cover).mean(axis=0) == pytest.approx([150, 200], abs=45)


def test_a_drag_with_shift_shifts_the_picture(tab, tmp_path):
    show(tab, player_html(replay_of(FOLDING)), tmp_path)
    before = picture(tab)[..., 3] > 0.5
    tab.mouse("mousePressed", 600, 250, button="left", clickCount=1, modifiers=8)
    tab.mouse("mouseMoved", 500, 210, button="left", buttons=1, modifiers=8)
    tab.mouse("mouseReleased", 500, 210, button="left", clickCount=1, modifiers=8)
    tab.value(TWO_FRAMES)
    after = picture(tab)[..., 3] > 0.5
    middles = [np.argwhere(cover).mean(axis=0) for cover in (before, after)]
    assert middles[1] - middles[0] == pytest.approx([-40, -100], abs=25)


def test_two_fingers_zoom_and_the_wheel_does_where_the_picture_has_the_focus(tab, tmp_path):
    show(tab, player_html(replay_of(FOLDING)), tmp_path)

    def cover() -> float:
        tab.value(TWO_FRAMES)
        return float((picture(tab)[..., 3] > 0.5).mean())

    first = cover()
    tab.mouse("mouseWheel", 600, 300, deltaX=0, deltaY=-300)
    assert cover() == first
    for k, kind in enumerate(["touchStart", "touchMove", "touchMove", "touchMove"]):
        points = [{"x": 600 + side * (60 + 40 * k), "y": 300, "id": side + 1} for side in (-1, 1)]
        tab.call("Input.dispatchTouchEvent", type=kind, touchPoints=points)
    tab.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
    near = cover()
    assert near > 1.5 * first
    # a finger has given the picture the focus
    tab.mouse("mouseWheel", 600, 300, deltaX=0, deltaY=300)
    assert cover() < 0.9 * near


def test_panels_are_where_python_places_them(tab, tmp_path):
    for name in (FOLDING, COLLIDES, "unit-ii"):
        payload = payload_of(replay_of(name))
        show(tab, bare(name), tmp_path)
        for share in (0.0, 0.37, 0.8, 1.0):
            at = payload["at"][0] + share * (payload["at"][-1] - payload["at"][0])
            data = "JSON.parse(document.getElementById('motion').textContent)"
            placed = np.array(tab.value(f"Array.from(hcsearchPlayer.poses({data}, {at}))")).reshape(-1, 3, 4)
            assert placed == pytest.approx(twin_poses(payload, at)[:, :3], abs=1e-9)


def test_a_page_has_one_webgl_context_and_plays_one_motion_at_a_time(tab, tmp_path):
    show(tab, bare(FOLDING), tmp_path)
    tab.value(MOUNT % "{}")
    tab.value(MOUNT.replace("handle", "second").replace("'player'", "'other'") % "{at: 1}")
    tab.value("handle.play(); second.play()")
    assert tab.value("[handle.playing, second.playing]") == [False, True]
    tab.value("handle.play()")
    assert tab.value("[handle.playing, second.playing]") == [True, False]
    tab.value("handle.pause(); handle.seek(0); second.seek(0.7)")
    tab.value(TWO_FRAMES)
    assert tab.value("window.contexts.length") == 1
    other = ROOT.replace("#player", "#other")
    one, two = (image(tab.value(f"{root}.querySelector('.stage canvas').toDataURL()")) for root in (ROOT, other))
    assert differ(one, two) > 0.05
    assert min((one[..., 3] > 0.5).sum(), (two[..., 3] > 0.5).sum()) > 2000
    tab.value("handle.dispose(); second.seek(0.5)")
    tab.value(TWO_FRAMES)
    assert tab.value("document.getElementById('player').childElementCount") == 0
    assert differ(two, image(tab.value(f"{other}.querySelector('.stage canvas').toDataURL()"))) > 0.05
    assert tab.complaints == []


def test_a_still_has_the_size_asked_for_and_colours_of_its_mode(tab, tmp_path):
    show(tab, bare(FOLDING), tmp_path)
    tab.value(MOUNT % "{colour: 'panel'}")
    panel = image(tab.value("handle.still(1, 300, 200)"))
    assert panel.shape == (200, 300, 4)
    tab.value("handle.colourBy('stack')")
    stack = image(tab.value("handle.still(1, 300, 200)"))
    tab.value("handle.colourBy('nearest')")
    near = image(tab.value("handle.still(0.4, 300, 200)"))
    assert differ(panel, stack) > 0.1
    # the two panels that are nearest are orange, the others grey
    red, _, blue = near[..., 0], near[..., 1], near[..., 2]
    assert ((red - blue > 0.3) & (near[..., 3] > 0.5)).sum() > 100
    assert "nearest: panels 1 and 9" in tab.value(f"handle.seek(0.4), {TWO_FRAMES}.then(() => {ROOT}.textContent)")
    assert tab.value("try { handle.colourBy('mood'); 0 } catch (error) { error.message }") == (
        "panels have no colours by mood"
    )


def test_a_collision_and_certified_intervals_are_marked_on_the_slider(tab, tmp_path):
    replay = replay_of(COLLIDES)
    show(tab, player_html(replay), tmp_path)
    when, (one, two) = replay.collision
    share = when / replay.at[-1]
    box = "(e => { const r = e.getBoundingClientRect(); return [r.left, r.right]; })"
    left, right = tab.value(f"{box}({ROOT}.querySelector('.track'))")
    band = tab.value(f"{box}({ROOT}.querySelector('.track i'))")
    mark = tab.value(f"{box}({ROOT}.querySelector('.track b'))")
    assert band == pytest.approx([left, left + share * (right - left)], abs=1.0)
    assert np.mean(mark) == pytest.approx(left + share * (right - left), abs=1.0)
    text = tab.value(f"{ROOT}.textContent")
    assert f"Panels {one} and {two} collide at {when:.3f} s." in text
    assert "States between the" in text
    assert "interpolated; a hinge is off by 0.12° at most." in text
    assert f"panels {one} and {two} collided" not in text
    tab.value(f"{ROOT}.querySelector('.stage').focus()")
    tab.press("End")
    tab.until(f"{ROOT}.querySelector('.tag').textContent.includes('panels {one} and {two} collided at')")


@pytest.mark.parametrize("dark", [False, True])
def test_paper_has_five_stills_in_place_of_the_picture(tab, tmp_path, dark):
    show(tab, player_html(replay_of(FOLDING)), tmp_path, dark=dark)
    assert tab.value(f"{ROOT}.querySelectorAll('.stills canvas').length") == 0
    printed = base64.b64decode(tab.call("Page.printToPDF")["data"])
    assert printed.startswith(b"%PDF")
    stills = [picture(tab, f".stills figure:nth-child({k}) canvas") for k in range(1, 6)]
    assert all(differ(one, two) > 0.02 for one, two in pairwise(stills))
    tab.call("Emulation.setEmulatedMedia", media="print")
    shown = f"(name => getComputedStyle({ROOT}.querySelector(name)).display)"
    assert tab.value(f"['.view', '.bar', '.tools', '.stills'].map({shown})") == ["none", "none", "none", "grid"]
    tab.call("Emulation.setEmulatedMedia", media="")
    assert tab.complaints == []


def test_named_views_look_from_the_top_and_from_the_front(tab, tmp_path):
    show(tab, bare(FOLDING), tmp_path)
    tab.value(MOUNT % "{at: 1}")

    def height(name: str) -> float:
        tab.value(f"[...{ROOT}.querySelectorAll('.looks button')].find(b => b.textContent === '{name}').click()")
        rows = np.flatnonzero((image(tab.value("handle.still(1, 400, 300)"))[..., 3] > 0.5).any(axis=1))
        return float(rows[-1] - rows[0])

    assert height("Top") > 8 * height("Front") > 0  # ten hexagons of 50 mm that are 6 mm thick


def test_a_motion_in_a_loop_begins_again(tab, tmp_path):
    show(tab, bare(FOLDING), tmp_path, still=False)
    tab.value(MOUNT % "{at: 0.95, loop: true}")
    tab.value("handle.setSpeed(4); handle.play()")
    tab.until("handle.at === 1")
    tab.until("handle.playing && handle.at > 0 && handle.at < 0.5")


def test_a_saved_picture_is_a_file_named_by_the_motion(tab, tmp_path):
    show(tab, bare(FOLDING), tmp_path)
    tab.value(MOUNT % "{at: 0.25}")
    tab.value("HTMLAnchorElement.prototype.click = function () { window.saved = [this.download, this.href]; }")
    tab.value(f"[...{ROOT}.querySelectorAll('button')].find(b => b.textContent === 'Save picture').click()")
    tab.until("Boolean(window.saved)")
    name, address = tab.value("window.saved")
    assert name == "hex-0234550132-4-25.0.png"
    assert address.startswith("blob:")
    assert tab.complaints == []


def test_panels_and_hinges_are_pointed_out_in_both_directions(tab, tmp_path):
    show(tab, bare(FOLDING), tmp_path)
    tab.value("window.seen = []")
    tab.value(MOUNT % "{at: 1, moved: (at) => { window.place = at; }, pointed: (panel) => window.seen.push(panel)}")
    plain = image(tab.value("handle.still(1, 400, 300)"))
    tab.value("handle.mark({hinges: [0]})")
    hinge = image(tab.value("handle.still(1, 400, 300)"))
    tab.value("handle.mark({panels: [0]})")
    panel = image(tab.value("handle.still(1, 400, 300)"))
    assert 0.001 < differ(plain, hinge) < differ(plain, panel) < 0.2
    tab.value(f"{ROOT}.querySelectorAll('.looks button')[0].click(), {TWO_FRAMES}")
    left, top, width, height = tab.value(
        f"(r => [r.left, r.top, r.width, r.height])({ROOT}.querySelector('.stage').getBoundingClientRect())"
    )
    tab.mouse("mouseMoved", left + 0.46 * width, top + 0.5 * height)
    tab.mouse("mouseMoved", left + 0.01 * width, top + 0.02 * height)
    panels = tab.value("window.seen")
    assert panels[-1] is None
    assert panels[0] in range(10)
    tab.value(f"handle.seek(0.5), {TWO_FRAMES}")
    assert tab.value("window.place") == 0.5


def test_numbers_that_could_be_read_upside_down_are_underlined(tab, tmp_path):
    show(tab, bare(FOLDING), tmp_path)
    tab.value(
        "window.bars = []; const fill = CanvasRenderingContext2D.prototype.fillRect;"
        "const write = CanvasRenderingContext2D.prototype.fillText;"
        "CanvasRenderingContext2D.prototype.fillText = function (text, ...more) {"
        " window.text = text; write.call(this, text, ...more); };"
        "CanvasRenderingContext2D.prototype.fillRect = function (...more) {"
        " window.bars.push(window.text); fill.apply(this, more); };"
    )
    tab.value(MOUNT % "{numbers: true}")
    assert tab.value("window.bars") == ["6", "9"]


@pytest.mark.parametrize("width", [800, 1100])
def test_a_frame_of_a_notebook_cuts_nothing(tab, tmp_path, width):
    show(tab, player_html(replay_of(FOLDING)), tmp_path, width=width)
    tab.call(
        "Emulation.setDeviceMetricsOverride",
        width=width,
        height=NOTEBOOK_FRAME_HEIGHT,
        deviceScaleFactor=1,
        mobile=False,
    )
    tab.value(TWO_FRAMES)
    assert tab.value("document.documentElement.scrollHeight") <= NOTEBOOK_FRAME_HEIGHT
    assert tab.value(f"{ROOT}.querySelector('.stage').clientHeight") > 240


def test_a_narrow_window_holds_all_of_it(tab, tmp_path):
    show(tab, player_html(replay_of(COLLIDES)), tmp_path, width=390, dark=True)
    assert tab.value("document.documentElement.scrollWidth") <= 390
    small = f"[...{ROOT}.querySelectorAll('button, select')].filter(e => e.getBoundingClientRect().height < 38).length"
    assert tab.value(small) == 0
    assert tab.value(f"{ROOT}.querySelector('.player').classList.contains('dark')")


def test_without_webgl_a_sentence_says_so_and_the_motion_is_drawn(tmp_path):
    with chromium(tmp_path / "profile", "--disable-3d-apis") as tab:
        show(tab, player_html(replay_of(FOLDING)), tmp_path)
        assert "This browser shows no WebGL" in tab.value(f"{ROOT}.querySelector('p:not([hidden]).source').textContent")
        first = picture(tab)
        tab.value(f"{ROOT}.querySelector('.stage').focus()")
        tab.press("End")
        tab.value(TWO_FRAMES)
        assert differ(first, picture(tab)) > 0.05
        assert tab.complaints == []


def test_a_lost_context_is_made_good(tab, tmp_path):
    show(tab, bare(FOLDING), tmp_path)
    tab.value(MOUNT % "{at: 1}")
    before = picture(tab)
    tab.value("window.contexts[0].getContext('webgl2').getExtension('WEBGL_lose_context').loseContext()")
    tab.value("handle.seek(0.9), new Promise(done => setTimeout(() => done(1), 200))")
    after = picture(tab)
    assert (after[..., 3] > 0.5).sum() > 0.7 * (before[..., 3] > 0.5).sum()
