"""Certificates of patterns of files."""

import json
import re

import pytest

from hcsearch import save
from hcsearch.api.proving import prove, verify
from hcsearch.basics.errors import HcsearchError
from hcsearch.motion.certificates import certificate_grammar, certifying, path_checker
from hcsearch.motion.certificates.certificate_grammar import checksum
from hcsearch.motion.certificates.certifying import CertificateError
from tests.export.test_any_panels import drawing_of, strip, written


def _square(x, y):
    return [(x, y), (x + 1.0, y), (x + 1.0, y + 1.0), (x, y + 1.0)]


def test_the_certificate_of_a_pattern_holds_and_one_that_is_changed_does_not(tmp_path):
    squares = [_square(0.0, 0.0), _square(1.0, 0.0), _square(2.0, 0.0), _square(2.0, 1.0)]
    path = written(tmp_path, drawing_of(squares, {(0, 1): "M", (1, 2): "V", (2, 3): "M"}))
    certificate = prove(path, tmp_path / "path.json", db="none.sqlite")
    (sentence,) = certificate.sentences
    assert re.match("the pattern of 4 panels and 3 hinges in the certificate, named 'own.fold': a path from", sentence)
    assert verify(certificate.path).sentences == certificate.sentences
    data = json.loads(certificate.path.read_text())
    array = data["claims"][0]["array"]
    turned = [array["hinges"][0] | {"face": "top"}, *array["hinges"][1:]]
    away = [[x + 500, y + 500] for x, y in array["facets"][0]]
    in_parts = array | {"facets": [*array["facets"], away], "panels": [[0, 4], [1], [2], [3]]}
    for changed, message in (
        ({"claims": [data["claims"][0] | {"array": array | {"hinges": turned}}]}, None),
        ({"claims": [data["claims"][0] | {"array": in_parts}]}, "panel 0 is in several parts"),
        ({"of": {"a": 1}}, "its key of holds no text"),
    ):
        other = {key: value for key, value in (data | changed).items() if key != "sha256"}
        certificate.path.write_text(json.dumps(other | {"sha256": checksum(other)}))
        with pytest.raises(CertificateError, match=message):
            verify(certificate.path)


def test_a_pattern_off_every_lattice_has_no_certificate(tmp_path):
    with pytest.raises(HcsearchError, match="on the lattice of a tiling, and this pattern is on none"):
        prove(written(tmp_path, strip([2.0, 1.5], "M")), tmp_path / "path.json", db="none.sqlite")
    assert not (tmp_path / "path.json").exists()


def test_a_path_with_dependent_equations_is_refused_after_the_first_effort(tmp_path):
    (module,) = save("module-i", tmp_path / "m.fold", db="none.sqlite")
    efforts = []
    with pytest.raises(HcsearchError, match="24 equations close the loops, of which 18 are independent along it"):
        prove(
            str(module),
            tmp_path / "path.json",
            panel="70x10",
            db="none.sqlite",
            progress=lambda done, total, _: efforts.append((done, total)),
        )
    assert efforts == [(0, certifying.DEFAULT_PROOF_BUDGET)]
    assert not (tmp_path / "path.json").exists()


def test_facets_may_have_unequal_numbers_of_corners(tmp_path):
    polygons = [_square(0.0, 0.0), _square(1.0, 0.0), [(2.0, 0.0), (3.0, 0.0), (2.0, 1.0)]]
    sizes = {"frame_unit": "cm", "hcsearch:thickness": 0.12}
    path = written(tmp_path, drawing_of(polygons, {(0, 1): "M", (1, 2): "V"}, **sizes))
    certificate = prove(path, tmp_path / "path.json", db="none.sqlite")
    assert verify(certificate.path).sentences == certificate.sentences
    array = json.loads(certificate.path.read_text())["claims"][0]["array"]
    assert [len(facet) for facet in array["facets"]] == [4, 4, 3]
    array["facets"][2] = array["facets"][2][:2]  # a segment
    with pytest.raises(path_checker.NotProvedError):
        path_checker.checked(json.loads(certificate.path.read_text())["claims"][0] | {"array": array})


def test_a_thickness_that_is_no_part_of_the_lattice_is_refused_before_the_search(tmp_path, monkeypatch):
    polygons = [_square(0.0, 0.0), [(1.0, 0.0), (3.0, 0.0), (3.0, 1.0), (1.0, 1.0)]]
    path = written(tmp_path, drawing_of(polygons, {(0, 1): "M"}))
    certificate = prove(path, tmp_path / "path.json", panel="100x6", db="none.sqlite")
    assert certificate.sentences[0].startswith("the pattern of 2 panels and 1 hinge in the certificate")
    monkeypatch.setattr(certifying, "plan_linkage_motion", None)
    with pytest.raises(HcsearchError, match=r"is no simple part of the lattice: give --panel LENGTHxTHICKNESS"):
        prove(path, tmp_path / "none.json", db="none.sqlite")


@pytest.mark.parametrize(
    ("limit", "value", "message"),
    [("MAX_BYTES", 1000, "it is larger than 0 MiB"), ("MAX_LISTS", 20, "it has more than 20 lists and objects")],
)
def test_no_certificate_is_written_that_verify_does_not_read(tmp_path, monkeypatch, limit, value, message):
    path = written(tmp_path, drawing_of([_square(0.0, 0.0), _square(1.0, 0.0)], {(0, 1): "M"}))
    monkeypatch.setattr(certificate_grammar, limit, value)
    with pytest.raises(HcsearchError, match=f"of own.fold is beyond what hcsearch verify reads: {message}") as refused:
        prove(path, tmp_path / "path.json", db="none.sqlite")
    assert "\n" not in str(refused.value)
    assert not (tmp_path / "path.json").exists()
