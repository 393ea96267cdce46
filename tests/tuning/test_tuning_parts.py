"""The parts of a tuning: objective, catalogue springs, samples of the tolerances, evaluations that are kept."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import beta

from hcsearch.basics.errors import HcsearchError
from hcsearch.scenes import SCENES, Scene
from hcsearch.scenes.scene_file import read_scene_file, scene_file_text, scene_in, scene_named
from hcsearch.scenes.setup import setup_of_scene, with_stiffnesses
from hcsearch.shape.labels import labels_of
from hcsearch.springs.deployment.compiled_scene import compile_scene
from hcsearch.springs.deployment.outcomes import DeploymentCheck
from hcsearch.springs.deployment.quick_check import check_deployments, checked_panels_of
from hcsearch.springs.deployment.spring_sets import stiffnesses_of, tied_hinges, with_springs
from hcsearch.springs.tuning.evaluation import (
    AMPLE_GAP,
    APPROACH_SPEED_SCALE,
    SOFTENED_SETUP_VALUES,
    TUNING_MARGIN_SHARE,
    TUNING_STEP_TOLERANCES,
    DatabaseMemory,
    Evaluator,
    tuning_objective,
)
from hcsearch.springs.tuning.robustness import Robustness, most_robust, robustness_of_checks, sampled_setups
from hcsearch.springs.tuning.spring_search import catalogue_levels, descend_levels, nearest_levels, neighbouring_levels
from hcsearch.springs.tuning.tuning_options import Spread
from hcsearch.store import open_database, select
from tests.linkages import linkage_named

DEFAULT = SCENES["default"]
GOOD = DeploymentCheck("flat", 0.4, True, None, 1e-3, 0.0, 0.001, 0.001, 0.01, 1e-6, 1e-7, 100, 1000, 500)
HIT = replace(GOOD, clear=False, collision=(0.2, (0, 3)), gap=None, speed=0.5, remaining=0.3)
SMALL = "hex:023350:1"

checks = st.builds(
    DeploymentCheck,
    outcome=st.sampled_from(("flat", "moving", "at rest", "stuck", "jammed", "diverged", "out of steps")),
    end_time=st.just(0.4),
    clear=st.sampled_from((True, False, None)),
    collision=st.none(),
    gap=st.none() | st.floats(0.0, 0.1),
    speed=st.floats(0.0, 10.0),
    remaining=st.floats(0.0, 1.0),
    end_remaining=st.floats(0.0, 1.0),
    widest=st.just(1.0),
    drift=st.just(0.0),
    opening=st.just(0.0),
    steps=st.just(1),
    evaluations=st.just(1),
    looks=st.just(1),
)


@given(checks)
def test_only_what_comes_flat_and_clear_is_at_most_nothing(one):
    assert (tuning_objective(one) <= 0.0) == one.deploys
    assert tuning_objective(one) >= -1.0


@given(checks, st.floats(0.01, 1.0))
def test_faster_earlier_and_less_open_is_worse(one, more):
    if not one.deploys:
        assert tuning_objective(replace(one, remaining=one.remaining + more)) > tuning_objective(one)
        assert tuning_objective(replace(one, outcome="flat", clear=True)) < 1.0 <= tuning_objective(one)
    if one.clear is not True:
        assert tuning_objective(replace(one, speed=one.speed + more)) > tuning_objective(one)
        # what comes after a collision counts for nothing
        assert tuning_objective(replace(one, end_remaining=one.end_remaining + more)) == tuning_objective(one)


@given(checks, st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_what_loops_give_way_lessens_the_gap_and_no_more(one, slack, more):
    assert tuning_objective(one, slack + more) >= tuning_objective(one, slack)
    assert (tuning_objective(one, slack) < 1.0) == one.deploys


def test_the_objective_is_the_thesis_one_where_that_speaks():
    assert tuning_objective(replace(GOOD, gap=0.5 * AMPLE_GAP)) == pytest.approx(-0.5)
    assert tuning_objective(replace(GOOD, gap=None)) == tuning_objective(replace(GOOD, gap=7 * AMPLE_GAP)) == -1.0
    assert tuning_objective(HIT) == pytest.approx(1.0 + 0.5 / APPROACH_SPEED_SCALE + 0.3)
    assert tuning_objective(replace(GOOD, gap=0.5 * AMPLE_GAP), 0.2 * AMPLE_GAP) == pytest.approx(-0.3)
    assert tuning_objective(replace(HIT, speed=math.nan)) == tuning_objective(replace(HIT, remaining=math.inf)) == 10.0


def test_catalogue_levels_are_none_one_or_two_springs():
    assert catalogue_levels((0.07, 0.10), 0.2) == pytest.approx((0.0, 0.07, 0.10, 0.14, 0.17, 0.20))
    assert catalogue_levels((0.15,), 0.2) == (0.0, 0.15)
    for bad in ((), (0.0,), (0.3,), (-0.1,)):
        with pytest.raises(HcsearchError, match="catalogue"):
            catalogue_levels(bad, 0.2)
    assert nearest_levels([0.001, 0.06, 0.19], (0.0, 0.07, 0.2)) == (0, 1, 2)


@given(st.lists(st.integers(0, 4), min_size=1, max_size=4).map(tuple))
def test_neighbours_are_one_level_off(chosen):
    around = neighbouring_levels(chosen, [5] * len(chosen))
    naive = [
        other
        for other in itertools.product(range(5), repeat=len(chosen))
        if sum(abs(a - b) for a, b in zip(chosen, other, strict=True)) == 1
    ]
    assert sorted(around) == sorted(naive)


def test_a_descent_finds_the_least_of_a_bowl_and_keeps_to_its_budget():
    asked = []

    def costs(sets):
        asked.extend(sets)
        return [sum((a - b) ** 2 for a, b in zip(one, (3, 1, 4), strict=True)) for one in sets]

    seen = descend_levels([(0, 0, 0), (0, 0, 0)], [6] * 3, costs, budget=60)
    assert min(seen, key=seen.__getitem__) == (3, 1, 4)
    assert len(asked) == len(set(asked)) == len(seen) < 60 + 6


def test_a_descent_ends_when_all_is_known():
    assert len(descend_levels([(0, 0)], [3, 3], lambda sets: [0.0] * len(sets), budget=1000)) == 9


@given(st.integers(1, 200).flatmap(lambda n: st.tuples(st.just(n), st.integers(0, n))))
def test_the_interval_is_clopper_and_pearsons(counts):
    samples, hits = counts
    low, high = Robustness(samples, hits, hits).interval
    assert low == pytest.approx(beta.ppf(0.025, hits, samples - hits + 1) if hits else 0.0)
    assert high == pytest.approx(beta.ppf(0.975, hits + 1, samples - hits) if hits < samples else 1.0)


def test_samples_are_spread_as_told_and_the_same_for_a_seed():
    spread = Spread(stiffness=0.05, damping=0.1, mass=0.02, start=0.002)
    linkage = linkage_named(SMALL)
    setup = setup_of_scene(DEFAULT, linkage)
    scenes = sampled_setups(setup, [0.1, 0.0], spread, 2000, seed=3)
    springs = np.array([stiffnesses_of(scene) for scene in scenes])
    assert np.log(springs[:, 0]).std() == pytest.approx(0.05, rel=0.1)
    assert not springs[:, 1].any()
    assert np.log([scene.damping_time for scene in scenes]).std() == pytest.approx(0.1, rel=0.1)
    assert np.log([scene.density for scene in scenes]).std() == pytest.approx(0.02, rel=0.1)
    starts = DEFAULT.start - np.array([scene.start for scene in scenes])
    assert starts.min() >= 0.0
    assert math.sqrt((starts**2).mean()) == pytest.approx(0.002, rel=0.1)
    assert sampled_setups(setup, [0.1, 0.0], spread, 20, seed=3) == scenes[:20]
    still = sampled_setups(setup, [0.1] * linkage.n_hinges, Spread(0.0, 0.0, 0.0, 0.0), 2, seed=0)
    assert still == [with_stiffnesses(setup, [0.1] * linkage.n_hinges)] * 2


def test_samples_are_counted_by_what_became_of_them():
    chance = robustness_of_checks([GOOD, HIT, replace(GOOD, clear=None), replace(GOOD, outcome="moving")])
    assert (chance.samples, chance.collisions, chance.failures) == (4, 2, 3)
    assert chance.probability == 0.5
    assert chance.interval[0] < 0.5 < chance.interval[1]
    assert chance.failure_interval[1] > chance.interval[1]


class Sure:
    """An evaluator of which the first spring says after how many samples a set fails."""

    setup = setup_of_scene(DEFAULT, linkage_named(SMALL))

    def __init__(self):
        self.asked = 0

    def of_setups(self, setups):
        self.asked += len(setups)
        chance = [stiffnesses_of(setup)[0] for setup in setups]
        return [HIT if k % 10 < 10 * p else GOOD for k, p in enumerate(chance)]


def test_few_samples_tell_which_sets_get_more():
    evaluator, sets = Sure(), [[0.9], [0.5], [0.1], [0.7]]
    still = Spread(0.0, 0.0, 0.0, 0.0)
    chances = most_robust(evaluator, sets, still, ((4, 10), (2, 20)), seed=0)
    assert [(k, chance.failures) for k, chance in chances] == [(2, 2), (1, 10)]
    assert evaluator.asked == 4 * 10 + 2 * 20


@pytest.mark.parametrize("name", ["thesis-4x4", "square:01222300:3", SMALL])
def test_tied_hinges_are_mirror_images_and_all_there(name):
    linkage = linkage_named(name)
    tied = tied_hinges(linkage, setup_of_scene(DEFAULT, linkage).held)
    assert sorted(itertools.chain(*tied)) == list(range(linkage.n_hinges))
    compiled = compile_scene(linkage, DEFAULT)
    for hinges in tied:
        assert len({compiled.joint_of[hinge] for hinge in hinges}) == 1 or compiled.factor == 1.0


def test_thesis_hinges_are_tied_as_in_its_figure():
    linkage = linkage_named("thesis-4x4")
    tied = tied_hinges(linkage, setup_of_scene(DEFAULT, linkage).held)
    assert tied == ((0, 11), (1, 10), (2, 9), (3, 8), (4, 7), (5,), (6,))


def test_stiffnesses_are_read_from_laws():
    linkage = linkage_named(SMALL)
    scene = replace(
        DEFAULT, springs=((labels_of(linkage).hinges[1], "linear:0.2"), (labels_of(linkage).hinges[2], "2*linear:0.05"))
    )
    assert stiffnesses_of(setup_of_scene(scene, linkage))[:4] == pytest.approx([0.1, 0.2, 0.1, 0.1])
    values = [0.01 * k for k in range(linkage.n_hinges)]
    assert stiffnesses_of(with_stiffnesses(setup_of_scene(DEFAULT, linkage), values)) == pytest.approx(values)
    for bad in ("linear:0.1+0.02", "quadratic:0.1,0.1", "tape:0.2@0.05,0.03@0.01"):
        with pytest.raises(HcsearchError, match="linear, without a preload"):
            stiffnesses_of(setup_of_scene(replace(DEFAULT, spring=bad), linkage))
    with pytest.raises(HcsearchError, match="there is no hinge 99"):
        setup_of_scene(replace(DEFAULT, springs=(("99", "linear:0.1"),)), linkage)


def test_an_evaluation_is_the_check_of_its_scene():
    linkage = linkage_named("square:01222300:3")
    evaluator = Evaluator(linkage, DEFAULT, "constrained")
    rng = np.random.default_rng(0)
    tied = tied_hinges(linkage, setup_of_scene(DEFAULT, linkage).held)
    sets = []
    for _ in range(3):
        one = np.empty(linkage.n_hinges)
        for hinges in tied:
            one[list(hinges)] = rng.uniform(0.01, 0.2)
        sets.append(one)
    scene = setup_of_scene(DEFAULT, linkage)  # the scene gives the time, whatever springs are tried
    scenes = [compile_scene(linkage, with_stiffnesses(scene, one), keep=frozenset({"stops"})) for one in sets]
    rules = {"tolerance": TUNING_STEP_TOLERANCES["constrained"], "past_collisions": False}
    naive = [
        check_deployments([one], screens=[checked_panels_of(one, TUNING_MARGIN_SHARE * scene.margin)], **rules)[0]
        for one in scenes
    ]
    assert evaluator.of_springs(sets) == naive
    assert (evaluator.evaluation_count, evaluator.recalled) == (3, 0)
    assert evaluator.of_springs(sets) == naive
    assert (evaluator.evaluation_count, evaluator.recalled) == (3, 0)  # each once
    assert evaluator.of_setups([with_stiffnesses(scene, sets[0])]) == naive[:1]


def test_compliant_scenes_are_searched_with_soft_stops():
    scene = Evaluator(linkage_named(SMALL), DEFAULT, "compliant").setup
    plain = setup_of_scene(DEFAULT, linkage_named(SMALL))
    assert scene == replace(plain, **SOFTENED_SETUP_VALUES)
    assert Evaluator(linkage_named(SMALL), DEFAULT, "constrained").setup == plain


def test_what_is_stored_is_not_computed_again(tmp_path, monkeypatch):
    linkage, scene = linkage_named(SMALL), replace(DEFAULT, seconds=0.05)
    sets = [[0.1] * linkage.n_hinges, [0.05] * linkage.n_hinges]
    with open_database(str(tmp_path / "a.sqlite"), create=True) as database:
        checks = Evaluator(linkage, scene, "constrained", DatabaseMemory(database, "small")).of_springs(sets)
        assert len(select(database, view="evaluations").rows) == 2
        monkeypatch.setattr("hcsearch.springs.tuning.evaluation.check_deployments", None)
        again = Evaluator(linkage, scene, "constrained", DatabaseMemory(database, "small"))
        assert again.of_springs(sets[::-1]) == checks[::-1]
        assert again.recalled == 2
        for changed in (replace(scene, seconds=0.04), replace(scene, gravity=(0.0, 0.0, 1.0))):
            with pytest.raises(TypeError, match="not callable"):
                Evaluator(linkage, changed, "constrained", DatabaseMemory(database, "small")).of_springs(sets)
        with pytest.raises(TypeError, match="not callable"):
            Evaluator(linkage, scene, "constrained", DatabaseMemory(database, "other")).of_springs(sets)


@given(checks)
def test_checks_come_back_as_they_were_stored(one):
    from hcsearch.springs.tuning.evaluation import EvaluationKey, check_of_row

    with_time = replace(one, collision=(0.1, (2, 5)) if one.clear is False else None)
    row = DatabaseMemory.row("subject", EvaluationKey("setting", "0.1"), with_time)
    assert check_of_row(row) == with_time


def test_numbers_that_overflowed_are_stored_as_nothing():
    from hcsearch.springs.tuning.evaluation import EvaluationKey, check_of_row

    one = replace(HIT, outcome="diverged", drift=math.inf, speed=math.nan)
    row = DatabaseMemory.row("subject", EvaluationKey("setting", "0.1"), one)
    assert row["drift"] is row["speed"] is None
    assert math.isnan(check_of_row(row).drift)


@pytest.mark.parametrize("name", sorted(SCENES))
def test_files_read_back_to_the_same_scene(tmp_path, name):
    springs = tuple((str(hinge), f"linear:{stiffness}") for hinge, stiffness in enumerate((0.1, 0.0, 0.0123)))
    scene = replace(scene_named(name), restitution=0.25, springs=springs)
    scene = replace(scene, panel=(0.05, 0.05, 0.006), flat_pairs="merged")
    facts = {"design": "hex:0234550132:4"}
    path = tmp_path / "found.toml"
    path.write_text(scene_file_text(facts, "compliant", scene))
    content = read_scene_file(str(path))
    assert scene_in(content) == scene
    assert content.pop("scene")["restitution"] == 0.25
    kept = {"panel_mm": "50x50x6", "flat_pairs": "merged", "springs": dict(springs), "formulation": "compliant"}
    held = {"held": "free"} if name == "satellite" else {}
    assert content == facts | kept | held | ({} if name == "default" else {"name": name})
    path.write_text(scene_file_text({"assembly": "unit-i", "parameters": {"alpha": 65.0}}, "constrained", Scene()))
    assert read_scene_file(str(path)) == {
        "assembly": "unit-i",
        "formulation": "constrained",
        "parameters": {"alpha": 65.0},
    }


def test_a_file_with_an_unknown_formulation_is_refused(tmp_path):
    path = tmp_path / "bad.toml"
    path.write_text('design = "hex:0234550132:4"\nformulation = "exact"\n')
    with pytest.raises(HcsearchError, match="write one of constrained, compliant"):
        read_scene_file(str(path))


def test_with_springs_of_one_joint_for_two_hinges_is_that_of_both():
    linkage = linkage_named("thesis-4x4")
    compiled = compile_scene(linkage, DEFAULT, keep=frozenset({"stops"}))
    sprung = with_springs(compiled, np.full(compiled.system.n_joints, 0.05))
    assert stiffnesses_of(sprung.setup) == pytest.approx(np.full(12, 0.05))
