"""Attacks on the checkers: no false certificate is accepted, by either of two checkers, and honest ones are."""

import json
import random
import re
from functools import cache
from pathlib import Path

import pytest
from click.testing import CliRunner

from hcsearch.cli import hcsearch
from hcsearch.motion.certificates import collision_checker, lock_checker, path_checker
from hcsearch.motion.certificates.certificate_grammar import NotProvedError
from hcsearch.motion.certificates.certifying import verify_certificate
from tests.certificates.attack_run import faults
from tests.certificates.attacks import REASONS, attacks_on, locks, refusal, renamed
from tests.certificates.exact_arrays import RefusedError
from tests.certificates.exact_checker import checked
from tests.certificates.mutations import mutated, verified

FOLDER = Path(__file__).parent
CHECKERS = {"path": path_checker, "lock": lock_checker, "collision": collision_checker}
CORPUS = json.loads((FOLDER / "corpus" / "index.json").read_text(encoding="utf-8"))
HONEST = sorted((FOLDER / "honest").glob("*.json"))
OF_PATHS = [file for file in HONEST if '"stretches"' in file.read_text(encoding="utf-8")]
FEW_BOXES = 30
"""Number of boxes that the exact checker tries of a claim that is false."""


@cache
def read(file):
    return json.loads(file.read_text(encoding="utf-8"))


def refuses_exactly(claim):
    """Whether the exact checker refuses a claim."""
    try:
        checked(claim, limit=FEW_BOXES)
    except RefusedError:
        return True
    return False


def test_the_corpus_is_listed():
    assert {entry["file"] for entry in CORPUS} == {file.name for file in (FOLDER / "corpus").iterdir()} - {"index.json"}
    assert {entry["reason"] for entry in CORPUS} <= set(REASONS)
    assert all(entry["why"] and entry["source"] and entry["date"] for entry in CORPUS)


@pytest.mark.parametrize("entry", CORPUS, ids=lambda entry: entry["file"])
def test_a_wrong_certificate_is_refused_for_its_reason(entry):
    file = FOLDER / "corpus" / entry["file"]
    result = CliRunner().invoke(hcsearch, ["verify", str(file)])
    assert result.exit_code in (1, 2)
    assert not result.stdout
    assert result.stderr.count("\n") == 1
    assert result.stderr.strip("\n").isprintable()
    assert re.search(REASONS[entry["reason"]], result.stderr)
    if entry["reason"] == "document" or entry["file"] == "keys_twice.json":
        assert result.exit_code == 2
        return
    data = read(file)
    if entry["reason"] == "name":  # what it claims may be true of another folding
        return
    claims = [claim for claim in data["claims"] if isinstance(claim, dict) and claim.get("kind") in CHECKERS]
    for claim in claims:
        with pytest.raises(NotProvedError):
            CHECKERS[claim["kind"]].checked(claim)
    if not re.search("parts$|checksum", file.stem):
        assert all(map(refuses_exactly, claims))


@pytest.mark.parametrize("file", HONEST, ids=lambda file: file.stem)
def test_an_honest_certificate_is_accepted_by_both_checkers(file):
    data = read(file)
    assert len(verify_certificate(data)) == len(data["claims"])
    if data["of"] == "hex:0233534001:3":  # it takes the exact checker a minute
        return
    for claim in data["claims"]:
        assert claim["kind"] in checked(claim)


@pytest.mark.slow
@pytest.mark.parametrize("file", OF_PATHS, ids=lambda file: file.stem)
def test_false_certificates_of_a_folding_that_moves_are_refused(file):
    data = read(file)
    built = attacks_on(data, seed=1, count=50)
    found = [fault for attack in built for fault in faults(data, attack)[0]]
    assert not found
    for kind, *certificate in renamed(data, "hex:0234550132:4", random.Random(1)):
        assert refusal(*certificate), kind


@pytest.mark.slow
@pytest.mark.parametrize("file", OF_PATHS, ids=lambda file: file.stem)
def test_the_exact_checker_refuses_false_certificates(file):
    built = attacks_on(read(file), seed=2, count=20)
    assert [attack.kind for attack in built if attack.named and not refuses_exactly(attack.claim)] == []


def test_a_box_about_an_end_is_left_by_a_path():
    """The one attack that says nothing odd: both checkers search its faces, and find the path there."""
    claim = read(FOLDER / "honest" / "hex_023350_1.json")["claims"][0]
    attacks = [attack for attack in locks(claim, random.Random(1)) if attack.kind == "lock: a box about an end"]
    assert len(attacks) == 2
    for attack in attacks:
        with pytest.raises(NotProvedError, match="a face of its boxes"):
            lock_checker.checked(attack.claim)
        with pytest.raises(RefusedError, match="a face of its boxes"):
            checked(attack.claim)


def test_paths_of_a_locked_folding_are_refused():
    """A motion of another folding, equal turns and straight lines do not open a lock."""
    lock = read(FOLDER / "honest" / "hex_0234435011_4.json")["claims"][0]
    array = lock["array"]
    base = {"kind": "path", "array": array, "pairs": lock["pairs"], "margin": "0.00002"}
    closing = [k for k, hinge in enumerate(array["hinges"]) if hinge["closes"]]
    rng = random.Random(5)
    for _ in range(40):
        rest, stretches = list(closing), []
        while rest:
            own = rng.sample(rest, rng.randint(1, len(rest)))
            rest = [k for k in rest if k not in own]
            stretches.append({"kind": "equal", "hinges": sorted(own)})
        with pytest.raises(NotProvedError):
            path_checker.checked({**base, "stretches": stretches})
        assert refuses_exactly({**base, "stretches": stretches})


def test_mutated_certificates_end_within_their_limits(tmp_path):
    """Each runs in a process that a limit of a minute, or of a gigabyte, would end with a code below 0."""
    rng, files = random.Random(7), [*HONEST, *sorted((FOLDER / "corpus").glob("*.json"))]
    sources = [read(file) for file in files if not re.search("deep|cut_short|empty|index", file.stem)]
    for _ in range(150):
        text = mutated(rng.choice(sources), rng)
        file = tmp_path / "mutated.json"
        file.write_bytes(text.encode("utf-8", "surrogatepass"))
        outcome = verified(file)
        assert outcome.code in (0, 1, 2), text
        assert outcome.said.count("\n") <= 10
