"""Values that hold arrays: `==` says whether they are equal, and they are members of lists, sets and dictionaries."""

import dataclasses
import importlib
import inspect
import math
import typing
from collections.abc import Callable
from dataclasses import dataclass, replace
from pkgutil import walk_packages

import numpy as np
import pytest

import hcsearch
from hcsearch import Deployed, Replay, Tuning, deploy, replay, tune
from hcsearch.basics.array_values import ByValue

MOVING = "hex:0234550132:4"
LATER = ("hcsearch.store.migrations.", "hcsearch.__main__")
"""Modules that are run, and not imported."""


def dataclasses_of_the_program():
    for found in walk_packages(hcsearch.__path__, "hcsearch."):
        if found.name.startswith(LATER):
            continue
        try:
            module = importlib.import_module(found.name)
        except ModuleNotFoundError:  # of an extra
            continue
        for value in vars(module).values():
            if inspect.isclass(value) and dataclasses.is_dataclass(value) and value.__module__ == found.name:
                yield value


def holds_arrays(kind):
    """Whether values of an annotation may be arrays, or tuples, lists or mappings of them."""
    if typing.get_origin(kind) in {Callable, type}:
        return False
    if inspect.isclass(kind) and issubclass(kind, tuple) and hasattr(kind, "_fields"):
        return any(map(holds_arrays, typing.get_type_hints(kind).values()))
    own = typing.get_origin(kind) or kind
    return (inspect.isclass(own) and issubclass(own, np.ndarray)) or any(map(holds_arrays, typing.get_args(kind)))


def annotations_of(kind):
    """What the fields of a class are; names that only type checkers import are left out."""
    module = vars(importlib.import_module(kind.__module__))
    for own in dataclasses.fields(kind):
        if own.compare:
            try:
                yield eval(own.type, dict(module)) if isinstance(own.type, str) else own.type
            except NameError:
                assert "Reals" not in own.type


def test_every_class_with_arrays_compares_them_as_wholes():
    holding = [kind for kind in dataclasses_of_the_program() if any(map(holds_arrays, annotations_of(kind)))]
    assert {"Motion", "Replay", "CompiledScene", "StagedDesigns", "StoredPath"} <= {kind.__name__ for kind in holding}
    # a class that is made with eq=True has an `__eq__` of its own; what grows or goes on is itself alone
    alone = {"_Chain", "CubeFlood", "_FacePart", "FlatModel"}
    ways = {kind: (kind.__eq__, kind.__hash__) for kind in holding if kind.__name__ not in alone}
    assert [kind for kind, way in ways.items() if way != (ByValue.__eq__, ByValue.__hash__)] == []


@dataclass(frozen=True, eq=False)
class Value(ByValue):
    content: object
    aside: object = dataclasses.field(default=0, compare=False)


@pytest.mark.parametrize(
    ("one", "two", "equal"),
    [
        (np.arange(3), np.arange(3), True),
        (np.arange(3), np.arange(3.0), True),
        (np.arange(3), np.arange(4), False),
        (np.arange(3), np.zeros((1, 3)), False),
        (np.array([0.0, math.nan]), np.array([-0.0, math.nan]), True),
        (np.array([0.0, 1.0]), np.array([0.0, math.nan]), False),
        (np.arange(1), 0, False),
        (np.array([True]), np.array([False]), False),
        (np.array(["a"]), np.array(["a"]), True),
        ((np.arange(2), "a"), (np.arange(2), "a"), True),
        ((np.arange(2), "a"), (np.arange(2), "b"), False),
        ([np.arange(2)], (np.arange(2),), False),
        ({"a": np.arange(2)}, {"a": np.arange(2)}, True),
        ({"a": np.arange(2)}, {"a": np.ones(2)}, False),
        ({"a": np.arange(2)}, {"b": np.arange(2)}, False),
        (Value(np.arange(2)), Value(np.arange(2)), True),
        (math.nan, float("nan"), True),
        (math.nan, 1.0, False),
        (None, np.arange(2), False),
    ],
)
def test_contents_are_compared_and_hashed(one, two, equal):
    first, second = Value(one, aside=1), Value(two, aside=2)
    assert (first == second) is equal
    assert (second == first) is equal
    assert (first != second) is not equal
    assert (first in [second]) is equal
    assert len({first, second}) == 2 - equal


def test_other_classes_are_never_equal():
    assert Value(np.arange(2)) != np.arange(3).tolist()
    assert replace(Value(1)) != 1


def made_twice(make, *words, **options):
    return make(*words, **options), make(*words, **options)


@pytest.mark.parametrize(
    ("make", "options", "kind", "change"),
    [
        (deploy, {}, Deployed, {"start": 0.99}),
        (replay, {}, Replay, {"panel": "50x7"}),
        (tune, {"evaluations": 3}, Tuning, {"spring_range": "0.05,0.3"}),
    ],
)
def test_results_of_one_call_made_twice_are_equal(make, options, kind, change):
    one, two = made_twice(make, MOVING, **options)
    assert isinstance(one, kind)
    assert one == two
    assert one in [two]
    assert len({one, two}) == 1
    other = make(MOVING, **options | change)
    assert one != other
    assert len({one, other}) == 2
