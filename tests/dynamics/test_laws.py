"""Laws as the kernel evaluates them: energy is the moment's integral, and each does what its name says."""

import math
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from hcsearch.basics.errors import HcsearchError, NotationError
from hcsearch.kernels.multibody.hinges import law_moment, law_slope
from hcsearch.scenes.laws import (
    FREE_LAW,
    Law,
    LawBranch,
    law_named,
    linear_law,
    quadratic_law,
    scaled_law,
    spring_law,
    tables_of_laws,
    tabulated_law,
    tape_spring_law,
)
from hcsearch.springs.dynamics.body_trees import Body, TreeJoint
from hcsearch.springs.dynamics.system import JointDrive, System

Z = np.array([0.0, 0.0, 1.0])

moments = st.floats(-3.0, 3.0).map(lambda x: round(x, 6))
preloads = st.sampled_from([0.0, 0.02, -0.3, 1e-5])
angles = st.floats(-0.5, 3.6)


@st.composite
def tables(draw):
    n = draw(st.integers(2, 7))
    steps = draw(st.lists(st.floats(0.05, 1.5), min_size=n - 1, max_size=n - 1))
    start = draw(st.floats(-0.5, 1.0))
    return [start, *(start + np.cumsum(steps)).tolist()], draw(st.lists(moments, min_size=n, max_size=n))


@st.composite
def tapes(draw):
    peak, angle = draw(st.floats(0.01, 2.0)), draw(st.floats(0.02, 0.5))
    low = peak * draw(st.floats(0.02, 0.5))
    back = angle * low / peak * draw(st.floats(0.1, 1.9))
    return tape_spring_law(peak, angle, low, draw(st.sampled_from([None, back])), draw(preloads))


laws = st.one_of(
    st.just(FREE_LAW),
    st.builds(linear_law, moments, preloads),
    st.builds(quadratic_law, moments, moments, preloads),
    st.builds(lambda table, preload: tabulated_law(*table, preload), tables(), preloads),
    tapes(),
    st.builds(lambda table, factor: scaled_law(tabulated_law(*table), factor), tables(), st.floats(0.1, 4.0)),
)


def kernel(*laws):
    """The tables of laws, one a joint."""
    joints = tuple(TreeJoint(-1, Z, np.zeros(3)) for _ in laws)
    bodies = tuple(Body(1.0, np.zeros(3), np.eye(3)) for _ in laws)
    return System(joints, bodies, tuple(JointDrive(law) for law in laws)).mechanism.hinges


def value(law, angle, branch=0):
    return law_moment(kernel(law), 0, branch, angle)[0]


@settings(max_examples=60)
@given(laws, angles.filter(lambda x: x == 0.0 or abs(x) > 1e-100), st.integers(0, 1))
def test_energy_is_the_integral_of_the_moment_from_angle_0(law, angle, branch):
    hinges = kernel(FREE_LAW, law)
    breaks = [
        x for x in (law.bent if branch and law.bent else law.straight).breaks if min(0, angle) < x < max(0, angle)
    ]
    expected, error = quad(
        lambda x: law_moment(hinges, 1, branch, x)[0], 0.0, angle, points=breaks or None, epsabs=1e-12
    )
    assert law_moment(hinges, 1, branch, angle)[1] == pytest.approx(expected, abs=1e-10 + error, rel=1e-9)


@settings(max_examples=60)
@given(laws, angles, st.integers(0, 1))
def test_steepness_is_the_slope_of_the_moment(law, angle, branch):
    hinges = kernel(law)
    h = 1e-5
    breaks = (law.bent if branch and law.bent else law.straight).breaks
    if min(abs(angle - x) for x in breaks) > 2 * h:
        slope = (law_moment(hinges, 0, branch, angle + h)[0] - law_moment(hinges, 0, branch, angle - h)[0]) / (2 * h)
        assert law_slope(hinges, 0, branch, angle) == pytest.approx(slope, abs=1e-5, rel=1e-5)


@settings(max_examples=60)
@given(laws)
def test_moments_do_not_jump_at_breaks(law):
    hinges = kernel(law)
    for x in law.straight.breaks:
        before, after = (law_moment(hinges, 0, 0, x + d) for d in (-1e-9, 1e-9))
        assert before == pytest.approx(after, abs=1e-6)


