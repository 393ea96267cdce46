import re
from itertools import pairwise

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from hcsearch.basics.vocabulary import WAYS
from hcsearch.cli import hcsearch
from hcsearch.designs.folding import Folding
from hcsearch.springs.deployment.simulated_deployment import simulate_deployment
from hcsearch.subjects.replay_sources import REPLAY_ANGLE_TOLERANCE, replay_of_deployment, replay_of_path
from hcsearch.subjects.resolve import resolve
from tests.planned import SAMPLES, joined, planned

CLEAR, COLLIDES = "hex:0234550132:4", "thesis-4x4"


@pytest.fixture(scope="module", params=[CLEAR, COLLIDES])
def let_go(request):
    """A deployment and its replay."""
    subject = resolve(request.param, "none.sqlite")
    deployment = simulate_deployment(subject.linkage, subject.setup, "constrained")
    return deployment, replay_of_deployment(deployment, request.param)


def shares_of(states) -> np.ndarray:
    turned = [0.0]
    for before, after in pairwise(states):
        turned.append(turned[-1] + sum(abs(b - a) for a, b in zip(before, after, strict=True)))
    return np.array(turned) / turned[-1]


@pytest.mark.parametrize("name", SAMPLES)
def test_a_replay_follows_its_path_within_its_error_and_has_its_ends(name):
    path = planned(name)
    replay = replay_of_path(path.linkage, path.states, name, margin=1e-5)
    at = shares_of(path.states)
    missed = np.abs(replay.at_time(at) - path.states).max()
    assert missed == pytest.approx(replay.error, abs=1e-12)
    assert replay.error <= REPLAY_ANGLE_TOLERANCE
    assert len(replay.at) < len(path.states)
    assert replay.angles[0].tolist() == path.states[0].tolist()
    assert replay.angles[-1].tolist() == path.states[-1].tolist()
    assert (replay.axis, replay.at[0], replay.at[-1]) == ("path", 0.0, 1.0)
    assert (np.diff(replay.at) > 0.0).all()


def test_only_a_proved_path_is_certified():
    linkage = joined(CLEAR, "hinged")
    states = np.stack([linkage.folded, linkage.flat])
    proved, plain = (replay_of_path(linkage, states, "two", margin=margin) for margin in (2e-5, None))
    assert (proved.certified, proved.margin) == (((0.0, 1.0),), 2e-5)
    assert proved.source.endswith("proved with 0.02 mm of play on every face")
    assert (plain.certified, plain.margin) == ((), 0.0)
    assert plain.source.endswith("not proved")


@given(st.integers(1, 6), st.integers(0, 2**32 - 1))
def test_states_that_are_repeated_are_stored_once(k, seed):
    linkage = joined(CLEAR, "rigid")
    random = np.random.default_rng(seed)
    states = np.repeat(random.uniform(-1.0, 1.0, (k, linkage.n_hinges)), random.integers(1, 4, k), axis=0)
    replay = replay_of_path(linkage, states, "repeated", margin=None, near=0.0)
    if k > 1:
        assert len(replay.at) == k
        assert (
            replay.angles.tolist() == states[np.append(np.abs(np.diff(states, axis=0)).sum(axis=1) > 0, True)].tolist()
        )
    else:
        assert np.unique(replay.angles, axis=0).tolist() == states[:1].tolist()


def test_a_replay_follows_its_deployment_within_its_error(let_go):
    deployment, replay = let_go
    assert replay.axis == "time"
    assert (replay.at[0], replay.at[-1]) == (0.0, deployment.motion.times[-1])
    assert replay.error <= REPLAY_ANGLE_TOLERANCE
    assert len(replay.at) < len(deployment.motion.times)
    at = np.random.default_rng(5).uniform(0.0, replay.at[-1], 2000)
    q = deployment.motion.at(at)
    exact = deployment.compiled.of_hinges(q, np.zeros_like(q))[0]
    assert np.abs(replay.at_time(at) - exact).max() <= 1.1 * replay.error


def test_a_deployment_is_certified_to_its_end_or_to_its_first_collision(let_go):
    deployment, replay = let_go
    assert deployment.clearance is not None
    if deployment.clearance.kind == "clear":
        assert replay.collision is None
        assert replay.certified == ((0.0, deployment.motion.times[-1]),)
    else:
        assert replay.collision is not None
        assert replay.collision[0] == deployment.clearance.time
        assert replay.certified == ((0.0, replay.collision[0]),)
    assert replay.margin == deployment.compiled.margin


def shown(name: str) -> dict[str, set[int]]:
    """Creases of each kind as `hcsearch show` prints them."""
    result = CliRunner().invoke(hcsearch, ["show", name])
    assert result.exit_code == 0, result.output
    lines = re.findall(r"^  (\w+) creases.*: (.*)$", result.output, re.MULTILINE)
    return {kind: set(map(int, re.findall(r"\d+", text))) for kind, text in lines}


JOINED = [
    (name, way)
    for name in ("hex:0234550132:4", "square:012230:1", "triangle:0123434501:1")
    for way in WAYS
    if Folding.from_notation(name).can_join(way)
]


@pytest.mark.parametrize(("name", "way"), JOINED)
def test_names_of_hinges_are_creases_that_show_prints_whatever_is_joined(name, way):
    folding, creases = Folding.from_notation(name), shown(name)
    linkage, n = joined(name, way), folding.circuit.n
    labels = replay_of_path(linkage, np.stack([linkage.folded, linkage.flat]), name, margin=None).labels
    panels, hinges = ([set(map(int, label.split("+"))) for label in own] for own in (labels.panels, labels.hinges))
    assert sorted(panel for own in panels for panel in own) == list(range(n))
    rigid = [] if way == "hinged" else [(k, (k + 1) % n) for k in (folding.crease, folding.opposite)]
    one = [*rigid, *(folding.mirror_pairs if way == "merged" else ())]
    assert all(any({*pair} <= own for own in panels) for pair in one)
    hidden = {k for k in range(n) if any({k, (k + 1) % n} <= own for own in panels)}
    assert set().union(*hinges) == set(range(n)) - hidden
    for own, hinge in zip(hinges, linkage.pattern.hinges, strict=True):
        assert own <= creases["flat" if not hinge.closes else "valley" if hinge.face == "top" else "mountain"]
        for crease in own:
            sides = [panels[hinge.first], panels[hinge.second]]
            assert any(crease in one and (crease + 1) % n in two for one, two in (sides, sides[::-1]))


def test_panels_of_an_assembly_have_the_numbers_of_its_pattern(let_go):
    deployment, replay = let_go
    if replay.title == COLLIDES:
        assert replay.labels.panels == tuple(map(str, range(deployment.compiled.linkage.n_panels)))
        assert replay.labels.hinges == tuple(map(str, range(deployment.compiled.linkage.n_hinges)))
    else:
        assert replay.labels.panels[4] == "4+5"
        assert "4" not in replay.labels.hinges
