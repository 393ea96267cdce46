"""Mutated notations through the Python API: each is read, and reads back as the same, or is refused in one line."""

import random

import pytest

from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import split_crease
from hcsearch.designs.grid import GRIDS, Array, grid_named, parse_array
from hcsearch.store.conditions import parse_query, quantities_named, sort_terms
from tests.fuzz.mutations import judge, mutated

SEEDS = [
    *("6x5", "3-4-3", "4-4-4", "p5x4", "t5", "h3", "@cells.txt", "@/dev/zero", "hex:e.f.7", "square:f.f"),
    *("hex:f." + "f" * 50_000, "hex:" + "f." * 20_000 + "f", "9" * 5000 + "x1", "1-" * 20_000 + "1", "triangle:7.f"),
    *("hex:0234550132", "hex:024", "rectangle:1233300011123321", "triangle:012345", "square:0123", "hex:" + "0" * 9999),
    *("hex:" + "0" * 50_000, "hex:0234550132:4", "hex:0234550132:" + "0" * 5000, "17:4", "17", "9" * 5000),
    *("grid=hex n=12 untwisted dof<=6", "array=4-4-4 or not(circuit=hex:024 score>1e300)", "status=deploys or n=6"),
    *("(" * 2000 + "n=6" + ")" * 2000, "not " * 2000 + "n=6", "n=6 " * 2000, "-score,n,id", "array=@/dev/zero"),
    *("", "\ud800", "hex\0", "\x1b[31m", "hex:0234550132:" + "9" * 5000),
]


def judge_all(text):
    """How many readers take a text."""
    taken = [judge(text, lambda t, g=grid: parse_array(g, t), lambda a: eval(repr(a))) for grid in GRIDS.values()]
    taken.append(judge(text, Array.from_notation, lambda array: Array.from_notation(array.notation)))
    taken.append(judge(text, Circuit.from_notation, lambda circuit: Circuit.from_notation(circuit.notation)))
    taken.append(judge(text, lambda t: Circuit.from_notation(t).canonical(), lambda circuit: circuit.canonical()))
    taken.append(judge(text, split_crease))
    taken.append(judge(text, parse_query))
    taken.append(judge(text, lambda t: sort_terms("designs", t)))
    taken.append(judge(text, lambda t: quantities_named("designs", t)))
    taken.append(judge(text, grid_named))
    return sum(taken)


def fuzz(seed, count, folder):
    """Judge so many mutations; the numbers taken and refused by all."""
    (folder / "cells.txt").write_text("0 0\n0 1\n1 0\n")
    chance = random.Random(seed)
    numbers = [judge_all(text) for text in SEEDS]
    numbers += [judge_all(mutated(chance, chance.choice(SEEDS))) for _ in range(count)]
    return sum(map(bool, numbers)), numbers.count(0)


def test_mutated_notations_are_read_or_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    taken, refused = fuzz(1, 300, tmp_path)
    assert taken > 50
    assert refused > 50


@pytest.mark.slow
def test_many_mutated_notations_are_read_or_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    taken, refused = fuzz(2, 1500, tmp_path)
    assert taken > 400
    assert refused > 250
