"""Screenshots of pages in a browser, which how-to guides show, made by Chromium."""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from hcsearch.api.replaying import replay
from hcsearch.web.player import motion_json, player_script
from hcsearch_bench.gallery.compression import compress_picture

_DATABASE = "hexagons.sqlite"
_FLIGHT_SCENE = "solar.toml"
_COMMANDS = (
    f"hcsearch enumerate --grid hex --n 12 --db {_DATABASE}",
    f"hcsearch report 'grid=hex n=12' --db {_DATABASE} --output report.html",
    f"hcsearch show 1131 --html --db {_DATABASE} --output design.html",
    f"hcsearch tune square:01223321123330000121:3 --scene {_FLIGHT_SCENE} --rule ecss --output chosen.toml",
    "hcsearch sheet chosen.toml --output sheet.html",
)
"""What makes the pages, in a folder with the scene of the how-to guide for flight."""
_PLAYED = "hex:0234550132:4"
_CHROMIUM = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--hide-scrollbars"),
    # nothing moves by itself, so that every run makes the same picture
    *("--force-prefers-reduced-motion", "--virtual-time-budget=20000"),
)


@dataclass(frozen=True)
class Screenshot:
    """A picture of a page.

    file : of the picture. page : a file that `_COMMANDS` write, or an address on a server of the database, from / on.
    size : width and height, px. share : the place on the slider of the first player of a page.
    """

    file: str
    page: str
    size: tuple[int, int]
    share: float | None = None


_COLUMNS = "id,circuit,symmetry,dof,needed_margin,status"
SCREENSHOTS = (
    Screenshot("report.webp", "report.html", (1000, 1160), 0.7),
    Screenshot("design-page.webp", "design.html", (1000, 1180), 0.5),
    Screenshot("server.webp", f"/designs?q=symmetry>1&status=deploys,movable&as=table&columns={_COLUMNS}", (1000, 780)),
    Screenshot("player.webp", "player.html", (760, 560)),
    Screenshot("flight-sheet.webp", "sheet.html", (1000, 780)),
)


def write_screenshots(folder: Path, guides: Path) -> None:
    """Write all screenshots into a folder; without Chromium those that are there stay.

    guides : the folder of the how-to guides, one of which holds the scene of the flight sheet.
    """
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    if program is None:
        print(f"no Chromium: {', '.join(one.file for one in SCREENSHOTS)} stay as they are", file=sys.stderr)
        return
    with TemporaryDirectory() as name:
        work = Path(name)
        _make_pages(work, guides)
        with _server(work) as address:
            for shown in SCREENSHOTS:
                if shown.page.startswith("/"):
                    page = address + shown.page
                else:
                    page = _at_share(work / shown.page, shown.share).as_uri()
                _shoot(program, work, page, shown.size)
                compress_picture(work / "shot.png", folder / shown.file, lossless=False)


def _make_pages(work: Path, guides: Path) -> None:
    """Write the files that screenshots show into a folder."""
    scene = re.search(
        rf"```toml\n(# {re.escape(_FLIGHT_SCENE)}\n.*?)```", (guides / "flight.md").read_text("utf-8"), re.S
    )
    assert scene, guides
    (work / _FLIGHT_SCENE).write_text(scene[1], encoding="utf-8")
    for command in _COMMANDS:
        subprocess.run([sys.executable, "-m", *shlex.split(command)], cwd=work, check=True)
    (work / "player.html").write_text(_player_page(), encoding="utf-8")


def _player_page() -> str:
    """A page with the player in it, as docs/howto/player.md describes it, in the middle of a motion."""
    return f"""<!DOCTYPE html>
<html lang="en"><meta charset="utf-8"><title>{_PLAYED}</title>
<style>body {{ font-family: sans-serif; margin: 16px; }}</style>
<div id="here"></div>
<script type="application/json" id="motion">{motion_json(replay(_PLAYED))}</script>
<script>{player_script()}</script>
<script>
const motion = document.getElementById("motion").textContent;
const handle = hcsearchPlayer.mount(document.getElementById("here"), motion, {{ numbers: true, at: 0.5 }});
</script></html>
"""


def _at_share(page: Path, share: float | None) -> Path:
    """Return a copy of a page whose first player is moved to a place, without the policy that bars scripts."""
    if share is None:
        return page
    text = re.sub(r'<meta http-equiv="Content-Security-Policy"[^>]*>', "", page.read_text(encoding="utf-8"))
    # a page makes its players when they come into view, and may begin its motion anew then
    mover = (
        "<script>setInterval(() => {"
        "const roots = [...document.querySelectorAll('*')].map((one) => one.shadowRoot).filter(Boolean);"
        "const range = roots.map((root) => root.querySelector('input[type=range]')).find(Boolean);"
        f"const place = Math.round((range?.max ?? 0) * {share});"
        "if (range && Number(range.value) !== place) {"
        "range.value = place; range.dispatchEvent(new Event('input'));"
        "}}, 100);</script>"
    )
    moved = page.with_name(f"moved-{page.name}")
    moved.write_text(text.replace("</body>", f"{mover}</body>"), encoding="utf-8")
    return moved


def _shoot(program: str, work: Path, page: str, size: tuple[int, int]) -> None:
    """Take a picture of a page as shot.png in the folder of work."""
    options = (f"--user-data-dir={work / 'profile'}", f"--window-size={size[0]},{size[1]}")
    subprocess.run(
        [program, *_CHROMIUM, *options, f"--screenshot={work / 'shot.png'}", page],
        capture_output=True,
        timeout=300,
        check=True,
    )


@contextmanager
def _server(work: Path) -> Iterator[str]:
    """Serve the database, and yield the address of the server."""
    command = [sys.executable, "-m", "hcsearch", "serve", "--db", _DATABASE, "--port", "0"]
    with subprocess.Popen(command, cwd=work, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            yield process.stdout.readline().split("/ ")[0]
        finally:
            process.terminate()
