import pytest

from hcsearch.designs.grid import GRIDS
from hcsearch.web.report.headline import StageCounts, headline_of, title_of

NOT_RUN = (None, None)


@pytest.mark.parametrize(
    ("counts", "query", "sentence"),
    [
        ((1175, 239, 88, 61, 33, 0), "grid=hex n=12", "33 of 1,175 designs open by springs, 28 more by motors."),
        ((61, 61, 61, 61, 33, 0), "n=12 deployable", "33 of 61 selected designs open by springs, 28 more by motors."),
        ((4, 4, 4, 4, 4, 0), "", "All 4 designs open by springs."),
        ((16, 2, 1, 1, 1, 0), "n=8", "1 of 16 designs opens by springs."),
        ((16, 2, 1, 1, 0, 0), "n=8 or n=10", "1 of 16 designs opens by motors, none by springs alone."),
        ((16, 2, 1, 1, None, 0), "", "1 of 16 designs opens by motors; springs have not been tried."),
        ((16, 4, 3, 0, None, 0), "", "None of 16 designs is known to open by motors; springs have not been tried."),
        (
            (16, 4, 3, None, 0, 0),
            "",
            "None of 16 designs is known to open by springs; no motion by motors has been searched for.",
        ),
        ((16, 4, 3, 0, 0, 2), "", "None of 16 designs is known to open."),
        ((16, 4, 3, 0, 0, 3), "", "None of 16 designs can open: they have no folding, are twisted, or are locked."),
        (
            (120, 32, 25, *NOT_RUN, 0),
            "",
            "25 of 120 designs fold without twist; their motion has not been searched for.",
        ),
        (
            (120, 32, None, *NOT_RUN, 0),
            "",
            "32 of 120 designs fold into two stacks; their twist has not been computed.",
        ),
        ((120, None, None, *NOT_RUN, 0), "", "120 designs; their foldings have not been computed."),
        ((1, 1, 1, 1, 1, 0), "#", "The selected design opens by springs."),
        ((1, 1, 1, 1, 0, 0), "", "The design opens by motors, not by springs alone."),
        ((1, None, None, *NOT_RUN, 0), "", "1 design; its foldings have not been computed."),
        ((1, 1, 1, 0, 0, 0), "", "The design is not known to open."),
        ((1, 0, 0, 0, 0, 0), "", "The design cannot open."),
        ((0, 0, 0, 0, 0, 0), "n=99", "No design satisfies the query."),
    ],
)
def test_the_sentence_says_how_many_open(counts, query, sentence):
    assert headline_of(StageCounts(*counts), "id=1" if query == "#" else query) == sentence


@pytest.mark.parametrize(
    ("sizes", "array", "title"),
    [
        ([("hex", 12)], None, "Twelve thick hexagons"),
        ([("square", 20)], "square:x", "20 thick squares in one array"),
        ([("hex", 8), ("hex", 10)], None, "8 to 10 thick hexagons"),
        ([("hex", 8), ("kite", 8), ("square", 8)], None, "Eight thick hexagons, kites or squares"),
        ([], None, "No designs"),
        ([("hex", -3)], None, "-3 thick hexagons"),
    ],
)
def test_the_title_names_the_panels(sizes, array, title):
    assert title_of(sizes, array) == title


def test_every_grid_has_a_noun():
    assert all(grid.noun for grid in GRIDS.values())
