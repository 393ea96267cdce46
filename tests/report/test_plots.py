import re
import xml.etree.ElementTree as ET

import pytest
from hypothesis import given
from hypothesis import strategies as st

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
    svg = draw_plot([PlotCurve("one", x, y)], "title", "time, s", "gap, mm", linear_to=linear_to)
    ET.fromstring(svg)
    (drawn,) = points(svg)
    assert len(drawn) == len(values)
    for place, other, a, b in zip(drawn, drawn[1:], y, y[1:], strict=False):
        assert (place[1] - other[1]) * (b - a) >= 0
        assert place[0] <= other[0]
    assert all(0 <= px <= PLOT_WIDTH and 0 <= py <= PLOT_HEIGHT for px, py in drawn)


def test_a_value_that_is_not_known_breaks_the_line():
    svg = draw_plot([PlotCurve("gap", [0, 1, 2, 3, 4], [1, 2, None, None, 3])], "", "", "")
    assert [len(piece) for piece in points(svg)] == [2, 1]


@pytest.mark.parametrize("low", [-7.5, -0.02, 0.0])
def test_the_logarithmic_scale_has_ticks_at_powers_of_ten(low):
    svg = draw_plot([PlotCurve("gap", [0, 1], [low, 50])], "", "", "gap", linear_to=0.01)
    texts = [text.text for text in ET.fromstring(svg).iter("text")]
    assert {"0", "0.01", "0.1", "1", "10", "100"} <= set(texts)
    assert ("-10" in texts, "-0.1" in texts) == (low == -7.5, low < 0.0)


def test_texts_are_escaped_and_marks_are_where_they_happen():
    hostile = "<script>&\"'"
    svg = draw_plot(
        [PlotCurve(hostile, [0, 10], [0, 1])],
        hostile,
        hostile,
        hostile,
        marks=[PlotMark(5, hostile, is_collision=True)],
    )
    root = ET.fromstring(svg)
    assert not [child for child in root.iter() if child.tag == "script"]
    assert [text.text for text in root.iter("text")].count(hostile) == 3
    (x,) = re.findall(r'class="bad" d="M([\d.]+) ', svg)
    (drawn,) = points(svg)
    assert float(x) == pytest.approx(0.5 * (drawn[0][0] + drawn[1][0]), abs=0.1)
