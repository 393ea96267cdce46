"""Wrong input to the functions of Python is one line that names the argument and what to give, and nothing is run."""

import re

import numpy as np
import pytest

import hcsearch
from hcsearch import (
    GRIDS,
    Array,
    Circuit,
    Folding,
    Linkage,
    Scene,
    count_array,
    deploy,
    enumerate_circuits,
    enumerate_into,
    foldings,
    open_readonly,
    parse_array,
    rank,
    read,
    replay,
    save,
    select,
    tune,
    twist,
)
from hcsearch.basics.errors import HcsearchError

FOLDING = Folding.from_notation("hex:0234550132:4")
CIRCUIT, LINKAGE = FOLDING.circuit, FOLDING.linkage()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Folding.from_notation(5), "the notation of a folding cannot be 5: give a text"),
        (lambda: Folding("hex:024", 0), "give a Circuit, or use Folding.from_notation"),
        (lambda: Circuit.from_notation(None), "cannot be None: give a text, such as 'hex:024'"),
        (lambda: Circuit("hex", (0, 2, 4)), "give a Grid, such as GRIDS['hex']"),
        (lambda: Array.from_notation(3), "the notation of an array cannot be 3"),
        (lambda: Array.from_cells("hex", [(0, 0, 0)]), "(0, 0, 0) is no cell of the hex grid: give (q, r)"),
        (lambda: Array.from_cells("square", [1]), "1 is no cell of the square grid"),
        (lambda: Array.from_cells("triangle", [(0, 0, 2)]), "u 0 (up) or 1 (down)"),
        (lambda: parse_array("hexagon", "3-4-3"), "unknown grid 'hexagon'"),
        (lambda: parse_array("hex", 343), "cannot be 343: give a text, such as '3-4-3'"),
        (enumerate_circuits, "give a grid and n"),
        (lambda: enumerate_circuits("hex", n=6.0), "n cannot be 6.0: give a whole number"),
        (lambda: enumerate_circuits(array="3-4-3"), "give an Array, such as parse_array('hex', '3-4-3')"),
        (lambda: foldings("hex:0234550132"), "give a Circuit, such as Circuit.from_notation"),
        (lambda: twist(CIRCUIT), "give a Folding, such as Folding.from_notation"),
        (lambda: count_array(CIRCUIT), "give an Array"),
        (lambda: Folding(CIRCUIT, 99), "its creases are 3, 4"),
        (lambda: Folding.from_notation("triangle:012345:0"), "at crease 0 or any other: choose a circuit that folds"),
        (lambda: FOLDING.linkage((0.05, 0.006)), "give a text in millimetres, such as '50x6', or three lengths in m"),
        (lambda: FOLDING.linkage(flat_pairs="hing"), "flat_pairs cannot be 'hing': give 'rigid', 'hinged' or 'merged'"),
        (lambda: Linkage(LINKAGE.pattern, 99), "there is no panel 99 to stand on: give 0 to 7"),
        (lambda: LINKAGE.closure(np.zeros(2)), "fold angles are one number for each hinge: give 8"),
        (lambda: LINKAGE.solids("flat"), "fold angles are one number for each hinge: give 8"),
        (lambda: deploy(17), "deploy: what cannot be 17: give a text, a Folding, a Circuit, a Linkage or a Case"),
        (lambda: deploy(FOLDING, 7), "deploy: scene cannot be 7: give a Scene or a text"),
        (lambda: deploy(FOLDING, panel=50), "deploy: panel cannot be 50: give a text"),
        (
            lambda: deploy(FOLDING, flat_pairs="x"),
            "deploy: flat_pairs cannot be 'x': give 'rigid', 'hinged' or 'merged'",
        ),
        (lambda: deploy(FOLDING, formulation="x"), "give 'constrained', 'compliant', 'penalty' or 'quasistatic'"),
        (lambda: deploy(FOLDING, tolerance="a"), "deploy: tolerance cannot be 'a': give a number"),
        (lambda: deploy(LINKAGE, panel="50x6"), "a Linkage has panels and flat pairs: leave out panel"),
        (lambda: tune(FOLDING, evaluations=0), "evaluations cannot be 0: give 1 or more"),
        (lambda: tune(FOLDING, samples=-1), "samples cannot be -1: give 0 or more"),
        (lambda: tune(FOLDING, catalogue="0.1"), "catalogue cannot be '0.1': give a list of numbers"),
        (lambda: tune(FOLDING, spread={"mass": 0.1}), "spread cannot be {'mass': 0.1}: give a Spread"),
        (lambda: tune(FOLDING, progress=3), "progress cannot be 3: give a function"),
        (lambda: replay(LINKAGE), "replay: what cannot be"),
        (lambda: replay(FOLDING, motion="x"), "replay: motion cannot be 'x': give 'path' or 'springs'"),
        (lambda: save(FOLDING, "x.csv", motion="x"), "save: motion cannot be 'x': give 'path' or 'springs'"),
        (lambda: save(FOLDING, 5), "save: path cannot be 5: give a text or a Path"),
        (lambda: enumerate_into("a.db", grid="hex", n="6"), "enumerate_into: n cannot be '6': give a whole number"),
        (lambda: enumerate_into("a.db", grid="hex", n=6, keep="x"), "give 'all', 'two-stack' or 'untwisted'"),
        (lambda: enumerate_into("a.db", grid="hex", n=6, jobs=0), "--jobs 0 is too few"),
        (lambda: enumerate_into("a.db", grid="hex", n=6, announce=3), "announce cannot be 3: give a function"),
        (lambda: enumerate_into("a.db", grid="square", array=CIRCUIT.array), "the array is on the grid hex"),
        (lambda: read(5), "read: db cannot be 5: give a text, a Path or a Database"),
        (lambda: read("a.db", columns=[1]), "columns cannot be [1]: give a text or a list of texts"),
        (lambda: rank("a.db", weights={"dof": "a"}), "give a dict from texts to numbers"),
        (lambda: rank("a.db", limit=-1), "the limit -1 is negative"),
        (lambda: open_readonly(None), "None names no database: give a path"),
        (lambda: select("a.db"), "give an open one, such as open_readonly"),
        (lambda: deploy(FOLDING, Scene(density=-1)), "density cannot be -1"),
        (lambda: deploy(FOLDING, Scene(margin="1")), "margin cannot be '1': give a number"),
        (lambda: deploy(FOLDING, Scene(panel="50x6")), "give length, width and thickness in m"),
        (lambda: deploy(FOLDING, Scene(springs={7: "free"})), "give pairs of a hinge and its law"),
        (lambda: deploy(FOLDING, Scene(name=5)), "name cannot be 5: give a text"),
        (lambda: deploy(LINKAGE, Scene(gravity=5)), "gravity cannot be 5: give x,y,z"),
        (lambda: enumerate_into("a.db", grid="hex", n=6, scene=Scene(flat_pairs="x")), "flat_pairs cannot be 'x'"),
    ],
)
def test_wrong_input_is_refused_in_one_line(call, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(HcsearchError, match=re.escape(message)):
        call()
    assert list(tmp_path.iterdir()) == []


def test_grids_go_by_their_names_and_panels_by_texts_in_millimetres():
    assert parse_array("hex", "3-4-3") == parse_array(GRIDS["hex"], "3-4-3")
    assert Array.from_cells("square", [[0, 0], np.array([1, 0])]).notation == "square:3"
    assert FOLDING.linkage("50x6") == FOLDING.linkage((0.05, 0.05, 0.006))


def test_results_have_a_short_text():
    replayed = hcsearch.replay(FOLDING, motion="springs", seconds=0.001)
    pattern = "<Pattern of 10 facets, 8 panels, 8 hinges, 6 mm thick>"
    assert repr(LINKAGE.pattern) == pattern
    assert re.fullmatch(r"<hex:0234550132:4: simulated in .*; \d+ states>", repr(replayed))
    tuning = tune("hex:0233340501:3", evaluations=1, samples=0)
    assert re.fullmatch(r"<8 tuned springs: .*certified clear, \d+ evaluations>", repr(tuning))
