"""Rules of standards: those that come with the program, and files of one's own."""

from importlib.resources import files

import pytest

from hcsearch.basics.errors import InputFileError
from hcsearch.designs.folding import Folding
from hcsearch.scenes import SCENES
from hcsearch.springs.flight.flight_figures import figures_of
from hcsearch.springs.flight.rules import RULE_KINDS, STANDARDS, Judged, JudgedTravel, RuleKind, read_rules
from hcsearch.springs.flight.travel import travel_along
from tests.documents import ROOT

OWN = """
title = "House rules"
issue = "2"
[motorisation]
clause = "1.1"
overall = 2
springs = 1
friction = 1.5
harness = 3
friction_measured = 1
harness_measured = 1.2
[frequency]
clause = "2.1"
hz = 0.1
"""


def test_the_factors_of_ecss_are_those_of_its_issue():
    rules = read_rules("ecss")
    assert rules.standard == "ECSS-E-ST-33-01C, 6 March 2009"
    # 2 x 3 / 0.8, and 2 x 1.5 / 0.8 where measured
    assert rules.weights(measured=False) == (7.5, 7.5)
    assert rules.weights(measured=True) == (3.75, 3.75)
    assert (rules.given["clearance"].numbers, rules.given["latch"].numbers) == ({"ratio": 3.0}, {"factor": 2.0})
    clauses = {key: rule.clause for key, rule in rules.given.items()}
    assert clauses == {
        "motorisation": "4.7.5.3.1",
        "redundancy": "4.7.5.3.2 f",
        "latch": "4.7.5.4.4",
        "clearance": "4.7.5.4.8 d",
    }


def test_aiaa_asks_for_twice_what_resists_and_for_no_redundancy():
    rules = read_rules("aiaa")
    assert rules.standard == "AIAA S-114, 2005"
    assert rules.weights(measured=False) == rules.weights(measured=True) == (2.0, 2.0)
    assert rules.given["latch"].numbers == {"factor": 2.0}
    assert set(rules.given) == {"motorisation", "latch"}


def test_a_further_kind_of_rule_is_one_row(tmp_path, monkeypatch):
    heavy = RuleKind("mass", ("kg",), "mass of panels", lambda it: Judged(it.figure("mass")), unit="kg", at_least=False)
    monkeypatch.setitem(RULE_KINDS, "mass", heavy)
    path = tmp_path / "house.toml"
    path.write_text('title = "House rules"\nissue = "3"\n[mass]\nclause = "9"\nkg = 0.1\n')
    travel = travel_along(Folding.from_notation("hex:0234550132:4").linkage(), SCENES["default"])
    numbers = figures_of(travel)
    (row,) = JudgedTravel(travel, read_rules(str(path)), numbers).rows()
    assert (row.rule, row.clause, row.figure, row.required) == ("mass of panels", "9", numbers["mass"], 0.1)
    assert row.verdict == ("pass" if numbers["mass"] <= 0.1 else "fail")


@pytest.mark.parametrize("kind", RULE_KINDS.values(), ids=RULE_KINDS)
def test_a_kind_of_rule_is_in_the_reference(kind):
    page = (ROOT / "docs" / "reference" / "rules.md").read_text(encoding="utf-8")
    assert f"\n| `{kind.key}` | {', '.join(f'`{name}`' for name in kind.numbers)}" in page


def test_every_standard_stands_in_a_file_and_is_read():
    folder = files("hcsearch.springs.flight").joinpath("standards")
    assert sorted(file.name for file in folder.iterdir()) == sorted(f"{name}.toml" for name in STANDARDS)
    assert len({read_rules(name).standard for name in STANDARDS}) == len(STANDARDS)


def test_a_file_has_the_rules_that_it_names(tmp_path):
    path = tmp_path / "house.toml"
    path.write_text(OWN)
    rules = read_rules(str(path))
    assert rules.weights(measured=False) == (3.0, 6.0)
    assert rules.weights(measured=True) == (2.0, 2.4)
    assert rules.given["frequency"].numbers == {"hz": 0.1}
    assert set(rules.given) == {"motorisation", "frequency"}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("title = 'A'", "has no issue: write issue"),
        ("issue = '1'", "has no title: write title"),
        (OWN + "[colour]\nred = 1", "has the unknown key 'colour': it has title, issue, motorisation"),
        (OWN.replace("hz = 0.1", ""), r"must have all of \[frequency\] and nothing else there: clause, hz"),
        (OWN.replace("hz = 0.1", "hz = 0.1\nmm = 2"), r"must have all of \[frequency\]"),
        (OWN.replace("hz = 0.1", "hz = 0"), "has frequency.hz = 0: write a number above 0"),
        (OWN.replace("hz = 0.1", "hz = inf"), "has frequency.hz = inf: write a number above 0"),
        (OWN.replace("hz = 0.1", "hz = -0.0"), "has frequency.hz = -0.0: write a number above 0"),
        (OWN.replace("hz = 0.1", "hz = nan"), "has frequency.hz = nan: write a number above 0"),
        (OWN.replace("hz = 0.1", "hz = 1e400"), "has frequency.hz = inf: write a number above 0, from 1e-09 to 1e"),
        (OWN.replace("overall = 2", "overall = 1e308"), "has motorisation.overall = 1e.308: write a number above 0"),
        (OWN.replace("springs = 1", "springs = 5e-324"), "has motorisation.springs = 5e-324: write a number above 0"),
        (OWN.replace("hz = 0.1", "hz = 1" + 310 * "0"), "is no TOML: it has an integer of more than 64 bits"),
        (
            OWN.replace('clause = "2.1"', "clause = 0x" + 5000 * "f"),
            "is no TOML: it has an integer of more than 64 bits",
        ),
        (OWN.replace("hz = 0.1", "hz = true"), "has frequency.hz = True: write a number above 0"),
        (OWN.replace('clause = "2.1"', "clause = 2.1"), "has frequency.clause = 2.1: write a text"),
        ("title = 'A'\nissue = '1'\n[redundancy]\nclause = '3'", "has redundancy without motorisation"),
        ("frequency = 3\n" + OWN.replace("[frequency]", "[flatness]"), r"must have all of \[frequency\]"),
        ("title = ", "is no TOML"),
    ],
)
def test_files_that_are_no_rules_are_refused_with_a_remedy(tmp_path, text, message):
    path = tmp_path / "house.toml"
    path.write_text(text)
    with pytest.raises(InputFileError, match=message):
        read_rules(str(path))


def test_unknown_standards_and_missing_files_are_refused():
    with pytest.raises(InputFileError, match=r"there are no rules 'nasa': name ecss, aiaa, or a file \.toml"):
        read_rules("nasa")
    with pytest.raises(InputFileError, match=r"cannot read none\.toml"):
        read_rules("none.toml")
