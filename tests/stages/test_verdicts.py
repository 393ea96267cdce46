"""The stages in a scene: verdicts on batches of foldings, and the law of twisted ones."""

import tomllib
from dataclasses import replace

import numpy as np
import pytest

from hcsearch.basics.vocabulary import STATUSES
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, folding_at
from hcsearch.designs.grid import GRIDS
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.designs.records import (
    NO_NUMBER,
    CircuitBatch,
    DeploymentBatch,
    FoldingBatch,
    MobilityBatch,
    MotionBatch,
    StagedDesigns,
)
from hcsearch.kernels.multibody.endings import MAX_BALANCE_ERROR
from hcsearch.scenes import SCENES
from hcsearch.scenes.looks import (
    GRADED_STIFFNESS_RATIO,
    OUTER_FIRST_SET,
    SPREAD_SPRING_SETS,
    SPRING_SET_GRADES,
    VARIANT_TIME_FACTOR,
)
from hcsearch.scenes.scene_file import read_scene_text, scene_in
from hcsearch.scenes.setup import MAX_SPRING_STIFFNESS, MIN_SPRING_STIFFNESS
from hcsearch.search.enumeration import PolygonSearch
from hcsearch.search.pipeline.judging import (
    PIECE_CORE_SECONDS,
    CandidatePiece,
    Judge,
    candidate_pieces,
    judging_seconds,
    unfinished_shards,
)
from hcsearch.search.pipeline.shards import candidates_of, design_rows, run_shard
from hcsearch.search.stages.motion import motions_of_batch
from hcsearch.search.stages.order import STAGES, stages_until
from hcsearch.shape.labels import labels_of
from hcsearch.springs.deployment.agreement import agreement_of_checks, confirm_deployment
from hcsearch.springs.deployment.compiled_scene import compile_scene
from hcsearch.springs.deployment.deployment_verdicts import deploy_foldings
from hcsearch.springs.deployment.quick_check import check_deployments
from hcsearch.springs.deployment.simulated_deployment import simulate_deployment
from hcsearch.springs.deployment.spring_sets import springs_of, with_springs

DEFAULT = SCENES["default"]
STOPS = frozenset({"stops"})
IN_A_SCENE = tuple(stage for stage in STAGES.values() if stage.depends_on_scene)


def shard_of(grid, n, until="mobility"):
    search = PolygonSearch(GRIDS[grid], n)
    (prefix,) = search.prefixes
    return search, run_shard(search, prefix, stages_until(until), "all")[0]


@pytest.fixture(scope="module")
def tens():
    """The untwisted foldings of ten hexagons, their motions, and their deployments."""
    own = candidates_of(shard_of("hex", 10)[1])
    locks = own.mobility.locked, own.mobility.locked_hinged
    motion = motions_of_batch(own.circuits, own.foldings, locks, DEFAULT, threads=2)
    return own, motion, deploy_foldings(own.circuits, own.foldings, own.mobility.locked, motion.met, DEFAULT)


@pytest.mark.parametrize(("grid", "n", "twisted"), [("hex", 12, 251), ("square", 14, 66)])
def test_no_twisted_folding_deploys(grid, n, twisted):
    _, shard = shard_of(grid, n, "twist")
    numbers = np.flatnonzero(shard.twists != 0).tolist()
    assert len(numbers) == twisted
    scenes = [compile_scene(folding_at(shard.circuits, shard.foldings, i).linkage(), DEFAULT) for i in numbers]
    rows = check_deployments(scenes, tolerance=1e-5, threads=2)
    assert not [
        folding_at(shard.circuits, shard.foldings, i).notation
        for i, row in zip(numbers, rows, strict=True)
        if row.deploys
    ]
    # the check did follow them: most move, and what comes flat collides on the way
    assert sum(row.evaluations > 100 for row in rows) > 0.3 * twisted
    assert all(row.clear is False for row in rows if row.outcome == "flat")


