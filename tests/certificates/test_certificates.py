"""Certificates: what is proved of foldings is proved by the checkers, alone, and what is changed is refused."""

import ast
import copy
import json
import math
import random
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest
from click.testing import CliRunner

from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import WAYS
from hcsearch.cli import hcsearch
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, foldings
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.motion.certificates import (
    balls,
    certificate_grammar,
    collision_checker,
    lock_checker,
    path_checker,
    polynomials,
)
from hcsearch.motion.certificates.certificate_data import array_data, lock_claim
from hcsearch.motion.certificates.certificate_grammar import NotProvedError, checksum
from hcsearch.motion.certificates.certifying import CertificateError, prove_folding, verify_certificate
from hcsearch.motion.locks.enclosures import Enclosure
from hcsearch.motion.planning.motion_search import plan_motion
from hcsearch.motion.searching import Budget
from hcsearch.scenes import SCENES
from tests.planned import joined, region_of
from tests.strategies import writings

DEFAULT = SCENES["default"]
CHECKERS = {"path": path_checker, "lock": lock_checker, "collision": collision_checker}
LINES = 400
SAMPLES = {
    "hex:0234550132:4": ["path"],
    "square:012233230011:4": ["path"],
    "square:01222300:0": ["path"],  # of simple moves
    "triangle:012343454505012321:3": ["path"],
    "kite:1320302313:4": ["path"],
    "right45:0101:0": ["path"],  # of one hinge, in no loop
    "hex:0233534001:3": ["lock"],
    "hex:0232335050:2": ["lock"],
    "hex:0232435051:3": ["collision"],
}


def proof_of(folding, **options):
    return prove_folding(folding, default_panel(folding.circuit.grid.name), WAYS, None, **options)


@cache
def certificate(name):
    """The certificate of a folding, as it is read from a file."""
    return json.loads(json.dumps(proved(name)[0]))


@cache
def proved(name):
    """The certificate of a folding, and what is said of it."""
    return proof_of(Folding.from_notation(name))


def signed(data):
    """A changed certificate with the checksum of what it holds."""
    return {**data, "sha256": checksum({key: value for key, value in data.items() if key != "sha256"})}


@pytest.mark.parametrize("name", SAMPLES)
def test_what_is_proved_is_proved_by_the_checkers(name):
    data = certificate(name)
    assert [claim["kind"] for claim in data["claims"]] == SAMPLES[name]
    sentences = verify_certificate(data)
    assert all(name in sentence for sentence in sentences)
    assert sentences == proved(name)[1]
    for claim in data["claims"]:
        assert claim["array"] == array_data(joined(name, claim["pairs"]))


@pytest.mark.parametrize("name", ["hex:0233435001:2", "hex:0223335500:4", "square:0112223300:4", "hex:0234435011:4"])
def test_boxes_of_a_region_are_proved_by_the_checker(name):
    linkage = joined(name, "hinged")
    region = region_of(linkage, 1, 3000, climbs=300)
    assert region.run(Budget(20_000))
    lock = Enclosure("flat", region.cubes, region.faces, region.efforts, False, None, *region.bounds)
    sentence = lock_checker.checked(json.loads(json.dumps(lock_claim(linkage, lock))))
    assert sentence.startswith(f"no motion leads from flat to packed, or leaves {region.cubes} boxes of fold angles: ")
    assert region.cubes > 5


@pytest.mark.parametrize("kind", CHECKERS)
def test_a_checker_needs_numpy_and_its_folder_alone(kind, tmp_path):
    own = [Path(module.__file__) for module in (*CHECKERS.values(), balls, polynomials, certificate_grammar)]
    for source in own:
        text = source.read_text(encoding="utf-8")
        assert text.count("\n") <= LINES
        for node in ast.walk(ast.parse(text)):
            names = [node.module] if isinstance(node, ast.ImportFrom) else []
            names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            allowed = {"numpy", *sys.stdlib_module_names, *(file.stem for file in own)}
            names = [name.removeprefix("hcsearch.motion.certificates.") for name in names]
            assert {name.split(".")[0] for name in names} <= allowed | {"hcsearch"}
            assert "hcsearch" not in names
        shutil.copy(source, tmp_path)
    name = {"path": "square:01222300:0", "lock": "hex:0233534001:3", "collision": "hex:0232435051:3"}[kind]
    data = certificate(name)
    (claim,), array = data["claims"], data["claims"][0]["array"]
    keep = {"path": ["stretches"], "lock": ["lows", "highs"], "collision": ["pairs_of_facets"]}[kind]
    wrong = {key: claim[key][:1] for key in keep}
    hinges = [array["hinges"][0] | {"face": "side"}, *array["hinges"][1:]]
    for file, content in {
        "proof": data,
        "refused": signed({**data, "claims": [claim | wrong]}),
        "changed": {**data, "claims": [claim | wrong]},
        "side": signed({**data, "claims": [claim | {"array": array | {"hinges": hinges}}]}),
        "none": [],
    }.items():
        (tmp_path / file).write_text(json.dumps(content), encoding="utf-8")
    source = Path(CHECKERS[kind].__file__).name

    def run(file, *options):
        command = [sys.executable, "-E", "-s", source, file, *options]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)

    proved = run("proof")
    assert proved.returncode == 0
    assert name in proved.stdout
    for file, code, reason in (
        ("refused", 1, "not proved"),
        ("changed", 2, "the file was changed"),
        ("side", 2, "a hinge is on no face"),
        ("none", 2, "it is no hcsearch certificate of version 1"),
    ):
        failed = run(file)
        assert failed.returncode == code
        assert reason in failed.stderr
        assert failed.stderr.count("\n") == 1
    late = run("proof", "--seconds", "1e-9")
    assert late.returncode == 1
    assert late.stderr == "proof: not proved: not decided in 1e-09 s: give --seconds 1e-08\n"


