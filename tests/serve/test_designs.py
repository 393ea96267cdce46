import base64
import hashlib
import io
import json
import re
import zipfile
from pathlib import Path

import pytest

from hcsearch.designs.grid import GRIDS
from hcsearch.library.assemblies import ASSEMBLIES
from hcsearch.search.enumeration import PolygonSearch
from hcsearch.search.pipeline import Plan, run_into
from hcsearch.store import find_circuit, open_database, open_readonly
from hcsearch.web.player import replay_in
from tests.judging import judge
from tests.report.pages import data_of
from tests.serve.asking import Asking
from tests.serve.conftest import MOVES

pytestmark = pytest.mark.extra


def test_the_page_of_a_design_plays_its_motion_and_names_its_files(asking, number):
    answer = asking(f"/designs/{number}")
    assert answer.status == 200
    assert MOVES in answer.text
    motion, mode = data_of(answer.text)
    assert mode["source"].startswith("mode 1 of the flat array on its latches")
    assert motion["title"] == f"{MOVES}:1"
    policy = re.search('Content-Security-Policy" content="(.*?)"', answer.text)[1]
    for script in re.findall("<script>(.*?)</script>", answer.text, re.DOTALL):
        digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
        assert f"'sha256-{digest}'" in policy
    assert "frame-ancestors 'none'" in answer.headers["Content-Security-Policy"]
    files = re.findall(f'href="(/designs/{number}/foldings/1/export[^"]*)"', answer.text)
    assert {Path(file).suffix for file in files} >= {".fold", ".glb", ".stl", ".urdf"}


def test_the_list_of_assemblies_leads_to_a_page_of_each(asking):
    assert 'href="/assemblies"' in asking("/designs").text
    page = asking("/assemblies")
    assert page.status == 200
    addresses = re.findall(r'href="(/assemblies/[^"]*)"', page.text)
    assert addresses == [f"/assemblies/{name}" for name in ASSEMBLIES]
    assert page.text.count("<svg") == len(ASSEMBLIES)
    answer = asking("/assemblies/element-6r")
    assert (answer.status, data_of(answer.text)[0]["title"]) == (200, "element-6r")
    assert 'href="/assemblies"' in answer.text
    assert "frame-ancestors 'none'" in answer.headers["Content-Security-Policy"]


def test_an_assembly_that_is_not_there_is_named(asking):
    answer = asking("/assemblies/unit-iv")
    assert answer.status == 404
    assert "no assembly &#39;unit-iv&#39;: choose one of those at /assemblies" in answer.text
    assert "they have none" in asking("/assemblies?q=unit").text


@pytest.mark.parametrize("below", ["", "/export.g6", "/foldings/1/export.fold", "/foldings/1/motion.json"])
@pytest.mark.parametrize("missing", [121, 99999, 2**63, 10**60])
def test_a_design_that_is_not_there_is_named(asking, missing, below):
    answer = asking(f"/designs/{missing}{below}")
    assert (answer.status, f"no design {missing} in " in answer.text) == (404, True)


@pytest.mark.parametrize("scene", ["", "?scene=solar"])
def test_a_database_with_verdicts_of_one_scene_alone_has_all_pages(tmp_path, scene):
    from hcsearch.web.serve.application import Application

    file = str(tmp_path / "solar.sqlite")
    with open_database(file, create=True) as database:
        run_into(Plan(PolygonSearch(GRIDS["hex"], 10), "twist"), database)
        judge(database, [(MOVES, 1, "movable", None, None)], "solar")
        number, _ = find_circuit(database, MOVES)
    with open_readonly(file) as database:
        application = Application(database, file, scene="solar")
        asking = Asking(application)
        for below in ("", "/export.json", "/foldings/1/export.csv", "/foldings/1/motion.json"):
            assert asking(f"/designs/{number}{below}{scene}").status == 200
        refused = asking(f"/designs/{number}?scene=default")
        assert (refused.status, "no verdicts of the scene" in refused.text) == (400, True)
        application.close()


def test_a_list_names_the_motions_that_the_database_holds(asking, number):
    page = asking(f"/designs?q=id={number}").text
    (address,) = re.findall(r"/designs/[0-9]+/foldings/[0-9]+/motion\.json", page)
    assert address == f"/designs/{number}/foldings/1/motion.json"
    answer = asking(address)
    assert answer.headers["Content-Type"].startswith("application/json")
    assert replay_in(json.loads(answer.body)).title == f"{MOVES}:1"
    assert [asking(address.replace("/1/", f"/{crease}/")).status for crease in (3, 4, 10**30)] == [404] * 3
    missing = asking(f"{address}?scene=solar")
    assert missing.status == 404
    assert f"no path of folding 1 of design {number} in the scene solar" in missing.text
    assert "motion.json" not in asking(f"/designs?q=id={number}&scene=solar").text
    assert asking(f"{address}?scene=lunar").status == 400


def test_verdicts_on_the_page_are_those_of_its_scene(asking, number):
    solar = asking(f"/designs/{number}?scene=solar").text
    assert "badge s-locked" in solar
    assert f'href="/designs/{number}/foldings/1/export.fold?scene=solar"' in solar
    assert f'href="/designs.json?q=id={number}&amp;scene=solar"' in solar
    assert asking(f"/designs/{number}?scene=lunar").status == 400
    assert asking(f"/designs/{number}?scene=earth").status == 400


def test_exports_are_files_to_download(asking, number):
    from hcsearch.export.formats import EXPORT_FORMATS

    below = f"/designs/{number}/foldings/1/export"
    fold = asking(f"{below}.fold")
    assert fold.headers["Content-Disposition"] == f"attachment; filename=design-{number}-folding-1.fold"
    assert json.loads(fold.body)["file_spec"] == 1.2
    assert asking(f"{below}.stl?state=folded&part=3").body != asking(f"{below}.stl?state=flat&part=3").body
    moving = asking(f"{below}.svg?format=animation")
    assert moving.headers["Content-Disposition"] == f"attachment; filename=design-{number}-folding-1-animation.svg"
    assert moving.body != asking(f"{below}.svg").body
    bill = asking(f"{below}.md?format=bom")
    assert bill.headers["Content-Disposition"] == f"attachment; filename=design-{number}-folding-1-bom.md"
    assert bill.text.startswith("# Bill of materials")
    assert asking(f"{below}.png?state=folded").body.startswith(b"\x89PNG")
    tree = asking(f"{below}.urdf")
    assert zipfile.ZipFile(io.BytesIO(tree.body)).namelist()[0] == f"design-{number}-folding-1.urdf"
    graph = asking(f"/designs/{number}/export.g6")
    assert graph.body.strip().isascii()
    whole = asking(f"/designs/{number}/export.fold")
    assert (whole.status, "exports one folding" in whole.text) == (400, True)
    assert asking(f"{below}.fold?state=flat").status == 400  # it has both states
    assert "takes no --state" in asking(f"{below}.fold?state=flat").text
    assert asking(f"/designs/{number}/foldings/0/export.fold").status == 400
    assert all(form.endings[0] not in (".html", ".js") for form in EXPORT_FORMATS.values())
