"""The page that says where things are names all there is, on the floors that `make check` holds; SQL is of `store`."""

import ast
import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "explanation" / "architecture.md").read_text(encoding="utf-8")
CONTRACTS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]["contracts"]


def layers(container):
    (floors,) = [one["layers"] for one in CONTRACTS if one.get("containers") == [container]]
    return [layer.split(" | ") for layer in floors]


def test_floors_stand_in_the_order_of_the_contract():
    rows = re.findall(r"^\| (`.*?) \|", PAGE, flags=re.MULTILINE)
    named = [re.findall(r"`(\w+)`", row) for row in rows]
    floor = {name: number for number, layer in enumerate(layers("hcsearch")) for name in layer}
    assert {name for row in named for name in row} == set(floor)
    assert [floor[name] for row in named for name in row] == sorted(floor[name] for row in named for name in row)


def test_no_module_names_one_of_a_layer_above_in_a_text():
    floor = {name: number for number, layer in enumerate(layers("hcsearch")) for name in layer}
    for path in sorted((ROOT / "hcsearch").rglob("*.py")):
        own = path.relative_to(ROOT / "hcsearch").parts[0].removesuffix(".py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            text = node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else ""
            named = re.match(r"hcsearch\.(\w+)[\w.]*$", text)
            if own in floor and named and named[1] in floor:
                assert floor[named[1]] >= floor[own], f"{path}:{node.lineno}"


def test_rooms_of_kernels_and_of_benches_are_named():
    rooms = [*layers("hcsearch.kernels"), *layers("hcsearch_bench")[3:]]
    assert all(f"`{name}`" in PAGE for layer in rooms for name in layer)


SQL = re.compile(
    r"\bSELECT\b.*\bFROM\b|\bINSERT INTO\b|\bUPDATE\b.*\bSET\b|\bDELETE FROM\b|\bWHERE\b|\b(GROUP|ORDER) BY\b"
    r"|\b(LEFT|INNER|OUTER) JOIN\b|\b(CREATE|ALTER|DROP) (TABLE|VIEW|INDEX)\b|\bPRAGMA\b|\bcount\(\*\)|\bAS [a-z_]+,",
    re.DOTALL,
)
"""What a text of SQL has in it: texts that are put together have it in parts."""
RUNS_SQL = {"execute", "executemany", "executescript", "exec_driver_sql", "scalars", "dialect", "begin_nested"}
DRIVERS = {"sqlite3", "sqlalchemy", "alembic", "psycopg"}
AS_USERS = {"hcsearch_bench/stability/processors.py": "asks by `hcsearch query --sql` in another process"}


def sql_in(source):
    """Lines of a module that hold SQL, or reach for what runs it; docstrings and examples of commands may show some."""
    tree = ast.parse(source)
    opens = any(isinstance(node, ast.ImportFrom) and "store" in str(node.module).split(".") for node in ast.walk(tree))
    documented = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    shown = {id(node.body[0].value) for node in ast.walk(tree) if isinstance(node, documented) and _has_docstring(node)}
    lines = set()
    for node in ast.walk(tree):
        text = _text(node)
        if text is not None and id(node) not in shown and SQL.search(text) and "hcsearch query" not in text:
            lines.add(node.lineno)
        if isinstance(node, ast.Attribute) and (node.attr in RUNS_SQL or (node.attr == "engine" and opens)):
            lines.add(node.lineno)
        if isinstance(node, ast.Import) and DRIVERS & {alias.name.split(".")[0] for alias in node.names}:
            lines.add(node.lineno)
        if isinstance(node, ast.ImportFrom) and str(node.module).split(".")[0] in DRIVERS:
            lines.add(node.lineno)
    return sorted(lines)


def _has_docstring(node):
    return bool(node.body) and isinstance(node.body[0], ast.Expr) and isinstance(node.body[0].value, ast.Constant)


def _text(node):
    """A text as it stands, that of a formatted one with `{}` for its values."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return "".join(str(part.value) if isinstance(part, ast.Constant) else "{}" for part in node.values)
    return None


def test_sql_lives_in_store():
    modules = [file for package in ("hcsearch", "hcsearch_bench") for file in (ROOT / package).rglob("*.py")]
    outside = [file for file in modules if not file.is_relative_to(ROOT / "hcsearch" / "store")]
    found = {str(file.relative_to(ROOT)): sql_in(file.read_text(encoding="utf-8")) for file in outside}
    assert len(outside) > 100
    assert {name for name, lines in found.items() if lines} == set(AS_USERS)


@pytest.mark.parametrize(
    "planted",
    [
        'rows = ask(database, f"SELECT {names} FROM {source} LIMIT 2")',
        'census = f"SELECT n_foldings, count(*) FROM {designs}"',
        'planned = has_rows(database, f"motions WHERE scene = {scene}")',
        'COUNTS = "count(*) AS circuits, sum(two_stack) AS two_stack"',
        'sql = "DELETE FROM design"',
        'sql = "UPDATE run SET finished = NULL"',
        'sql = "INSERT INTO scene VALUES (1)"',
        'order = " ORDER BY design_id"',
        "rows = connection.execute(statement)",
        "rows = connection.exec_driver_sql(text)",
        "from hcsearch.store import Database\ndialect = database.engine",
        "import sqlite3",
        "from sqlalchemy import select",
        "def read():\n    import psycopg",
    ],
)
def test_sql_elsewhere_is_found(planted):
    assert sql_in(f'"""A module."""\n\nvalue = 1\n{planted}\n') == [4 + planted.count("\n")]


@pytest.mark.parametrize(
    "innocent",
    [
        '"""Run one SELECT, as SELECT id FROM designs."""',
        "EXAMPLE = \"hcsearch query --sql 'SELECT id FROM designs WHERE n = 12'\"",
        'message = "a SELECT stands alone: put conditions, columns, order and limit into it"',
        "rows = [row for row in rows if row.engine == ours]",
        "from hcsearch.store import select\nrows = select(database).records()",
    ],
)
def test_what_only_speaks_of_sql_is_not(innocent):
    assert sql_in(innocent) == []