def leaves(data, path=()):
    """Where the numbers, words and truths of a certificate stand."""
    if isinstance(data, dict | list):
        items = data.items() if isinstance(data, dict) else enumerate(data)
        for key, value in items:
            yield from leaves(value, (*path, key))
    else:
        yield path


def changed_at(data, path, change):
    """A copy of a certificate with one value changed."""
    changed = copy.deepcopy(data)
    place = changed
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = change(place[path[-1]])
    return changed


SPOILED = (None, "", "x", [], {}, [[]], -1, 10**30, 1e300, math.nan, math.inf)


def spoiled(value, rng):
    """Another value of any kind."""
    return rng.choice([other for other in SPOILED if other != value and type(other) is not type(value)])


def test_six_hundred_certificates_with_a_value_of_another_kind_are_refused():
    rng = random.Random(1)
    for name in ("square:01222300:0", "hex:0233534001:3", "hex:0232435051:3"):
        data = certificate(name)
        places = list(leaves(data["claims"]))
        for _ in range(200):
            changed = changed_at(data["claims"], rng.choice(places), lambda value: spoiled(value, rng))
            with pytest.raises(CertificateError):
                verify_certificate(signed({**data, "claims": changed}))


def test_four_hundred_certificates_of_another_array_are_refused():
    rng = random.Random(2)
    for name in ("square:01222300:0", "hex:0234550132:4", "hex:0233534001:3", "hex:0232335050:2"):
        data = certificate(name)
        array = data["claims"][0]["array"]
        places = list(leaves(array))
        for _ in range(100):
            changed = changed_at(
                array,
                rng.choice(places),
                lambda value: (
                    (not value) if isinstance(value, bool) else value + 1 if isinstance(value, int) else value + "1"
                ),
            )
            claims = [{**data["claims"][0], "array": changed}]
            with pytest.raises(CertificateError):
                verify_certificate(signed({**data, "claims": claims}))


def test_a_file_that_was_changed_is_refused():
    data = certificate("hex:0232335050:2")
    rng = random.Random(3)
    places = list(leaves(data))
    for _ in range(200):
        changed = changed_at(data, rng.choice(places), lambda value: spoiled(value, rng))
        with pytest.raises(CertificateError):
            verify_certificate(changed)


def refused(claim):
    """Whether a claim is refused by its checker."""
    checker = CHECKERS[claim["kind"]]
    try:
        checker.checked(claim)
    except NotProvedError:
        return True
    return False


def test_a_path_that_leaves_closed_states_is_refused():
    claim, rng = certificate("hex:0234550132:4")["claims"][0], random.Random(4)
    (stretch,) = claim["stretches"]
    states, hinges = len(stretch["angles"]), len(stretch["angles"][0])
    for row in ("angles", "rates"):
        for _ in range(4):
            own = copy.deepcopy(stretch)
            own[row][rng.randrange(1, states - 1)][rng.randrange(hinges)] += rng.choice([-1.0, 1.0]) * 1e-2
            assert refused({**claim, "stretches": [own]})
    for cut in (slice(1, None), slice(None, -1)):
        own = {key: value if key == "kind" else value[cut] for key, value in stretch.items()}
        assert refused({**claim, "stretches": [own]})


def test_a_path_of_other_simple_moves_is_refused():
    claim = certificate("square:01222300:0")["claims"][0]
    first, second = claim["stretches"]
    for stretches in ([], [first], [second], [first, first], [first, second, second]):
        assert refused({**claim, "stretches": stretches})
    for hinge in range(len(claim["array"]["hinges"])):
        hinges = set(first["hinges"]) ^ {hinge}
        assert refused({**claim, "stretches": [{**first, "hinges": sorted(hinges)}, second]})


@pytest.mark.parametrize("name", ["hex:0234550132:4", "square:012233230011:4"])
def test_margins_at_which_panels_collide_or_stops_are_overstepped_are_refused(name):
    claim = certificate(name)["claims"][0]
    for margin in (1e-9, 0.0, -1e-4, 0.01):
        assert refused({**claim, "margin": repr(margin)})


