"""Tables and arrays of kernels: lent by pointer, of one type each, and kept where a kernel returns them."""

import gc
import weakref
from typing import NamedTuple

import numpy as np
import pytest
from numba.core import types
from numba.core.errors import TypingError

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.compiling.lent_types import LentArray, LentTable, lent_type


class Inner(NamedTuple):
    rows: Reals
    count: int


class Outer(NamedTuple):
    inner: Inner
    line: Reals
    signs: np.ndarray
    scale: float
    place: tuple[float, float]
    doubled: bool


@compiled
def value_at(table, i):
    total = table.inner.rows[i, 1] * table.scale + table.line[i] + table.signs[i] + table.place[1] + table.inner.count
    return 2.0 * total if table.doubled else total


@compiled
def total_of(table):
    total = 0.0
    for i in range(len(table.line)):
        total += value_at(table, i)
    return total


@compiled
def fill(table, value):
    table.line[:] = value


@compiled
def new_table(n):
    line = np.arange(n) * 1.0
    return Outer(Inner(np.ones((n, 2)), n), line, np.ones(n, np.int8), 2.0, (0.0, 0.5), False)


@compiled
def inner_of(table):
    return table.inner


@compiled
def same(table):
    return table, table.line


@compiled
def scaled(table, scale):
    return Outer(table.inner, table.line[1:], table.signs[1:], scale, table.place, table.doubled)


@compiled
def totals_in_a_loop(n):
    """Tables that live on while the next one is made in the same place."""
    before, totals = new_table(n), np.zeros(n)
    for k in range(n):
        after = scaled(before, 1.0 + k)
        fill(after, 1.0 * k)
        totals[k] = total_of(before) - total_of(after)
        before = after if k % 2 else new_table(n)
    return totals


@compiled
def kept_from_one_that_is_gone(n):
    inner = inner_of(new_table(n))
    waste = np.full((n, 2), 7.0)
    return inner.rows.sum() + 0.0 * waste[0, 0], scaled(new_table(n), 3.0).line


@compiled
def chosen(table, other, first):
    one = table if first else other
    return total_of(one)


@compiled
def countdown(table, n):
    if n == 0:
        return table.line[0]
    return 1.0 + countdown(table, n - 1)


def table():
    rows = np.arange(6.0).reshape(3, 2)
    return Outer(Inner(rows, 3), np.array([1.0, 2.0, 4.0]), np.array([1, -1, 0], np.int8), 0.5, (0.0, 0.25), True)


def test_a_table_from_python_is_read_and_written():
    one = table()
    assert total_of(one) == sum(value_at.py_func(one, i) for i in range(3))
    fill(one, 9.0)
    assert one.line.tolist() == [9.0, 9.0, 9.0]
    assert total_of(one._replace(scale=2)) == sum(value_at.py_func(one._replace(scale=2), i) for i in range(3))


def test_a_table_of_a_kernel_is_returned_and_lent_to_others():
    made = new_table(3)
    assert isinstance(made, Outer)
    assert isinstance(made.inner, Inner)
    assert (made.scale, made.doubled, made.inner.count, made.place) == (2.0, False, 3, (0.0, 0.5))
    assert totals_in_a_loop(4).tolist() == totals_in_a_loop_in_python(4)


def totals_in_a_loop_in_python(n):
    """The same by the plain functions, with tables that Python keeps."""
    before, totals = new_table.py_func(n), []
    for k in range(n):
        after = scaled.py_func(before, 1.0 + k)
        fill.py_func(after, 1.0 * k)
        totals.append(
            sum(value_at.py_func(before, i) for i in range(len(before.line)))
            - sum(value_at.py_func(after, i) for i in range(len(after.line)))
        )
        before = after if k % 2 else new_table.py_func(n)
    return totals


def test_a_lent_table_is_kept_where_it_is_returned():
    one = table()
    (other, line), inner = same(one), inner_of(one)
    assert type(other) is Outer
    assert type(inner) is Inner
    assert inner.rows.ctypes.data == other.inner.rows.ctypes.data == one.inner.rows.ctypes.data
    assert line.ctypes.data == one.line.ctypes.data
    rows = weakref.ref(one.inner.rows)
    part = scaled(one, 3)
    del one, other, line
    gc.collect()
    assert inner.rows.tolist() == [[0.0, 1.0], [2.0, 3.0], [4.0, 5.0]]
    assert part.line.tolist() == [2.0, 4.0]
    del inner, part
    gc.collect()
    assert rows() is None


def test_arrays_outlive_the_table_that_they_were_taken_from():
    for n in (2, 30, 1000):
        total, line = kept_from_one_that_is_gone(n)
        assert total == 2.0 * n
        assert line.tolist() == [float(i) for i in range(1, n)]


def test_nothing_is_lost_in_many_calls():
    one = table()
    references = weakref.ref(one.line)
    for _ in range(1000):
        total_of(one)
        inner_of(one)
        same(one)
    del one
    gc.collect()
    assert references() is None


def test_tables_are_chosen_and_handed_on_by_a_kernel_that_calls_itself():
    one, other = table(), new_table(3)
    assert chosen(one, other, True) == total_of(one)
    assert chosen(one, other, False) == total_of(other)
    assert countdown(one, 5) == 6.0


def test_a_kernel_has_one_signature_whatever_the_widths_and_literals():
    one = table()
    one.line.flags.writeable = False
    for i, other in enumerate((table(), one._replace(scale=1, inner=Inner(one.inner.rows, np.int32(3))), new_table(2))):
        total_of(other)
        value_at(other, (0, np.int8(1), np.int32(0))[i])
    assert len(total_of.signatures) == len(value_at.signatures) == 1
    (kinds,) = total_of.signatures
    assert kinds == (
        LentTable(
            Outer,
            (
                LentTable(Inner, (LentArray(types.float64, 2), types.int64)),
                LentArray(types.float64, 1),
                LentArray(types.int8, 1),
                types.float64,
                types.UniTuple(types.float64, 2),
                types.boolean,
            ),
        ),
    )


def test_what_is_not_in_order_of_rows_keeps_its_type():
    turned = types.Array(types.float64, 2, "F")
    assert lent_type(turned) == turned
    assert lent_type(types.Array(types.float64, 2, "C", readonly=True)) == LentArray(types.float64, 2)
    assert lent_type(types.literal(3)) == lent_type(types.int16) == types.int64
    assert lent_type(types.uint64) == types.uint64


def test_a_wrong_table_is_refused():
    with pytest.raises(TypingError, match="Unknown attribute 'line'"):
        total_of(Inner(np.zeros((1, 2)), 1))
