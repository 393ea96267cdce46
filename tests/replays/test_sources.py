import math
import shutil
import zlib

import numpy as np
import pytest

from hcsearch.basics.errors import HcsearchError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.grid import GRIDS, parse_array
from hcsearch.search.enumeration import ArraySearch
from hcsearch.search.pipeline import Plan, run_into
from hcsearch.springs.drive import driven_folding
from hcsearch.store import open_database, open_readonly, schema, select
from hcsearch.subjects.replay_sources import stored_replays
from hcsearch.subjects.resolve import resolve

MOVES, STUCK, TWISTED, ASSEMBLY = "hex:0234550132:4", "hex:0234451512:0", "hex:02334051:0", "thesis-4x4"


@pytest.fixture(scope="module")
def searched(tmp_path_factory):
    """A database of the array 3-4-3 of hexagons, in which the foldings of one design have paths."""
    path = str(tmp_path_factory.mktemp("replays") / "designs.sqlite")
    with open_database(path, create=True) as database:
        run_into(Plan(ArraySearch(parse_array(GRIDS["hex"], "3-4-3")), "motion"), database)
    return path


def replays_in(path: str):
    with open_readonly(path) as database:
        rows = select(database, "untwisted", columns="id,circuit").rows
        circuits = {int(number): Circuit.from_notation(name) for number, name in rows}
        return circuits, list(stored_replays(database, circuits))


def test_stored_paths_are_replayed_as_they_were_planned(searched):
    circuits, replays = replays_in(searched)
    names = [f"{circuits[path.design_id].notation}:{path.crease}" for path, _ in replays]
    assert names == ["hex:0234550132:3", MOVES]
    for name, (path, replay) in zip(names, replays, strict=True):
        planned = resolve(name, "none.sqlite", path=True).replay("path")[0]
        assert replay.at == pytest.approx(planned.at, abs=1e-12)
        assert replay.angles == pytest.approx(planned.angles, abs=1e-12)
        assert replay.angles[[0, -1]] == pytest.approx(path.states[[0, -1]])
        assert replay.margin == pytest.approx(1e-3 * path.needed_margin)
        for field in ("labels", "axis", "certified", "collision", "title", "source"):
            assert getattr(replay, field) == getattr(planned, field)


def test_the_path_of_a_design_named_by_its_id_is_the_stored_one(searched, tmp_path, monkeypatch):
    class PlannedError(Exception):
        pass

    def planning(*_):
        raise PlannedError

    monkeypatch.setattr(driven_folding, "find_drive_motion", planning)
    for path, stored in replays_in(searched)[1]:
        name = f"{path.design_id}:{path.crease}"
        assert resolve(name, searched).replay()[0].angles.tolist() == stored.angles.tolist()
        assert resolve(name, searched, scene="default", path=True).replay("path")[0].source == stored.source
        for other in ({"panel": "60x8"}, {"scene": "earth"}, {"flat_pairs": "merged"}, {"values": {"held": "free"}}):
            with pytest.raises(PlannedError):
                resolve(name, searched, **other, path=True).replay("path")[0]
        with pytest.raises(PlannedError):
            resolve(name, change(searched, tmp_path, flat_pairs=None, needed_margin=None), path=True).replay("path")[0]


def test_designs_and_scenes_without_paths_have_no_replays(searched):
    with open_readonly(searched) as database:
        assert list(stored_replays(database, {})) == []
        (still,) = select(database, "circuit=hex:0234451512", columns="id").rows[0]
        assert list(stored_replays(database, {still: Circuit.from_notation("hex:0234451512")})) == []
        with pytest.raises(HcsearchError, match="no scene 'moon'"):
            list(stored_replays(database, {}, "moon"))


def test_a_path_without_a_proof_has_the_linkage_that_its_hinges_say(searched, tmp_path):
    path = change(searched, tmp_path, flat_pairs=None, needed_margin=None)
    for (stored, replay), (_, proved) in zip(replays_in(path)[1], replays_in(searched)[1], strict=True):
        assert stored.way is None
        assert replay.certified == ()
        assert replay.labels == proved.labels
        assert replay.angles.tolist() == proved.angles.tolist()


def change(file: str, folder, **values) -> str:
    """A copy of a database in which all motions with a path have other values."""
    copy = str(shutil.copy(file, folder))
    with open_database(copy, create=False) as database, database.engine.begin() as connection:
        connection.execute(schema.motion.update().where(schema.motion.c.path.is_not(None)).values(values))
    return copy


@pytest.mark.parametrize(
    ("packed", "message"),
    [
        (b"no path", "is damaged: a path cannot be read"),
        (zlib.compress(b"1234567"), "is damaged: a path cannot be read"),
        (zlib.compress(np.full(20, math.nan).tobytes()), "is damaged: a path cannot be read"),
        (zlib.compress(np.zeros((2, 7), "<f8").tobytes()), "has 7 hinges, as no linkage of it"),
    ],
)
def test_a_damaged_path_is_reported_in_one_line_with_the_remedy(searched, tmp_path, packed, message):
    with pytest.raises(HcsearchError, match=message) as caught:
        replays_in(change(searched, tmp_path, path=packed, states=2))
    assert "restore a copy, or enumerate anew" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_folding_is_replayed_along_its_path_or_let_go_as_asked():
    path, asked, springs = (
        resolve(MOVES, "none.sqlite", path=by == "path").replay(by)[0] for by in (None, "path", "springs")
    )
    assert path.source == asked.source
    assert path.angles.tolist() == asked.angles.tolist()
    assert (path.axis, springs.axis) == ("path", "time")
    assert springs.source.startswith("simulated in the scene 'default', loops closed exactly: flat after 0.14")
    assert path.title == springs.title == MOVES


@pytest.mark.parametrize(("name", "reason"), [(TWISTED, "the folding is twisted"), (STUCK, "no path was found")])
def test_a_folding_without_a_path_is_let_go_and_refused_where_a_path_is_asked_for(name, reason):
    replay = resolve(name, "none.sqlite").replay()[0]
    assert (replay.axis, replay.title) == ("time", name)
    with pytest.raises(HcsearchError, match=reason):
        resolve(name, "none.sqlite", path=True).replay("path")[0]


def test_an_assembly_is_let_go_and_has_no_path():
    replay = resolve(ASSEMBLY, "none.sqlite").replay()[0]
    assert (replay.axis, replay.title) == ("time", ASSEMBLY)
    assert replay.angles.shape[1] == replay.linkage.n_hinges
    with pytest.raises(HcsearchError, match="is an assembly, for which no path is planned: ask for --motion springs"):
        resolve(ASSEMBLY, "none.sqlite", path=True).replay("path")[0]
