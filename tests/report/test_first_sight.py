"""What a report shows first and what its address holds, in a real browser. Needs chromium."""

import random
from collections import Counter
from dataclasses import replace

import pytest

from hcsearch.designs.grid import GRIDS
from hcsearch.search.enumeration import PolygonSearch
from hcsearch.search.pipeline import Plan, run_into
from hcsearch.search.ranking import rank_designs
from hcsearch.store import open_database, open_readonly, select
from hcsearch.store.columns import RANKING_CRITERIA
from hcsearch.web.player import payload_of
from hcsearch.web.report.data import fetch_report_data
from hcsearch.web.report.page_files import render_report
from hcsearch.web.report.script_data import first_design, page_data
from tests.judging import judge
from tests.player.browser import TWO_FRAMES, chromium
from tests.player.motions import replay_of
from tests.report.test_browser import run_modules

pytestmark = pytest.mark.extra

PLAYED = "hex:0234550132"


@pytest.fixture(scope="module")
def data(hex_ten):
    """Two designs with a motion, and numbers by which designs differ."""
    (number,) = [design["id"] for design in hex_ten.designs if design["circuit"] == PLAYED]
    payload = payload_of(replay_of(f"{PLAYED}:4"))
    designs = [
        {**design, "dof": 4 + k % 5, "needed_margin": 0.01 * (k % 7), "status": "movable", "deployable": 1}
        if design["untwisted"]
        else {**design, "deployable": 0}
        for k, design in enumerate(hex_ten.designs)
    ]
    return replace(hex_ten, designs=designs, best={number: 4}, players={(number, 4): payload})


@pytest.fixture(scope="module")
def number(data):
    (key,) = data.players
    return key[0]


@pytest.fixture(scope="module")
def page(data, tmp_path_factory):
    path = tmp_path_factory.mktemp("first") / "page.html"
    path.write_text(render_report(data), encoding="utf-8")
    return path.as_uri()


@pytest.fixture(scope="module")
def tab(tmp_path_factory):
    with chromium(tmp_path_factory.mktemp("first-browser") / "profile") as opened:
        opened.call("Emulation.setDeviceMetricsOverride", width=1300, height=900, deviceScaleFactor=1, mobile=False)
        yield opened


def show(tab, address):
    tab.open("about:blank")  # else only the part after # would change
    tab.events.clear()
    tab.open(address)
    tab.value(TWO_FRAMES)


def ids(tab, where=".gallery .card h3"):
    return tab.value(f"[...document.querySelectorAll('{where}')].map((head) => Number(head.textContent.slice(1)))")


def place(tab):
    return tab.value("Object.fromEntries(new URLSearchParams(location.hash.slice(1)))")


def test_the_first_design_with_a_motion_plays_unless_less_motion_is_preferred(tab, page, data, number):
    assert data.designs[first_design(data)]["id"] == number
    shadow = "document.querySelector('#first .player').lastElementChild.shadowRoot"
    at = f"Number({shadow}.querySelector('input[type=range]').value)"
    show(tab, page)
    tab.until(f"{at} > 0")
    assert f"#{number}" in tab.value("document.querySelector('#first').textContent")
    tab.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-reduced-motion", "value": "reduce"}])
    show(tab, page)
    tab.until(f"Boolean({shadow}.querySelector('canvas'))")
    tab.value("new Promise((done) => setTimeout(done, 200))")
    assert tab.value(at) == 0
    assert tab.complaints == []


def test_an_address_restores_what_was_shown(tab, page, data):
    show(tab, f"{page}#q=two_stack&sort=-n_foldings&status=movable&columns=min_twist")
    movable = [design for design in data.designs if design["status"] == "movable"]
    wanted = [design["id"] for design in sorted(movable, key=lambda design: (-design["n_foldings"], design["id"]))]
    assert ids(tab) == wanted[: len(ids(tab))]
    assert tab.value("document.getElementById('state').textContent") == f"{len(wanted)} of 120 designs"
    facts = "[...document.querySelectorAll('.gallery .card')[0].querySelectorAll('dt')].map((fact) => fact.textContent)"
    assert tab.value(facts) == ["least twist"]
    tab.value("document.querySelector('[data-facet=\"status=movable\"]').click()")
    assert place(tab) == {"q": "two_stack", "sort": "-n_foldings", "columns": "min_twist"}


def test_the_first_click_gives_the_better_end(tab, page):
    show(tab, page)
    for name, sort in (("needed_margin", "needed_margin"), ("symmetry", "-symmetry"), ("min_twist", "min_twist")):
        tab.value(f"document.getElementById('column').value = '{name}'")
        tab.value("document.getElementById('column').dispatchEvent(new Event('input', {bubbles: true}))")
        assert place(tab)["sort"] == sort


