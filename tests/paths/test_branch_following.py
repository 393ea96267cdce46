"""Motions that are followed from a state along a branch, and the laws that they obey."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch import Folding, Linkage, follow_motion
from hcsearch.basics.errors import HcsearchError
from hcsearch.designs.folding import foldings
from hcsearch.library.assemblies import ASSEMBLIES, Parameters
from hcsearch.motion.kinematics.closing import CLOSED_LOOP_RESIDUAL
from hcsearch.motion.kinematics.numerical_rank import NEAR_ZERO_SHARE
from hcsearch.motion.paths.branches import find_branches, follow_branch
from tests.strategies import circuits

ONE_FREEDOM = ("unit-i", "unit-ii", "unit-iii", "fig-5.10b")


def linkage_of(name):
    return Linkage(ASSEMBLIES[name].build(Parameters()))


def nullity_by_svd(linkage, angles):
    """Hinges less singular values of the Jacobian that are not zero, at a state or at a singular one near by."""
    values = np.linalg.svd(linkage.closure(angles)[1])[1]
    least = 8 * max(linkage.closure(angles)[1].shape) * np.finfo(float).eps * values[0]
    kept = int((values > NEAR_ZERO_SHARE * values[0]).sum())
    if kept < len(values) and values[kept - 1] < 1e3 * values[kept]:  # no gap: a state in general position
        kept = int((values > 10.0 * least).sum())
    return linkage.n_hinges - kept


def rows_obey_the_laws(motion):
    table, rows, linkage = motion.table(), motion.rows, motion.linkage
    assert (
        len(table)
        == len(rows.angles)
        == len(motion.followed.path.angles)
        + sum(map(bool, rows.kinds))
        - (motion.followed.path.outcome in {"branch", "singular"})
    )
    assert (np.diff(rows.lengths) >= 0.0).all()
    # arc length is no less than the chord, up to the place of a singular state, and close to it where states are near
    chords = np.linalg.norm(np.diff(rows.angles, axis=0), axis=1)
    assert (np.diff(rows.lengths) - chords).min(initial=0.0) > -1e-5
    assert rows.lengths[-1] == pytest.approx(chords.sum(), rel=2e-3)
    for k, angles in enumerate(rows.angles):
        residual, jacobian = linkage.closure(angles)
        assert rows.residuals[k] == np.abs(residual).max(initial=0.0)
        assert rows.residuals[k] <= (CLOSED_LOOP_RESIDUAL if not rows.kinds[k] else 1e-9)
        if not rows.kinds[k]:
            assert rows.nullities[k] == nullity_by_svd(linkage, angles)
        values = np.linalg.svd(jacobian, compute_uv=False)
        assert np.abs(values - rows.least_values[k]).min() < 1e-12
    assert [kind for kind in rows.kinds if kind] == [event.kind for event in motion.events]
    assert [rows.nullities[k] for k, kind in enumerate(rows.kinds) if kind] == [
        event.nullity for event in motion.events
    ]


@pytest.mark.parametrize("name", [*ONE_FREEDOM, "element-8r", "element-6r", "thesis-4x4", "module-i"])
@pytest.mark.parametrize("start", ["folded", "flat"])
def test_states_are_closed_and_their_nullity_is_that_of_numpy(name, start):
    motion = follow_motion(name, start=start)
    assert motion.reached
    rows_obey_the_laws(motion)
    stops = np.minimum(motion.rows.angles, math.pi - motion.rows.angles)
    assert stops.min() >= -1e-9


@settings(max_examples=8)
@given(st.data())
def test_motions_of_designs_obey_them_too(data):
    circuit = data.draw(circuits(("hex", "square", "triangle"), even=True))
    options = foldings(circuit)
    if not options:
        return
    linkage = data.draw(st.sampled_from(options)).linkage("50x6")
    if not linkage.loops or linkage.n_hinges > 10:
        return
    motion = follow_motion(linkage, start=data.draw(st.sampled_from(["folded", "flat"])))
    rows_obey_the_laws(motion)
    assert (motion.followed.number is None) == (motion.followed.path.outcome in {"rigid", "undecided"})


@pytest.mark.parametrize("name", ONE_FREEDOM)
def test_a_motion_followed_back_is_the_same(name):
    there = follow_motion(name)
    back = follow_motion(name, start="flat")
    assert (there.followed.path.outcome, back.followed.path.outcome) == ("flat", "folded")
    length = there.rows.lengths[-1]
    assert back.rows.lengths[-1] == pytest.approx(length, rel=1e-5)
    events = [(event.kind, event.nullity) for event in there.events]
    assert [(event.kind, event.nullity) for event in back.events] == events[::-1]
    for one, other in zip(there.events, back.events[::-1], strict=True):
        assert one.angles == pytest.approx(other.angles, abs=1e-6)
        assert one.length == pytest.approx(length - other.length, abs=1e-4)
    # states of one are on the other, between two states of it
    for k, column in enumerate(there.rows.angles.T):
        between = np.interp(there.rows.lengths, length - back.rows.lengths[::-1], back.rows.angles[::-1, k])
        assert column == pytest.approx(between, abs=2e-3)


# docs/explanation/kinematics.md, section 3: phi_1 of the shaky states, in degrees
SHAKY = {"unit-i": [158.292, 134.862], "unit-ii": [7.187, 142.949, 152.722]}


@pytest.mark.parametrize("name", SHAKY)
def test_units_are_shaky_at_the_documented_angles(name):
    motion = follow_motion(name, start="flat" if name == "unit-i" else "folded")
    assert [(event.kind, event.nullity) for event in motion.events] == [("shaky", 2)] * len(SHAKY[name])
    legs = motion.events[0].angles
    wanted = [math.radians(180.0 - phi) for phi in SHAKY[name]]
    for event, angle in zip(motion.events, wanted, strict=True):
        assert np.abs(event.angles - angle).min() < 1e-4
        assert len(np.unique(np.round(event.angles, 6))) == len(np.unique(np.round(legs, 6))) == 2
    assert motion.rows.nullities[[0, -1]].tolist() == [4, 4]


def test_the_8r_element_has_families_at_its_ends_and_two_degrees_of_freedom_between():
    motion = follow_motion("element-8r")
    assert motion.followed.branches.nullity == 3
    assert {branch.dimension for branch in motion.branches} == {1}
    assert set(motion.rows.nullities[1:].tolist()) == {2}
    assert motion.followed.path.outcome == "stopped"


def test_the_loop_of_the_4x4_array_has_six_freedoms_and_more_at_its_ends():
    folded, flat = follow_motion("thesis-4x4"), follow_motion("thesis-4x4", start="flat")
    assert (folded.followed.branches.nullity, flat.followed.branches.nullity) == (7, 8)
    assert min(flat.rows.nullities) == 6


def test_a_motion_ends_at_a_singular_state_and_goes_on_from_there():
    whole = follow_motion("unit-ii")
    first = follow_motion("unit-ii", until="event")
    assert first.followed.path.outcome == "singular"
    assert first.rows.kinds[-1] == "shaky"
    assert first.rows.lengths[-1] == pytest.approx(whole.events[0].length, abs=1e-6)
    on = follow_motion("unit-ii", start=first.rows.angles[-1])
    assert on.followed.branches.nullity == 2
    # there and back along one motion
    assert [branch.status for branch in on.branches] == ["finite", "finite"]
    assert on.branches[0].direction == pytest.approx(-on.branches[1].direction, abs=1e-6)
    assert [event.kind for event in on.events] == ["shaky", "shaky"]
    assert on.followed.path.outcome == "flat"
    assert first.rows.lengths[-1] + on.rows.lengths[-1] == pytest.approx(whole.rows.lengths[-1], abs=1e-4)
    other = follow_motion("unit-ii", start=first.rows.angles[-1], branch=3 - on.followed.number)
    assert other.followed.path.outcome == "folded"
    assert other.rows.lengths[-1] == pytest.approx(first.rows.lengths[-1], abs=1e-5)


def test_all_branches_of_a_bifurcation_are_followed():
    # the planar 4R of the 6R element meets its other branch, and the stage in which the two other joints open
    first = follow_motion("element-6r", until="bifurcation", stops=False)
    assert first.followed.path.outcome == "branch"
    # a state is located where singular values are least, and these hardly change beside it
    assert first.rows.lengths[-1] == pytest.approx(2.0 * math.pi, abs=1e-4)
    ends = []
    for branch in (1, 2, 3, -1, -2, -3):
        on = follow_motion("element-6r", start=first.rows.angles[-1], stops=False, branch=branch, length=0.5)
        assert len(on.branches) == 3
        assert on.followed.number == branch
        assert on.followed.path.outcome == "length"
        assert on.rows.lengths[-1] == pytest.approx(0.5)
        rows_obey_the_laws(on)
        ends.append(on.rows.angles[-1])
    distances = [np.linalg.norm(one - other) for k, one in enumerate(ends) for other in ends[:k]]
    assert min(distances) > 0.3
    assert not follow_motion("element-6r", until="bifurcation").reached


def test_finite_members_of_a_family_are_found_where_those_listed_are_not_finite():
    # along this motion, on which the array opens, four pairs of hinges turn alike: it is singular all the way
    linkage = Folding.from_notation("hex:0234435011:1").linkage("50x6")
    for state in (linkage.folded, linkage.flat):
        found = [branch for branch in find_branches(linkage, state, stops=True).finite if branch.within_stops]
        assert found
        for branch in found:
            pairs = np.abs(branch.direction[[0, 2]] - branch.direction[[1, 3]])
            assert pairs.max() < 1e-3
        motion = follow_branch(linkage, state, max_step=0.2)
        assert motion.path.lengths[-1] > 5.0
        assert motion.path.events == ()
        assert motion.path.residuals.max() <= CLOSED_LOOP_RESIDUAL


def test_a_step_bounds_the_arc_length_between_states():
    coarse, fine = follow_motion("unit-ii", step=1.0), follow_motion("unit-ii", step=0.1)
    assert np.diff(fine.rows.lengths).max() <= 0.1 * (1.0 + 1e-3)
    assert len(fine.rows.lengths) > 2 * len(coarse.rows.lengths)
    assert [event.length for event in fine.events] == pytest.approx([event.length for event in coarse.events], abs=1e-3)


def test_a_locked_folding_does_not_move_and_says_so():
    motion = follow_motion("hex:0234550132:3")
    assert (motion.followed.number, motion.followed.path.outcome, motion.reached) == (None, "rigid", False)
    assert "no finite motion was found at the start" in motion.sentence
    assert len(motion.table()) == 1


def test_a_rank_that_rounding_hides_leaves_the_motion_undecided():
    linkage = Linkage(ASSEMBLIES["unit-ii"].build(Parameters(thickness=1e-9 * 0.03)))
    motion = follow_motion(linkage)
    assert motion.followed.path.outcome == "undecided"
    assert motion.facts()["nullity"] is None


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"branch": 2}, "there is no branch 2 at the start: the branches are 1 alone"),
        ({"branch": 0}, "there is no branch 0"),
        ({"branch": -1}, "opposite sense"),
        ({"start": "flat", "until": "flat"}, "the motion begins flat"),
        ({"until": "folded"}, "the motion begins folded"),
        ({"length": 0.0}, "length cannot be 0.0"),
        ({"step": -1.0}, "step cannot be -1.0"),
        ({"step": math.nan}, "step cannot be nan"),
        ({"start": "nowhere"}, "'nowhere' names no state"),
        ({"row": 3}, "row 3 is one of a table"),
        ({"start": [0.0] * 24, "row": 3}, "row 3 is one of a table"),
        ({"start": [0.0] * 23}, "24 fold angles"),
        ({"start": [math.nan] * 24}, "not a finite number"),
        ({"start": [0.1, *[0.0] * 23]}, "the loops are not closed"),
        ({"until": "sometime"}, "until cannot be 'sometime'"),
        ({"branch": "first"}, "branch cannot be 'first'"),
    ],
)
def test_wrong_branches_states_and_bounds_are_refused(options, message):
    with pytest.raises(HcsearchError, match=message):
        follow_motion("unit-ii", **options)


def test_branches_of_a_locked_folding_cannot_be_chosen():
    with pytest.raises(HcsearchError, match=r"no branch begins at the start .*: leave out --branch"):
        follow_motion("hex:0234550132:3", branch=1)
