import pytest
from store_samples import NOT_ALLOWED
from store_samples import evaluation_row as row

from hcsearch.basics.errors import DatabaseError
from hcsearch.store import find_evaluations, open_database, open_readonly, record_evaluations, select
from hcsearch.store.columns import column_names
from tests.loosening import loosened


def test_evaluations_come_back_as_they_were_stored(database):
    hit = row(springs="0.1 0.1", clear=0, collision_time=0.3, first_panel=0, second_panel=7, gap=None)
    assert record_evaluations(database, [row(), hit]) == 2
    assert find_evaluations(database, "thesis-4x4") == [hit, row()]
    assert find_evaluations(database, "unit-i") == []


def test_the_view_tells_gaps_in_millimetres(database):
    record_evaluations(database, [row()])
    selected = select(database, view="evaluations")
    assert selected.columns == column_names("evaluations")
    row_shown = dict(zip(selected.columns, selected.rows[0], strict=True))
    assert row_shown.pop("clearance") == pytest.approx(2.0)
    assert row_shown == {name: value for name, value in row().items() if name != "gap"}


def test_the_same_again_adds_nothing(database):
    assert record_evaluations(database, [row()]) == 1
    assert record_evaluations(database, [row(), row(springs="0.2 0.2")]) == 1
    assert record_evaluations(database, []) == 0
    assert len(select(database, view="evaluations").rows) == 2


def test_an_evaluation_that_cannot_be_leaves_nothing_behind(database):
    for bad in (row(outcome="round"), row(clear=2), row(subject=None)):
        with pytest.raises(Exception, match=NOT_ALLOWED):
            record_evaluations(database, [row(), bad])
    assert select(database, view="evaluations").rows == ()


def test_a_read_only_database_takes_no_evaluations(database, place):
    with open_readonly(place) as reader, pytest.raises(DatabaseError, match="read-only"):
        record_evaluations(reader, [row()])


@pytest.mark.parametrize("column", ["remaining", "speed", "clear", "steps"])
def test_text_where_numbers_belong_is_damage(tmp_path, column):
    path = tmp_path / "designs.sqlite"
    with open_database(str(path), create=True) as made:
        record_evaluations(made, [row()])
    with loosened(path) as connection:
        connection.execute(f"UPDATE evaluation SET {column} = 'x'")
    with (
        open_database(str(path), create=False) as made,
        pytest.raises(DatabaseError, match=f"column {column} "),
    ):
        find_evaluations(made, "thesis-4x4")