def test_a_hinge_between_other_panels_than_its_facets_is_refused():
    """A number that counts from the end names a facet, too; in the list of another panel it would open the loop."""
    claim = copy.deepcopy(certificate("square:01222300:0")["claims"][0])
    array = claim["array"]
    last = len(array["facets"]) - 1
    hinge = next(hinge for hinge in array["hinges"] if last in hinge["facets"])
    hinge["facets"] = [-1 if facet == last else facet for facet in hinge["facets"]]
    for panel in array["panels"]:
        panel.append(-1)
        assert refused(claim)
        panel.remove(-1)


def test_boxes_that_a_motion_leaves_are_refused():
    claim = certificate("hex:0233534001:3")["claims"][0]
    assert not refused(claim)
    assert refused({**claim, "end": "flat" if claim["end"] == "packed" else "packed"})
    for keep in (slice(0, 1), slice(0, 3)):
        assert refused({**claim, "lows": claim["lows"][keep], "highs": claim["highs"][keep]})
    moving = array_data(joined("hex:0234550132:4", "hinged"))
    assert refused({**claim, "array": moving})


@pytest.mark.parametrize(
    ("name", "way"), [("rhombus:23121320:1", "hinged"), ("kite:23203030:3", "rigid"), ("right30:20201210:3", "rigid")]
)
def test_boxes_that_hold_the_other_end_below_a_last_cut_are_refused(name, way):
    """A review built this in 2026: a hinge has two cuts beyond pi, and its last face, beyond its stop, is empty."""
    array, above = array_data(joined(name, way)), math.nextafter(math.pi, 4.0)
    n = len(array["hinges"])
    boxes = {"lows": [[0] * n], "highs": [[1] * n], "tried": 100_000}
    for own in (hinge for hinge in range(n) if array["hinges"][hinge]["closes"]):
        cuts = [[0.0, 3.1999, 3.19999] if hinge == own else [0.0, above] for hinge in range(n)]
        for end in ("flat", "packed"):
            claim = {"kind": "lock", "array": array, "end": end, "cuts": cuts, **boxes}
            collision = {**claim, "kind": "collision", "margin": "0.0001", "pairs_of_facets": [[0, n // 2]]}
            for false in (claim, collision):
                with pytest.raises(NotProvedError, match="hold the one end alone"):
                    CHECKERS[false["kind"]].checked(false)


def test_margins_with_which_facets_pass_each_other_are_refused():
    """With 1.2 mm of play a path is met. Without its pairs of facets, closure does not lock it."""
    claim = certificate("hex:0232435051:3")["claims"][0]
    assert not refused(claim)
    assert not refused({**claim, "margin": "0.00005"})
    for margin in ("0.0014", "0.003", "-0.0001", "nan"):
        assert refused({**claim, "margin": margin})
    for pairs in ([], claim["pairs_of_facets"][:1], [[0, 0]], [[0, -1]], [[0, 99]]):
        assert refused({**claim, "pairs_of_facets": pairs})
    assert refused({**claim, "kind": "lock"})


def test_a_folding_that_is_written_differently_has_the_same_certificate():
    """Its lock is found in the position of another one, whose hinges have other numbers."""
    name, panel = "hex:0233534001:3", default_panel("hex")
    circuit = Circuit.from_notation(name.rpartition(":")[0])
    for number, writing in enumerate(writings(circuit)):
        if number % 5 == 1:
            own = [folding for folding in foldings(writing) if folding.likeness(panel).folding.notation == name]
            assert proof_of(own[0]) == proved(name)
            ((_, lock),) = plan_motion(own[0], panel, ("hinged",), budget=3).locks
            claim = lock_claim(own[0].linkage(panel, flat_pairs="hinged"), lock)
            assert not refused(json.loads(json.dumps(claim)))


def test_commands_write_and_check_certificates(tmp_path):
    file = str(tmp_path / "proof.json")
    runner = CliRunner()
    written = runner.invoke(hcsearch, ["prove", "hex:0233534001:3", "--output", file, "--panel", "100x12"])
    assert written.exit_code == 0
    assert "panels of 100x100x12 mm" in written.output
    checked = runner.invoke(hcsearch, ["verify", file])
    assert checked.exit_code == 0
    assert checked.output in written.output
    data = json.loads(Path(file).read_text(encoding="utf-8"))
    data["panel_mm"] = "50x50x6"
    Path(file).write_text(json.dumps(signed(data)), encoding="utf-8")
    other = runner.invoke(hcsearch, ["verify", file])
    assert other.exit_code == 1
    assert "not proved: its array is not that of" in other.stderr


def test_what_has_no_certificate():
    with pytest.raises(HcsearchError, match="is twisted, with linking number"):
        proof_of(Folding.from_notation("hex:0234405022:1"))
    with pytest.raises(HcsearchError, match="give --budget 3"):
        proof_of(Folding.from_notation("hex:0234451512:0"), budget=1)
