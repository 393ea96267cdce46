import itertools
import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from sqlalchemy import Connection
from sqlalchemy.exc import IntegrityError
from store_samples import RESULTS, VERSIONS, WORK, begin, circuits, contents, everything, record, sample

from hcsearch.designs.records import StageResult, WorkKey
from hcsearch.store import (
    count_arrays,
    design_rows,
    finish_run,
    finished_batches,
    open_database,
    open_readonly,
    record_batches,
    schema,
    select,
    start_run,
)
from tests.judging import judge


def test_round_trip(database):
    record(database, circuits(1, 3))
    names = "circuit,array,orbit_size,n_fixed,n_foldings,two_stack,n_untwisted,untwisted,min_twist,deployable,status"
    assert select(database, columns=names).rows == (
        ("hex:007919", "hex:array0", 12, 12, 0, 0, 0, 0, None, 0, "no_folding"),
        ("hex:015838", "hex:array0", 6, 6, 2, 1, 0, 0, 1, 0, "twisted"),
        ("hex:023757", "hex:array1", 2, 2, 2, 1, 1, 1, 0, None, None),
    )
    names = "design_id,crease,opposite,twist,untwisted,status,deployable"
    assert select(database, columns=names, view="foldings").rows == (
        (2, 1, 7, 1, 0, "twisted", 0),
        (2, 4, 10, 2, 0, "twisted", 0),
        (3, 0, 6, 1, 0, "twisted", 0),
        (3, 3, 9, 0, 1, None, None),
    )


@pytest.mark.parametrize(
    ("until", "known"), [("circuits", (None,) * 4), ("foldings", (2, 1, None, None)), ("twist", (2, 1, 0, 0))]
)
def test_null_where_a_stage_has_not_run(database, until, known):
    record(database, circuits(1, 3), until=until)
    rows = select(database, "id=2", columns="n_foldings,two_stack,n_untwisted,untwisted,status,dof,score").rows
    assert rows == ((*known, "twisted" if until == "twist" else None, None, None),)
    twists = {row[0] for row in select(database, columns="twist", view="foldings").rows}
    assert twists == {"circuits": set(), "foldings": {None}, "twist": {0, 1, 2}}[until]


def test_later_stages_show_in_designs(database):
    record(database, circuits(1, 3))
    verdicts = {"deploys": 1, "movable": 1, "locked": 0, "undecided": None}
    for status, deployable in verdicts.items():
        with database.writing() as connection:
            connection.execute(schema.design.update().values(best_crease=3))
            connection.execute(schema.folding.update().values(dof=5))
        judge(database, [("hex:023757", 3, status, 0.5 if status == "deploys" else None, None)])
        shown = select(database, columns="dof,min_clearance,status,deployable").rows
        assert shown == (
            (None, None, "no_folding", 0),
            (None, None, "twisted", 0),
            (5, 0.5 if status == "deploys" else None, status, deployable),
        )
        shown = select(database, "design_id=3", columns="status,deployable", view="foldings").rows
        assert shown == (("twisted", 0), (status, deployable))


def test_same_batch_twice_adds_nothing(database):
    names = circuits(1, 30)
    record(database, names)
    before, shown = everything(database), (select(database), select(database, view="foldings"))
    record(database, names)
    after = everything(database)
    assert {**after, "run": before["run"], "batch": before["batch"]} == before
    assert (select(database), select(database, view="foldings")) == shown


@pytest.mark.parametrize("text", ["a\tb", "a\\b", "a\nb", "\\N", "", "é'\"%", "a\r"])
def test_any_text_survives_the_way_to_the_database(database, place, text):
    record(database, [text])
    with open_readonly(place) as reader:
        assert select(reader, columns="circuit").rows == ((text,),)


def insert_and(database, names, then):
    """Insert designs, and do something before the transaction ends."""
    with database.writing() as connection:
        design_rows.insert_designs(connection, database.location, sample(names))
        then()
        design_rows.insert_designs(connection, database.location, sample(names))


def test_a_failed_batch_leaves_nothing_and_burns_no_id(database):
    record(database, circuits(1, 3))
    before = everything(database)
    with pytest.raises(ZeroDivisionError):
        insert_and(database, circuits(4, 3), lambda: 1 / 0)
    assert everything(database) == before
    record(database, circuits(4, 3))
    assert select(database, columns="id").rows == tuple((k,) for k in range(1, 7))
    assert select(database, view="runs", columns="id").rows == ((1,), (2,))


def test_empty_batch_is_work_done(database):
    record(database, [], results=[StageResult("circuits", 1, 0, 0, 0.0)])
    assert select(database).rows == ()
    assert list(finished_batches(database, WORK, {"circuits": 1})) == ["p"]


def test_one_circuit_twice_in_a_batch(database):
    record(database, ["hex:1", "hex:2", "hex:1", "hex:2"], creases=[[2]], twists=[[0]])
    assert select(database, columns="id,circuit").rows == ((1, "hex:1"), (2, "hex:2"))
    assert len(select(database, view="foldings").rows) == 2


