"""Damaged models of robots: each shows a pattern, or is refused in one line."""

import json
import random
from xml.etree import ElementTree as Xml

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch import save
from hcsearch.subjects.pattern_files import read_pattern_file
from tests.fuzz.mutations import judge, mutated
from tests.fuzz.test_fuzz_fold import changed

VALUES = ["", "0", "nan", "1e308", "1e11", "x", "0 0 0", "0 0 1", "0.1 0.1 0.1", "panel_0", "panel_1", "hinge_0"]


@pytest.fixture(scope="module")
def models(tmp_path_factory):
    """A folder with a model of each kind, and the content of its files."""
    folder = tmp_path_factory.mktemp("models")
    for name in ("a.urdf", "b.xml"):
        save("element-6r", folder / name)
    return {path: path.read_bytes() for path in folder.iterdir()}


def _damaged(chance, path, content):
    kind = chance.choice((".stl", ".json", "text", "tree", "tree"))
    if path.suffix == ".stl" or kind == ".stl":
        place = chance.randrange(len(content))
        return content[:place] + chance.choice((b"", b"\x7f\xc0", content[place:][::-1]))
    if path.suffix == ".json":
        return json.dumps(changed(chance, json.loads(content))).encode()
    if kind == "text":
        return mutated(chance, content.decode()).encode(errors="replace")
    root = Xml.fromstring(content)
    for _ in range(chance.randint(1, 2)):
        element, other = (chance.choice(list(root.iter())) for _ in range(2))
        for parent in list(root.iter()):  # an element that stands in it twice has been visited before
            if element in list(parent):
                chance.choice((parent.remove, parent.append))(element)
        if element.attrib:
            element.attrib[chance.choice(list(element.attrib))] = chance.choice(VALUES)
        element.tag = chance.choice((element.tag, element.tag, other.tag))
    return Xml.tostring(root)


@settings(max_examples=40)
@given(st.integers(0, 2**32))
def test_damaged_models_are_read_or_refused(models, seed):
    chance = random.Random(seed)
    folder = next(iter(models)).parent
    victim = folder / chance.choice(("a.urdf", "a.closure.json", "a.panel_0.stl", "b.xml"))
    try:
        victim.write_bytes(_damaged(chance, victim, models[victim]))
        judge(str(folder / ("b.xml" if victim.suffix == ".xml" else "a.urdf")), read_pattern_file)
    finally:
        victim.write_bytes(models[victim])
