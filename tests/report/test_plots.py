import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hcsearch.system.curve_labels import LabelFrame, coinciding, label_places
from hcsearch.system.figures import curve_look
from hcsearch.web.report.plots import PLOT_HEIGHT, PLOT_WIDTH, PlotCurve, PlotMark, draw_plot

numbers = st.floats(-1e6, 1e6).map(lambda x: round(x, 6))


def points(svg: str, k: int = 0) -> list[list[tuple[float, float]]]:
    """The pieces of curve k, as a browser reads them."""
    data = re.findall(r'<path class="curve" d="([^"]*)"', svg)[k]
    return [
        [tuple(map(float, point.split())) for point in piece.split("L")] for piece in data.removeprefix("M").split("M")
    ]


def test_curves_differ_in_colour_and_in_dashes():
    looks = [curve_look(k) for k in range(32)]
    assert len(set(looks)) == 32
    assert len({dashes for _, dashes in looks[:4]}) == 4
    assert len({colour for colour, _ in looks[:8]}) == 8


@given(st.lists(st.tuples(numbers, numbers), min_size=1, max_size=20), st.sampled_from([None, 0.01, 5.0]))
def test_greater_values_lie_higher_and_everything_lies_in_the_frame(values, linear_to):
    values.sort()
    x, y = zip(*values, strict=True)
    svg = draw_plot([PlotCurve("one", x, y)], "title", "time, s", "gap, mm", linear_to=linear_to).svg
    ET.fromstring(svg)
    (drawn,) = points(svg)
    assert len(drawn) == len(values)
    for place, other, a, b in zip(drawn, drawn[1:], y, y[1:], strict=False):
        assert (place[1] - other[1]) * (b - a) >= 0
        assert place[0] <= other[0]
    assert all(0 <= px <= PLOT_WIDTH and 0 <= py <= PLOT_HEIGHT for px, py in drawn)


def test_a_value_that_is_not_known_breaks_the_line():
    svg = draw_plot([PlotCurve("gap", [0, 1, 2, 3, 4], [1, 2, None, None, 3])], "", "", "").svg
    assert [len(piece) for piece in points(svg)] == [2, 1]


@pytest.mark.parametrize("low", [-7.5, -0.02, 0.0])
def test_the_logarithmic_scale_has_ticks_at_powers_of_ten(low):
    svg = draw_plot([PlotCurve("gap", [0, 1], [low, 50])], "", "", "gap", linear_to=0.01).svg
    texts = [text.text for text in ET.fromstring(svg).iter("text")]
    assert {"0", "0.01", "0.1", "1", "10", "100"} <= set(texts)
    assert ("-10" in texts, "-0.1" in texts) == (low == -7.5, low < 0.0)


def test_texts_are_escaped_and_marks_are_where_they_happen():
    hostile = "<script>&\"'"
    svg = draw_plot(
        [PlotCurve(hostile, [0, 10], [0, 1], hostile)],
        hostile,
        hostile,
        hostile,
        marks=[PlotMark(5, hostile, is_collision=True)],
    ).svg
    root = ET.fromstring(svg)
    assert not [child for child in root.iter() if child.tag == "script"]
    assert [text.text for text in root.iter("text")].count(hostile) == 4  # both axes, the mark and the label
    (x,) = re.findall(r'class="bad" d="M([\d.]+) ', svg)
    (drawn,) = points(svg)
    assert float(x) == pytest.approx(0.5 * (drawn[0][0] + drawn[1][0]), abs=0.1)


def test_angles_have_ticks_at_parts_of_a_turn_and_marks_stand_above_the_curves():
    drawn = draw_plot([PlotCurve("one", [0, 1], [180, 0])], "", "", "", marks=[PlotMark(1, "flat, 1 s")], degrees=True)
    texts = {text.text: text for text in ET.fromstring(drawn.svg).iter("text")}
    assert {"0", "30", "60", "90", "120", "150", "180"} <= set(texts)
    highest = min(y for piece in points(drawn.svg) for _, y in piece)
    assert float(texts["flat, 1 s"].get("y")) < highest


def test_labels_stand_on_their_curves_where_they_cover_no_other_and_else_in_the_legend():
    x = list(range(11))
    far = [PlotCurve("first", x, [0.0] * 11, "one"), PlotCurve("second", x, [10.0] * 11, "two")]
    near = [*far, PlotCurve("third", x, [9.9] * 11, "three")]
    assert draw_plot(far, "", "", "").legend == ()
    drawn = draw_plot(near, "", "", "")
    assert [curve.name for _, curve in drawn.legend] == ["second", "third"]
    assert [text.text for text in ET.fromstring(drawn.svg).iter("text") if text.get("class") == "name"] == ["one"]


curves = st.lists(
    st.lists(st.floats(0.0, 100.0), min_size=5, max_size=5).map(
        lambda y: list(zip(range(0, 401, 100), y, strict=True))
    ),
    min_size=1,
    max_size=5,
)


def at(line, x):
    return np.interp(x, *zip(*line, strict=True))


@given(curves)
def test_no_label_covers_another_curve_or_label_and_its_own_curve_is_nearest(lines):
    frame = LabelFrame(0.0, 400.0, 0.0, 100.0, 10.0)
    widths = [10.0 * (k + 1) for k in range(len(lines))]
    places = label_places(lines, widths, frame)
    found = [(k, place) for k, place in enumerate(places) if place is not None]
    for k, (x, y) in found:
        under = np.linspace(x - 0.5 * widths[k], x + 0.5 * widths[k], 9)
        stands_on_it = y == pytest.approx(at(lines[k], x))
        for other, line in enumerate(lines):
            if other != k or not stands_on_it:
                assert np.abs(at(line, under) - y).min() > 5.0
        for other, (a, b) in found:
            assert other == k or abs(x - a) >= 0.5 * (widths[k] + widths[other]) or abs(y - b) >= 7.5
        if not stands_on_it:
            beside = np.linspace(x - 0.5 * widths[k] - 23.0, x + 0.5 * widths[k] + 23.0, 400)
            assert np.abs(at(lines[k], beside) - y).min() < 2.0


def test_labels_of_steep_curves_that_are_near_each_other_stand_on_their_outer_sides():
    frame = LabelFrame(0.0, 400.0, 0.0, 400.0, 10.0)
    lower, upper = [(0.0, 400.0), (396.0, 0.0)], [(4.0, 400.0), (400.0, 0.0)]
    (low_x, low_y), (high_x, high_y) = label_places([lower, upper], [60.0, 60.0], frame)
    assert low_x + 30.0 < np.interp(-low_y, [-400.0, 0.0], [0.0, 396.0])
    assert high_x - 30.0 > np.interp(-high_y, [-400.0, 0.0], [4.0, 400.0])


def test_columns_that_differ_by_little_are_one_group():
    columns = np.array([[0.0, 5.0, 0.3, 5.4], [1.0, 5.0, 1.2, 5.0]])
    assert coinciding(columns, 0.5) == [[0, 2], [1, 3]]
    assert coinciding(columns, 0.1) == [[0], [1], [2], [3]]
