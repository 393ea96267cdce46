"""Reports to look at: real designs as rows of the views, and a database that holds them."""

from __future__ import annotations

from pathlib import Path

import pytest

from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import foldings
from hcsearch.designs.grid import GRIDS, parse_array
from hcsearch.designs.twisting import twist
from hcsearch.scenes import Scene
from hcsearch.search.enumeration import ArraySearch, PolygonSearch, enumerate_circuits
from hcsearch.search.pipeline import Plan, run_into
from hcsearch.store import open_database
from hcsearch.web.report.data import FunnelStage, ReportData


def design_row(number: int, circuit: Circuit) -> dict[str, object]:
    array = circuit.array.canonical()
    twists = [twist(folding) for folding in foldings(circuit)]
    return {
        "id": number,
        "grid": circuit.grid.name,
        "n": circuit.n,
        "array": array.notation,
        "circuit": circuit.notation,
        "array_symmetry": array.symmetry,
        "symmetry": circuit.symmetry,
        "orbit_size": circuit.orbit_size,
        "n_fixed": circuit.n_fixed,
        "n_foldings": len(twists),
        "two_stack": int(bool(twists)),
        "n_untwisted": twists.count(0),
        "untwisted": int(0 in twists),
        "min_twist": min(twists, default=None),
        "status": None if 0 in twists else "twisted" if twists else "no_folding",
    }


def folding_rows(number: int, circuit: Circuit) -> list[dict[str, object]]:
    return [
        {
            "design_id": number,
            "crease": folding.crease,
            "opposite": folding.opposite,
            "twist": twist(folding),
            "untwisted": int(twist(folding) == 0),
        }
        for folding in foldings(circuit)
    ]


@pytest.fixture(scope="session")
def hex_ten() -> ReportData:
    """Data of all 120 designs of ten hexagons."""
    circuits = list(enumerate_circuits("hex", n=10))
    designs = [design_row(number, circuit) for number, circuit in enumerate(circuits, 1)]
    return ReportData(
        title="Ten hexagons",
        meta=[("query", "grid=hex n=10")],
        funnel=[
            FunnelStage("fixed circuits", 1212),
            FunnelStage("two-stack", 32, 120),
            FunnelStage("movable", None, 120),
        ],
        census=[(0, None, 88), (1, 0, 32)],
        designs=designs,
        foldings={number: folding_rows(number, circuit) for number, circuit in enumerate(circuits, 1)},
        total=120,
    )


@pytest.fixture(scope="session")
def database_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Hexagons n = 8 (all), n = 10 (circuits alone); 4x4 rectangles of 60 x 30 (untwisted ones)."""
    path = tmp_path_factory.mktemp("report") / "designs.sqlite"
    four = ArraySearch(parse_array(GRIDS["rectangle"], "4x4"))
    with open_database(str(path), create=True) as database:
        run_into(Plan(PolygonSearch(GRIDS["hex"], 8), "twist"), database)
        run_into(Plan(PolygonSearch(GRIDS["hex"], 10), "circuits"), database)
        run_into(Plan(four, "twist", keep="untwisted", scene=Scene("flat", panel=(0.060, 0.030, 0.006))), database)
    return path
