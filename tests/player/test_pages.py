"""Pages of motions: whole in themselves, nothing in them can run but their one script."""

import base64
import hashlib
import json
import re
from dataclasses import replace
from html import unescape
from html.parser import HTMLParser
from pathlib import Path

import pytest

from hcsearch.web.player import motion_json, notebook_html, payload_of, player_html, player_script
from tests.player.motions import replay_of

JS = Path(__file__).parents[2] / "hcsearch" / "web" / "player" / "js"
HOSTILE = "</script><script>alert(1)</script><!-- \" ' & <b>"


@pytest.fixture(scope="module")
def replay():
    return replay_of("unit-ii")


class Tags(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict]] = []

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))


def test_the_policy_admits_the_script_and_the_style_of_the_page(replay):
    page = player_html(replay)
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', page)[1]
    for kind, text in (
        ("script", re.search(r"<script>(.*?)</script>", page, re.DOTALL)[1]),
        ("style", re.search(r"<style>(.*?)</style>", page, re.DOTALL)[1]),
    ):
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        assert f"{kind}-src 'sha256-{digest}'" in policy
    assert policy.startswith("default-src 'none'")
    assert "unsafe" not in policy


def test_a_page_asks_for_nothing(replay):
    reader = Tags()
    reader.feed(player_html(replay))
    assert [tag for tag, _ in reader.tags if tag == "script"] == ["script", "script"]
    attributes = {name for _, attrs in reader.tags for name in attrs}
    assert not attributes & {"src", "href", "action", "style"}
    assert not [name for name in attributes if name.startswith("on")]


def test_no_text_of_a_motion_ends_its_element(replay):
    hostile = replace(replay, title=HOSTILE, source=HOSTILE)
    page = player_html(hostile)
    assert "alert(1)" in page
    assert page.count("<script") == 2
    assert page.count("</script>") == 2
    data = re.search(r'<script type="application/json" id="motion">(.*?)</script>', page, re.DOTALL)[1]
    assert json.loads(data) == json.loads(json.dumps(payload_of(hostile)))
    assert data == motion_json(hostile)


def test_a_notebook_shows_the_page_in_a_frame(replay):
    frame = notebook_html(replay)
    reader = Tags()
    reader.feed(frame)
    ((tag, attributes),) = reader.tags
    assert tag == "iframe"
    assert attributes["sandbox"] == "allow-scripts allow-downloads"
    assert attributes["srcdoc"] == player_html(replay)
    assert unescape(attributes["title"]) == replay.title


def test_the_script_makes_no_request_and_runs_no_text():
    script = player_script()
    for word in ("fetch(", "XMLHttpRequest", "WebSocket", "eval(", "Function(", "import(", "innerHTML", "EventSource"):
        assert word not in script
    assert "http" not in script.replace("http://www.w3.org/2000/svg", "").replace("https://unlicense.org", "").replace(
        "https://github.com/oframe/ogl", ""
    )


def test_the_script_carries_the_licence_of_what_is_bundled():
    licence = (JS / "LICENSE-ogl.txt").read_text(encoding="utf-8").strip()
    assert "the Unlicense" in licence
    assert licence in player_script()


def test_versions_of_what_is_bundled_are_pinned():
    package = json.loads((JS / "package.json").read_text(encoding="utf-8"))
    lock = json.loads((JS / "package-lock.json").read_text(encoding="utf-8"))["packages"]
    for name, version in (package["dependencies"] | package["devDependencies"]).items():
        assert re.fullmatch(r"\d+\.\d+\.\d+", version)
        assert lock[f"node_modules/{name}"]["version"] == version
    assert f"OGL {package['dependencies']['ogl']}" in player_script()
