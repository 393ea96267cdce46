"""The bench `deployability`: its rows add up, and it is saved."""

import pytest

from hcsearch.designs.folding import folding_at
from hcsearch.designs.grid import GRIDS
from hcsearch.search.enumeration import PolygonSearch
from hcsearch_bench.deployability.deployability import DEPLOYABILITY
from hcsearch_bench.subjects.foldings import packed, untwisted


@pytest.fixture(scope="module")
def report():
    said = []
    return DEPLOYABILITY.run(quick=True, say=said.append), said


def test_every_folding_is_counted_once(report):
    table, said = report[0].results, report[1]
    assert len(said) == len(table.rows)
    for row, line in zip(table.rows, said, strict=True):
        assert line.startswith(
            f"{row.grid} {row.cells}: untwisted {row.untwisted}, foldings {row.foldings}, default {row.default}, "
        )
        deploys = row.default + row.hinged + row.merged + row.graded + row.spread
        assert row.foldings == deploys + row.movable + row.undecided + row.locked
        assert row.foldings == row.untwisted  # there are fewer than a sample has
        assert min(row.movable, row.undecided, row.locked, row.tight) >= 0
        assert row.tight <= row.foldings - row.locked
        assert 0 <= row.deployable <= row.designs <= row.foldings
        assert (row.deployable > 0) == (deploys + row.movable > 0) == bool(row.best)
        assert row.play is None or row.best


def test_a_sample_is_even():
    search = PolygonSearch(GRIDS["hex"], 10)
    every = [
        (folding.circuit.notation, folding.crease)
        for circuits, foldings in untwisted(search)
        for folding in (folding_at(circuits, foldings, i) for i in range(len(foldings)))
    ]
    assert len(every) == 40
    for step in (1, 3, 7):
        ((circuits, foldings),) = packed(untwisted(search, step))
        picked = [folding_at(circuits, foldings, i) for i in range(len(foldings))]
        assert [(folding.circuit.notation, folding.crease) for folding in picked] == every[::step]
        assert len(circuits) == len({folding.circuit for folding in picked})


def test_known_small_cases(report):
    rows = {(row.grid, row.cells): row for row in report[0].results.rows}
    assert rows["hex", "n = 8"].designs == 1
    assert rows["square", "n = 8"].designs == 1
    eight_r = rows["triangle", "n = 10"]
    assert (eight_r.designs, eight_r.default) == (1, eight_r.foldings)  # the thesis's 8R element deploys


def test_it_is_saved_among_the_tables(report, tmp_path):
    page = tmp_path / "tables.md"
    page.write_text("# Tables\n\nOthers.\n\n# Deployability\n\nOf before.\n", encoding="utf-8")
    for _ in range(2):
        report[0].save(tmp_path)
        text = page.read_text(encoding="utf-8")
        assert text.startswith("# Tables\n\nOthers.\n\n# Deployability\n\nWhich foldings come flat")
        assert text.count("| triangle | n = 10") == 1
        assert "Of before" not in text
        assert text.endswith("|\n")
    table = (tmp_path / "deployability" / "deployability.csv").read_text(encoding="utf-8")
    assert table.count("\n") == len(report[0].results.rows) + 1
