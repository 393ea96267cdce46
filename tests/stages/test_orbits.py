"""Congruent foldings have one verdict, however a circuit is written: laws of likenesses, and what stages carry over."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, folding_of, foldings
from hcsearch.designs.grid import GRIDS
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.designs.records import CircuitBatch, StagedDesigns
from hcsearch.motion.locks.end_locks import lock_at
from hcsearch.motion.planning.motion_search import plan_motion
from hcsearch.scenes import SCENES
from hcsearch.scenes.looks import OUTER_FIRST_SET, SPREAD_SPRING_SETS, SPRING_SET_GRADES
from hcsearch.search.pipeline.shards import candidates_of
from hcsearch.search.stages.order import STAGES
from hcsearch.search.stages.stage import run_stages
from hcsearch.shape.labels import labels_of
from hcsearch.springs.deployment.compiled_scene import compile_scene
from hcsearch.springs.deployment.deployment_verdicts import deploy_foldings
from hcsearch.springs.deployment.simulated_deployment import simulate_deployment
from hcsearch.springs.deployment.spring_sets import springs_of
from tests.strategies import rewritten

DEFAULT = SCENES["default"]
RING = "hex:012223444500"
"""The ring of the README: its three foldings are congruent."""
CROSSED = "square:012232330101"
"""A symmetry of this circuit carries the lower flat crease of one folding to the upper one of another."""
TURNED = "square:012123230301"
"""The symmetries of this circuit make two orbits of its six foldings."""
ODD = "triangle:012323434545050121"
"""The same, and an odd number of layers: mountains become valleys."""
SYMMETRIC = (RING, CROSSED, ODD, "square:0112223300", "rectangle:0112223300", "hex:0234550132", "triangle:0123434501")


@st.composite
def written(draw, names=SYMMETRIC):
    """A folding of a circuit in any writing."""
    circuit = Circuit.from_notation(draw(st.sampled_from(names)))
    isometry = draw(st.sampled_from(circuit.grid.point_group))
    own = rewritten(circuit, isometry, draw(st.integers(0, circuit.n - 1)), draw(st.booleans()))
    return draw(st.sampled_from(foldings(own)))


@given(written(), st.sampled_from(("rigid", "hinged", "merged")), st.booleans())
def test_a_twin_is_congruent(folding, way, narrow):
    size = (0.05, 0.04, 0.006) if narrow and folding.circuit.grid.directions == 4 else (0.05, 0.05, 0.006)
    own = folding.linkage(size, flat_pairs=way)
    twin, like = own.twin, folding.likeness(size)
    if like is None:
        assert twin is None
        circuit = folding.circuit
        if size[0] != size[1]:
            circuit = Circuit(GRIDS["rectangle"], circuit.word)
        assert circuit.word == circuit.canonical().word
        return
    assert like.folding.likeness(size) is None
    turn = np.array(like.turn)
    assert np.abs(turn @ turn.T - np.eye(3)).max() < 1e-12
    centres = np.array([np.mean(facet, axis=0) for facet in own.pattern.facets])
    images = np.array([np.mean(facet, axis=0) for facet in twin.linkage.pattern.facets])[list(like.panels)]
    moved = (centres - centres.mean(axis=0)) @ turn[:2, :2].T
    assert np.abs(moved - (images - images.mean(axis=0))).max() < 1e-12
    assert sorted(twin.panels) == list(range(own.n_panels))
    assert sorted(twin.hinges) == list(range(own.n_hinges))
    assert twin.panels[own.base] == twin.linkage.base
    for hinge, image in zip(own.pattern.hinges, twin.hinges, strict=True):
        other = twin.linkage.pattern.hinges[image]
        assert {twin.panels[hinge.first], twin.panels[hinge.second]} == {other.first, other.second}
        assert hinge.closes == other.closes
        assert (hinge.face == other.face) == (turn[2, 2] > 0.0)


@given(st.data())
def test_all_foldings_of_an_orbit_have_one_that_stands_for_them(data):
    folding = data.draw(written())
    circuit, half = folding.circuit, folding.circuit.n // 2
    ways = circuit.renumberings()
    assert len(ways) == circuit.symmetry
    images = {way(crease) % half for way in ways for crease in (folding.crease, folding.opposite)}
    size = default_panel(circuit.grid.name)
    like = folding.likeness(size)
    standing = folding if like is None else like.folding
    assert standing.crease == min(images)
    canonical = circuit.canonical()
    for crease in images:
        other = Folding(canonical, crease).likeness(size)
        assert (Folding(canonical, crease) if other is None else other.folding) == standing


def test_rectangles_have_fewer_symmetries_than_squares():
    narrow, plain = (0.05, 0.04, 0.006), (0.05, 0.05, 0.006)
    square, turned = Circuit.from_notation("square:0112223300"), Circuit.from_notation("square:1223330011")
    folding, other = folding_of(square, 3), folding_of(turned, 3)
    assert folding.likeness(plain).folding == other.likeness(plain).folding
    assert folding.likeness(narrow).folding.circuit != other.likeness(narrow).folding.circuit


@pytest.mark.parametrize("gravity", [(0.0, 0.0, 0.0), (1.0, 2.0, -9.81)])
def test_deployments_do_not_hang_on_how_a_circuit_is_written(gravity):
    """Times are equal to the last digit, as one and the same system is simulated."""
    circuit = Circuit.from_notation("hex:0234550132")
    scene = replace(DEFAULT, gravity=gravity, springs=((0, "linear:0.2"),), seconds=0.1)
    for isometry in circuit.grid.point_group[1::4]:
        for backwards in (False, True):
            own = rewritten(circuit, isometry, 3, backwards)
            folding = next(one for one in foldings(own) if one.notation.endswith(":4"))
            linkage = folding.linkage(default_panel("hex"), flat_pairs="hinged")
            twin = linkage.twin
            back = tuple(float(x) for x in twin.turn.T @ np.array(gravity))
            found = simulate_deployment(
                linkage, replace(scene, gravity=back, springs=((twin.hinges.index(0), "linear:0.2"),))
            )
            one = simulate_deployment(twin.linkage, scene)
            assert len(found.motion.times) == len(one.motion.times)
            assert found.angles[-1] == pytest.approx(one.angles[-1][list(twin.hinges)], abs=1e-9)
            if not any(gravity):
                assert (found.motion.times == one.motion.times).all()
            assert found.check.collision is None
            # its own geometry moves as the twin's
            assert np.abs(linkage.closure(found.angles[-1])[0]).max() < 1e-6


@pytest.mark.parametrize("formulation", ["penalty", "compliant", "quasistatic"])
def test_all_formulations_are_of_the_twin(formulation):
    ring = Circuit.from_notation(RING)
    scene = replace(DEFAULT, seconds=0.003)
    own = [folding_of(ring, crease).linkage(flat_pairs="hinged") for crease in (0, 4)]
    one, other = (simulate_deployment(linkage, scene, formulation) for linkage in own)
    assert (one.motion.times == other.motion.times).all()
    assert (other.angles == one.angles[:, list(own[1].twin.hinges)]).all()


@given(
    written((RING, CROSSED, "square:0112223300")),
    st.sampled_from((*SPRING_SET_GRADES, OUTER_FIRST_SET, *SPREAD_SPRING_SETS)),
)
def test_spring_sets_are_those_of_the_twin(folding, name):
    linkage = folding.linkage(default_panel(folding.circuit.grid.name), flat_pairs="hinged")
    if linkage.twin is None:
        return
    panel = default_panel(folding.circuit.grid.name)
    like = folding.likeness(panel)
    own, other = (compile_scene(one, DEFAULT, keep=frozenset({"stops"})) for one in (linkage, linkage.twin.linkage))
    springs = springs_of(folding, panel, own, name)
    assert (springs == springs_of(like.folding, panel, other, name)).all()
    assert (own.joint_of == other.joint_of[list(linkage.twin.hinges)]).all()


def staged(name, until, scene=DEFAULT):
    """A design with the untwisted foldings that have been through all stages until one."""
    circuit = Circuit.from_notation(name)
    batch = CircuitBatch(circuit.grid.name, np.array([circuit.word], np.int8), np.array([circuit.symmetry], np.int16))
    designs = StagedDesigns(batch, np.array([1]))
    first = [STAGES[stage] for stage in ("foldings", "twist", "mobility")]
    designs = candidates_of(run_stages(designs, first, scene)[0])
    return run_stages(designs, [STAGES[stage] for stage in until], scene)


@pytest.mark.parametrize(
    ("name", "until"),
    [
        (RING, ("motion", "deployment")),
        (TURNED, ("motion", "deployment")),
        ("square:01223230300121", ("motion",)),  # two foldings stand for others upside down
    ],
)
def test_one_folding_of_an_orbit_is_judged(name, until):
    designs, _ = staged(name, until)
    motion, deployment = designs.motion, designs.deployment
    circuit, creases = Circuit.from_notation(name), designs.folded.crease.tolist()
    paths = 0
    for i, crease in enumerate(motion.as_crease):
        if crease is None:
            continue
        k = creases.index(crease)
        assert motion.as_crease[k] is None
        numbers = [motion.margin, motion.gap, motion.slack]
        if deployment is not None:
            numbers += [deployment.clearance, deployment.time, deployment.margin, deployment.gap]
            own, other = ([one for one in deployment.trials if one.folding == place] for place in (i, k))
            assert [one.as_crease for one in own] == [crease] * len(own)
            named = ("scene", "status", "clearance", "deploy_time", "needed_margin", "first_contact", "energy_error")
            assert [[getattr(one, word) for word in named] for one in own] == [
                [getattr(one, word) for word in named] for one in other
            ]
            assert all(f'design = "{name}:{creases[i]}"' in one.values for one in own)
        assert all(own[i] == own[k] or np.isnan([own[i], own[k]]).all() for own in numbers)
        assert motion.flat_pairs[i] == motion.flat_pairs[k]
        if (way := motion.flat_pairs[i]) is not None:
            # the path is one of the folding's own linkage
            linkage = folding_of(circuit, creases[i]).linkage(default_panel(circuit.grid.name), flat_pairs=way)
            path = motion.paths[i]
            assert np.abs(path[[0, -1]] - [linkage.folded, linkage.flat]).max() < 1e-9
            assert max(np.abs(linkage.closure(state)[0]).max() for state in path) < 1e-8
            paths += 1
    assert paths


def test_reasons_name_the_panels_of_their_folding():
    """Panels that collide in the folding that was simulated are other ones in those it stands for."""
    designs, _ = staged(TURNED, ("motion", "deployment"))
    trials = {designs.folded.crease[one.folding]: one for one in designs.deployment.trials if one.scene == "default"}
    for crease in (2, 3, 5):
        assert trials[crease].as_crease == 0
        linkage = folding_of(Circuit.from_notation(TURNED), crease).linkage()
        found = simulate_deployment(linkage, DEFAULT)
        assert found.verdict == trials[crease].status == "collides"
        assert found.check.reason(labels_of(linkage)) == trials[crease].reason
        assert found.check.collision[0] == pytest.approx(trials[crease].first_contact, rel=1e-6)


@pytest.mark.parametrize(
    ("name", "changes", "alone"),
    [
        (RING, {}, {0}),
        (RING, {"gravity": (0.0, 0.0, -9.81)}, {0}),
        (RING, {"gravity": (0.0, 9.81, 0.0)}, {0, 2, 4}),
        (RING, {"held": "3"}, {0, 2, 4}),
        (CROSSED, {"gravity": (0.0, 0.0, -9.81)}, {1}),
        (ODD, {}, {2}),
        (ODD, {"gravity": (0.0, 0.0, -9.81)}, {2, 5}),
    ],
)
def test_only_symmetries_of_the_scene_count(name, changes, alone):
    designs, _ = staged(name, ())
    creases = designs.folded.crease.tolist()
    none = np.zeros(len(creases), bool)
    scene = replace(DEFAULT, seconds=0.001, **changes)
    trials = deploy_foldings(designs.circuits, designs.folded, none, none, scene).trials
    assert {creases[one.folding] for one in trials} == set(creases)
    standing = {creases[one.folding] for one in trials if one.as_crease is None}
    assert standing & {0, 1, 2, 4, 5} == alone


def test_locks_are_the_same_for_congruent_foldings():
    circuit = Circuit.from_notation("square:012123230301")
    for crease in (2, 4):
        linkage = folding_of(circuit, crease).linkage()
        for end in ("folded", "flat"):
            one, other = (lock_at(own, getattr(own, end)).locked for own in (linkage, linkage.twin.linkage))
            assert one == other


def test_paths_do_not_hang_on_how_a_circuit_is_written():
    circuit = Circuit.from_notation("hex:0234550132")
    size = default_panel("hex")
    known = plan_motion(folding_of(circuit, 4), size, ("rigid",))
    own = rewritten(circuit, circuit.grid.point_group[7], 3, True)
    folding = next(one for one in foldings(own) if one.notation.endswith(":4"))
    found = plan_motion(folding, size, ("rigid",))
    linkage = folding.linkage(size, flat_pairs="rigid")
    assert (found.way, found.margin) == (known.way, known.margin)
    assert (found.states == known.states[:, list(linkage.twin.hinges)]).all()
    assert (found.proof.motion.angles == known.proof.motion.angles[:, list(linkage.twin.hinges)]).all()


def test_what_deploys_without_a_path_moves(monkeypatch):
    """The funnel never widens."""
    monkeypatch.setattr("hcsearch.motion.planning.schedule.TIGHT_SEARCH_ROUNDS", 0)
    monkeypatch.setattr("hcsearch.motion.planning.schedule.LOOSE_SEARCH_ROUNDS", 0)
    designs, results = staged("hex:0234550132", ("motion", "deployment"))
    assert not designs.motion.moves.any()
    assert designs.deployment.deploys.any()
    assert [(one.stage, one.passed) for one in results] == [("motion", 1), ("deployment", 1)]
    _, results = staged("hex:0234550132", ("motion",))
    assert [(one.stage, one.passed) for one in results] == [("motion", 0)]
