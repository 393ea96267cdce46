"""Models for simulators, read back: the same mechanism as that which was exported."""

import re

import numpy as np
import pytest

from hcsearch import save
from hcsearch.cases.resolve import resolve
from hcsearch.motion.kinematics.numerical_rank import generic_rank, rank_at
from tests.commands import run_here

_NAMES = (
    "hex:0234550132:4",
    "square:012233230011:0",
    "triangle:0123434501:1",
    "unit-ii",
    "module-i",
    "element-6r",
)


@pytest.fixture(scope="module", params=[(name, ending) for name in _NAMES for ending in (".urdf", ".xml")], ids=str)
def models(request, tmp_path_factory):
    """An exported linkage, and that of the case of its model."""
    name, ending = request.param
    path = tmp_path_factory.mktemp("models") / f"model{ending}"
    save(name, path, db="none.sqlite")
    return resolve(name, "none.sqlite").linkage, resolve(str(path), "none.sqlite").linkage


def test_a_model_has_the_panels_and_hinges_that_were_exported(models):
    exported, read = models
    assert (read.n_panels, read.n_hinges, len(read.loops)) == (
        exported.n_panels,
        exported.n_hinges,
        len(exported.loops),
    )
    assert read.pattern.thickness == pytest.approx(exported.pattern.thickness, rel=1e-6)
    areas = [
        sorted(sum(_area(linkage.pattern.facets[f]) for f in panel) for panel in linkage.pattern.panels)
        for linkage in models
    ]
    assert np.allclose(*areas, rtol=1e-5)
    faces = [sorted((hinge.face, hinge.closes) for hinge in linkage.pattern.hinges) for linkage in models]
    assert faces[0] == faces[1]


def test_a_model_has_the_mobility_of_what_was_exported(models):
    for state in ("folded", "flat"):
        ranks = [rank_at(linkage, getattr(linkage, state)) for linkage in models]
        assert ranks[0].nullity == ranks[1].nullity is not None
    generic = [generic_rank(linkage).nullity for linkage in models]
    assert generic[0] is None or generic[0] == generic[1]


def _area(facet):
    x, y = np.array(facet).T
    return 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        (
            "other.urdf",
            "<robot name='arm'><link name='a'/></robot>",
            "the loops, which URDF cannot hold, in .*other.closure.json",
        ),
        ("other.xml", "<mujoco><worldbody/></mujoco>", "is no model that hcsearch export wrote"),
        ("other.xml", "<html/>", "is no model that hcsearch export wrote"),
        (
            "other.xml",
            "<mujoco><worldbody><body name='a' pos='0 0 0'><geom type='box'/></body></worldbody></mujoco>",
            "no keyframe",
        ),
        ("other.mjcf", "<mujoco", "is no model, which is XML"),
    ],
)
def test_models_of_other_programs_are_refused_in_one_line(name, text, message, tmp_path, capfd):
    path = tmp_path / name
    path.write_text(text)
    result = run_here(["check", str(path)], capfd)
    assert (result.returncode, result.stdout, len(result.stderr.splitlines())) == (2, "", 1)
    assert re.search(message, result.stderr)
