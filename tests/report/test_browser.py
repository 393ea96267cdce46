"""The page in a real browser. Needs chromium: without it these tests fail, they are not skipped."""

import json
import re
import shutil
import subprocess
from html import unescape
from pathlib import Path

import pytest
from matplotlib.image import imread

from hcsearch.circuit import Circuit
from hcsearch.drawing import draw_circuit
from hcsearch.folding import Folding
from hcsearch.report import render

pytestmark = pytest.mark.extra

QUIET = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"),
    *("--disable-component-update", "--disable-sync", "--enable-logging=stderr", "--v=0"),
    *("--virtual-time-budget=4000", "--window-size=1300,900"),
)

# Sorts, filters and chooses foldings as a reader would, and leaves what is then on the page in an element.
DRIVER = """
const probe = {errors: window.failures};
const visible = () => [...document.querySelectorAll(".gallery .card")].filter((card) => !card.hidden);
const ids = () => visible().map((card) => Number(card.querySelector("h3").textContent.slice(1)));
const columns = [...document.querySelectorAll("[data-column]")];
const press = (name) => columns.find((button) => button.textContent.split(" ")[0] === name).click();
probe.all = ids();
press("min_twist"); probe.up = ids();
press("min_twist"); probe.down = ids();
const box = document.querySelector("input[value=untwisted]");
box.click(); probe.untwisted = ids(); probe.state = document.getElementById("state").textContent; box.click();
const find = document.getElementById("find");
const type = (text) => { find.value = text; find.dispatchEvent(new Event("input", {bubbles: true})); };
type("#7 no hex"); probe.matching = ids();
type("nothing like it"); probe.none = !document.getElementById("none").hidden; type("");
probe.drawn = [];
for (const chip of document.querySelectorAll(".gallery .fold")) {
  chip.click();
  const card = chip.closest(".card");
  const paths = [...card.querySelectorAll("svg path")].map((path) => [path.className.baseVal, path.getAttribute("d")]);
  probe.drawn.push([card.querySelector("code").textContent, chip.textContent.trim().split(" ")[0],
    Object.fromEntries(paths), card.querySelectorAll("[aria-pressed=true]").length]);
}
document.querySelector(".gallery .thumb").click();
const large = document.getElementById("large");
probe.large = [large.open, large.querySelectorAll(".numbers text").length];
large.querySelector(".close").click(); probe.closed = !large.open;
const place = document.createElement("pre");
place.id = "probe"; place.textContent = JSON.stringify(probe); document.body.append(place);
"""


def chromium(page: Path, *options: str) -> subprocess.CompletedProcess[str]:
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    assert program, "chromium is not installed: apt-get install chromium"
    profile = page.with_name(f"profile-{page.stem}")
    command = [program, *QUIET, f"--user-data-dir={profile}", *options, page.as_uri()]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=True, cwd=page.parent)


def complaints(run: subprocess.CompletedProcess[str]) -> list[str]:
    return [line for line in run.stderr.splitlines() if "CONSOLE" in line]


@pytest.fixture(scope="module")
def page(hex_ten, tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("browser") / "page.html"
    path.write_text(render(hex_ten), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def probe(page) -> dict:
    """What the driver saw. The page's policy bars the driver, so it runs on a copy without the policy."""
    text, barred = re.subn(r'<meta http-equiv="Content-Security-Policy"[^>]*>', "", page.read_text(encoding="utf-8"))
    assert barred == 1
    listen = "<script>window.failures = []; window.onerror = (text) => { window.failures.push(text); };</script>"
    text = text.replace("<head>", f"<head>{listen}").replace("</body>", f"<script>{DRIVER}</script></body>")
    copy = page.with_name("driven.html")
    copy.write_text(text, encoding="utf-8")
    run = chromium(copy, "--dump-dom")
    assert not complaints(run)
    return json.loads(unescape(re.search(r'<pre id="probe">(.*?)</pre>', run.stdout, re.DOTALL)[1]))


def test_a_console_error_would_be_seen(tmp_path):
    page = tmp_path / "bad.html"
    page.write_text("<!DOCTYPE html><script>missing();</script>")
    assert complaints(chromium(page, "--dump-dom"))


def test_the_page_opens_without_a_complaint_and_with_all_pictures(page):
    run = chromium(page, "--dump-dom")
    assert complaints(run) == []
    gallery = run.stdout.partition('id="gallery"')[2]
    assert gallery.count("<svg") == 120
    assert '<form class="tools" id="tools">' in run.stdout  # the script ran: it shows the tools


def test_the_page_is_not_blank(page):
    shot = page.with_name("shot.png")
    assert complaints(chromium(page, f"--screenshot={shot}")) == []
    pixels = imread(shot)[..., :3]
    assert pixels.shape[:2] == (900, 1300)
    assert pixels.std() > 0.05
    # mountain red and valley blue are on it
    red, green, blue = (pixels[..., k] for k in range(3))
    assert ((red > 0.6) & (green < 0.3) & (blue < 0.35)).sum() > 50
    assert ((blue > 0.6) & (red < 0.3)).sum() > 50


def test_sorting_puts_unknown_values_last(probe, hex_ten):
    twist = {design["id"]: design["min_twist"] for design in hex_ten.designs}
    last = max(value for value in twist.values() if value is not None) + 1
    rank = {number: last if value is None else value for number, value in twist.items()}
    assert probe["errors"] == []
    assert probe["all"] == sorted(twist)
    assert probe["up"] == sorted(twist, key=lambda number: (rank[number], number))
    assert probe["down"] == sorted(twist, key=lambda number: (rank[number] == last, -rank[number], number))


def test_filters_leave_what_fits(probe, hex_ten):
    untwisted = {design["id"] for design in hex_ten.designs if design["untwisted"]}
    assert set(probe["untwisted"]) == untwisted
    assert probe["state"] == "25 of 120 designs"
    rejected = [design["id"] for design in hex_ten.designs if design["status"] == "no_folding"]
    assert sorted(probe["matching"]) == [number for number in rejected if str(number).startswith("7")]
    assert probe["none"]


def test_a_chosen_folding_is_drawn_as_python_draws_it(probe, hex_ten):
    assert len(probe["drawn"]) == sum(map(len, hex_ten.foldings.values()))
    for notation, creases, paths, pressed in probe["drawn"]:
        circuit = Circuit.from_notation(notation)
        folding = Folding(circuit, int(creases.partition("|")[0]))
        svg = draw_circuit(circuit.grid, circuit.cells, folding.assignment, standalone=False)
        assert paths == dict(re.findall(r'<path class="(\w+)" d="([^"]*)"', svg))
        assert pressed == 1


def test_a_large_picture_opens_with_numbers_and_closes(probe):
    assert probe["large"] == [True, 10]
    assert probe["closed"]