@pytest.mark.parametrize("chunk", [2, 1000])
def test_overlapping_batches_in_both_orders(tmp_path, monkeypatch, chunk):
    monkeypatch.setattr(design_rows, "INSERT_CHUNK_ROWS", chunk)
    names = circuits(1, 9)
    batches = [(names[:6], "twist"), (names[3:], "twist")]
    orders = []
    for number, order in enumerate(itertools.permutations(batches)):
        with open_database(str(tmp_path / f"{number}.sqlite"), create=True) as database:
            for part, until in order:
                record(database, part, until=until)
            orders.append([(row["circuit"], row["n_foldings"], row["foldings"]) for row in contents(database)])
    assert orders[0] == orders[1]
    assert len(orders[0]) == 9


@pytest.mark.parametrize("order", list(itertools.permutations(["circuits", "foldings", "twist"])))
def test_stages_that_did_not_run_leave_columns_alone(database, order):
    for until in order:
        record(database, circuits(1, 3), until=until)
    assert select(database, "id=3", columns="n_foldings,n_untwisted,min_twist").rows == ((2, 1, 0),)
    assert select(database, columns="twist", view="foldings").rows == ((1,), (2,), (1,), (0,))


def test_columns_of_later_stages_survive_a_rerun(database):
    record(database, circuits(1, 3))
    with database.writing() as connection:
        connection.execute(schema.design.update().values(best_crease=3))
        connection.execute(schema.folding.update().values(dof=4))
        connection.execute(schema.score.insert().values(design_id=3, scene="default", score=1.5))
    record(database, circuits(1, 4))
    assert select(database, columns="dof,score", sort="id").rows[2] == (4, 1.5)
    assert select(database, "dof=4", view="foldings").rows[-1][:2] == (3, 3)


def test_newer_version_refutes_old_foldings(database):
    record(database, ["hex:1", "hex:2"], creases=[[0, 1, 2]], twists=[[0, 0, 0]])
    record(database, ["hex:2", "hex:3"], creases=[[1, 4]], twists=[[1, 0]])
    pairs = select(database, columns="design_id,crease,twist", view="foldings").rows
    of = dict(select(database, columns="circuit,id").rows)
    assert set(pairs) == {
        *((of["hex:1"], crease, 0) for crease in (0, 1, 2)),
        *((of[name], crease, twist) for name in ("hex:2", "hex:3") for crease, twist in ((1, 1), (4, 0))),
    }


@pytest.mark.parametrize("n_foldings", [None, np.array([2])])
def test_search_for_some_foldings_refutes_nothing(database, n_foldings):
    record(database, ["hex:1"], creases=[[0, 1]], twists=[[0, 1]])
    batch = sample(["hex:1"], creases=[[0]], twists=[[0]])
    counted = {"n_foldings": n_foldings} if n_foldings is not None else {}
    batch = replace(
        batch, designs={name: batch.designs[name] for name in batch.designs if name != "n_foldings"} | counted
    )
    record_batches(database, begin(database), WORK, [("q", batch, RESULTS)])
    assert len(select(database, view="foldings").rows) == 2
    assert select(database, columns="n_foldings,n_untwisted").rows == ((2, 1),)


