"""Pages that play a motion: a self-contained file, and a frame for notebooks."""

from __future__ import annotations

import base64
import hashlib
import json
from functools import cache
from html import escape
from importlib.resources import files
from string import Template

from hcsearch.subjects.replay import Replay
from hcsearch.web.player.player_data import payload_of


def as_script(value: object) -> str:
    """Return JSON for a script element, with `<`, `>` and `&` escaped so that no text ends the element."""
    text = json.dumps(value, separators=(",", ":"), allow_nan=False)
    for mark in "<>&":
        text = text.replace(mark, f"\\u{ord(mark):04x}")
    return text


def digest_of(text: str) -> str:
    """Return the base64 SHA-256 by which a content security policy admits a script or a style."""
    return base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii")


NOTEBOOK_FRAME_HEIGHT = 640
"""Height of the frame in a notebook, pixels; the picture takes what the controls and texts leave of it."""

PAGE_COLOURS = """
:root {
  color-scheme: light dark;
  --page: #f3f4f6; --card: #ffffff; --text: #1b1f27; --quiet: #5c6370; --line: #d9dce2; --accent: #1f6f54;
}
@media screen and (prefers-color-scheme: dark) {
  :root {
    --page: #14171c; --card: #1d2128; --text: #e7e9ee; --quiet: #a2a9b6; --line: #343a45; --accent: #63c9a2;
  }
}
"""
"""Style sheet with the colours of pages, light and dark; the player inherits them."""

_STYLE = (
    PAGE_COLOURS
    + """\
* { box-sizing: border-box; }
body { margin: 0; background: var(--page); color: var(--text); font: 15px/1.45 system-ui, sans-serif; }
main { display: flex; flex-direction: column; min-height: 100dvh; max-width: 1080px;
  margin: 0 auto; padding: 20px 24px; }
#player { display: flex; flex-direction: column; flex: 1; }
h1 { margin: 0 0 14px; font-size: 20px; line-height: 1.25; overflow-wrap: anywhere; }
@media (max-width: 520px) { main { padding: 12px; } h1 { font-size: 17px; } }
@media print { :root { --page: #ffffff; } main { max-width: none; min-height: 0; padding: 0; } }
"""
)

_PAGE = Template("""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; script-src 'sha256-$script_hash'; style-src\
 'sha256-$style_hash'; img-src data:; base-uri 'none'; form-action 'none'">
<title>$title</title>
<style>$style</style>
</head>
<body>
<main>
<h1>$title</h1>
<div id="player"><noscript>$source. The motion plays where scripts may run.</noscript></div>
</main>
<script type="application/json" id="motion">$motion</script>
<script>$script</script>
</body>
</html>
""")

_START = """
hcsearchPlayer.mount(
  document.getElementById("player"), document.getElementById("motion").textContent, { autoplay: true, fill: true }
);
"""


def player_html(replay: Replay) -> str:
    """Return a self-contained page that plays a motion; it makes no request, its policy admits only its own script."""
    script = player_script() + _START
    return _PAGE.substitute(
        title=escape(replay.title),
        source=escape(replay.source),
        style=_STYLE,
        style_hash=digest_of(_STYLE),
        motion=motion_json(replay),
        script=script,
        script_hash=digest_of(script),
    )


def notebook_html(replay: Replay) -> str:
    """Return the page of a motion in a sandboxed frame for notebooks, isolated from the notebook's page."""
    return (
        f'<iframe title="{escape(replay.title)}" sandbox="allow-scripts allow-downloads" width="100%" '
        f'height="{NOTEBOOK_FRAME_HEIGHT}" frameborder="0" srcdoc="{escape(player_html(replay))}"></iframe>'
    )


def motion_json(replay: Replay) -> str:
    """Return the plain data of a motion as JSON for a script element."""
    return as_script(payload_of(replay))


@cache
def player_script() -> str:
    """Return the player script, which defines `hcsearchPlayer`; `npm run build` makes it from `js`."""
    return (files("hcsearch.web.player") / "player.js").read_text(encoding="ascii")
