"""Type checks of the arguments of public functions by their annotations; errors name the argument."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from numbers import Integral, Real
from pathlib import Path
from types import NoneType, SimpleNamespace, UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from hcsearch.basics.errors import HcsearchError, wrong_kind_message


def _class_named(name: str, module: str) -> type:
    """Return a stand-in for a class: while its module is not loaded, no value is an instance of it."""

    class Kind(type):
        def __instancecheck__(cls, value: object) -> bool:
            loaded = sys.modules.get(module)
            return loaded is not None and isinstance(value, getattr(loaded, name))

    return Kind(name, (), {})


_NOT_LOADED = {
    "pd": SimpleNamespace(DataFrame=object),
    "Place": str | Path | _class_named("Database", "hcsearch.store.database"),
    "Case": _class_named("Case", "hcsearch.subjects.case"),
}
"""Stand-ins for names in annotations whose modules are loaded only if needed."""
_UNIONS = (Union, UnionType)
_NUMBERS: dict[type, type] = {int: Integral, float: Real}
_SAID = {str: "a text", int: "a whole number", float: "a number", bool: "True or False"}


def check_kinds(function: Callable[..., Any], arguments: Mapping[str, Any]) -> None:
    """Raise HcsearchError for arguments whose types differ from the annotations; arguments : by name.

    The error names the function, the argument and the expected kind.
    """
    for name, kind in _annotated(function).items():
        if not _is(arguments[name], kind):
            raise HcsearchError(
                wrong_kind_message(f"{function.__name__}: {name}", arguments[name], describe_kind(kind))
            )


@cache
def _annotated(function: Callable[..., Any]) -> dict[str, Any]:
    hints = get_type_hints(function, localns=_NOT_LOADED)
    return {name: kind for name, kind in hints.items() if name != "return" and kind is not Any}


def _is(value: Any, kind: Any) -> bool:
    """Return whether a value matches an annotation, including the items of lists and dicts."""
    origin, args = get_origin(kind), get_args(kind)
    if origin in _UNIONS:
        return any(_is(value, item) for item in args)
    if origin is Literal:
        return isinstance(value, (str, bool)) and value in args
    if origin is Sequence:
        return isinstance(value, Sequence) and not isinstance(value, str) and all(_is(item, args[0]) for item in value)
    if origin is Mapping:
        return isinstance(value, Mapping) and all(_is(k, args[0]) and _is(v, args[1]) for k, v in value.items())
    if origin is Callable or _is_protocol(kind):
        return callable(value)
    return isinstance(value, _NUMBERS.get(kind, kind)) and (kind is bool or not isinstance(value, bool))


def describe_kind(kind: Any) -> str:
    """Return an annotation in words."""
    origin, args = get_origin(kind), get_args(kind)
    if origin in _UNIONS:
        return _either([describe_kind(part) for part in args if part is not NoneType])
    if origin is Literal:
        return _either([repr(part) for part in args])
    if origin is Sequence:
        return f"a list of {_several(args[0])}"
    if origin is Mapping:
        return f"a dict from {_several(args[0])} to {_several(args[1])}"
    if origin is Callable or _is_protocol(kind):
        return "a function"
    return _SAID.get(kind) or f"a {kind.__name__}"


def _is_protocol(kind: Any) -> bool:
    """Return whether a kind is a protocol, which here always describes a callable."""
    return bool(getattr(kind, "_is_protocol", False))


def _several(kind: Any) -> str:
    return describe_kind(kind).removeprefix("a ") + "s"


def _either(words: Sequence[str]) -> str:
    return " or ".join(word for word in (", ".join(words[:-1]), words[-1]) if word)
