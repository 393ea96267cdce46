"""Two commands that write one database at once."""

import pytest

from tests.faults.fault_tools import MANY, MOST, OTHER, SMALL, Running, batches


def run_both(path, first, second):
    """Start two jobs on one database, which neither finds there; the batches that each says it has done."""
    with Running(*first.into(path)) as one, Running(*second.into(path)) as two:
        ends = [one.end(), two.end()]
    for code, _, err in ends:
        assert (code, err) == (0, "")
    return [batches(out)[0] for _, out, _ in ends]


@pytest.mark.parametrize("job", [MANY, pytest.param(MOST, marks=pytest.mark.slow)])
def test_the_same_job_twice_at_once(tmp_path, reference, law, job):
    path = tmp_path / "designs.sqlite"
    done = run_both(path, job, job)
    before = reference(job).state.finished
    assert sum(done) >= len(before)
    law("two writers", path, job, injected=1, before=before)


@pytest.mark.slow
def test_different_jobs_at_once(tmp_path, reference, law):
    path = tmp_path / "designs.sqlite"
    run_both(path, SMALL, OTHER)
    law(
        "two writers", path, SMALL, OTHER, injected=1, before=(reference(SMALL).state + reference(OTHER).state).finished
    )
