"""The figures of the stage `flight` in the database: in the units of the views, by scene, made anew, and gone."""

import pytest
from test_store_verdicts import CUT, FLAT, LOCKED, list_designs

from hcsearch.basics.errors import QueryError, SceneError
from hcsearch.store import select
from hcsearch.store.columns import FLIGHT_QUANTITIES
from tests.judging import judge

NUMBERS = {
    "torque_margin": 8.25,
    "torque_margin_hinge": "3",
    "torque_margin_at": 0.75,
    "torque_margin_failed": 1.5,
    "deployed_hz": 0.75,
    "soft_modes": 2,
    "latch_torque": 0.25,
    "latch_impulse": 0.125,
    "clearance_ratio": 3.5,
    "self_stresses": 4,
    "flatness_mm_per_mrad": 0.5,
    "tilt": 2.5,
    "stowed_length": 0.34,
    "stowed_width": 0.1,
    "stowed_height": 0.09,
    "area_per_volume": 80.0,
    "mass": 2.75,
    "craft_clearance": -0.004,
}
LENGTHS = {"stowed_length": 340.0, "stowed_width": 100.0, "stowed_height": 90.0, "craft_clearance": -4.0}
NAMES = [quantity.name for quantity in FLIGHT_QUANTITIES]


@pytest.fixture
def listed(database):
    list_designs(database)
    return database


def figures(database, scene="default"):
    """What both views say of the third design; they must agree."""
    (row,) = select(database, "untwisted", columns=NAMES, scene=scene).rows
    assert select(database, "crease=3", columns=NAMES, view="foldings", scene=scene).rows == (row,)
    return dict(zip(NAMES, row, strict=True))


def test_each_figure_is_stored_in_the_unit_of_its_column(listed):
    judge(listed, [FLAT], flight=[NUMBERS])
    assert figures(listed) == NUMBERS | LENGTHS
    assert set(NUMBERS) == set(NAMES)


def test_a_figure_that_is_not_known_or_not_finite_is_null(listed):
    judge(listed, [CUT], flight=[{"torque_margin": float("inf"), "latch_torque": float("nan"), "mass": 1.5}])
    assert {name: value for name, value in figures(listed).items() if value is not None} == {"mass": 1.5}


def test_figures_are_of_a_scene_and_made_anew(listed):
    judge(listed, [FLAT], flight=[NUMBERS])
    judge(listed, [FLAT], "solar", flight=[NUMBERS | {"torque_margin": 2.0}])
    assert (figures(listed)["torque_margin"], figures(listed, "solar")["torque_margin"]) == (8.25, 2.0)
    judge(listed, [FLAT], flight=[{"mass": 1.0}])
    assert [figures(listed)[name] for name in ("torque_margin", "mass")] == [None, 1.0]
    assert figures(listed, "solar")["torque_margin"] == 2.0
    judge(listed, [LOCKED], flight=[None])
    assert set(figures(listed).values()) == {None}
    judge(listed, [FLAT], "solar")
    assert set(figures(listed, "solar").values()) == {None}, "figures of an earlier motion stay where none are computed"


def test_figures_are_words_of_queries(listed):
    judge(listed, [FLAT], flight=[NUMBERS])
    assert len(select(listed, "torque_margin>=7.5 deployed_hz>0.5 soft_modes<=2 torque_margin_hinge=3").rows) == 1
    assert not select(listed, "clearance_ratio>=3.6").rows
    with pytest.raises(QueryError, match="did you mean torque_margin"):
        select(listed, "torque_margins>1")


def test_designs_are_selected_by_the_envelope_into_which_they_fit(listed):
    judge(listed, [FLAT], flight=[NUMBERS])  # 340 x 100 x 90 mm
    for envelope, fits in (
        ("3U", True),
        ("340x100x90", True),
        ("90x340x100", True),
        ("340x100x89", False),
        ("2U", False),
    ):
        assert len(select(listed, f"fits={envelope}").rows) == fits
        assert len(select(listed, f"fits!={envelope}").rows) == (not fits)
        assert len(select(listed, f"crease=3 fits={envelope}", view="foldings").rows) == fits
    assert len(select(listed, "untwisted (fits=2U or fits=3U) not fits=1U").rows) == 1


def test_a_design_without_figures_neither_fits_nor_does_not(listed):
    judge(listed, [CUT])
    assert select(listed, "fits=12U").rows == select(listed, "fits!=12U").rows == ()


@pytest.mark.parametrize("query", ["fits", "fits>3U", "fits=", "fits<=3U"])
def test_an_envelope_is_named_by_one_condition(listed, query):
    with pytest.raises(QueryError, match=r"write fits=3U, or fits=340x640x130 in mm"):
        select(listed, query)


def test_an_unknown_envelope_names_the_catalogue(listed):
    with pytest.raises(SceneError, match="there is no envelope '4U': write one of 1U"):
        select(listed, "fits=4U")
    with pytest.raises(QueryError, match="no column 'fits' in runs"):
        select(listed, "fits=3U", view="runs")
