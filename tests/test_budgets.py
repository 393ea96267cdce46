"""Budgets of the search for motions: what is undecided is searched on, and comes to what one search comes to."""

import pytest
from click.testing import CliRunner

from hcsearch.cli import hcsearch
from hcsearch.store import open_readonly, schema, select

SQUARES = ("enumerate", "--grid", "square", "--n", "10")
"""Three of nine foldings are undecided without a budget; one of these is proved locked in the third effort."""


def call(*words, code=0):
    result = CliRunner().invoke(hcsearch, [str(word) for word in words])
    assert result.exit_code == code, result.output
    return result


def verdicts(path):
    """All that is stored of verdicts, motions and deployments, but for errors of simulations."""
    names = {"outcome": None, "verdict": None, "motion": None, "deployment": ("energy_error", "closure_error")}
    with open_readonly(str(path)) as database, database.reading() as connection:
        return {
            name: sorted(
                map(
                    repr,
                    connection.execute(
                        schema.metadata.tables[name]
                        .select()
                        .with_only_columns(*(c for c in schema.metadata.tables[name].c if c.name not in (left or ())))
                    ),
                )
            )
            for name, left in names.items()
        }


@pytest.fixture(scope="module")
def stepwise(tmp_path_factory):
    """A database searched with the usual budget, then with a larger one; what the runs printed."""
    path = tmp_path_factory.mktemp("budgets") / "squares.sqlite"
    texts = [call(*SQUARES, "--db", path).stdout]
    with open_readonly(str(path)) as database:
        before = select(database, "status=undecided", view="foldings", columns="design_id,crease,known").rows
    texts += [call(*SQUARES, "--db", path, "--budget", 3).stdout for _ in range(2)]
    return path, texts, before


def test_what_is_undecided_is_searched_on(stepwise):
    path, texts, before = stepwise
    assert len(before) == 3
    assert {known for *_, known in before} == {"no_path_met"}
    assert "3 foldings are undecided: the same command with --budget 3 searches on" in texts[0]
    assert "2 foldings are undecided: the same command with --budget 4 searches on" in texts[1]
    with open_readonly(str(path)) as database:
        (row,) = select(database, "status=locked", view="foldings", columns="design_id,crease,known,deployable").rows
        assert row[2:] == ("kept_apart", 0)
        # proofs at both ends take as many boxes, up to rounding: either may come first
        lock = "lock_pairs=hinged lock_cubes>0 lock_faces>1 efforts=3"
        (found,) = select(database, lock, view="motions", columns="design_id,crease,lock_end").rows
        assert found[:2] == row[:2]
        assert found[2] in {"packed", "flat"}
        (reason,) = select(database, lock, view="motions", columns="reason").rows[0]
        assert reason.startswith("closed loops and stops keep the packed and the flat state apart")
        left = select(database, "known=no_path_met", view="foldings", columns="critical_margin,unmet_margin").rows
        assert left == ((None, pytest.approx(2.47, rel=0.01)),) * 2


def test_the_same_budget_again_does_no_work(stepwise):
    _, texts, _ = stepwise
    assert "batches: 0 done" in texts[2]
    for text in texts[1:]:
        assert [line for line in text.splitlines() if line.startswith("  ")] == [
            line for line in texts[0].splitlines() if line.startswith("  ")
        ]


def test_going_on_comes_to_what_one_search_comes_to(stepwise, tmp_path):
    path = tmp_path / "once.sqlite"
    text = call(*SQUARES, "--db", path, "--budget", 3).stdout
    assert "2 foldings are undecided" in text
    assert verdicts(path) == verdicts(stepwise[0])


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--budget", 0), "a budget of 0 is too small: give 1 or more efforts, or leave it out"),
        (("--budget", -1), "a budget of -1 is too small"),
        (("--budget", 3, "--until", "twist"), "--budget applies to the stage motion, which does not run"),
    ],
)
def test_budgets_that_say_nothing_are_refused(words, message, tmp_path):
    path = tmp_path / "none.sqlite"
    result = CliRunner().invoke(hcsearch, [*map(str, (*SQUARES, "--db", path, *words))])
    assert message in str(result.exception)
    assert not path.exists()
