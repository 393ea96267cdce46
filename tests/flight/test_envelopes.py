"""Envelopes by name and by their sides, and queries for what fits into them."""

import math
from itertools import permutations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hcsearch.basics.errors import SceneError
from hcsearch.scenes.envelopes import box_placements, envelope_catalogue, envelope_sides
from hcsearch.springs.flight.stowage import UprightBox

sides = st.tuples(*(st.floats(1.0, 1000.0).map(lambda side: round(side, 3)) for _ in range(3)))


def test_the_catalogue_has_the_sides_of_the_cubesat_design_specification():
    assert envelope_sides("3U") == envelope_sides(" 3u ") == (340.5, 100.0, 100.0)
    assert envelope_sides("12U") == (366.0, 226.3, 226.3)
    units = {name: math.prod(box) for name, box in envelope_catalogue().items() if not name.endswith("-side")}
    assert all(units[f"{k}U"] == pytest.approx(k * units["1U"]) for k in (1.5, 2, 3))
    # between rails of 8.5 mm on both sides, 6.5 mm deep
    assert envelope_sides("3U-side") == (340.5, 83.0, 6.5)
    assert envelope_sides("6U-side") == pytest.approx((366.0, 209.3, 6.5))


@given(sides)
def test_three_lengths_in_any_order_are_an_envelope(lengths):
    for order in permutations(lengths):
        assert envelope_sides("x".join(f"{length:.3f}" for length in order)) == tuple(sorted(lengths, reverse=True))


@pytest.mark.parametrize(
    "text", ["", "4U", "100x100", "100x100x-1", "0x10x10", "1x2x3x4", "axbxc", "1e3x1x1", "100X1X1"]
)
def test_other_texts_are_refused_with_the_catalogue(text):
    with pytest.raises(SceneError, match=r"write one of 1U, 1\.5U, 2U, 3U, 6U, 12U, 1U-side"):
        envelope_sides(text)


@given(sides, sides)
def test_a_box_has_room_where_some_placement_has(box, room):
    text = "x".join(f"{side:.3f}" for side in room)
    fits = any(all(a <= b for a, b in zip(box, laid, strict=True)) for laid in permutations(room))
    assert (UprightBox(*(1e-3 * side for side in box)).room_in(text) >= 0.0) == fits
    laid = box_placements(envelope_sides(text))
    assert fits == any(all(a <= b for a, b in zip(box, one, strict=True)) for one in laid)


def test_the_room_is_that_of_the_tightest_side():
    assert UprightBox(0.3, 0.09, 0.08).room_in("3U") == pytest.approx(0.01)
    assert UprightBox(0.3, 0.12, 0.08).room_in("3U") == pytest.approx(-0.02)