@pytest.mark.parametrize("size", [100, 200])
def test_opposite_crease_of_long_circuits(database, size):
    batch = sample(["hex:1"], creases=[[99]], twists=[[0]])
    batch = replace(batch, designs={**batch.designs, "n": size})
    record_batches(database, begin(database), WORK, [("p", batch, RESULTS)])
    assert select(database, columns="opposite", view="foldings").rows == ((99 + size // 2,),)


def test_failure_in_the_middle_leaves_nothing(database, monkeypatch):
    record(database, circuits(1, 3))
    before = contents(database)
    real = Connection.exec_driver_sql

    def fail(connection, statement, *args, **options):
        if "folding" in statement:
            raise KeyboardInterrupt
        return real(connection, statement, *args, **options)

    with monkeypatch.context() as patch:
        patch.setattr(Connection, "exec_driver_sql", fail)
        with pytest.raises(KeyboardInterrupt):
            record(database, circuits(2, 30), prefix="other")
    assert contents(database) == before
    assert list(finished_batches(database, WORK, VERSIONS)) == ["p"]


def test_results_without_their_run_leave_nothing(database):
    with pytest.raises(IntegrityError, match=r"(?i)foreign key"):
        record_batches(database, 99, WORK, [("p", sample(circuits(1, 3)), RESULTS)])
    assert select(database).rows == ()


def test_finished_batches_need_every_stage_at_its_version(database):
    record(database, circuits(1, 3), prefix="")
    record(database, circuits(4, 3), prefix="10", results=RESULTS[:2])
    assert finished_batches(database, WORK, VERSIONS) == {"": RESULTS}
    assert finished_batches(database, WORK, {"foldings": 1, "circuits": 1}) == {
        "": [RESULTS[1], RESULTS[0]],
        "10": [RESULTS[1], RESULTS[0]],
    }
    assert finished_batches(database, WORK, VERSIONS | {"twist": 2}) == {}
    assert finished_batches(database, WORK, VERSIONS | {"mobility": 1}) == {}


def test_finished_batches_are_of_this_work_alone(database):
    record(database, circuits(1, 3))
    others = [("square", 12, "", "all", ""), ("hex", 10, "", "all", ""), ("hex", 12, "hex:a", "all", "")]
    others += [("hex", 12, "", "two-stack", ""), ("hex", 12, "", "all", "default")]
    for other in others:
        assert finished_batches(database, WorkKey(*other), VERSIONS) == {}
    for other in others:
        record(database, circuits(1, 3), prefix="q", work=WorkKey(*other))
    assert list(finished_batches(database, WORK, VERSIONS)) == ["p"]


def test_newer_work_takes_the_place_of_older(database):
    record(database, circuits(1, 3))
    newer = [StageResult(r.stage, 2, r.passed + 1, r.n_fixed, r.seconds) for r in RESULTS]
    record(database, circuits(1, 3), results=newer)
    assert finished_batches(database, WORK, VERSIONS) == {}
    assert finished_batches(database, WORK, dict.fromkeys(VERSIONS, 2)) == {"p": newer}


def test_numbers_of_numpy_are_stored_as_numbers(database):
    odd = [StageResult("circuits", 1, np.int64(3), np.int32(30), np.float32(0.5))]
    record(database, circuits(1, 3), results=odd)
    assert finished_batches(database, WORK, {"circuits": 1}) == {"p": [StageResult("circuits", 1, 3, 30, 0.5)]}


def test_runs(database):
    work = WorkKey("square", 24, "square:6x4", "two-stack")
    options = {"until": "twist", "panel": "50x40x6", "arguments": {"n": None, "jobs": 2}, "versions": {"twist": 1}}
    first = start_run(database, work=work, **options)
    second = start_run(database, work=work, **options)
    assert (first, second) == (1, 2)
    funnel = {"fixed_circuits": np.int64(2**40), "circuits": 37, "arrays": 1, "two_stack": None}
    finish_run(database, second, funnel, {"circuits": np.float64(0.5)}, 3, 4)
    interrupted, finished = (
        dict(zip(result.columns, result.rows[0], strict=True))
        for result in (select(database, f"id={number}", view="runs") for number in (first, second))
    )
    assert interrupted["finished"] is None
    assert interrupted["batches_done"] is None
    assert finished["started"] <= finished["finished"]
    assert finished["started"].endswith("+00:00")
    assert json.loads(finished["arguments"]) == {"n": None, "jobs": 2}
    assert json.loads(finished["stage_times"]) == {"circuits": 0.5}
    names = ["grid", "n", "target", "keep", "until", "panel", *schema.FUNNEL_COLUMNS, "batches_done", "batches_reused"]
    assert [finished[name] for name in names] == [
        *("square", 24, "square:6x4", "two-stack", "twist", "50x40x6"),
        *(2**40, 37, 1, None, None, None, None, 3, 4),
    ]


def test_unknown_funnel_counts_are_a_mistake(database):
    with pytest.raises(KeyError, match="no funnel column"):
        finish_run(database, begin(database), {"square": 1}, {}, 0, 0)


def test_count_arrays(database):
    record(database, circuits(1, 5))
    assert count_arrays(database, WORK) == 3
    assert count_arrays(database, WorkKey("hex", 12, "hex:array1", "all")) == 1
    assert count_arrays(database, WorkKey("hex", 12, "hex:array9", "all")) == 0
    assert count_arrays(database, WorkKey("hex", 10, "", "all")) == 0
    assert count_arrays(database, WorkKey("square", 12, "", "all")) == 0


@given(st.lists(st.lists(st.integers(0, 12), max_size=8), max_size=5), st.data())
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_batches_store_each_circuit_once(tmp_path_factory, batches, data):
    with open_database(str(tmp_path_factory.mktemp("any") / "a.sqlite"), create=True) as database:
        run = begin(database)
        expected = {}
        for number, batch in enumerate(batches):
            until = data.draw(st.sampled_from(["circuits", "foldings", "twist"]))
            names = [f"hex:{k}" for k in dict.fromkeys(batch)]
            # Foldings follow from the circuit, as they do in truth.
            creases = [[int(name[4:]) % 6] if int(name[4:]) % 2 else [] for name in names] or [[]]
            twists = [[0] * len(c) for c in creases]
            record_batches(database, run, WORK, [(str(number), sample(names, until, creases, twists), RESULTS)])
            for name in names:
                known = expected.get(name, "circuits")
                latest = max(known, until, key=["circuits", "foldings", "twist"].index)
                expected[name] = latest
        stages = {name: [stage != "circuits", stage == "twist"] for name, stage in expected.items()}
        rows = select(database, columns="circuit,n_foldings,n_untwisted").rows
        assert {row[0]: [value is not None for value in row[1:]] for row in rows} == stages
        foldings = sum(int(name[4:]) % 2 for name, stage in expected.items() if stage != "circuits")
        assert len(select(database, view="foldings").rows) == foldings
        assert len(rows) == len(expected)
