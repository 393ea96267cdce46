"""Names of a package that are imported from their modules on first use."""

from __future__ import annotations

TYPE_CHECKING = False  # as type checkers know it; `typing` takes longer to load than Ctrl-C may go unanswered
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence


def importing(package: str, homes: Mapping[str, Sequence[str]]) -> Callable[[str], object]:
    """The `__getattr__` of a package; homes : the names in each of its modules."""
    module_of = {name: module for module, names in homes.items() for name in names}

    def find(name: str) -> object:
        if name not in module_of:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        from importlib import import_module  # noqa: PLC0415 - as `typing` above

        return getattr(import_module(f"{package}.{module_of[name]}"), name)

    return find
