"""The quick check of many foldings in one call against one deployment at a time."""

from dataclasses import fields, replace

import pytest

from hcsearch.basics.errors import HcsearchError
from hcsearch.scenes import SCENES
from hcsearch.springs.deployment.compiled_scene import compile_scene
from hcsearch.springs.deployment.quick_check import check_deployments
from hcsearch.springs.deployment.simulated_deployment import simulate_compiled, simulate_deployment
from tests.linkages import linkage_named

DEFAULT = SCENES["default"]
TOLERANCE = 1e-5
NAMES = [
    "hex:0234550132:4",  # flat and clear
    "hex:02234400:1",  # flat, collides
    "hex:0233235500:0",  # the same, long before it is flat
    "hex:0234535012:4",  # locked: at rest
    "hex:0234405022:1",  # jammed
    "hex:0233340501:3",
    "hex:0233235500:0",  # flat, collides long before
    "hex:023424540021:3",  # diverges at a singular state
    "square:01222300:3",  # half of it is simulated
    "square:0123:0",  # a single joint
    "hex:023350:1",  # in the plane
    "thesis-4x4",
    "element-8r",
    "square:012230:1",
]
VERDICTS = {"clear": True, "collides": False, "undecided": None}


def compiled(name, formulation="constrained", **changes):
    return compile_scene(linkage_named(name), replace(DEFAULT, **changes), formulation)


def agrees(found, one):
    """An entry tells what a deployment of its own does, to the last bit."""
    clearance = one.clearance
    moves_alike(found, one)
    assert found.clear is VERDICTS[clearance.kind]
    assert found.looks == clearance.bound_count
    assert found.collision == ((clearance.time, clearance.panels) if clearance.kind == "collides" else None)
    assert found.gap == clearance.gap
    assert found.deploys is (one.outcome == "flat" and clearance.kind == "clear")
    assert found.verdict == one.verdict
    same(found, one)


def same(found, one):
    """An entry is the deployment without its states: numpy may add fold angles up in another order, and states that are
    put between others, where loops are opened, move the fold angles at a collision by next to nothing.
    """
    for field in fields(found):
        mine, alone = getattr(found, field.name), getattr(one.check, field.name)
        if field.name in {"remaining", "end_remaining", "widest", "drift"}:
            assert mine == pytest.approx(alone, rel=1e-9), field.name
        else:
            assert mine == alone, field.name
    assert found.flat_time == one.flat_time


def moves_alike(found, one):
    """An entry has the motion of a deployment of its own."""
    motion = one.motion
    assert found.outcome == one.outcome
    assert found.end_time == motion.times[-1]
    assert (found.steps, found.evaluations) == (len(motion.times) - 1, motion.evaluations)
    assert found.drift == pytest.approx(motion.drift / largest_energy(motion), rel=1e-12)


def largest_energy(motion):
    books = (motion.kinetic, motion.stored, motion.height, motion.in_stops, motion.damped, motion.lost)
    return max(abs(book).max() for book in books)


def test_each_entry_is_that_of_its_own_deployment():
    scenes = [compiled(name) for name in NAMES]
    found = check_deployments(scenes, tolerance=TOLERANCE)
    assert {each.outcome for each in found} >= {"flat", "at rest", "jammed", "diverged"}
    assert {each.clear for each in found} >= {True, False}
    for scene, entry in zip(scenes, found, strict=True):
        agrees(entry, simulate_compiled(scene, tolerance=TOLERANCE))
    assert found[NAMES.index("hex:0234550132:4")].deploys
    assert not found[NAMES.index("hex:02234400:1")].deploys


def test_the_order_of_a_batch_does_not_matter():
    scenes = [compiled(name, seconds=0.1) for name in NAMES]
    found = check_deployments(scenes, tolerance=TOLERANCE)
    assert check_deployments(scenes[::-1], tolerance=TOLERANCE) == found[::-1]
    assert check_deployments(scenes[:1], tolerance=TOLERANCE) == found[:1]
    twice = check_deployments([scenes[0], *scenes, scenes[0]], tolerance=TOLERANCE)
    assert twice == [found[0], *found, found[0]]
    assert check_deployments([]) == []