@settings(max_examples=60)
@given(tables(), preloads)
def test_tabulated_laws_pass_through_their_points_and_rise_where_they_rise(table, preload):
    x, y = table
    hinges = kernel(tabulated_law(x, y, preload))
    for angle, m in zip(x, y, strict=True):
        assert law_moment(hinges, 0, 0, angle)[0] == pytest.approx(m + preload, abs=1e-9)
    for k in range(len(x) - 1):
        between = [law_moment(hinges, 0, 0, t)[0] for t in np.linspace(x[k], x[k + 1], 20)]
        assert (np.diff(between) * math.copysign(1.0, y[k + 1] - y[k])).min() >= -1e-9


@given(laws)
def test_a_law_reads_its_own_text(law):
    again = law_named(law.text)
    assert again == law
    assert again.text == law.text


@given(laws, st.floats(0.1, 9.0), angles)
def test_springs_in_parallel_add_their_moments(law, factor, angle):
    hinges = kernel(law, scaled_law(law, factor))
    for branch in (0, 1):
        one, many = law_moment(hinges, 0, branch, angle), law_moment(hinges, 1, branch, angle)
        assert np.array(many) == pytest.approx(factor * np.array(one), rel=1e-12, abs=1e-12)
    assert (scaled_law(law, factor).snap_up, scaled_law(law, factor).snap_down) == (law.snap_up, law.snap_down)


@given(tapes())
def test_a_tape_spring_leaves_its_straight_branch_at_the_peak_and_comes_back_at_a_smaller_angle(law):
    hinges = kernel(law)
    assert law.snap_down < law.snap_up
    (peak, before), (low, after) = (law_moment(hinges, 0, branch, law.snap_up) for branch in (0, 1))
    assert low < peak
    assert after <= before + 1e-12 * abs(before) + 1e-15
    assert law_moment(hinges, 0, 1, math.pi)[0] == pytest.approx(low)
    (_, straight), (_, bent) = (law_moment(hinges, 0, branch, law.snap_down) for branch in (0, 1))
    # there and back takes the area between the branches
    area, _ = quad(
        lambda x: law_moment(hinges, 0, 0, x)[0] - law_moment(hinges, 0, 1, x)[0], law.snap_down, law.snap_up
    )
    assert bent >= straight - 1e-12
    assert (before - after) + (bent - straight) == pytest.approx(area, abs=1e-12)


def test_a_tape_spring_snaps_back_where_its_branches_meet_unless_told():
    law = tape_spring_law(peak=0.2, peak_angle=0.05, low=0.04)
    assert law.snap_down == pytest.approx(0.01)
    assert value(law, 0.01) == pytest.approx(value(law, 0.01, branch=1))


@pytest.mark.parametrize(
    ("text", "angle", "expected"),
    [
        ("free", 2.0, 0.0),
        ("linear:0.1", 2.0, 0.2),
        ("linear:0.1+0.02", 0.0, 0.02),
        ("linear:1e-1-2e-2", 1.0, 0.08),
        ("linear:-.1", 1.0, -0.1),
        (" linear:0.1 ", 1.0, 0.1),
        ("quadratic:0.02,0.03", 2.0, 0.16),
        ("quadratic:0.02,0.03+1", 2.0, 1.16),
        ("table:0@0,0.1@1,0.3@3", 1.0, 0.1),
        ("table:0@0,0.1@1,0.3@3-0.1", 3.0, 0.2),
        ("tape:0.2@0.05,0.03@0.01", 0.05, 0.2),
        ("2*linear:0.1+0.02", 1.0, 0.24),
        ("3*2*linear:0.1", 1.0, 0.6),
    ],
)
def test_notations_say_what_they_mean(text, angle, expected):
    assert value(law_named(text), angle) == pytest.approx(expected)


def test_laws_of_one_text_are_one_whoever_made_them():
    assert linear_law(1).text == "linear:1"
    assert linear_law(0.1, -0.02).text == "linear:0.1-0.02"
    assert law_named("2*linear:0.1") == linear_law(0.2)
    assert tabulated_law(np.array([0.0, 3.0]), np.array([0, 1])).text == "table:0@0,1@3"
    assert Law(LawBranch((0.0,), ((0.0, 1.0, 0.0, 0.0),))).text == ""


