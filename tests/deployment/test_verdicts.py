"""The stage `deployment`: verdicts on batches of foldings, and the law of twisted ones."""

import tomllib
from dataclasses import replace

import numpy as np
import pytest
from hcsearch.pipeline.deployments import BEST_FIRST, PIECE_SECONDS, Deploy, pieces, seconds_of, unfinished

from hcsearch.circuit import Circuit
from hcsearch.deployment.agreement import agreed_checks, confirmed
from hcsearch.deployment.checking import check
from hcsearch.deployment.compiling import compile_scene
from hcsearch.deployment.deploying import deploy
from hcsearch.deployment.looks import GRADED, GRADES, OUTER, PATIENT, SPREAD, springs_of
from hcsearch.deployment.scales import SOFTEST, STIFFEST
from hcsearch.deployment.scene_files import read_text, scene_in
from hcsearch.deployment.springs import with_springs
from hcsearch.deployment.verdicts import verdicts
from hcsearch.enumeration import PolygonSearch
from hcsearch.flat_pairs import folding_linkage
from hcsearch.folding import Folding, folding_of
from hcsearch.grid import GRIDS
from hcsearch.pipeline.designs import candidates_of, design_rows, run_unit
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
    return unit, verdicts(unit.circuits, unit.foldings, unit.twists, unit.mobility.locked, DEFAULT, threads=2)


def folding_at(unit, i):
    word = tuple(unit.circuits.words[unit.foldings.row[i]].tolist())
    return Folding(Circuit(GRIDS[unit.circuits.grid], word), int(unit.foldings.crease[i]))


@pytest.mark.parametrize(
    ("grid", "n", "twisted"), [pytest.param("hex", 12, 251, marks=pytest.mark.long), ("square", 14, 66)]
)
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
            assert trial.scene == "default" or trial.reason.startswith("branch-singular: ")
            assert trial.deploy_time is None
        values = tomllib.loads(trial.values)
        assert values["panel_mm"] == "50x50x6"
        assert values["design"] == folding_at(unit, trial.folding).notation
        assert values.get("name", "default") == trial.scene
        assert (values["flat_pairs"] == "hinged") == trial.scene.startswith("hinged")


def test_what_deploys_in_a_trial_does_so_when_it_is_simulated_alone(tens):
    unit, found = tens
    chosen = [trial for trial in found.trials if trial.status == "deploys"]
    graded_ones = [trial for trial in chosen if "first" in trial.scene]
    assert graded_ones
    for trial in (chosen[0], graded_ones[0], graded_ones[-1]):
        scene = scene_in(read_text(trial.values, "the trial"))
        linkage = folding_linkage(
            folding_at(unit, trial.folding), hinged=scene.flat_pairs == "hinged", merged=scene.merge
        )
        alone = deploy(linkage, scene, keep=STOPS)
        assert (alone.outcome, alone.clearance.kind, alone.verdict) == ("flat", "clear", "deploys")
        assert confirmed(alone).flat_time == trial.deploy_time


def test_a_motion_along_singular_states_is_no_deployment(tens):
    """One that comes flat at 1e-6 and diverges at 1e-8 is undecided; other springs deploy the folding."""
    unit, found = tens
    own = [trial for trial in found.trials if folding_at(unit, trial.folding).notation == "hex:0223335500:0"]
    assert [trial.status for trial in own] == ["undecided", "deploys"]
    assert own[0].reason.startswith("branch-singular: flat ")
    assert (own[0].clearance, own[0].deploy_time) == (None, None)
    assert found.time[own[1].folding] == own[1].deploy_time == float(f"{own[1].deploy_time:.3e}")


def test_what_deploys_at_one_tolerance_only_is_undecided(tens, monkeypatch):
    unit, found = tens
    one = next(trial.folding for trial in found.trials if trial.status == "deploys" and trial.scene != "default")
    alone = np.arange(len(unit.twists)) == one
    twists = np.where(alone, 0, 1).astype(unit.twists.dtype)

    def jams(checks, tolerances):
        return agreed_checks([*checks[:-1], replace(checks[-1], outcome="jammed")], tolerances)

    monkeypatch.setattr("hcsearch.deployment.verdicts.agreed_checks", jams)
    again = verdicts(unit.circuits, unit.foldings, twists, unit.mobility.locked, DEFAULT)
    assert again.status[one] == "undecided"
    assert np.isnan(again.time).all()
    first, last = again.trials
    assert (first.scene, last.status) == ("default", "undecided")
    assert last.reason.startswith("branch-singular: flat at tolerance 1e-6, flat at 1e-7, jammed at 1e-8; ")


