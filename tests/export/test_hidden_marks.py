"""What is left out of a moving picture is covered by what is drawn after it."""

import shapely
from hypothesis import given
from hypothesis import strategies as st

from hcsearch.export.animation import ink_of, seen

points = st.tuples(st.integers(0, 20), st.integers(0, 20))
marks = st.one_of(
    st.tuples(st.lists(points, min_size=2, max_size=2), st.just(False)),
    st.builds(lambda low, size: ([low, (low[0] + size[0], low[1]), (low[0] + size[0], low[1] + size[1])], True),
              points, points),
)  # fmt: skip


@given(st.lists(marks, min_size=1, max_size=12))
def test_marks_that_are_left_out_change_no_colour_of_any_place(drawn):
    inks = [ink_of(corners, 2.0, is_face=is_face) for corners, is_face in drawn]
    kept = [ink for ink, is_seen in zip(inks, seen(inks), strict=True) if is_seen]
    assert inks[-1] in kept
    above = shapely.Polygon()
    for ink in reversed(inks):
        uncovered = ink.difference(above).area
        assert ink in kept or uncovered < 0.1
        above = above.union(ink)
    assert above.difference(shapely.union_all(kept)).area < 0.1 * len(inks)


def test_a_face_under_a_larger_one_or_under_two_halves_is_not_seen_and_flat_ones_are_lines():
    small = ink_of([(2, 2), (8, 2), (8, 8), (2, 8)], 1.0, is_face=True)
    large = ink_of([(0, 0), (10, 0), (10, 10), (0, 10)], 1.0, is_face=True)
    left = ink_of([(0, 0), (5, 0), (5, 10), (0, 10)], 1.0, is_face=True)
    right = ink_of([(5, 0), (10, 0), (10, 10), (5, 10)], 1.0, is_face=True)
    flat = ink_of([(2, 2), (8, 2), (5, 2)], 1.0, is_face=True)
    assert seen([small, large, flat]) == [False, True, True]
    assert seen([small, left, right]) == [False, True, True]
    assert seen([small, left]) == [True, True]
