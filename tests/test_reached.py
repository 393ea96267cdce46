"""What only tests reach leaves: each module and public name of the package serves Python, a command or a bench."""

import ast
import re
from pathlib import Path

from hcsearch.basics.vocabulary import STAGE_NAMES

ROOT = Path(__file__).parents[1]
STARTS = (
    *("hcsearch.__main__", "hcsearch_bench.command", "hcsearch_bench.gallery.__main__", "hcsearch.store.generated"),
    *(f"hcsearch.search.stages.{name}" for name in STAGE_NAMES),
)
"""Modules that a shell, an entry point or the Makefile starts, and those of the stages, which are loaded by name."""
BY_NAME = ("hcsearch.store.migrations.", "hcsearch_bench.")
"""Packages of which modules are loaded by their names, as a text: migrations, and benches."""


def sources(*packages):
    """The tree of each module of some packages, stubs with the modules they stand beside."""
    files = [file for package in packages for kind in ("*.py", "*.pyi") for file in (ROOT / package).rglob(kind)]
    trees = {}
    for file in files:
        name = ".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
        trees.setdefault(name, []).append(ast.parse(file.read_text(encoding="utf-8")))
    return trees


def imported(trees):
    """Names that a module imports, with those of the modules that they may be."""
    for tree in trees:
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and node.module:
                yield from (node.module, *(f"{node.module}.{alias.name}" for alias in node.names))
            elif isinstance(node, ast.Import):
                yield from (alias.name for alias in node.names)


def reached(modules, starts):
    """Modules that some import, directly or not, with the packages that hold them."""
    found, waiting = set(), [*starts]
    while waiting:
        name = waiting.pop()
        if name in modules and name not in found:
            found.add(name)
            waiting += [name.rpartition(".")[0], *imported(modules[name])]
    return found


def named(trees):
    """Names that a module uses: of values, attributes and imports, but for those it only defines."""
    for tree in trees:
        for node in ast.walk(tree):
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
                yield node.id
            elif isinstance(node, ast.Attribute):
                yield node.attr
            elif isinstance(node, ast.ImportFrom | ast.Import):
                yield from (alias.name for alias in node.names)
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                # of `getattr` or an annotation, and of a program for another process
                yield from re.findall(r"^\w+$|(?<= import )\w+", node.value)


def defined(tree):
    """Functions, classes and constants at the top of a module."""
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield node.name
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            yield from (part.id for target in targets for part in ast.walk(target) if isinstance(part, ast.Name))


def unreached(modules, texts):
    """Public names that nothing uses, by module; texts : templates, which name attributes, and documents."""
    used = {name for trees in modules.values() for name in named(trees)}
    used |= {name for text in texts for name in re.findall(r"\w+", text)}
    return {
        f"{module}.{name}"
        for module, trees in modules.items()
        for name in defined(trees[0])
        if not name.startswith("_") and name not in used
    }


def test_each_module_serves_python_a_command_or_a_bench():
    modules = sources("hcsearch", "hcsearch_bench")
    by_name = [name for name in modules if name.startswith(BY_NAME)]
    assert set(modules) - reached(modules, [*STARTS, "hcsearch", *by_name]) == set()


def test_each_public_name_serves_python_a_command_or_a_bench():
    modules = sources("hcsearch", "hcsearch_bench")
    templates = [file.read_text(encoding="utf-8") for file in (ROOT / "hcsearch").rglob("*.html")]
    documents = [file.read_text(encoding="utf-8") for file in (ROOT / "docs").rglob("*.md")]
    spans = [span for text in documents for span in re.findall(r"`[^`\n]*`", text)]
    ours = {name: trees for name, trees in modules.items() if not name.startswith(BY_NAME)}
    found = {name for name in unreached(modules, [*templates, *spans]) if name.rpartition(".")[0] in ours}
    assert found == set()


def test_what_nothing_reaches_is_found():
    modules = {
        "one": [ast.parse("from two import used\nWIDTH = 3\nprint(used(WIDTH), 'from two import spoken')")],
        "two": [ast.parse("def used(x): ...\ndef left(): ...\ndef spoken(): ...\ndef told(): ...\nDEPTH = 2")],
        "three": [ast.parse("import one")],
    }
    assert unreached(modules, ["`two.told`"]) == {"two.left", "two.DEPTH"}
    assert reached(modules, ["one"]) == {"one", "two"}
