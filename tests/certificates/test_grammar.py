"""The grammar of certificates: what is none, what is over its limits, and that each ends in its time and memory."""

import copy
import json
import os
import random
import resource
import subprocess
import sys

import pytest
from click.testing import CliRunner

from hcsearch.cli import hcsearch
from hcsearch.motion.certificates import collision_checker, lock_checker, path_checker
from hcsearch.motion.certificates.certificate_grammar import (
    MAX_BYTES,
    Clock,
    NoCertificateError,
    checksum,
    parsed,
    printable,
)
from hcsearch.motion.certificates.certifying import CLAIM_CHECKERS, CertificateError, verify_certificate
from tests.certificates.test_certificates import certificate, signed

LOCK, COLLISION, PATH = "hex:0233534001:3", "hex:0233435001:3", "square:01222300:0"
MEMORY = 2**30


def of_pattern(name, array=None, **changes):
    """A certificate as one of a pattern, which is not compared with a folding, with other values in its claim."""
    data = copy.deepcopy(certificate(name))
    data["claims"][0] |= changes
    data["claims"][0]["array"] |= array or {}
    return signed({**data, "panel_mm": None})


def verified(tmp_path, data, *options):
    """The exit code of verify, what it printed, and the error line."""
    file = tmp_path / "file.json"
    if isinstance(data, bytes):
        file.write_bytes(data)
    else:
        file.write_text(json.dumps(data), encoding="utf-8")
    result = CliRunner().invoke(hcsearch, ["verify", str(file), *options])
    return result.exit_code, result.stdout, result.stderr


def ring(n):
    """The array of a ring of n squares in two rows."""
    half = n // 2
    places = [(k, 0) for k in range(half)] + [(k, 1) for k in reversed(range(half))]
    facets = [[[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]] for x, y in places]
    faces = ("top", "bottom")
    hinges = [
        {"facets": [k, (k + 1) % n], "face": faces[k % 2], "closes": (k + 1) % half != 0}  # packed, a stack a row
        for k in range(n)
    ]
    own = {"facets": facets, "panels": [[k] for k in range(n)], "hinges": hinges}
    return {"unit": "1/1000", "root": 1, "thickness": 1, **own}


@pytest.mark.parametrize(
    "content",
    [
        b"[]",
        b"{}",
        b"",
        b"\xff\xfe",
        b"[" * 100_000,
        b'{"format": NaN}',
        b'{"format": Infinity}',
        b'{"format": ' + b"1" * 50 + b"}",
        b'{"format": 1, "format": 1}',
    ],
)
def test_what_is_no_certificate_ends_with_exit_code_2(tmp_path, content):
    code, printed, error = verified(tmp_path, content)
    assert (code, printed, error.count("\n")) == (2, "", 1)


def test_a_file_over_the_limit_is_refused():
    with pytest.raises(NoCertificateError, match="it is larger than 16 MiB"):
        parsed(b" " * (MAX_BYTES + 1))


@pytest.mark.parametrize("text", ["1e-999999999", "1e999999999", "1e-100", "0", "0.0", "0e5", "-1", "+1", "nan", "1/0"])
@pytest.mark.parametrize("name", [COLLISION, PATH])
def test_margins_are_texts_of_numbers_above_0(tmp_path, name, text):
    for margin in (text, text + "\n", " " + text, float("1e-4"), None):
        code, _, error = verified(tmp_path, of_pattern(name, margin=margin))
        assert code == 2
        assert error.endswith("no certificate: margin is no text of a number above 0\n")


@pytest.mark.parametrize("name", [LOCK, COLLISION, PATH])
def test_units_are_texts_of_numbers_above_0(tmp_path, name):
    for unit in ("1e-99999999", "1/" + "9" * 40, "x", "", 0.001):
        assert verified(tmp_path, of_pattern(name, {"unit": unit}))[0] == 2


@pytest.mark.parametrize("kind", ["lock", "collision", "path"])
def test_an_array_over_the_limits_is_refused_at_once(kind, tmp_path):
    n, name = 1002, {"lock": LOCK, "collision": COLLISION, "path": PATH}[kind]
    code, _, error = verified(tmp_path, of_pattern(name, ring(n)))
    assert code == 2
    assert "its facets and hinges are more than 1500" in error


def test_a_file_of_many_lists_is_refused_before_they_are_read(monkeypatch):
    monkeypatch.setattr(json, "loads", None)
    for text in (b"[", b'{"":'):
        with pytest.raises(NoCertificateError, match="it has more than 500000 lists and objects"):
            parsed(text * 500_001)