def test_arrow_keys_go_on_and_back_leaves_the_large_view(tab, page):
    show(tab, page)
    first, second = ids(tab)[:2]
    tab.value("document.querySelector('.gallery .thumb').click()")
    assert place(tab) == {"id": str(first)}
    tab.press("ArrowRight")
    assert (place(tab), ids(tab, "dialog h3")) == ({"id": str(second)}, [second])
    tab.press("ArrowLeft")
    tab.press("ArrowLeft")  # before the first there is none
    assert ids(tab, "dialog h3") == [first]
    tab.value("history.back()")
    tab.until("!document.querySelector('dialog').open && location.hash.length < 2")
    show(tab, f"{page}#id={second}")
    assert ids(tab, "dialog h3") == [second]
    tab.value("document.querySelector('dialog .close').click()")
    tab.until("!document.querySelector('dialog').open && location.hash.length < 2")
    assert tab.complaints == []


def test_the_exploded_view_of_a_design_stays_in_the_address(tab, page, number):
    boxes = "document.querySelector('dialog .player > :not(.moves)')?.shadowRoot?.querySelectorAll('label') ?? []"
    box = f"[...{boxes}].find((one) => one.textContent === 'Exploded view')?.firstElementChild"
    show(tab, f"{page}#id={number}")
    tab.until(f"Boolean({box})")
    assert not tab.value(f"{box}.checked")
    tab.value(f"{box}.click()")
    assert place(tab) == {"id": str(number), "exploded": "yes"}
    show(tab, f"{page}#id={number}&exploded=yes")
    tab.until(f"{box}?.checked")
    tab.value(f"{box}.click()")
    assert place(tab) == {"id": str(number)}
    tab.value(f"{box}.click()")
    tab.value("document.querySelector('dialog .close').click()")
    tab.until("location.hash.length < 2")
    assert tab.complaints == []


def test_the_table_sorts_by_its_heads_and_opens_designs(tab, page, data):
    show(tab, f"{page}#q=untwisted&columns=dof&as=table")
    rows = "[...document.querySelectorAll('.rows tbody tr')]"
    heads = "[...document.querySelectorAll('.rows thead th')].map((head) => head.dataset.name || '')"
    assert tab.value(heads) == ["", "id", "status", "dof", "circuit", "array"]
    assert not tab.value("document.querySelector('.gallery .card')")
    named = f"[...{rows}[0].cells].map((cell) => cell.dataset.name ?? '')"  # read in print
    assert tab.value(named) == ["", "", "", "degrees of freedom", "circuit", "array"]
    fitting = [design for design in data.designs if design["untwisted"]]
    dofs = {design["id"]: design["dof"] for design in fitting}
    by_dof = sorted(dofs, key=lambda one: (dofs[one], one))
    click = "document.querySelector('.rows [data-sort={}]').click()"
    for name, sort, wanted in (
        ("dof", "dof", by_dof),  # fewer degrees of freedom are better
        ("dof", "-dof", sorted(dofs, key=lambda one: (-dofs[one], one))),
        ("id", "id", sorted(dofs)),
    ):
        tab.value(click.format(name))
        assert ids(tab, ".rows tbody th") == wanted
        assert place(tab) == {"q": "untwisted", "sort": sort, "columns": "dof", "as": "table"}
        ends = "[...document.querySelectorAll('[aria-sort]')].map((head) => [head.dataset.name, head.ariaSort])"
        assert tab.value(ends) == [[name, "descending" if sort.startswith("-") else "ascending"]]
    tab.value(f"{rows}[1].cells[3].click()")
    assert ids(tab, "dialog h3") == [sorted(dofs)[1]]
    tab.value("document.querySelector('dialog .close').click()")
    tab.until("!document.querySelector('dialog').open && !location.hash.includes('&id=')")
    tab.value("document.querySelector('.rows tbody th button').focus()")
    tab.press("Enter", text="\r")
    assert ids(tab, "dialog h3") == [sorted(dofs)[0]]
    tab.value("document.querySelector('dialog .close').click()")
    tab.until("!document.querySelector('dialog').open && !location.hash.includes('&id=')")
    assert tab.value("document.activeElement.dataset.design") == tab.value(f"{rows}[0].dataset.index")
    tab.value("document.querySelector('.rows [name=pick]').click()")
    tab.value("document.getElementById('shape').value = 'cards'")
    tab.value("document.getElementById('shape').dispatchEvent(new Event('input'))")
    assert ids(tab)[0] == sorted(dofs)[0]
    assert tab.value("document.querySelector('.gallery [name=pick]').checked")
    assert place(tab) == {"q": "untwisted", "sort": "id", "columns": "dof", "compare": str(sorted(dofs)[0])}
    assert tab.complaints == []


def test_more_rows_of_the_table_come_as_its_end_comes_near(tab, page, data):
    show(tab, f"{page}#as=table")
    count = "document.querySelectorAll('.rows tbody tr').length"
    assert tab.value(count) < len(data.designs)
    tab.value("scrollTo(0, document.body.scrollHeight)")
    tab.until(f"{count} === {len(data.designs)}")


