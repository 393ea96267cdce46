"""Dampers in a tuning: more damping of all hinges first, dampers as variables, and dampers of a catalogue."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from hcsearch.basics.errors import HcsearchError
from hcsearch.cli import hcsearch
from hcsearch.scenes import SCENES
from hcsearch.scenes.setup import setup_of_scene, with_stiffnesses
from hcsearch.springs.deployment.compiled_scene import compile_scene
from hcsearch.springs.deployment.quick_check import check_deployments, checked_panels_of
from hcsearch.springs.deployment.spring_sets import stiffnesses_of, tied_hinges
from hcsearch.springs.tuning.damping_ladder import DAMPING_FACTORS, damping_factors
from hcsearch.springs.tuning.evaluation import (
    TUNING_MARGIN_SHARE,
    TUNING_STEP_TOLERANCES,
    Evaluator,
    damped_more,
    tied_parts,
    with_parts,
)
from hcsearch.springs.tuning.spring_search import stiffnesses_of_groups
from hcsearch.springs.tuning.spring_tuning import tune_springs
from hcsearch.springs.tuning.tuning_options import TuningOptions, damper_bounds
from tests.linkages import linkage_named

DEFAULT = SCENES["default"]
SMALL = "hex:023350:1"
COLLIDING = "square:012233230011:4"
"""A folding that collides by equal springs, and opens by equal springs with 1.25 times the damping."""


TABLES = st.tuples(
    st.lists(st.sampled_from([0.01, 0.1, 0.2]), min_size=4, max_size=4),
    st.lists(st.sampled_from([0.002, 0.02, math.nan]), min_size=4, max_size=4),
)


@given(TABLES, st.none() | st.just(0.007))
def test_a_table_of_parts_is_springs_and_dampers(table, damping):
    stiffnesses, dampings = table
    linkage = linkage_named("square:0123:0")
    n = linkage.n_hinges
    setup = setup_of_scene(replace(DEFAULT, damping=damping), linkage)
    with_both = with_parts(setup, stiffnesses[:n] + dampings[:n])
    assert stiffnesses_of(with_both).tolist() == stiffnesses[:n]
    for hinge in range(n):
        plain = DEFAULT.damping_time * stiffnesses[hinge] if damping is None else damping
        chosen = plain if math.isnan(dampings[hinge]) else dampings[hinge]
        assert with_both.dampings[hinge] == pytest.approx(chosen, rel=1e-14)
    assert with_parts(setup, stiffnesses[:n]) == with_stiffnesses(setup, stiffnesses[:n])


def test_dampers_are_checked_as_their_scene_is():
    linkage = linkage_named("square:01222300:3")
    evaluator = Evaluator(linkage, DEFAULT, "constrained")
    tied = tied_parts(tied_hinges(linkage, linkage.base))
    rng = np.random.default_rng(1)
    groups = len(tied) // 2
    values = [*rng.uniform(0.01, 0.2, groups), *rng.uniform(0.002, 0.02, groups - 1), math.nan]
    parts = stiffnesses_of_groups(values, tied)
    compiled = compile_scene(linkage, with_parts(setup_of_scene(DEFAULT, linkage), parts), keep=frozenset({"stops"}))
    screens = [checked_panels_of(compiled, TUNING_MARGIN_SHARE * compiled.margin)]
    rules = {"tolerance": TUNING_STEP_TOLERANCES["constrained"], "past_collisions": False}
    (naive,) = check_deployments([compiled], screens=screens, **rules)
    assert evaluator.of_springs([parts]) == [naive] != evaluator.of_springs([parts[: linkage.n_hinges]])
    assert evaluator.evaluation_count == 2


def test_more_damping_takes_the_time_that_it_needs_unless_that_is_given():
    linkage = linkage_named(SMALL)
    setup = setup_of_scene(DEFAULT, linkage)
    more = damped_more(setup, 2.5, linkage)
    assert more.dampings == pytest.approx([2.5 * damping for damping in setup.dampings])
    assert (setup.seconds, more.seconds) == (1.0, 2.5)
    given_time = setup_of_scene(replace(DEFAULT, seconds=0.3), linkage)
    assert damped_more(given_time, 2.5, linkage).seconds == 0.3


@pytest.mark.parametrize(
    ("options", "factors"),
    [
        (TuningOptions(), DAMPING_FACTORS),
        (TuningOptions(most_damping=1.0), ()),
        (TuningOptions(most_damping=2.2), (1.25, 1.6, 2.0)),
        (TuningOptions(damper_range=(0.001, 0.0069)), (1.25, 1.6)),
    ],
)
def test_multiples_of_the_damping_keep_to_what_is_allowed(options, factors):
    setup = setup_of_scene(DEFAULT, linkage_named(SMALL))
    assert damping_factors(setup, options) == factors
    assert damping_factors(setup_of_scene(replace(DEFAULT, damping=0.0), linkage_named(SMALL)), options) == ()


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"most_damping": 0.5}, "most_damping cannot be 0.5: give 1 to 10"),
        ({"most_damping": 11.0}, "most_damping cannot be 11: give 1 to 10"),
        ({"damper_catalogue": (0.01,)}, "dampers of a catalogue go with springs of one"),
        ({"catalogue": (0.1,), "damper_catalogue": (0.01, 0.0)}, "a catalogue has dampers above 0"),
        ({"catalogue": (0.1,), "damper_range": (0.001, 0.02)}, "springs of a catalogue go with dampers of one"),
    ],
)
def test_options_of_dampers_that_do_not_fit_are_refused(values, message):
    with pytest.raises(HcsearchError, match=message):
        TuningOptions(**values)


@pytest.mark.parametrize("values", [(0.02, 0.01), (0.0, 0.01), (0.01,), (0.01, math.inf), (math.nan, 0.1)])
def test_what_is_no_range_of_dampers_is_refused(values):
    with pytest.raises(HcsearchError, match="give the least and the greatest"):
        damper_bounds(values)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("HCSEARCH_DB", raising=False)
    return tmp_path


def run(*words):
    result = CliRunner().invoke(hcsearch, words, catch_exceptions=False)
    assert result.exit_code == 0
    return result.stdout


def test_equal_springs_with_more_damping_are_tried_first_and_suffice(folder):
    words = ("tune", COLLIDING, "--samples", "4", "--most-damping", "2", "--output", "found.toml")
    printed = json.loads(run(*words, "--json"))
    assert printed["damping_factor"] == 1.25
    assert printed["use"] == (
        "the springs of the scene with 1.25 times its damping: flat, certified clear, in all 4 samples too"
    )
    assert printed["best"] == printed["damped"]
    assert printed["best"]["stiffness_N_m_rad"] == printed["start"]["stiffness_N_m_rad"] == [0.1] * 10
    assert printed["best"]["damping_N_m_s_rad"] == pytest.approx([1.25 * 0.0043] * 10)
    assert not printed["start"]["confirmed"]
    assert printed["evaluations"] <= 17  # no other springs were searched
    assert printed["seconds"] == 1.25
    assert "[hinges]" not in Path("found.toml").read_text()
    replayed = json.loads(run("deploy", "found.toml", "--json"))
    assert replayed["verdict"] == "deploys"
    assert replayed["flat_time_s"] == printed["best"]["flat_time_s"]
    lines = run(*words).splitlines()
    (told,) = [line for line in lines if line.startswith("damped ")]
    assert told.split(maxsplit=1)[1].startswith("1.25 x damping: flat after")
    heads = [line.split()[2:] for line in lines if line.startswith("hinge ")]
    assert heads == [["start", "damped", "N", "m/rad"], ["start", "damped", "N", "m", "s/rad"]]


def test_without_more_damping_other_springs_are_searched_as_before():
    options = TuningOptions((), 24, 0, most_damping=1.0)
    plain = tune_springs(linkage_named("hex:0123434501:1"), DEFAULT, options, "constrained")
    with_more = tune_springs(
        linkage_named("hex:0123434501:1"), DEFAULT, replace(options, most_damping=1.5), "constrained"
    )
    assert plain.damped is None
    assert with_more.damped.factor == 1.25
    assert not with_more.damped.springs.confirmed
    assert plain.best.parts == with_more.best.parts
    assert plain.evaluations == with_more.evaluations


def test_dampers_are_searched_together_with_springs(folder):
    range_of = ("--damper-range", "0.002,0.02", "--most-damping", "1", "--evaluations", "30", "--samples", "0")
    printed = json.loads(run("tune", COLLIDING, *range_of, "--output", "found.toml", "--json"))
    best = printed["best"]
    assert best["confirmed"]
    assert min(best["damping_N_m_s_rad"]) >= 0.002
    assert max(best["damping_N_m_s_rad"]) <= 0.02
    assert len(set(best["damping_N_m_s_rad"])) == len(printed["tied_hinges"])
    number = {hinge: k for k, hinge in enumerate(printed["hinges"])}
    for hinges in printed["tied_hinges"]:
        assert len({best["damping_N_m_s_rad"][number[hinge]] for hinge in hinges}) == 1
    assert printed["evaluations"] <= 30
    assert printed["use"].startswith("tuned springs and dampers: flat, certified clear")
    assert run("tune", COLLIDING, *range_of).count("N m s/rad") == 1
    replayed = json.loads(run("deploy", "found.toml", "--json"))
    assert replayed["verdict"] == "deploys"
    assert replayed["flat_time_s"] == best["flat_time_s"]


def test_springs_and_dampers_that_can_be_bought_are_chosen_together(folder):
    words = ("--catalogue", "0.07,0.10", "--damper-catalogue", "0.02,0.01", "--most-damping", "1")
    words += ("--evaluations", "40", "--samples", "0", "--output", "found.toml")
    printed = json.loads(run("tune", COLLIDING, *words, "--json"))
    rounded, dampers = printed["rounded"], printed["buy"]["dampers_N_m_s_rad"]
    assert rounded["confirmed"]
    assert set(np.round(rounded["stiffness_N_m_rad"], 9)) <= {0.0, 0.07, 0.1, 0.14, 0.17, 0.2}
    assert set(dampers) <= {None, 0.01, 0.02}
    for stiffness, damping, damper in zip(
        rounded["stiffness_N_m_rad"], rounded["damping_N_m_s_rad"], dampers, strict=True
    ):
        assert damping == pytest.approx(0.043 * stiffness if damper is None else damper)
    assert any(damper is not None for damper in dampers)
    assert "; dampers: " in Path("found.toml").read_text().splitlines()[0]
    assert json.loads(run("deploy", "found.toml", "--json"))["flat_time_s"] == rounded["flat_time_s"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--damper-range", "0.02"), "give the least and the greatest, above 0"),
        (("--damper-range", "soft,stiff"), "'soft,stiff' is no range of dampers: write N m s/rad, such as 0.001,0.02"),
        (("--damper-catalogue", "0.01"), "dampers of a catalogue go with springs of one: add --catalogue 0.07,0.10"),
        (("--catalogue", "0.1", "--damper-catalogue", "oil"), "'oil' is no catalogue: write dampings in N m s/rad"),
        (("--rule", "ecss", "--damper-range", "0.01,0.02"), "leave out --catalogue, --spread, --formulation and damp"),
    ],
)
def test_wrong_dampers_say_what_to_do(folder, words, message):
    result = CliRunner().invoke(hcsearch, ["tune", SMALL, *words])
    assert isinstance(result.exception, HcsearchError), result.exception
    assert message in str(result.exception)


@pytest.mark.slow
@pytest.mark.parametrize(("scene", "factor"), [("thesis", 1.6), ("default", 2.5)])
def test_equal_springs_with_more_damping_open_the_array_of_the_thesis(scene, factor):
    linkage = linkage_named("thesis-4x4")
    options = TuningOptions(evaluations=16, samples=0)
    damped = tune_springs(linkage, SCENES[scene], options, "compliant").damped
    assert damped.factor == factor
    assert damped.springs.confirmed
    assert damped.springs.agreement.verdict == "deploys"