@pytest.mark.parametrize(
    "text",
    [
        "angle_rad,moment_N_m\n0,0\n1.5, 0.1\n3.1,3e-1\n",
        "\ufeffangle (rad),moment (N m)\n\n0,0\n1.5,0.1\n3.1,0.3\n",
        "moment_N_mm,angle_rad\n0,0\n100,1.5\n300,3.1\n",
        ",Moment [N mm],remark,Angle (rad),\n0,300,ok,3.1,\n1,100,,1.5,\n2,0,slack,0,\n",
    ],
)
def test_a_table_in_a_file_is_the_law_of_its_points(tmp_path, text):
    file = tmp_path / "spring+1.csv"
    file.write_text(text, encoding="utf-8")
    expected = tabulated_law([0.0, 1.5, 3.1], [0.0, 0.1, 0.3])
    assert law_named(f"table:{file}") == expected
    assert law_named(f"2*table:{file}+0.02").text == "2*table:0@0,0.1@1.5,0.3@3.1+0.02"


@pytest.mark.parametrize(
    ("make", "remedy"),
    [
        (lambda: tabulated_law([0.0], [0.0]), "give two points"),
        (lambda: tabulated_law([0.0, 1.0], [0.0]), "give one moment for each angle"),
        (lambda: tabulated_law([0.0, 2.0, 1.0], [0.0, 1.0, 2.0]), "sort it"),
        (lambda: tabulated_law([0.0, 1.0, 1.0], [0.0, 1.0, 2.0]), "each angle once"),
        (lambda: tabulated_law([0.0, math.nan], [0.0, 1.0]), "give finite numbers"),
        (lambda: tabulated_law([0.0, 1.0], [0.0, math.inf]), "give finite numbers"),
        (lambda: linear_law(math.nan), "give finite numbers"),
        (lambda: quadratic_law(0.1, math.inf), "give finite numbers"),
        (lambda: linear_law(0.1, math.nan), "give finite numbers"),
        (lambda: tape_spring_law(-0.2, 0.05, 0.03), "give positive numbers"),
        (lambda: tape_spring_law(0.2, 0.05, 0.15), "at most half the peak"),
        (lambda: tape_spring_law(0.2, 0.05, 0.03, 0.06), "give an angle above 0"),
        (lambda: tape_spring_law(0.2, 0.05, 0.03, 0.02), "at most 0.015"),
        (lambda: tape_spring_law(0.2, 0.05, 0.03, math.nan), "give an angle above 0"),
        (lambda: scaled_law(FREE_LAW, 0.0), "give a positive factor"),
        (lambda: scaled_law(FREE_LAW, math.nan), "give a positive factor"),
        (lambda: law_named("linear:1e999"), "give finite numbers"),
        (lambda: law_named("table:nowhere.csv"), "name a file that is there"),
        (lambda: law_named("table:/dev/../dev/zero.csv"), "name a file that is there"),
        (lambda: law_named("table:\0.csv"), "no file has such a name"),
        (lambda: law_named("table:\ud800.csv"), "no file has such a name"),
        (lambda: law_named("1e308*linear:1e300"), "overflow: give smaller moments"),
        (lambda: law_named("1e300*1e300*linear:1"), "overflow: give smaller moments"),
        (lambda: law_named("table:-1e300@0,1e300@1e-9"), "overflow: give smaller moments"),
        (lambda: law_named("table:0@0,1e300@1e-3,-1e300@3"), "overflow: give smaller moments"),
        (lambda: law_named("1*" * 2000 + "linear:0.1"), "2000 factors .*: multiply them"),
    ],
)
def test_refusals_name_their_remedy(make, remedy):
    with pytest.raises(HcsearchError, match=remedy):
        make()