def test_verdicts_of_ten_hexagons(tens):
    own, motion, deployments = tens
    deploys = deployments.deploys
    assert len(deploys) == len(own.foldings) == 40
    assert not deploys[own.mobility.locked_hinged].any()
    assert 6 <= deploys.sum() <= 25
    assert (np.isfinite(deployments.time) == deploys).all()
    assert (np.isfinite(deployments.clearance) == deploys).all()
    assert (deployments.time[deploys] > 0.05).all()
    assert (deployments.time[deploys] <= VARIANT_TIME_FACTOR).all()
    assert motion.met[deploys].all()  # what springs bring flat has a path, which need not be proved
    assert motion.moves[deploys].mean() > 0.5


def test_trials_whose_energy_balance_is_violated_are_no_evidence(tens):
    _, _, deployments = tens
    violated = [trial for trial in deployments.trials if not trial.energy_error <= MAX_BALANCE_ERROR]
    assert violated
    for trial in violated:
        assert trial.status == "undecided"
        assert trial.reason.startswith(("diverged at ", "branch-singular: "))


def test_without_a_path_a_folding_gets_the_first_look_alone(tens):
    own, motion, deployments = tens
    for trial in deployments.trials:
        assert motion.met[trial.folding] or trial.scene == "default"
    none = np.zeros(len(own.foldings), bool)
    brief = deploy_foldings(own.circuits, own.foldings, own.mobility.locked, none, DEFAULT)
    first = tuple(trial for trial in deployments.trials if trial.scene == "default")
    assert brief.trials == first
    assert np.flatnonzero(brief.deploys).tolist() == [trial.folding for trial in first if trial.status == "deploys"]
    assert brief.deploys.sum() < deployments.deploys.sum()


def test_each_trial_tells_what_it_was(tens):
    own, _, deployments = tens
    first = {trial.folding: trial for trial in deployments.trials if trial.scene == "default"}
    assert sorted(first) == np.flatnonzero(~own.mobility.locked).tolist()
    for trial in deployments.trials:
        assert trial.status in {"deploys", "collides", "undecided"}
        assert (trial.first_contact is not None) == (trial.status == "collides")
        if trial.status == "deploys":
            assert deployments.deploys[trial.folding]
            assert deployments.clearance[trial.folding] == trial.clearance
            assert deployments.time[trial.folding] == trial.deploy_time
        else:
            assert trial.scene == "default" or trial.reason.startswith("branch-singular: ")
            assert trial.deploy_time is None
        values = tomllib.loads(trial.values)
        assert values["panel_mm"] == "50x50x6"
        assert values["design"] == folding_at(own.circuits, own.foldings, trial.folding).notation
        assert values.get("name", "default") == trial.scene
        assert (values["flat_pairs"] == "hinged") == trial.scene.startswith("hinged")


def test_what_deploys_in_a_trial_does_so_when_it_is_simulated_alone(tens):
    own, _, deployments = tens
    chosen = [trial for trial in deployments.trials if trial.status == "deploys"]
    graded_ones = [trial for trial in chosen if "first" in trial.scene]
    assert graded_ones
    for trial in (chosen[0], graded_ones[0], graded_ones[-1]):
        scene = scene_in(read_scene_text(trial.values, "the trial"))
        linkage = folding_at(own.circuits, own.foldings, trial.folding).linkage(flat_pairs=scene.flat_pairs[0])
        alone = simulate_deployment(linkage, scene, keep=STOPS)
        assert (alone.outcome, alone.clearance.kind, alone.verdict) == ("flat", "clear", "deploys")
        agreement = confirm_deployment(alone)
        assert agreement.flat_time == trial.deploy_time
        assert agreement.errors.angle == trial.error_angle
        assert trial.method == alone.motion.method
        assert trial.omitted == tuple(omission.name for omission in alone.compiled.omissions)


def test_stored_errors_are_at_least_those_beside_a_method_of_order_eight(tens):
    own, _, deployments = tens
    chosen = [trial for trial in deployments.trials if trial.status == "deploys"]
    smooth = [trial for trial in chosen if trial.error_angle < 1e-3]
    assert len(smooth) > 1
    for trial in smooth:
        scene = scene_in(read_scene_text(trial.values, "the trial"))
        linkage = folding_at(own.circuits, own.foldings, trial.folding).linkage(flat_pairs=scene.flat_pairs[0])
        one = simulate_deployment(linkage, scene, keep=STOPS, certified=False)
        exact = simulate_deployment(
            *(linkage, scene), method="dormand-prince-8", tolerance=1e-13, keep=STOPS, certified=False
        )
        times = np.linspace(0.0, min(one.motion.times[-1], exact.motion.times[-1]), 300)
        error = np.abs(one.angles_at(times) - exact.angles_at(times)).max()
        assert 0.0 < error <= trial.error_angle
        assert abs(trial.deploy_time - exact.flat_time) <= trial.error_time < 1e-2 * trial.deploy_time


