"""The paper: its numbers are measured ones, and it cites what its bibliography has."""

import csv
import re

import pytest

from tests.documents import ROOT

PAPER = (ROOT / "paper" / "paper.md").read_text(encoding="utf-8")
BIBLIOGRAPHY = (ROOT / "paper" / "paper.bib").read_text(encoding="utf-8")
MEASURED = ROOT / "docs" / "measurements"


def row_of(table, **key):
    with (MEASURED / table).open(encoding="utf-8") as file:
        (row,) = [row for row in csv.DictReader(file) if all(row[name] == value for name, value in key.items())]
    return row


def sentence_with(words):
    """The sentences of the paper, from one that begins with some words to the end of its paragraph."""
    (found,) = re.findall(rf"{words}.*?(?=\n\n)", PAPER, re.DOTALL)
    return found


@pytest.mark.parametrize(
    ("words", "n", "columns"),
    [
        ("Among all arrays of twelve hexagons", "12", ("fixed", "free", "arrays", "two_stack", "untwisted")),
        ("For eighteen hexagons", "18", ("free", "two_stack", "untwisted")),
    ],
)
def test_counts_are_those_of_the_tables(words, n, columns):
    row = row_of("tables/designs.csv", grid="hex", n=n)
    shown = re.findall(r"\d[\d,]*", sentence_with(words))
    assert shown[: len(columns)] == [f"{int(row[column]):,}" for column in columns]


def test_verdicts_are_those_of_the_tables():
    row = row_of("deployability/deployability.csv", grid="hex", cells="n = 12")
    assert f"and {row['deployable']} can be opened" in sentence_with("Among all arrays of twelve hexagons")
    limits = sentence_with("Among the 131 untwisted foldings")
    assert re.findall(r"\d+", limits)[:2] == [row["untwisted"], row["undecided"]]


@pytest.mark.parametrize(
    ("words", "page"),
    [
        ("440,506,542 designs | 43.6 s", "scale"),
        ("1,090,386 of 1,100,000", "collision"),
        ("At tolerance 1e-10 the error is 5.3e-8 m", "bench"),
    ],
)
def test_other_numbers_stand_on_the_pages_of_measurements(words, page):
    assert words in (MEASURED / f"{page}.md").read_text(encoding="utf-8")
    assert all(number in PAPER for number in re.findall(r"\d[\d,.]{4,}|5\.3e-8|43\.6", words))


def test_what_is_cited_is_in_the_bibliography():
    cited = re.findall(r"@(\w+)", PAPER.partition("# Summary")[2])
    assert set(cited) == set(re.findall(r"^@\w+\{(\w+),$", BIBLIOGRAPHY, re.MULTILINE))


def test_the_paper_has_the_length_of_one():
    assert 700 <= len(PAPER.partition("# Summary")[2].split()) <= 1000
