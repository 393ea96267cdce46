"""The stage `deployment`: verdicts on batches of foldings, and the law of twisted ones."""

import json
from dataclasses import replace

import numpy as np
import pytest

from hcsearch.circuit import Circuit
from hcsearch.deployment.checking import check
from hcsearch.deployment.compiling import compile_scene
from hcsearch.deployment.deploying import deploy
from hcsearch.deployment.springs import SOFTEST, STIFFEST, with_springs
from hcsearch.deployment.subjects import folding_linkage
from hcsearch.deployment.verdicts import (
    GRADES,
    OUTER,
    PATIENT,
    SOFT,
    SPREAD,
    STIFF,
    springs_of,
    status_of,
    verdicts,
)
from hcsearch.enumeration import PolygonSearch
from hcsearch.folding import Folding, folding_of
from hcsearch.grid import GRIDS
from hcsearch.pipeline.designs import BEST_FIRST, design_rows, run_unit
from hcsearch.pipeline.stages import stages_until
from hcsearch.scenes import SCENES

DEFAULT = SCENES["default"]
STOPS = frozenset({"stops"})


def unit_of(grid, n, until="mobility"):
    search = PolygonSearch(GRIDS[grid], n)
    (prefix,) = search.prefixes
    return search, run_unit(search, prefix, stages_until(until), "all")


@pytest.fixture(scope="module")
def tens():
    _, unit = unit_of("hex", 10)
    return unit, verdicts(unit.circuits, unit.foldings, unit.twists, unit.mobility, threads=2)


def folding_at(unit, i):
    word = tuple(unit.circuits.words[unit.foldings.row[i]].tolist())
    return Folding(Circuit(GRIDS[unit.circuits.grid], word), int(unit.foldings.crease[i]))


@pytest.mark.parametrize(("grid", "n", "twisted"), [("hex", 12, 251), ("square", 14, 66)])
def test_no_twisted_folding_deploys(grid, n, twisted):
    _, unit = unit_of(grid, n, "twist")
    found = np.flatnonzero(unit.twists != 0).tolist()
    assert len(found) == twisted
    scenes = [compile_scene(folding_linkage(folding_at(unit, i)), DEFAULT) for i in found]
    rows = check(scenes, tolerance=1e-5, threads=2)
    assert not [folding_at(unit, i).notation for i, row in zip(found, rows, strict=True) if row.deploys]
    # the check did follow them: most move, and what comes flat collides on the way
    assert sum(row.evaluations > 100 for row in rows) > 0.3 * twisted
    assert all(row.clear is False for row in rows if row.outcome == "flat")


def test_verdicts_of_ten_hexagons(tens):
    unit, found = tens
    words = [word for word in found.status if word is not None]
    assert [word is None for word in found.status] == (unit.twists != 0).tolist()
    assert set(words) <= set(BEST_FIRST)
    assert words.count("locked") <= int(unit.mobility.locked.sum())
    deploys = np.array([word == "deploys" for word in found.status])
    assert 6 <= deploys.sum() <= 25
    assert (np.isfinite(found.time) == deploys).all()
    assert (np.isfinite(found.clearance) == deploys).all()
    assert (found.time[deploys] > 0.05).all()
    assert (found.time[deploys] <= PATIENT).all()


def test_each_trial_tells_what_it_was(tens):
    unit, found = tens
    first = {trial.folding: trial for trial in found.trials if trial.scene == "default"}
    untwisted = np.flatnonzero((unit.twists == 0) & ~unit.mobility.locked)
    assert sorted(first) == untwisted.tolist()
    for trial in found.trials:
        assert trial.status in {"deploys", "collides", "undecided"}
        assert (trial.first_contact is not None) == (trial.status == "collides")
        if trial.status == "deploys":
            assert found.status[trial.folding] == "deploys"
            assert found.time[trial.folding] == trial.deploy_time
        else:
            assert trial.scene == "default"
        values = json.loads(trial.values)
        assert values["panel_mm"] == "50x50x6"
        assert (values["flat_pairs"] == "hinged") == trial.scene.startswith("hinged")


def test_what_deploys_in_a_trial_does_so_when_it_is_simulated_alone(tens):
    unit, found = tens
    chosen = [trial for trial in found.trials if trial.status == "deploys"]
    graded_ones = [trial for trial in chosen if "first" in trial.scene]
    assert graded_ones
    for trial in (chosen[0], graded_ones[0], graded_ones[-1]):
        values = json.loads(trial.values)
        linkage = folding_linkage(
            folding_at(unit, trial.folding), hinged=values["flat_pairs"] == "hinged", merged=values["merge"]
        )
        springs = tuple((int(hinge), law) for hinge, law in values["springs"].items())
        scene = replace(DEFAULT, springs=springs, seconds=values["seconds"])
        alone = deploy(linkage, scene, keep=STOPS)
        assert (alone.outcome, alone.clearance.kind) == ("flat", "clear")
        assert alone.flat_time == pytest.approx(trial.deploy_time, rel=1e-3)


