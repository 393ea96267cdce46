import pytest
from store_samples import NOT_ALLOWED
from store_samples import unit_row as row

from hcsearch.basics.errors import DatabaseError
from hcsearch.store import open_readonly, record_units, select
from hcsearch.store.columns import column_names


def test_units_come_back_as_they_were_stored(database):
    assert record_units(database, [row(), row(alpha=70.0, known="")]) == 2
    selected = select(database, view="units")
    assert selected.columns == column_names("units") == ("id", *row())
    assert selected.rows == ((1, *row().values()), (2, *row(alpha=70.0, known="").values()))


def test_the_same_units_again_add_nothing(database):
    assert record_units(database, [row()]) == 1
    assert record_units(database, [row(), row(placements="[1]"), row(placements="[1]")]) == 1
    assert record_units(database, [row()]) == record_units(database, []) == 0
    assert [line[0] for line in select(database, view="units").rows] == [1, 2]


def test_units_are_queried_like_designs(database):
    record_units(database, [row(), row(placements="[1]", known="")])
    assert select(database, "known!=unit-i copies=4 path=flat contact=0", columns="id", view="units").rows == ((2,),)
    assert select(database, columns="id", view="units", sort="-id").rows == ((2,), (1,))


def test_a_unit_that_cannot_be_leaves_nothing_behind(database):
    for bad in (row(path="round"), row(merged=2), row(alpha=90.0), row(copies=1)):
        with pytest.raises(Exception, match=NOT_ALLOWED):
            record_units(database, [row(), bad])
    assert select(database, view="units").rows == ()


def test_a_read_only_database_takes_no_units(database, place):
    with open_readonly(place) as reader, pytest.raises(DatabaseError, match="read-only"):
        record_units(reader, [row()])