@pytest.mark.parametrize(
    "text",
    [
        *("", "spring", "linear", "linear:", "linear:a", "linear:nan", "linear:1,2", "tape:1@2", "2*"),
        *("linear:\u0661", "\u0662*linear:1", "linear:\0", "linear:\ud800", "x" * 100_000),
        "table:" + "11@11," * 1000 + "x",  # was read in 4^1000 ways
    ],
)
def test_what_is_no_notation_is_refused(text):
    with pytest.raises(NotationError, match="write free, linear") as caught:
        law_named(text)
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 500


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0,0\n3.1,0.3\n", "first line .* names no columns"),
        ("angle,moment\n0,0\n3.1,0.3\n", "no columns of the angle .* angle_rad or angle_deg"),
        ("angle_rad,moment_kN_m\n0,0\n3.1,0.3\n", "no columns of the moment .* moment_N_m or moment_N_mm"),
        ("angle_rad,moment_N_m\n0,0\n1;1\n", "line 3 .* 1 values for 2 columns"),
        ("angle_rad,moment_N_m\n0,0\n1,0,1\n", "line 3 .* 3 values for 2 columns"),
        ("angle_rad,moment_N_m\n0,0\n1,one\n", "line 3 .* 'one' for moment_N_m: leave the row out"),
        ("angle_rad,moment_N_m\n0,0\n150,1\n", "an angle of 150 rad, .* name the column angle_deg"),
        ("angle_deg,moment_N_m\n0,0\n200,1\n", "an angle of 3.49066 rad, .* hinges turn from 0 .flat. to pi"),
        ("angle_deg,moment_N_m\n0,0\n-20,-1\n", "turn the sign of its angles and moments"),
        ("angle_deg,moment_N_m\n0,0\n-20,1\n", "turn the sign of its angles$"),
        ("angle_deg,moment_N_m\n0,0\n20,-1\n", "turn the sign of its moments"),
        ("angle_deg,moment_N_m\n0,0\n20,2\n10,1\n", "sort it, each angle once, or .* identify spring"),
    ],
)
def test_files_that_are_no_table_are_refused(tmp_path, text, message):
    file = tmp_path / "spring.csv"
    file.write_text(text)
    with pytest.raises(HcsearchError, match=message):
        law_named(f"table:{file}")


@given(tables(), st.sampled_from(["rad", "deg"]), st.sampled_from(["N_m", "N_mm"]), st.booleans())
def test_a_table_means_the_same_in_any_unit_and_order(table, angle, moment, swapped):
    angles, moments = np.array(table[0]), np.array(table[1])
    angles = abs(angles - angles[0]) * 3.0 / np.ptp(angles)
    moments = abs(moments)
    columns = {f"angle_{angle}": np.degrees(angles) if angle == "deg" else angles}
    columns[f"moment_{moment}"] = 1e3 * moments if moment == "N_mm" else moments
    names = list(columns)[::-1] if swapped else list(columns)
    with TemporaryDirectory() as folder:
        lines = [",".join(names), *(",".join(repr(float(columns[n][k])) for n in names) for k in range(len(angles)))]
        (Path(folder) / "spring.csv").write_text("\n".join(lines))
        read = law_named(spring_law("table:spring.csv", Path(folder)))
    for one, two in zip(angles, moments, strict=True):
        assert value(read, one) == pytest.approx(two, rel=1e-9, abs=1e-9)


def test_a_law_of_a_file_becomes_its_points(tmp_path):
    (tmp_path / "s.CSV").write_text("angle_deg,moment_N_m\n0,0\n90,0.1\n")
    assert spring_law("2*table:s.CSV+0.02", tmp_path) == f"2*table:0@0,0.1@{math.pi / 2}+0.02"
    assert spring_law("table:s.CSV-1e-2", tmp_path) == f"table:0@0,0.1@{math.pi / 2}-1e-2"
    for text in ("linear:0.1", "nonsense", "table:0@0,1@3.1416"):
        assert spring_law(text, tmp_path) == text
    with pytest.raises(HcsearchError, match=r"an angle of 120 rad, .* are in rad"):
        spring_law("3*table:0@0,209@120+1", tmp_path)


def test_a_table_in_the_folder_of_the_user_is_named_by_a_tilde(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    (tmp_path / "s.csv").write_text("angle_deg,moment_N_m\n0,0\n90,0.1\n")
    law = f"table:0@0,0.1@{math.pi / 2}"
    assert spring_law("2*table:~/s.csv", Path("elsewhere")) == f"2*{law}"
    assert law_named("table:~/s.csv").text == law


def test_joints_of_one_law_share_its_pieces():
    law = tabulated_law([0.0, 1.0, 2.0], [0.0, 1.0, 3.0])
    pieces, breaks, cubics, energies = tables_of_laws([law, FREE_LAW, law])
    assert (pieces[0] == pieces[2]).all()
    assert len(breaks) == len(cubics) == len(energies) == 3
