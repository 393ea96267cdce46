"""Tables of motions, and graphs of arrays: what pandas and networkx read back."""

import json
import re
from io import BytesIO, StringIO

import networkx as nx
import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings

from hcsearch.basics.errors import OutputError
from hcsearch.export.exported import Exported
from hcsearch.export.formats import export_format_of
from hcsearch.scenes import Scene
from hcsearch.subjects.design_cases import CircuitCase
from tests.collision.naive_distances import feature_distance
from tests.export.exports import MOVING, exported, written
from tests.strategies import circuits


def test_the_table_of_a_path_reads_back_to_the_last_digit():
    value = exported(MOVING, "csv")
    table = pd.read_csv(StringIO(written(value, "csv")), dtype=str)  # pandas 2 reads numbers to 15 digits
    motion = value.motion
    hinges = [f"angle_{label}_rad" for label in value.labels.hinges]
    assert list(table) == ["path_share", *hinges, "gap_mm", "nearest", "touching"]
    np.testing.assert_array_equal(table["path_share"].astype(float), motion.at)
    np.testing.assert_array_equal(table[hinges].astype(float), motion.angles)
    assert table["touching"].iloc[[0, -1]].astype(int).min() > 3  # packed and flat panels do


@pytest.mark.extra
def test_a_table_in_parquet_is_that_in_csv():
    value = exported(MOVING, "csv")
    table = pd.read_parquet(BytesIO(written(value, "parquet")))
    pd.testing.assert_frame_equal(table, value.motion.table(), check_dtype=False)


def test_the_table_of_a_deployment_has_its_times():
    value = exported("thesis-4x4", "csv", by="springs")
    table = value.motion.table()
    assert next(iter(table)) == "time_s"
    np.testing.assert_array_equal(table["time_s"], value.motion.at)
    assert not table["gap_mm"].isna().any()


def test_gaps_are_those_of_the_nearest_panels():
    value = exported(MOVING, "csv")
    linkage, panel_of = value.linkage, value.linkage.pattern.panel_of
    table, number = value.motion.table(), {label: k for k, label in enumerate(value.labels.panels)}
    looked_at = 0
    for angles, gap, names in zip(value.motion.angles, table["gap_mm"], table["nearest"], strict=True):
        solids = [solid.reshape(-1, 3) for solid in linkage.solids(angles)]
        own = [
            [solid for solid, panel in zip(solids, panel_of, strict=True) if panel == number[name]]
            for name in names.split(" ")
        ]
        if gap > 0.0:
            nearest = min(feature_distance(a, b) for a in own[0] for b in own[1])
            assert gap == pytest.approx(1e3 * nearest, abs=1e-6)
            looked_at += 1
    assert looked_at > 3


@given(circuits())
@settings(max_examples=40)
def test_graphs_are_those_of_the_array_whatever_reads_them(circuit):
    case = CircuitCase(name=circuit.notation, scene=Scene(), given=circuit, foldings=())
    value = Exported(circuit.notation, case)
    ours = circuit.array.graph()
    data = json.loads(written(value, "networkx"))
    graph = nx.node_link_graph(data, edges="edges")
    small = nx.from_graph6_bytes(written(value, "graph6").strip())
    assert nx.is_isomorphic(graph, ours)
    assert set(map(frozenset, small.edges)) == set(map(frozenset, graph.edges))
    creases = {d["crease"]: frozenset((a, b)) for a, b, d in graph.edges(data=True) if d["kind"] == "crease"}
    assert creases == {k: frozenset((k, (k + 1) % circuit.n)) for k in range(circuit.n)}
    assert [tuple(cell) for _, cell in sorted(graph.nodes(data="cell"))] == list(circuit.cells)


@pytest.mark.parametrize(("gone", "instead"), [("sparse6", ".g6"), ("edgelist", ".json")])
def test_a_format_that_is_written_no_more_names_another(gone, instead):
    ending = {"sparse6": "s6"}.get(gone, gone)
    said = rf"is written no more: a file {re.escape(instead)} holds the same graph$"
    with pytest.raises(OutputError, match=f"^{gone} {said}"):
        export_format_of(f"array.{ending}", gone)
    with pytest.raises(OutputError, match=rf"^\.{ending} {said}"):
        export_format_of(f"array.{ending}")


def test_the_graph_of_a_folding_has_its_folds_and_one_of_an_assembly_its_hinges():
    graph = nx.node_link_graph(json.loads(written(exported(MOVING, "networkx"), "networkx")), edges="edges")
    folds = {d["crease"]: d["fold"] for _, _, d in graph.edges(data=True) if d["kind"] == "crease"}
    assert [folds[k] for k in range(10)] == list(exported(MOVING).case.folding.assignment)
    unit = exported("unit-ii", "networkx")
    graph = nx.node_link_graph(json.loads(written(unit, "networkx")), edges="edges")
    hinges = {d["hinge"] for _, _, d in graph.edges(data=True) if d["kind"] == "crease"}
    assert hinges == set(range(unit.linkage.n_hinges))
    rigid = nx.Graph((a, b) for a, b, d in graph.edges(data=True) if d["kind"] == "rigid")
    panels = nx.get_node_attributes(graph, "panel")
    assert all(panels[a] == panels[b] for a, b in rigid.edges)
