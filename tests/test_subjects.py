"""What a subject is, is asked in the room of subjects alone; a command opens one database and resolves one name."""

import ast
from collections import Counter
from pathlib import Path
from types import SimpleNamespace

import pytest
from click.testing import CliRunner

from hcsearch import enumerate_into, store
from hcsearch.cli import hcsearch
from hcsearch.designs import folding
from hcsearch.shape.linkage import Linkage
from hcsearch.store import open_readonly, select
from hcsearch.subjects.resolve import KINDS

ROOT = Path(__file__).parents[1]
CLASSES = {"Case", "AssemblyCase", "PatternCase", "LinkageCase", "FoldingCase", "CircuitCase", "DesignReading"}
CLASSES |= {"DrawnPattern", "DrawnDesign", "PatternVerdict", "FoldingVerdict"}
QUESTIONS = {"is_pattern_file", "is_id"}
ENDINGS = (".toml", ".fold", ".cp", ".opx", ".svg", ".urdf", ".xml", ".mjcf")
OTHERS = {
    "hcsearch/springs/drive/drive_facts.py": "writes a table or a scene, by the ending of the file",
    "hcsearch/springs/flight/rules.py": "reads the rules of a standard, which are no subject",
    "hcsearch/scenes/scene_file.py": "reads scenes",
}


def questions_in(source):
    """Lines of a module that ask what a subject is: by its class, its name or the ending of its file."""
    lines = set()
    for node in ast.walk(ast.parse(source)):
        words = {part.id for part in ast.walk(node) if isinstance(part, ast.Name)}
        words |= {part.attr for part in ast.walk(node) if isinstance(part, ast.Attribute)}
        if isinstance(node, ast.Call):
            called = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            asks = called in {"isinstance", "issubclass"} and bool(words & CLASSES)
            texts = [part.value for part in ast.walk(node) if isinstance(part, ast.Constant)]
            if asks or called in QUESTIONS or (called == "endswith" and set(texts) & set(ENDINGS)):
                lines.add(node.lineno)
        if isinstance(node, ast.Compare):
            contains = isinstance(node.ops[0], ast.In | ast.NotIn)
            is_none = isinstance(node.ops[0], ast.Is | ast.IsNot) and isinstance(node.left, ast.Attribute)
            if (contains and "ASSEMBLIES" in words) or (is_none and node.left.attr in {"folding", "what"}):
                lines.add(node.lineno)
        if isinstance(node, ast.MatchClass) and words & CLASSES:
            lines.add(node.lineno)
    return sorted(lines)


def test_nobody_else_asks_what_a_subject_is():
    found = {}
    for file in sorted((ROOT / "hcsearch").rglob("*.py")):
        name = str(file.relative_to(ROOT))
        if not name.startswith("hcsearch/subjects/") and name not in OTHERS:
            found[name] = questions_in(file.read_text(encoding="utf-8"))
    assert len(found) > 200
    assert {name: lines for name, lines in found.items() if lines} == {}


@pytest.mark.parametrize(
    "planted",
    [
        "if isinstance(case, PatternCase): pass",
        "shown = isinstance(case, (FoldingCase, CircuitCase))",
        "if case.folding is None: pass",
        "if name not in ASSEMBLIES: pass",
        'if name.endswith(".toml"): pass',
        'if path.lower().endswith((".fold", ".cp")): pass',
        "if pattern_files.is_pattern_file(name): pass",
        "match case:\n    case AssemblyCase(): pass",
    ],
)
def test_a_question_elsewhere_is_found(planted):
    assert questions_in(planted)


@pytest.mark.parametrize(
    "innocent", ["case.page(maker)", "for one in ASSEMBLIES.values(): pass", "if scene is None: pass"]
)
def test_what_asks_no_kind_is_not(innocent):
    assert questions_in(innocent) == []


COMMANDS = {
    "export": ("export", "--output", "a.fold"),
    "deploy": ("deploy",),
    "drive": ("drive",),
    "prove": ("prove", "--output", "a.json"),
    "show": ("show",),
    "show --html": ("show", "--html", "--output", "a.html"),
    "sheet": ("sheet",),
    "check": ("check",),
    "tune": ("tune", "--evaluations", "2", "--samples", "0"),
}


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """A database of eight hexagons, and the name of a folding in it that has no congruent twin."""
    path = str(tmp_path_factory.mktemp("subjects") / "hexagons.sqlite")
    enumerate_into(path, grid="hex", n=8, until="twist")
    with open_readonly(path) as database:
        ((number, crease),) = select(database, "untwisted", columns="design_id,crease", view="foldings").rows
    return path, f"{number}:{crease}"


@pytest.fixture
def counted(monkeypatch):
    """How often a database is opened, a name resolved, and a linkage made."""
    counts = Counter()

    def counting(word, call):
        def count(*args, **options):
            counts[word] += 1
            return call(*args, **options)

        return count

    for word, kind in KINDS.items():
        monkeypatch.setitem(KINDS, word, SimpleNamespace(claims=kind.claims, read=counting("resolved", kind.read)))
    monkeypatch.setattr(store, "open_readonly", counting("opened", store.open_readonly))
    monkeypatch.setattr(Linkage, "__post_init__", counting("linkages", Linkage.__post_init__))
    folding._linkage.cache_clear()
    return counts


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_opens_one_database_resolves_one_name_and_makes_two_linkages(
    command, stored, counted, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    path, name = stored
    first, *options = COMMANDS[command]
    result = CliRunner().invoke(hcsearch, [first, name, *options, "--db", path])
    assert result.exit_code in (0, 1), result.exception
    assert (counted["opened"], counted["resolved"]) == (1, 1)
    assert 1 <= counted["linkages"] <= 2
