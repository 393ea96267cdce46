"""A public name of the package stands for one thing: no function, class, constant or module has the name of another."""

import ast
from collections import defaultdict
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SHARED = {
    "STAGE": ("hcsearch.search.stages.", "each stage of the search"),
    "ASSEMBLIES": ("hcsearch.library.assemblies", "the assemblies of a chapter, and all of them"),
    "P": ("hcsearch.", "a parameter of types"),
    "T": ("hcsearch.", "a type parameter"),
    "main": ("hcsearch.", "the start of a program"),
}
"""Names that mean the same wherever they stand, below a package, and what that is."""
ALONE = ("lock_checker", "path_checker", "collision_checker", "balls", "polynomials", "certificate_grammar")
"""Checkers of certificates, which import nothing else of the package, so that a stranger can read them alone."""


def public_names(source):
    """Functions, classes and constants that a module defines at its top, but for private ones."""
    names = set()
    for node in ast.parse(source).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.add(node.name)
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            names |= {part.id for target in targets for part in ast.walk(target) if isinstance(part, ast.Name)}
    return {name for name in names if not name.startswith("_")}


def shared_names(sources):
    """Names that several modules define, with these modules; sources : text by name of the module."""
    modules = defaultdict(list)
    for module, source in sources.items():
        if module.rpartition(".")[2] not in ALONE and ".versions." not in module:
            for name in public_names(source):
                modules[name].append(module)
    return {name: sorted(found) for name, found in modules.items() if len(found) > 1 and not is_meant(name, found)}


def is_meant(name, modules):
    """Whether a name means the same in these modules: one of `SHARED`, or a command and its function."""
    package, _ = SHARED.get(name, ("", ""))
    command = len(modules) == 2 and {module.split(".")[1] for module in modules} == {"api", "cli"}
    return command or (bool(package) and all(module.startswith(package) for module in modules))


def sources_of(package):
    files = sorted((ROOT / package).rglob("*.py"))
    return {".".join(file.relative_to(ROOT).with_suffix("").parts): file.read_text(encoding="utf-8") for file in files}


def test_no_public_name_stands_for_two_things():
    sources = sources_of("hcsearch")
    assert len(sources) > 200
    assert shared_names(sources) == {}


@pytest.mark.parametrize("package", ["hcsearch", "hcsearch_bench"])
def test_no_module_has_the_name_of_another(package):
    stems = defaultdict(list)
    for module in sources_of(package):
        stems[module.rpartition(".")[2]].append(module)
    assert {stem: modules for stem, modules in stems.items() if len(modules) > 1 and stem != "__init__"} == {}


@pytest.mark.parametrize(
    "planted",
    ["def swatch(): ...", "class Lattice: ...", "SAME_POINT = 1e-9", "Rows: object = 3", "LOW, HIGH = 1, 2\nROWS = 5"],
)
def test_a_name_that_stands_twice_is_found(planted):
    both = {"hcsearch.shape.one": f"import math\n{planted}\n", "hcsearch.springs.two": f'"""Two."""\n{planted}\n'}
    assert set(shared_names(both)) == public_names(planted) != set()
    assert shared_names({"hcsearch.shape.one": planted, "hcsearch.springs.two": "def _swatch(): ..."}) == {}


def test_a_command_and_its_function_have_one_name_and_nothing_else_has_it():
    both = {"hcsearch.api.deploying": "def deploy(): ...", "hcsearch.cli.deploy": "def deploy(): ..."}
    assert shared_names(both) == {}
    assert set(shared_names(both | {"hcsearch.springs.third": "def deploy(): ..."})) == {"deploy"}
    assert set(shared_names({"hcsearch.search.stages.a": "STAGE = 1", "hcsearch.shape.b": "STAGE = 2"})) == {"STAGE"}