def tail(n):
    """The array of four squares about a point, whose hinges close a loop, and a tail of n squares."""
    places = [(0, 0), (1, 0), (1, 1), (0, 1), *((2 + k, 0) for k in range(n))]
    facets = [[[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]] for x, y in places]
    joined = [(0, 1), (1, 2), (2, 3), (3, 0), *((3 + k if k else 1, 4 + k) for k in range(n))]
    hinges = [{"facets": [*pair], "face": "top", "closes": max(pair) > 3} for pair in joined]
    own = {"facets": facets, "panels": [[k] for k in range(4 + n)], "hinges": hinges}
    return {"unit": "1/1000", "root": 1, "thickness": 1, **own}


def test_boxes_that_do_not_meet_end_in_the_time(tmp_path):
    """No box covers a part of another one's faces, of which there are 200 times as many."""
    rng, n = random.Random(3), 200
    lows = [[0] * n, *([rng.randrange(2) for _ in range(n)] for _ in range(1000))]
    boxes = {"cuts": [[0.0, 1.0, 3.15]] * n, "lows": lows, "highs": [[1 + k for k in low] for low in lows]}
    data = of_pattern(LOCK, tail(196), **boxes, end="flat", tried=0)
    code, _, error = verified(tmp_path, data, "--seconds", "1")
    assert code == 1
    assert "not decided in 1 s" in error
    few = {key: own if key == "cuts" else own[:120] for key, own in boxes.items()}
    code, _, error = verified(tmp_path, of_pattern(LOCK, tail(196), **few, end="flat", tried=0))
    assert code == 2
    assert error.endswith("the faces of its boxes have more than 20000 parts\n")


def test_ways_between_panels_are_held_once():
    """A way of 190 hinges has 18,000 pairs of them, and there may be 20,000 pairs of facets."""
    array = lock_checker.Array(tail(190))
    pairs = collision_checker.pairs_of(array, [[0, 193]] * 3, "1/100000", Clock())
    assert {id(pair.ways) for pair in pairs[::2]} == {id(pairs[0].ways)}
    assert pairs[0].ways[0].pairs is pairs[1].ways[0].pairs


def test_paths_over_the_limits_are_refused(tmp_path):
    rows = [[[x, 0] for x in range(51)] + [[50 - x, 1] for x in range(51)]]
    facets = [[[x + shift, y] for x, y in rows[0]] for shift in (0, 50)]
    hinges = [{"facets": [0, 1], "face": "top", "closes": True}]
    array = {"facets": facets, "panels": [[0], [1]], "hinges": hinges, "unit": "1/1000", "root": 1, "thickness": 1}
    code, _, error = verified(tmp_path, of_pattern(PATH, array))
    assert code == 2
    assert "a facet of a path has more than 100 corners" in error
    states = {"times": [*range(1700)], "angles": [[0.0] * 299] * 1700, "rates": [[0.0] * 299] * 1700}
    own = tail(295)
    code, _, error = verified(tmp_path, of_pattern(PATH, own, stretches=[{"kind": "cubics", **states}]))
    assert code == 2
    assert "a path of 299 hinges has more than 1672 pieces" in error


@pytest.mark.parametrize(
    "change", [{"version": 2}, {"version": 1.0}, {"version": True}, {"format": "x"}, {"claims": []}]
)
def test_heads_of_other_formats_and_versions_are_refused(change, tmp_path):
    code, _, error = verified(tmp_path, signed({**certificate(LOCK), **change}))
    assert code == 2
    assert "no certificate: " in error


def test_a_claim_is_not_decided_after_the_time(tmp_path):
    array = ring(60)
    low = [int(hinge["closes"]) for hinge in array["hinges"]]
    boxes = {"lows": [low], "highs": [[1 + index for index in low]], "tried": 10**9}
    data = of_pattern(LOCK, array, cuts=[[0.0, 3.0, 3.15]] * 60, end="packed", **boxes)
    code, _, error = verified(tmp_path, data, "--seconds", "0.5")
    assert code == 1
    assert error.endswith("not proved: not decided in 0.5 s: give --seconds 5\n")


def test_names_are_printed_without_what_moves_the_cursor(tmp_path):
    name = "a\n\x1b[31m\u202e\u2028\x00\ud800ü"
    code, printed, _ = verified(tmp_path, signed({**of_pattern(LOCK), "of": name}))
    assert code == 0
    assert printed.count("\n") == 1
    assert printed[:-1].isprintable()
    assert printable(name) == "a\\n\\x1b[31m\\u202e\\u2028\\x00\\ud800ü"


def still():
    """The claim of a path of two squares that do not fold."""
    squares = [[[k, 0], [k + 1, 0], [k + 1, 1], [k, 1]] for k in range(2)]
    array = {"unit": "1/10", "root": 1, "thickness": 1, "facets": squares, "panels": [[0], [1]]}
    hinges = [{"facets": [0, 1], "face": "top", "closes": False}]
    stretches = [{"kind": "equal", "hinges": []}]
    return {"kind": "path", "array": array | {"hinges": hinges}, "margin": "1/1000", "stretches": stretches}


