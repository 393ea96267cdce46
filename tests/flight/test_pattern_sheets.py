"""Flight sheets of patterns of files."""

import pytest

from hcsearch import save, sheet

_VALUES = {"friction": 0.0005, "latch_stiffness": 5.0, "envelope": "200x200x60"}
_FIGURES = ("deployed_hz", "latch_torque", "flatness_mm_per_mrad", "tilt", "stowed_length", "stowed_height", "mass")


def test_the_sheet_of_a_model_of_a_folding_is_that_of_the_folding(tmp_path):
    name = "square:012230:1"
    model, *_ = save(name, tmp_path / "a.urdf", db="none.sqlite")
    given, read = (
        sheet(subject, db="none.sqlite", flat_pairs=pairs, **_VALUES)
        for subject, pairs in ((name, "rigid"), (str(model), None))
    )
    assert read.facts()["pattern"] == "a.urdf"
    assert read.source == given.source
    assert [(row.rule, row.verdict) for row in read.rows] == [(row.rule, row.verdict) for row in given.rows]
    assert [read.figures()[key] for key in _FIGURES] == pytest.approx(
        [given.figures()[key] for key in _FIGURES], rel=1e-5
    )
