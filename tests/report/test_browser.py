import json
import random
import re
import shutil

import pytest
from matplotlib.image import imread

from hcsearch.basics.errors import HcsearchError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import foldings
from hcsearch.designs.grid import GRIDS
from hcsearch.designs.twisting import twist
from hcsearch.search.enumeration import enumerate_circuits
from hcsearch.shape.drawing import draw_circuit
from hcsearch.store import open_database, open_readonly, select
from hcsearch.web.report.data import fetch_report_data
from hcsearch.web.report.page_files import render_report
from hcsearch.web.report.script_data import grid_data, page_data
from hcsearch.web.report.templating import joined_script
from tests.judging import judge
from tests.report.browser import chromium, complaints, driven

pytestmark = pytest.mark.extra

HELPERS = """
const cards = () => [...document.querySelectorAll(".gallery .card")];
const ids = () => cards().map((card) => Number(card.querySelector("h3").textContent.slice(1)));
const byId = (name) => document.getElementById(name);
const set = (name, value) => {
  byId(name).value = value;
  byId(name).dispatchEvent(new Event("input", {bubbles: true}));
};
const type = (text) => set("find", text);
const sort = (name) => set("column", name);
"""

# Sorts, filters, scrolls and chooses foldings as a reader would.
DRIVER = """
probe.first = ids(); probe.state = byId("state").textContent;
probe.columns = [...byId("column").options].map((option) => option.value);
sort("min_twist"); probe.up = ids();
byId("direction").click(); probe.down = ids();
byId("direction").click(); sort("");
const facet = (value) => document.querySelector(`[data-facet="${value}"]`);
facet("status=untwisted").click(); probe.untwisted = byId("state").textContent;
probe.pressed = facet("status=untwisted").getAttribute("aria-pressed");
facet("status=twisted").click(); probe.either = byId("state").textContent;
facet("status=untwisted").click(); facet("status=twisted").click();
type("#7"); probe.number = ids();
type("no hex"); probe.words = byId("state").textContent;
type("min_twist<=1 n_foldings>=2"); probe.numeric = byId("state").textContent;
type("doff<=6");
probe.wrong = [byId("wrong").textContent, byId("find").getAttribute("aria-invalid"), byId("state").textContent];
type("nothing like it"); probe.none = !byId("none").hidden; type("");
scrollTo(0, document.body.scrollHeight); dispatchEvent(new Event("scroll"));
probe.last = ids().at(-1); probe.made = cards().length;
scrollTo(0, 0); dispatchEvent(new Event("scroll"));
type("n_foldings>=3");
const said = (chip) => [chip.className, chip.getAttribute("aria-pressed")];
probe.chips = cards().map((card) => [...card.querySelectorAll(".fold")].map(said));
const path = (card) => card.querySelector(".mountain").getAttribute("d");
const before = path(cards()[0]);
cards()[0].querySelector(".fold[aria-pressed=false]").click();
probe.redrawn = [path(cards()[0]) !== before, cards()[0].querySelectorAll("[aria-pressed=true]").length];
cards()[0].querySelector(".thumb").click();
const large = byId("large");
const count = (what) => large.querySelectorAll(what).length;
probe.large = [large.open, count(".numbers text"), count(".foldings tbody tr")];
large.querySelector(".close").click(); probe.closed = !large.open;
dispatchEvent(new Event("beforeprint")); probe.printed = cards().length;
dispatchEvent(new Event("afterprint"));
type(""); dispatchEvent(new Event("beforeprint")); probe.all = ids(); dispatchEvent(new Event("afterprint"));
probe.after = cards().length;
"""