def test_a_path_of_what_does_not_fold_is_said_to_be_one():
    head = "nothing folds, as packed and flat are one state: a path from packed to flat"
    assert CLAIM_CHECKERS["path"](still()).startswith(head)


def test_a_program_prints_names_on_any_terminal_and_reads_files_alone(tmp_path):
    data = signed({**certificate(PATH), "of": "\u6298\n", "panel_mm": None, "claims": [still()]})
    (tmp_path / "file.json").write_text(json.dumps(data), encoding="utf-8")
    os.mkfifo(tmp_path / "pipe")

    def run(name):
        command = [sys.executable, path_checker.__file__, str(tmp_path / name)]
        own = {**os.environ, "PYTHONIOENCODING": "ascii"}
        return subprocess.run(command, capture_output=True, text=True, check=False, env=own, timeout=60)

    proved = run("file.json")
    assert proved.returncode == 0
    assert proved.stdout.startswith(r"the array of claim 1 in the file, named '\u6298\n': proved: nothing folds")
    for name in ("pipe", "."):
        refused = run(name)
        assert refused.returncode == 2
        assert refused.stderr.endswith("no certificate: it is a folder, a pipe or a device\n")


def test_names_of_files_are_printed_escaped(tmp_path):
    file = tmp_path / "\x1b[31mred\n.json"
    file.write_text("[", encoding="utf-8")
    result = CliRunner().invoke(hcsearch, ["verify", str(file)], color=True)
    assert result.exit_code == 2
    assert result.stderr.startswith(str(tmp_path) + r"/\x1b[31mred\n.json: no certificate: it is no JSON")
    alone = subprocess.run(
        [sys.executable, path_checker.__file__, str(file)], capture_output=True, text=True, check=False, timeout=60
    )
    assert alone.returncode == 2
    assert alone.stderr.startswith(str(tmp_path) + r"/\x1b[31mred\n.json: no certificate: it is no JSON")


def test_names_are_printed_where_the_encoding_of_stdout_lacks_letters(tmp_path):
    data = signed({**certificate(PATH), "of": "\u6298", "panel_mm": None, "claims": [still()]})
    (tmp_path / "file.json").write_text(json.dumps(data), encoding="utf-8")
    command = [sys.executable, "-m", "hcsearch", "verify", str(tmp_path / "file.json")]
    own = {**os.environ, "PYTHONIOENCODING": "latin1"}
    result = subprocess.run(command, capture_output=True, text=True, check=False, env=own, timeout=60)
    assert (result.returncode, result.stderr) == (0, "")
    assert result.stdout.startswith(r"the pattern of 2 panels and 1 hinge in the certificate, named '\u6298': ")


def mutated(data, rng):
    """A certificate with one to three values, lists or keys changed, and the checksum of what it holds."""
    data = copy.deepcopy(data)
    for _ in range(rng.randrange(1, 4)):
        place = data
        while True:
            keys = list(place) if isinstance(place, dict) else range(len(place))
            key = rng.choice(list(keys))
            value = place[key]
            if not isinstance(value, dict | list) or not value or rng.random() < 0.1:
                break
            place = value
        number = value if type(value) in (int, float) else 1
        place[key] = rng.choice(
            [
                number + 1,
                -number,
                number * 1e-9,
                number * 10**6,
                10**12,
                True,
                "1e-9",
                "1e-99999",
                "1/3",
                [],
                {},
                [value],
            ]
        )
    return signed(data)


def test_mutated_certificates_end_in_time_and_memory(tmp_path):
    rng = random.Random(7)
    for number in range(60):
        data = mutated(of_pattern(rng.choice([LOCK, COLLISION, PATH])), rng)
        (tmp_path / f"{number:03d}.json").write_text(json.dumps(data), encoding="utf-8")
    program = (
        "import json, pathlib, resource\n"
        "from hcsearch.motion.certificates.certifying import *\n"
        f"for file in sorted(pathlib.Path({str(tmp_path)!r}).glob('*.json')):\n"
        "    try:\n"
        "        verify_certificate(read_certificate(str(file)), Clock(20.0))\n"
        "    except CertificateError:\n"
        "        pass\n"
        "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024)\n"
    )

    def limited():
        resource.setrlimit(resource.RLIMIT_CPU, (60, 60))

    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True, preexec_fn=limited
    )
    assert int(done.stdout) < MEMORY


def test_the_checksum_is_that_of_what_is_read():
    data = certificate(LOCK)
    assert data["sha256"] == checksum({key: data[key] for key in data if key != "sha256"})
    with pytest.raises(CertificateError, match="the file was changed"):
        verify_certificate({**data, "of": "hex:0233534001:4"})
