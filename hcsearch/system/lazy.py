"""Lazy imports: names of a package are imported from their modules on first use.

The stub `__init__.pyi` beside a package's `__init__.py` is the only list of its names, for type checkers and readers:
it imports each name from its module, in groups with a comment as heading.
"""

from __future__ import annotations

TYPE_CHECKING = False  # as type checkers know it; `typing` takes longer to load than Ctrl-C may go unanswered
if TYPE_CHECKING:
    from collections.abc import Callable

_READ: dict[str, dict[str, dict[str, str]]] = {}


def names_in_stub(package: str) -> dict[str, dict[str, str]]:
    """Return the module of each public name of a package, by group, as listed in its stub."""
    if package not in _READ:
        import ast  # noqa: PLC0415 - as `typing` above
        import sys  # noqa: PLC0415
        from pathlib import Path  # noqa: PLC0415

        text = Path(str(sys.modules[package].__file__)).with_suffix(".pyi").read_text(encoding="utf-8")
        lines = text.splitlines()
        groups: dict[str, dict[str, str]] = {}
        group, last_line = "", 0
        for node in ast.parse(text).body:
            if not isinstance(node, ast.ImportFrom):
                continue
            headings = [line for line in lines[last_line : node.lineno - 1] if line.startswith("# ")]
            group, last_line = headings[-1].removeprefix("# ") if headings else group, node.lineno
            names = groups.setdefault(group, {})
            names.update({alias.asname or alias.name: str(node.module) for alias in node.names})
        _READ[package] = groups
    return _READ[package]


def lazy_importer(package: str) -> Callable[[str], object]:
    """Return a `__getattr__` for a package, which also supplies `__all__`."""

    def find(name: str) -> object:
        modules = {alias: module for group in names_in_stub(package).values() for alias, module in group.items()}
        if name == "__all__":
            return sorted(modules)
        if name not in modules:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        from importlib import import_module  # noqa: PLC0415 - as `typing` above

        return getattr(import_module(modules[name]), name)

    return find