def test_errors_are_those_of_what_deploys_alone_and_each_trial_saves_work(tens):
    _, _, deployments = tens
    for trial in deployments.trials:
        assert (trial.error_angle is not None) == (trial.status == "deploys")
        assert trial.method == "dormand-prince"
        assert {"gravity", "base", "pairs"} <= set(trial.omitted)
        assert 0.2 < trial.time_saved < 0.8


def test_a_motion_along_singular_states_is_no_deployment(tens):
    """One whose loops stay open is undecided, in whichever way it goes on; other springs deploy the folding."""
    own, _, deployments = tens
    names = [folding_at(own.circuits, own.foldings, i).notation for i in range(len(own.foldings))]
    one, two = (trial for trial in deployments.trials if names[trial.folding] == "hex:0223335500:0")
    assert [one.status, two.status] == ["undecided", "deploys"]
    assert one.reason.startswith("branch-singular: loops stay open ")
    assert (one.clearance, one.deploy_time) == (None, None)
    assert deployments.time[two.folding] == two.deploy_time == float(f"{two.deploy_time:.3e}")


def test_what_deploys_at_one_tolerance_only_is_undecided(tens, monkeypatch):
    own, _, deployments = tens
    one = next(trial.folding for trial in deployments.trials if trial.status == "deploys" and trial.scene != "default")
    alone = FoldingBatch(own.foldings.row[one : one + 1], own.foldings.crease[one : one + 1])

    def jams(simulations):
        *others, last = simulations
        return agreement_of_checks([*others, last._replace(check=replace(last.check, outcome="jammed"))])

    monkeypatch.setattr("hcsearch.springs.deployment.deployment_verdicts.agreement_of_checks", jams)
    again = deploy_foldings(own.circuits, alone, own.mobility.locked[one : one + 1], np.ones(1, bool), DEFAULT)
    assert again.deploys.tolist() == [False]
    assert np.isnan(again.time).all()
    first, last = again.trials
    assert (first.scene, last.status) == ("default", "undecided")
    assert last.reason.startswith("branch-singular: flat at tolerance 1e-6, flat at 1e-7, jammed at 1e-8; ")


def test_which_foldings_are_tried_together_changes_nothing(tens):
    own, motion, deployments = tens
    parts = []
    for chosen in np.array_split(np.unique(own.foldings.row), 3):  # congruent foldings are of one design
        numbers = np.flatnonzero(np.isin(own.foldings.row, chosen))
        part = FoldingBatch(own.foldings.row[numbers], own.foldings.crease[numbers])
        again = deploy_foldings(own.circuits, part, own.mobility.locked[numbers], motion.met[numbers], DEFAULT)
        assert again.deploys.tolist() == deployments.deploys[numbers].tolist()
        parts += [replace(trial, folding=int(numbers[trial.folding])) for trial in again.trials]
    assert tuple(sorted(parts, key=lambda trial: trial.folding)) == deployments.trials


def test_looks_end_after_so_much_work(tens, monkeypatch):
    own, motion, deployments = tens
    monkeypatch.setattr("hcsearch.springs.deployment.deployment_verdicts.MAX_VARIANT_WORK", 20_000)
    given = own.circuits, own.foldings, own.mobility.locked, motion.met, DEFAULT
    one, two = (deploy_foldings(*given) for _ in range(2))
    assert one.trials == two.trials
    assert not (one.deploys & ~deployments.deploys).any()
    assert 0 < one.deploys.sum() < deployments.deploys.sum()