def test_threads_and_how_many_are_held_in_memory_change_nothing(tens, monkeypatch):
    unit, found = tens
    monkeypatch.setattr("hcsearch.deployment.verdicts.TOGETHER", 7)
    again = verdicts(unit.circuits, unit.foldings, unit.twists, unit.mobility.locked, DEFAULT)
    assert again.status == found.status
    assert again.trials == found.trials


def test_a_design_has_the_best_verdict_of_its_foldings():
    search, unit = unit_of("hex", 8)
    rows = design_rows(search, unit)
    for row, word in enumerate(rows.status):
        own = [rows.folding_status[i] for i in np.flatnonzero(rows.folding_row == row)]
        known = [other for other in own if other is not None]
        assert word == (min(known, key=BEST_FIRST.index) if known else None)
    own = candidates_of(search, unit)
    (piece,) = pieces("unit", own)
    found = Deploy(DEFAULT)(piece)
    assert found.verdicts.deployment.status == list(map(str, found.verdicts.deployment.status))
    for row, (word, crease) in enumerate(zip(found.verdicts.status, found.verdicts.best_crease, strict=True)):
        members = np.flatnonzero(own.foldings.row == row).tolist()
        ranked = [
            (BEST_FIRST.index(found.verdicts.deployment.status[i]), own.dof[i], own.foldings.crease[i]) for i in members
        ]
        assert (BEST_FIRST.index(word), crease) == (min(ranked)[0], min(ranked)[2])
    assert found.result.passed == found.verdicts.status.count("deploys")


def test_pieces_are_small_whole_and_the_same_each_time():
    search, unit = unit_of("hex", 10)
    own = candidates_of(search, unit)
    found = list(pieces("unit", own))
    assert [piece.key for piece in found] == [f"unit#{k}/{len(found)}" for k in range(len(found))]
    assert len(found) > 1
    assert sum(len(piece.candidates.foldings) for piece in found) == len(own.foldings)
    words = np.concatenate([piece.candidates.circuits.words for piece in found])
    assert (words == own.circuits.words).all()
    for piece in found:
        small = piece.candidates
        assert seconds_of(len(small.foldings), 10) <= PIECE_SECONDS or len(small.circuits) == 1
        assert set(small.foldings.row.tolist()) == set(range(len(small.circuits)))
    assert unfinished(["unit", "other"], [piece.key for piece in found]) == ["other"]
    assert unfinished(["unit"], [piece.key for piece in found[1:]]) == ["unit"]
    (empty,) = pieces("none", own.take(0, 0))
    assert (empty.key, len(empty.candidates.circuits)) == ("none#0/1", 0)
    assert Deploy(DEFAULT)(empty).result.passed == 0


@pytest.mark.parametrize("grade", [*GRADES, OUTER])
def test_graded_springs_run_between_both_bounds(grade):
    folding = folding_of(Circuit.from_notation("hex:0234435011").canonical(), 1)
    compiled = compile_scene(folding_linkage(folding), DEFAULT, keep=STOPS)
    found = springs_of(folding, compiled, grade)
    assert found.shape == (compiled.system.n_joints,)
    assert found.min() >= STIFFEST / GRADED * (1 - 1e-12)
    assert found.max() <= STIFFEST * (1 + 1e-12)
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
    assert found.verdict == "collides"
    assert found.reason == f"panels 3 and 5 collide at {found.collision[0]:.4g} s"
    still = replace(found, clear=True, collision=None, outcome="at rest", end_time=0.25)
    assert (still.verdict, still.reason) == ("undecided", "at rest at 0.25 s, clear until then")
    assert replace(still, outcome="flat").verdict == "deploys"
    wild = replace(found, outcome="diverged", end_time=0.25)
    assert (wild.verdict, wild.reason) == ("undecided", "diverged at 0.25 s, so nothing that it shows is certain")
