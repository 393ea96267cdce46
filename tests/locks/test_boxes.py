"""Boxes less boxes, their faces, and boxes around parts of closed states, each against points of a grid."""

from itertools import product

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

from hcsearch.motion.locks.boxes import (
    MAX_BOX_ANGLE,
    MIN_LAYOUT_SPACE,
    BoxFace,
    box_faces,
    boxes_outside,
    region_around,
    states_in,
)

SIZE = 4
"""Boxes of these tests have corners with whole numbers up to this one."""


@st.composite
def box_sets(draw):
    """A box, and some to be taken away from it."""
    n = draw(st.integers(1, 3))

    def box():
        sides = [sorted(draw(st.lists(st.integers(0, SIZE), min_size=2, max_size=2, unique=True))) for _ in range(n)]
        low, high = np.array(sides, float).T
        return low, high

    return box(), [box() for _ in range(draw(st.integers(0, 4)))]


def holds(box, point):
    """Whether a box holds a point inside."""
    return bool(((box[0] < point) & (point < box[1])).all())


def cells(n):
    """Middles of all unit cells."""
    return [np.array(cell) + 0.5 for cell in product(range(SIZE), repeat=n)]


@given(box_sets())
def test_what_is_left_of_a_box_is_covered_once(boxes):
    box, others = boxes
    left = boxes_outside([box], others)
    assert all((low < high).all() for low, high in left)
    for cell in cells(len(box[0])):
        expected = holds(box, cell) and not any(holds(other, cell) for other in others)
        assert sum(holds(part, cell) for part in left) == expected


@given(box_sets())
def test_faces_lie_once_between_what_is_covered_and_what_is_not(boxes):
    box, others = boxes
    left = boxes_outside([box], others)
    faces = box_faces(left, SIZE)
    for cell in cells(len(box[0])):
        for hinge in range(len(cell)):
            beyond = cell.copy()
            beyond[hinge] += 1.0
            if beyond[hinge] > SIZE:
                continue
            facet = 0.5 * (cell + beyond)
            apart = any(holds(part, cell) for part in left) != any(holds(part, beyond) for part in left)
            assert sum(on_face(face, hinge, facet) for face in faces) == apart


def on_face(face, hinge, point):
    """Whether a face across a hinge holds a point inside."""
    rest = np.arange(len(point)) != hinge
    inside = ((face.low < point) & (point < face.high))[rest].all()
    return bool(face.hinge == hinge and face.level == point[hinge] and inside)


@given(box_sets())
def test_a_face_less_parts_of_it_is_covered_once(boxes):
    box, others = boxes
    flat = [(np.append(low, 1.0), np.append(high, 1.0)) for low, high in [box, *others]]
    left = boxes_outside(flat[:1], flat[1:])
    for cell in cells(len(box[0])):
        expected = holds(box, cell) and not any(holds(other, cell) for other in others)
        assert sum(holds((low[:-1], high[:-1]), cell) for low, high in left) == expected
        assert all(low[-1] == high[-1] == 1.0 for low, high in left)


def test_halves_of_a_face_are_those_across_its_longest_side():
    face = BoxFace(1, np.array([0.0, 2.0, 1.0]), np.array([1.0, 2.0, 4.0]))
    below, above = face.halves()
    assert below.level == above.level == 2.0
    assert below.high.tolist() == [1.0, 2.0, 2.5]
    assert above.low.tolist() == [0.0, 2.0, 2.5]


@given(st.integers(0, 2**32 - 1), st.integers(1, 4), st.integers(1, 3))
def test_a_region_holds_one_part_and_none_of_others(seed, n, parts):
    rng = np.random.default_rng(seed)
    own, *others = (cloud(rng, n) for _ in range(parts + 1))
    assume(all(np.abs(own[:, None] - other).max(axis=2).min() > MIN_LAYOUT_SPACE for other in others))
    region = region_around(own, others, lambda states, _box: states)
    if region is None:
        return
    assert all(any(len(states_in(box, state[None])) for box in region) for state in own)
    assert not any(len(states_in(box, other)) for box in region for other in others)
    assert all((low >= 0.0).all() and (high <= MAX_BOX_ANGLE).all() for low, high in region)


def cloud(rng, n):
    """States of a part: some around a middle."""
    middle, width = rng.uniform(0.0, np.pi, n), rng.uniform(0.05, 1.5, n)
    return np.clip(rng.uniform(middle - width, middle + width, (40, n)), 0.0, np.pi)


def test_a_hole_is_left_in_a_region():
    rng = np.random.default_rng(3)
    around = rng.uniform(0.0, np.pi, (2000, 3))
    own = around[np.abs(around - 1.5).max(axis=1) > 0.9]
    other = rng.uniform(1.1, 1.9, (200, 3))
    region = region_around(own, [other], lambda states, _box: states)
    assert region is not None
    faces = box_faces(region, MAX_BOX_ANGLE)
    # a box in the middle is left out, with one face on each of its six sides
    assert len(faces) == 6
    assert all(0.6 < face.level < 2.4 for face in faces)
    assert all(len(states_in(box, other)) == 0 for box in region)


def test_parts_that_are_mixed_up_have_no_region():
    rng = np.random.default_rng(5)
    mixed = rng.uniform(0.0, np.pi, (400, 2))
    assert region_around(mixed[::2], [mixed[1::2]], lambda states, _box: states) is None