def test_a_design_has_the_best_verdict_of_its_foldings():
    search, shard = shard_of("hex", 8)
    rows = design_rows(search, shard)
    untwisted = set(rows.foldings["row"][rows.foldings["twist"] == 0].tolist())
    assert {row for row, crease in enumerate(rows.designs["best_crease"]) if crease != NO_NUMBER} == untwisted
    assert len(untwisted) < len(rows)
    for row, word in enumerate(rows.designs["status"]):
        own = [rows.foldings["status"][i] for i in np.flatnonzero(rows.foldings["row"] == row)]
        known = [other for other in own if other is not None]
        assert word == (min(known, key=STATUSES.index) if known else None)
    own = candidates_of(shard)
    (piece,) = candidate_pieces("shard", own)
    verdict = Judge(DEFAULT, IN_A_SCENE)(piece)
    judged = verdict.verdicts
    assert judged.folding_crease.tolist() == own.foldings.crease.tolist()
    assert judged.circuit == [Circuit(GRIDS["hex"], tuple(word)).notation for word in own.circuits.words.tolist()]
    assert_best_first(own, judged)
    for i, word in enumerate(judged.folding_status):
        known = [judged.deployment.deploys[i], judged.motion.moves[i], not own.mobility.locked_hinged[i]]
        assert word == next(name for name, holds in zip(STATUSES, [*known, True], strict=True) if holds)
    planned, simulated, reviewed = verdict.results
    assert (planned.stage, planned.version) == ("motion", STAGES["motion"].stored_version)
    assert (simulated.stage, simulated.version) == ("deployment", STAGES["deployment"].stored_version)
    assert planned.passed == sum(word in ("deploys", "movable") for word in judged.status)
    assert simulated.passed == judged.status.count("deploys")
    assert (reviewed.stage, reviewed.version) == ("flight", STAGES["flight"].stored_version)
    assert (reviewed.passed, reviewed.n_fixed) == (planned.passed, planned.n_fixed)
    assert [one is None for one in judged.flight] == [word == "locked" for word in judged.folding_status]
    for result, words in ((planned, ("deploys", "movable")), (simulated, ("deploys",))):
        assert result.n_fixed == sum(
            count for count, word in zip(own.n_fixed.tolist(), judged.status, strict=True) if word in words
        )


def test_until_motion_nothing_is_simulated():
    own = candidates_of(shard_of("hex", 8)[1])
    (piece,) = candidate_pieces("shard", own)
    whole, brief = Judge(DEFAULT, IN_A_SCENE)(piece), Judge(DEFAULT, IN_A_SCENE[:1])(piece)
    assert brief.verdicts.deployment is None
    assert [result.stage for result in brief.results] == ["motion"]
    assert brief.results[0].passed == whole.results[0].passed
    as_planned = ["movable" if word == "deploys" else word for word in whole.verdicts.folding_status]
    assert brief.verdicts.folding_status == as_planned


def assert_best_first(own, judged):
    """The best folding of each design is that of the best status, then least play, lowest dof, lowest crease."""
    margin = np.nan_to_num(judged.motion.margin, nan=np.inf)
    dof = np.where(own.mobility.dof == NO_NUMBER, np.inf, own.mobility.dof)
    for row, best in enumerate(zip(judged.status, judged.best_crease, strict=True)):
        members = np.flatnonzero(own.foldings.row == row).tolist()
        rank = [(STATUSES.index(judged.folding_status[i]), margin[i], dof[i], own.foldings.crease[i]) for i in members]
        place, *_, crease = min(rank)
        assert best == (STATUSES[place], crease)


# Of foldings of five designs: design, crease, dof, proved locked with rigid and with hinged pairs, needed margin (mm),
# whether springs bring it flat.
FOLDINGS = (
    (0, 5, 4, False, False, 0.02, False),
    (0, 3, 9, False, False, 0.01, False),  # less play
    (0, 0, 1, False, False, 0.05, True),  # deploys
    (1, 4, 3, False, False, 0.02, False),
    (1, 2, 7, False, False, 0.01, False),  # less play, in spite of its dof
    (1, 0, 1, True, False, None, False),
    (2, 6, 5, False, False, 0.01, False),
    (2, 5, 4, False, False, 0.01, False),  # lowest dof and crease
    (2, 3, NO_NUMBER, False, False, 0.01, False),
    (2, 7, 4, False, False, 0.01, False),
    (3, 1, 2, True, True, None, False),
    (3, 2, 6, True, False, None, False),  # locked with rigid pairs alone
    (4, 4, 6, True, True, None, False),
    (4, 6, 3, True, True, None, False),  # lowest dof
)