@pytest.fixture(scope="module")
def page(hex_ten, tmp_path_factory):
    path = tmp_path_factory.mktemp("browser") / "page.html"
    path.write_text(render_report(hex_ten), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def probe(page):
    return driven(page, HELPERS + DRIVER)


def test_a_console_error_would_be_seen(tmp_path):
    page = tmp_path / "bad.html"
    page.write_text("<!DOCTYPE html><script>missing();</script>")
    assert complaints(chromium(page, "--dump-dom"))


def test_the_page_opens_without_a_complaint_and_draws_what_is_seen(page):
    run = chromium(page, "--dump-dom")
    assert complaints(run) == []
    drawn = run.stdout.partition('id="gallery"')[2].count("<svg")
    assert 8 <= drawn < 120
    assert '<form class="tools" id="tools">' in run.stdout  # the script ran: it shows the tools


def test_the_page_is_not_blank(page):
    shot = page.with_name("shot.png")
    assert complaints(chromium(page, f"--screenshot={shot}", size="1300,1400")) == []
    pixels = imread(shot)[..., :3]
    assert pixels.std() > 0.05
    # mountain red and valley blue are on it
    red, green, blue = (pixels[..., k] for k in range(3))
    assert ((red > 0.6) & (green < 0.3) & (blue < 0.35)).sum() > 50
    assert ((blue > 0.6) & (red < 0.3)).sum() > 50


def test_sorting_puts_unknown_values_last(probe, hex_ten):
    twist = {design["id"]: design["min_twist"] for design in hex_ten.designs}
    last = max(value for value in twist.values() if value is not None) + 1
    rank = {number: last if value is None else value for number, value in twist.items()}
    up = sorted(twist, key=lambda number: (rank[number], number))
    down = sorted(twist, key=lambda number: (rank[number] == last, -rank[number], number))
    assert probe["errors"] == []
    assert probe["first"] == sorted(twist)[: len(probe["first"])]
    assert probe["up"] == up[: len(probe["up"])]
    assert probe["down"] == down[: len(probe["down"])]
    assert "min_twist" in probe["columns"]
    assert "n" not in probe["columns"]  # all alike


def test_filters_leave_what_fits(probe, hex_ten):
    def count(fits):
        return f"{sum(map(fits, hex_ten.designs))} of 120 designs"

    assert probe["state"] == "120 of 120 designs"
    assert probe["untwisted"] == count(lambda design: design["untwisted"]) == "25 of 120 designs"
    assert probe["pressed"] == "true"
    assert probe["either"] == count(lambda design: design["two_stack"]) == "32 of 120 designs"
    assert probe["number"] == [7]
    assert probe["words"] == count(lambda design: design["status"] == "no_folding")
    assert probe["numeric"] == count(lambda d: d["n_foldings"] >= 2 and d["min_twist"] <= 1)
    assert "no column “doff” (did you mean dof?)" in probe["wrong"][0]
    assert probe["wrong"][1:] == ["true", probe["numeric"]]  # what was shown stays
    assert probe["none"]


def test_only_what_is_near_is_made_and_print_makes_all(probe, hex_ten):
    assert probe["last"] == 120
    assert max(probe["made"], probe["after"]) < 60
    assert probe["all"] == [design["id"] for design in hex_ten.designs]
    assert probe["printed"] == sum(design["n_foldings"] >= 3 for design in hex_ten.designs)


def test_chips_have_the_colour_of_their_own_folding(probe, hex_ten):
    shown = [rows for rows in hex_ten.foldings.values() if len(rows) >= 3]
    for chips, rows in zip(probe["chips"], shown, strict=True):
        assert [
            f"s-{'untwisted' if row['untwisted'] else 'twisted'}" in name
            for (name, _), row in zip(chips, rows, strict=True)
        ]
        assert [pressed for _, pressed in chips].count("true") == 1


def test_another_folding_can_be_chosen_and_a_design_enlarged(probe):
    assert probe["redrawn"] == [True, 1]
    assert probe["large"] == [True, 10, 3]
    assert probe["closed"]


def run_modules(folder, modules: tuple[str, ...], setup: object, code: str) -> object:
    """What a script made of some modules of the page computes; `setup` is what it is given as `given`."""
    (folder / "given.js").write_text(f"const given = {json.dumps(setup)};\n", encoding="utf-8")
    script = joined_script(modules).removesuffix("})();\n") + f"probe.computed = {code};\n}})();"
    page = folder / "modules.html"
    page.write_text(
        '<!DOCTYPE html><head><meta http-equiv="Content-Security-Policy" content=""></head><body><svg></svg>'
        '<script src="given.js"></script></body>',
        encoding="utf-8",
    )
    return driven(page, script)["computed"]


def test_pictures_are_those_that_python_draws(tmp_path):
    sizes = {
        "hex": (6, 9, 10, 12),
        "square": (8, 12),
        "rectangle": (8, 12),
        "triangle": (10, 18),
        "rhombus": (10, 12),
        "kite": (6, 8, 10),
        "right45": (8, 12, 14),
        "right30": (8, 12),
        "obtuse": (12, 16),
    }
    circuits = [c for grid, ns in sizes.items() for n in ns for c in enumerate_circuits(grid, n=n, limit=40)]
    circuits += [Circuit(c.grid, c.word[1:] + c.word[:1]) for c in circuits]  # begins on a panel of any kind
    asked = [(circuit, None, None) for circuit in circuits]
    asked += [(circuit, folding, None) for circuit in circuits for folding in foldings(circuit)]
    asked += [(circuit, folding, (60, 37)) for circuit, folding, _ in asked if circuit.grid.name == "rectangle"]
    given = {
        "grids": {name: grid_data(grid) for name, grid in GRIDS.items()},
        "asked": [[c.notation, folding and folding.crease, size] for c, folding, size in asked],
    }
    code = "given.asked.map(([notation, crease, size]) => Geometry.picture(given.grids, notation, crease, size))"
    drawn = run_modules(tmp_path, ("geometry",), given, code)
    assert {circuit.grid.name for circuit, _, _ in asked} == set(GRIDS)
    assert len({circuit.notation.split(":")[1][0] for circuit, _, _ in asked} - set("0123456789")) > 3
    assert sum(folding is not None for _, folding, _ in asked) > 50
    for (circuit, folding, size), picture in zip(asked, drawn, strict=True):
        svg = draw_circuit(
            circuit.grid, circuit.cells, folding and folding.assignment, size=size, standalone=False, numbers=True
        )
        assert [tuple(path) for path in picture["paths"]] == re.findall(r'<path class="(\w+)" d="([^"]*)"', svg)
        assert f'viewBox="0 0 {picture["width"]} {picture["height"]}"' in svg
        assert 'cx="{}" cy="{}"'.format(*picture["start"]) in svg


WORDS = (
    *("untwisted", "not untwisted", "min_twist<=1", "min_twist>0", "n_foldings>=2", "symmetry>1", "two_stack=0"),
    *(
        "status=twisted",
        "status!=no_folding",
        "circuit>hex:0233",
        "n=8",
        "not min_twist=1",
        "deployable",
        "orbit_size<6",
    ),
    *(
        "degrees of freedom<=6",
        "Least  Twist >= 1",
        "not Two-Stack",
        "untwisted foldings > 0",
        "(SYMMETRY != 1)",
        "foldings",
    ),
    *("fits=150x100x30", "fits!=30x100x150", "fits=3u", "FITS=3U", "fits", "fits<=3U", "fits=4U", "fits=0x1x1"),
    *("N>8", "status=nothing", "n=x", "n=", "n==8", "circuit=hex:0234550132", "id<=40"),
)


def random_query(choose: random.Random, depth: int = 3) -> str:
    if depth == 0 or choose.random() < 0.3:
        return choose.choice(WORDS)
    parts = [random_query(choose, depth - 1) for _ in range(choose.randint(1, 3))]
    joined = choose.choice([" ", " and ", " or ", " OR "]).join(parts)
    return choose.choice([joined, f"({joined})", f"not ({joined})", f"({joined}"[choose.random() < 0.9 :]])


@pytest.fixture
def sized_file(database_file, tmp_path):
    """The database, with stowed boxes of some designs."""
    path = shutil.copy(database_file, tmp_path / "sized.sqlite")
    boxes = [(0.15, 0.1, 0.03), (0.15, 0.1, 0.031), (0.1, 0.1, 0.3405), (0.1, 0.09, 0.02)]
    sides = ("stowed_length", "stowed_width", "stowed_height")
    flight = [dict(zip(sides, box, strict=True)) for box in boxes]
    with open_database(str(path), create=False) as database:
        circuits = [row[0] for row in select(database, "untwisted", columns="circuit", limit=len(boxes)).rows]
        creases = [next(f.crease for f in foldings(Circuit.from_notation(one)) if not twist(f)) for one in circuits]
        judged = [(one, crease, "movable", None, None) for one, crease in zip(circuits, creases, strict=True)]
        judge(database, judged, flight=flight[: len(judged)])
    return path


def test_the_box_understands_queries_as_the_database_does(sized_file, tmp_path):
    choose = random.Random(20)
    queries = [
        "",
        *WORDS,
        *(random_query(choose) for _ in range(150)),
        "n=8 or",
        "(n=8",
        "n=8)",
        "and n=8",
        "not",
        "n <= 8",
        "n",
    ]
    queries = list(dict.fromkeys(queries))
    with open_readonly(str(sized_file)) as database:
        given = {"data": page_data(fetch_report_data(database, "", limit=None, sort="id")), "queries": queries}
        expected = []
        for query in queries:
            try:
                expected.append([row[0] for row in select(database, query, columns="id", sort="id").rows])
            except HcsearchError:
                expected.append(None)
    code = """given.queries.map((query) => {
      const table = Table.read(given.data);
      try { return Conditions.selected(table, query).map((i) => table.designs.id[i]); } catch { return null; }
    })"""
    chosen = run_modules(tmp_path, ("grammar", "nearest", "envelopes", "conditions", "table"), given, code)
    wrong = {query: (a, b) for query, a, b in zip(queries, chosen, expected, strict=True) if a != b}
    assert not wrong
    assert sum(ids is None for ids in expected) > 10
    assert len({tuple(ids) for ids in expected if ids}) > 20


def test_a_page_is_printed_from_its_first_to_its_last_card(page):
    file = page.with_name("printed.pdf")
    chromium(page, f"--print-to-pdf={file}", "--no-pdf-header-footer")
    pages = len(re.findall(rb"/Type\s*/Page\b", file.read_bytes()))
    assert 3 <= pages <= 8
