"""The page that says where things are names all there is, on the floors that `make check` holds."""

import ast
import re
import tomllib
from pathlib import Path

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
    rooms = [*layers("hcsearch.kernels"), *layers("hcsearch_bench")[2:]]
    assert all(f"`{name}`" in PAGE for layer in rooms for name in layer)