@pytest.mark.parametrize(
    ("scene", "deploys", "expected"),
    [
        ({}, True, ["deploys 0", "movable 2", "movable 5", "undecided 2", "locked 6"]),
        ({}, False, ["movable 3", "movable 2", "movable 5", "undecided 2", "locked 6"]),
        ({"flat_pairs": "hinged"}, True, ["deploys 0", "movable 2", "movable 5", "undecided 2", "locked 6"]),
        ({"flat_pairs": "rigid"}, True, ["deploys 0", "movable 2", "movable 5", "locked 1", "locked 6"]),
        ({"flat_pairs": "merged"}, True, ["deploys 0", "movable 2", "movable 5", "locked 1", "locked 6"]),
    ],
)
def test_best_foldings_by_status_play_dof_and_crease(monkeypatch, scene, deploys, expected):
    rows, creases, dof, locked, hinged, margin, flat = (np.array(column) for column in zip(*FOLDINGS, strict=True))
    margin = 1e-3 * margin.astype(float)
    time = np.where(flat, 0.5, np.nan)
    paths = tuple(None if np.isnan(play) else np.zeros((2, 8)) for play in margin)
    ways = [None if path is None else "rigid" for path in paths]
    motion = MotionBatch(ways, margin, margin, margin, paths, ["so it was"] * len(FOLDINGS))
    monkeypatch.setattr("hcsearch.search.stages.motion.motions_of_batch", lambda *_, **_options: motion)
    monkeypatch.setattr(
        "hcsearch.springs.deployment.deployment_verdicts.deploy_foldings",
        lambda *_: DeploymentBatch(time, time, time, time, ()),
    )
    words = np.array([Circuit.from_notation("hex:02234400").word] * 5, np.int8)
    circuits = CircuitBatch("hex", words, np.ones(5, np.int16))
    none = np.zeros(len(dof), int)
    mobility = MobilityBatch(0, dof, none, none, none, none, none, locked, hinged)
    own = StagedDesigns(circuits, np.arange(1, 6), FoldingBatch(rows, creases)).with_folding_results(mobility=mobility)
    verdict = Judge(replace(DEFAULT, **scene), IN_A_SCENE[: 1 + deploys])(CandidatePiece("p#0/1", own))
    judged = verdict.verdicts
    assert [f"{word} {crease}" for word, crease in zip(judged.status, judged.best_crease, strict=True)] == expected
    assert_best_first(own, judged)
    counts = [(result.stage, result.passed, result.n_fixed) for result in verdict.results]
    assert counts == [("motion", 3, 6), ("deployment", 1, 1)][: 1 + deploys]


def test_pieces_are_small_whole_and_the_same_each_time():
    _, shard = shard_of("hex", 10)
    own = candidates_of(shard)
    parts = list(candidate_pieces("shard", own))
    assert [piece.key for piece in parts] == [f"shard#{k}/{len(parts)}" for k in range(len(parts))]
    assert len(parts) > 1
    assert sum(len(piece.candidates.foldings) for piece in parts) == len(own.foldings)
    words = np.concatenate([piece.candidates.circuits.words for piece in parts])
    assert (words == own.circuits.words).all()
    for piece in parts:
        small = piece.candidates
        assert judging_seconds(len(small.foldings), 10) <= PIECE_CORE_SECONDS or len(small.circuits) == 1
        assert set(small.foldings.row.tolist()) == set(range(len(small.circuits)))
    assert unfinished_shards(["shard", "other"], [piece.key for piece in parts]) == ["other"]
    assert unfinished_shards(["shard"], [piece.key for piece in parts[1:]]) == ["shard"]
    assert unfinished_shards(["shard"], [*(piece.key for piece in parts[1:]), "shard", "shard#/", "shard#a/b"]) == [
        "shard"
    ]
    (empty,) = candidate_pieces("none", own.take(np.zeros(len(own), bool)))
    assert (empty.key, len(empty.candidates.circuits)) == ("none#0/1", 0)
    results = Judge(DEFAULT, IN_A_SCENE)(empty).results
    assert [(result.stage, result.passed, result.n_fixed) for result in results] == [
        ("motion", 0, 0),
        ("deployment", 0, 0),
        ("flight", 0, 0),
    ]