def test_threads_and_how_many_are_held_in_memory_change_nothing(tens, monkeypatch):
    unit, found = tens
    monkeypatch.setattr("hcsearch.deployment.verdicts.TOGETHER", 7)
    again = verdicts(unit.circuits, unit.foldings, unit.twists, unit.mobility)
    assert again.status == found.status
    assert again.trials == found.trials


def test_a_design_has_the_best_verdict_of_its_foldings():
    search, unit = unit_of("hex", 8, "deployment")
    rows = design_rows(search, unit)
    assert rows.folding_status == unit.deployment.status
    for row, word in enumerate(rows.status):
        own = [rows.folding_status[i] for i in np.flatnonzero(rows.folding_row == row)]
        told = [other for other in own if other is not None]
        assert word == (min(told, key=BEST_FIRST.index) if told else None)


@pytest.mark.parametrize("grade", [*GRADES, OUTER])
def test_graded_springs_run_between_both_bounds(grade):
    folding = folding_of(Circuit.from_notation("hex:0234435011").canonical(), 1)
    compiled = compile_scene(folding_linkage(folding), DEFAULT, keep=STOPS)
    found = springs_of(folding, compiled, grade)
    assert found.shape == (compiled.system.n_joints,)
    assert found.min() >= SOFT * (1 - 1e-12)
    assert found.max() <= STIFF * (1 + 1e-12)
    assert found.max() > 2.0 * found.min()


def test_spread_springs_differ_and_stay_within_the_bounds():
    folding = folding_of(Circuit.from_notation("hex:0234435011").canonical(), 1)
    compiled = compile_scene(folding_linkage(folding, hinged=True), DEFAULT, keep=STOPS)
    found = np.array([springs_of(folding, compiled, name) for name in SPREAD])
    assert found.shape == (len(SPREAD), compiled.system.n_joints)
    assert found.min() >= SOFTEST
    assert found.max() <= STIFFEST
    # eight points of a Sobol sequence lie one in each eighth of every coordinate
    eighths = np.floor(8 * np.log(found / SOFTEST) / np.log(STIFFEST / SOFTEST))
    assert (np.sort(eighths, axis=0) == np.arange(8)[:, None]).all()


def test_stops_that_seem_to_pull_in_a_singular_state_do_not_halt_the_motion():
    folding = folding_of(Circuit.from_notation("hex:023234340000").canonical(), 3)
    compiled = compile_scene(folding_linkage(folding, hinged=True), DEFAULT, keep=STOPS)
    scenes = [with_springs(compiled, springs_of(folding, compiled, name)) for name in SPREAD]
    for found in check(scenes, tolerance=1e-5):
        assert found.outcome != "out of steps"
        assert found.evaluations < 20_000


def test_springs_set_later_are_those_of_a_scene_compiled_with_them():
    folding = folding_of(Circuit.from_notation("hex:0234435011").canonical(), 1)
    linkage = folding_linkage(folding)
    compiled = compile_scene(linkage, DEFAULT, keep=STOPS)
    changed = with_springs(compiled, np.geomspace(0.01, 0.2, compiled.system.n_joints))
    anew = compile_scene(linkage, changed.scene, keep=STOPS)
    for one, two in zip(changed.system.drives, anew.system.drives, strict=True):
        assert one.law == two.law
        assert one.damping == pytest.approx(two.damping, rel=1e-12)
    (one,), (two,) = check([changed]), check([anew])
    assert (one.outcome, one.clear) == (two.outcome, two.clear)
    assert one.end_time == pytest.approx(two.end_time, rel=1e-9)


def test_a_verdict_has_a_reason():
    linkage = folding_linkage(folding_of(Circuit.from_notation("hex:02234400").canonical(), 1))
    (found,) = check([compile_scene(linkage, DEFAULT)])
    assert status_of(found) == "collides"
    assert found.reason == f"panels 3 and 5 collide at {found.collision[0]:.4g} s"
    still = replace(found, clear=True, collision=None, outcome="at rest", end_time=0.25)
    assert (status_of(still), still.reason) == ("undecided", "at rest at 0.25 s, clear until then")
    assert status_of(replace(still, outcome="flat")) == "deploys"
