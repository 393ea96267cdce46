"""Mutated FOLD files: each shows a design, or is refused in one line."""

import json
import random

import pytest

from hcsearch.search.own_patterns.fold_reading import parse_fold
from hcsearch.search.own_patterns.recognition import drawn_panel_size, recognise_design
from tests.export.exports import DESIGN, RING, exported, pattern_of, written
from tests.fuzz.mutations import judge, mutated

VALUES = [None, True, -1, 0, 2, 1e308, -1e300, float("nan"), float("inf"), "x", "", [], {}, [0, 0], 10**400, 3.7]
VALUES += list("MVFUBCJ")


def read(text):
    drawing = parse_fold(text)
    found = recognise_design(drawing)
    assert pattern_of(drawing, 1e-3).area > 0.0
    return drawn_panel_size(found, drawing)


def changed(chance, value):
    """A value of a file with one change somewhere within it."""
    if isinstance(value, dict | list) and value and chance.random() < 0.8:
        key = chance.choice(list(value)) if isinstance(value, dict) else chance.randrange(len(value))
        kind = chance.randrange(4)
        if kind == 0:
            del value[key]
        elif kind == 1 and isinstance(value, list):
            value.insert(key, json.loads(json.dumps(chance.choice(value))))
        else:
            value[key] = changed(chance, value[key])
        return value
    if isinstance(value, float) and chance.random() < 0.7:
        return value + chance.choice((1e-6, 0.01, 1.0, 50.0, -50.0))
    return chance.choice(VALUES)


@pytest.mark.parametrize("name", [DESIGN, RING])
def test_files_with_other_values_are_read_or_refused(name):
    chance = random.Random(name)
    whole = json.loads(written(exported(name)))
    del whole["file_frames"]
    taken = 0
    for _ in range(400):
        data = json.loads(json.dumps(whole))
        for _ in range(chance.randint(0, 3)):
            data = changed(chance, data)
        taken += judge(json.dumps(data), read)
    assert taken > 40


def test_files_with_other_letters_are_read_or_refused():
    chance = random.Random(1)
    text = written(exported(DESIGN))
    text = text[: text.index('"file_frames"') - 3] + "}"
    assert sum(judge(mutated(chance, text).encode(errors="replace").decode(), read) for _ in range(400)) > 40