@pytest.mark.parametrize("grade", [*SPRING_SET_GRADES, OUTER_FIRST_SET])
def test_graded_springs_run_between_both_bounds(grade):
    folding = Folding.from_notation("hex:0234435011:1")
    compiled = compile_scene(folding.linkage(), DEFAULT, keep=STOPS)
    stiffnesses = springs_of(folding, default_panel("hex"), compiled, grade)
    assert stiffnesses.shape == (compiled.system.n_joints,)
    assert stiffnesses.min() >= MAX_SPRING_STIFFNESS / GRADED_STIFFNESS_RATIO * (1 - 1e-12)
    assert stiffnesses.max() <= MAX_SPRING_STIFFNESS * (1 + 1e-12)
    assert stiffnesses.max() > 2.0 * stiffnesses.min()


def test_spread_springs_differ_and_stay_within_the_bounds():
    folding = Folding.from_notation("hex:0234435011:1")
    compiled = compile_scene(folding.linkage(flat_pairs="hinged"), DEFAULT, keep=STOPS)
    stiffnesses = np.array([springs_of(folding, default_panel("hex"), compiled, name) for name in SPREAD_SPRING_SETS])
    assert stiffnesses.shape == (len(SPREAD_SPRING_SETS), compiled.system.n_joints)
    assert stiffnesses.min() >= MIN_SPRING_STIFFNESS
    assert stiffnesses.max() <= MAX_SPRING_STIFFNESS
    # eight points of a Sobol sequence lie one in each eighth of every coordinate
    eighths = np.floor(
        8 * np.log(stiffnesses / MIN_SPRING_STIFFNESS) / np.log(MAX_SPRING_STIFFNESS / MIN_SPRING_STIFFNESS)
    )
    assert (np.sort(eighths, axis=0) == np.arange(8)[:, None]).all()


def test_stops_that_seem_to_pull_in_a_singular_state_do_not_halt_the_motion():
    folding = Folding.from_notation("hex:023234340000:3")
    compiled = compile_scene(folding.linkage(flat_pairs="hinged"), DEFAULT, keep=STOPS)
    scenes = [
        with_springs(compiled, springs_of(folding, default_panel("hex"), compiled, name)) for name in SPREAD_SPRING_SETS
    ]
    for checked in check_deployments(scenes, tolerance=1e-5):
        assert checked.outcome != "out of steps"
        assert checked.evaluations < 20_000


def test_springs_set_later_are_those_of_a_scene_compiled_with_them():
    folding = Folding.from_notation("hex:0234435011:1")
    linkage = folding.linkage()
    compiled = compile_scene(linkage, DEFAULT, keep=STOPS)
    changed = with_springs(compiled, np.geomspace(0.01, 0.2, compiled.system.n_joints))
    anew = compile_scene(linkage, changed.setup, keep=STOPS)
    for one, two in zip(changed.system.drives, anew.system.drives, strict=True):
        assert one.law == two.law
        assert one.damping == pytest.approx(two.damping, rel=1e-12)
    (one,), (two,) = check_deployments([changed]), check_deployments([anew])
    assert (one.outcome, one.clear) == (two.outcome, two.clear)
    assert one.end_time == pytest.approx(two.end_time, rel=1e-9)


def test_a_verdict_has_a_reason():
    linkage = Folding.from_notation("hex:02234400:1").linkage()
    (checked,) = check_deployments([compile_scene(linkage, DEFAULT)])
    assert checked.verdict == "collides"
    labels = labels_of(linkage)
    assert checked.reason(labels) == f"panels 4 and 7 collide at {checked.collision[0]:.4g} s"
    still = replace(checked, clear=True, collision=None, outcome="at rest", end_time=0.25)
    assert (still.verdict, still.reason(labels)) == ("undecided", "at rest at 0.25 s, clear until then")
    assert replace(still, outcome="flat").verdict == "deploys"
    wild = replace(checked, outcome="diverged", end_time=0.25)
    assert wild.verdict == "undecided"
    assert wild.reason(labels) == "diverged at 0.25 s: the results are not valid"