def test_picked_designs_are_compared_side_by_side(tab, page, data, number):
    symmetry = {design["id"]: design["symmetry"] for design in data.designs}
    other = next(one for one in symmetry if symmetry[one] != symmetry[number])
    show(tab, f"{page}#q={'%20or%20'.join(f'%23{one}' for one in (number, other))}")
    assert tab.value("document.getElementById('compare').hidden")
    tab.value("document.querySelectorAll('[name=pick]').forEach((box) => box.click())")
    tab.value("document.getElementById('compare').click()")
    tab.until("Boolean(document.querySelector('dialog .together input'))")
    shown = ids(tab, "dialog .columns strong")
    assert sorted(shown) == sorted((number, other))
    rows = "[...document.querySelectorAll('dialog .compared tr')]"
    rows += ".map((row) => [...row.cells].map((cell) => cell.className))"
    heads = tab.value("[...document.querySelectorAll('dialog .compared th')].map((head) => head.textContent)")
    marked = tab.value(rows)[heads.index("symmetry") - 2]  # after the heads of the two designs
    assert [name == "better" for name in marked[1:]] == [
        symmetry[one] == max(symmetry[number], symmetry[other]) for one in shown
    ]
    assert place(tab)["id"] == ",".join(map(str, shown))
    assert tab.complaints == []


def test_the_plot_opens_designs_by_mouse_and_keys(tab, page, data):
    show(tab, f"{page}#x=dof&y=needed_margin")
    tab.until("Boolean(document.querySelector('svg.scatter'))")
    assert {"degrees of freedom", "needed margin (mm)"} <= set(
        tab.value("[...document.querySelectorAll('.scatter text')].map((text) => text.textContent)")
    )
    tab.value("document.querySelector('svg.scatter').focus()")
    tab.press("ArrowRight")
    said = tab.value("document.querySelector('.said').textContent")
    tab.press("Enter")
    (opened,) = ids(tab, "dialog h3")
    assert f"#{opened}" in said
    dof = {design["id"]: design.get("dof") for design in data.designs}
    assert dof[opened] == 4 == min(value for value in dof.values() if value is not None)
    assert tab.complaints == []


def test_a_mark_of_one_design_says_its_status(tab, page, data):
    designs = [design for design in data.designs if None not in map(design.get, ("dof", "needed_margin"))]
    places = Counter((design["dof"], design["needed_margin"]) for design in designs)
    alone = {
        f"#{design['id']}, {design['status']}:"
        for design in designs
        if places[design["dof"], design["needed_margin"]] == 1
    }
    show(tab, f"{page}#x=dof&y=needed_margin")
    tab.until("Boolean(document.querySelector('svg.scatter'))")
    tab.value("document.querySelector('svg.scatter').focus()")
    said = []
    for _ in places:
        tab.press("ArrowRight")
        said.append(tab.value("document.querySelector('.said').textContent"))
    assert {text[: text.index(":") + 1] for text in said if " designs: " not in text} == alone != set()
    assert tab.complaints == []


@pytest.fixture(scope="module")
def ranked(tmp_path_factory):
    """Ten hexagons with made-up numbers, with ties and gaps."""
    path = str(tmp_path_factory.mktemp("ranked") / "designs.sqlite")
    choose = random.Random(7)
    with open_database(path, create=True) as database:
        run_into(Plan(PolygonSearch(GRIDS["hex"], 10), "twist"), database)
        foldings = select(database, "untwisted", columns="design_id,crease", view="foldings").rows
        circuits = dict(select(database, "untwisted", columns="id,circuit").rows)
        judged = {}
        for design, crease in foldings:
            status = choose.choice(["deploys", "deploys", "movable", "locked"])
            numbers = (choose.randint(1, 5) / 4, choose.randint(1, 6) / 8) if status == "deploys" else (None, None)
            judged[design] = (circuits[design], crease, status, *numbers)
        judge(database, list(judged.values()))
    with open_readonly(path) as database:
        yield database


@pytest.mark.parametrize(
    ("x", "y"), [("deploy_time", "min_clearance"), ("symmetry", "deploy_time"), ("hinges", "symmetry")]
)
def test_the_front_of_the_plot_is_that_of_rank(ranked, tmp_path, x, y):
    weights = {quantity.name: float(quantity.name in (x, y)) for quantity in RANKING_CRITERIA}
    result = rank_designs(ranked, "", weights).result
    at = [result.columns.index(name) for name in ("id", "pareto", x, y)]
    rows = [[row[k] for k in at] for row in result.rows]
    front = sorted(design for design, on_front, *numbers in rows if on_front and None not in numbers)
    code = """(() => {
      const table = Table.read(given.data), sign = { higher: 1, lower: -1 };
      const points = table.designs.id.map((id, i) => ({ id, deployable: table.designs.deployable[i],
        x: table.designs[given.x][i], y: table.designs[given.y][i] })).filter(({ x, y }) => x !== null && y !== null);
      const [p, q] = [given.x, given.y].map((name) => sign[table.quantity(name).better]);
      return [...Front.of(points, p, q)].map(({ id }) => id).sort((a, b) => a - b);
    })()"""
    given = {"data": page_data(fetch_report_data(ranked, "", limit=None)), "x": x, "y": y}
    assert run_modules(tmp_path, ("table", "front"), given, code) == front != []