def test_scenes_of_one_shape_may_differ():
    """Springs, gravity and start are told of each; times and restitution part them into calls of their own."""
    changes = [
        {},
        {"spring": "linear:0.2"},
        {"gravity": (0.0, 0.0, -9.81)},
        {"start": 0.99},
        {"seconds": 0.05},
        {"restitution": 0.5},
        {"held": 3},
        {"springs": ((0, "linear:0.05"),)},
    ]
    scenes = [compiled("hex:0233340501:3", **each) for each in changes]
    found = check_deployments(scenes, tolerance=TOLERANCE)
    assert len({each.end_time for each in found}) > 5
    for scene, entry in zip(scenes, found, strict=True):
        agrees(entry, simulate_compiled(scene, tolerance=TOLERANCE))


@pytest.mark.slow
def test_springs_across_the_loops_are_checked_too():
    names = ("hex:0234550132:4", "hex:023424540021:3")
    scenes = [compiled(name, "compliant", seconds=0.08, cut_stiffness=2.5e8) for name in names]
    scenes.append(compiled("hex:0234550132:4", seconds=0.08))
    # at 1e-4 rounding decides whether the energy balance holds where the first stop is met, at 0.07 s
    found = check_deployments(scenes, tolerance=1e-5)
    alone = [simulate_compiled(scene, tolerance=1e-5) for scene in scenes]
    for entry, one in zip(found[:2], alone[:2], strict=True):
        moves_alike(entry, one)
        # a check takes the largest opening of the loops for all times, a deployment that of each step
        assert entry.clear in {None, VERDICTS[one.clearance.kind]}
    agrees(found[2], alone[2])
    assert found[0].clear is None is not VERDICTS[alone[0].clearance.kind]
    assert found[0].end_time == pytest.approx(found[2].end_time, abs=1e-3)


@pytest.mark.parametrize(
    ("formulation", "changes"),
    [
        ("penalty", {}),
        ("quasistatic", {}),
        ("constrained", {"held": "free", "base_mass": 0.1, "base_inertia": (1e-4, 2e-4, 1e-4)}),
    ],
)
def test_other_scenes_are_refused(formulation, changes):
    scenes = [compiled("hex:023350:1"), compiled("hex:023350:1", formulation, **changes)]
    with pytest.raises(HcsearchError, match="the quick check is of scenes with a panel held, constrained or compliant"):
        check_deployments(scenes)


def test_margins_that_leave_nothing_are_refused():
    with pytest.raises(HcsearchError, match="leaves nothing of a panel: give more than 0 and less than 3 mm"):
        check_deployments([compiled("hex:023350:1", margin=0.003)])


def test_a_batch_tells_the_same_bits_again():
    scenes = [compiled(name, seconds=0.1) for name in NAMES[:5]]
    one, two = (check_deployments(scenes, tolerance=TOLERANCE) for _ in range(2))
    assert one == two
    again = simulate_deployment(linkage_named(NAMES[0]), replace(DEFAULT, seconds=0.1), tolerance=TOLERANCE)
    agrees(one[0], again)


def test_in_parts_a_motion_is_the_same_and_ends_soon_after_a_collision():
    scenes = [compiled(name) for name in NAMES]
    whole, parts = (check_deployments(scenes, tolerance=TOLERANCE, past_collisions=each) for each in (True, False))
    for scene, one, part in zip(scenes, whole, parts, strict=True):
        assert part.clear is one.clear
        if one.clear is False:
            assert part.collision[1] == one.collision[1]
            assert part.collision[0] == pytest.approx(one.collision[0], rel=1e-6)
            assert part.remaining == pytest.approx(one.remaining, rel=1e-5)
            times = simulate_compiled(scene, tolerance=TOLERANCE).motion.times
            assert part.collision[0] < part.end_time
            assert part.end_time in times
            assert part.steps <= 33 + 1.5 * (times < part.collision[0]).sum()
        else:
            assert (part.outcome, part.end_time, part.gap) == (one.outcome, one.end_time, one.gap)
            assert (part.steps, part.evaluations, part.drift) == (one.steps, one.evaluations, one.drift)
    assert sum(part.end_time < 0.99 * one.end_time for one, part in zip(whole, parts, strict=True)) >= 2


def test_a_motion_in_parts_keeps_its_books():
    """The energy that dampers and impacts took in the parts before counts on."""
    scene = compiled("hex:0234550132:4")
    (whole,), (parts,) = (check_deployments([scene], tolerance=1e-8, past_collisions=each) for each in (True, False))
    assert whole.deploys
    assert parts.deploys
    assert replace(parts, looks=whole.looks) == whole
    assert parts.end_time > 0.1
    assert parts.steps > 100  # more than one part
    assert parts.drift < 1e-5
