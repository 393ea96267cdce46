"""The graph of an array: which panels are neighbours, and what joins them."""

from __future__ import annotations

from typing import Any

from hcsearch.export.exported import Exported
from hcsearch.pattern import Pair


def graph_of(exported: Exported) -> dict[str, Any]:
    """Nodes and edges as plain data, in networkx's node-link form (`networkx.node_link_graph(data, edges="edges")`).

    Nodes are the panels of a design, by their numbers in the circuit, with their cells; or the facets of an assembly,
    with their panels. Edges say what joins two neighbours: `crease` or `slit`, the number of a crease, its fold.
    """
    head = {"name": exported.name}
    if exported.circuit is None:
        nodes, edges = _of_pattern(exported)
    else:
        head["array"] = exported.circuit.array.canonical().notation
        nodes, edges = _of_circuit(exported)
    return {"directed": False, "multigraph": False, "graph": head, "nodes": nodes, "edges": edges}


def neighbours(exported: Exported) -> tuple[int, list[Pair]]:
    """The number of panels (facets, of an assembly), and the pairs that share an edge."""
    circuit = exported.circuit
    if circuit is None:
        pattern = exported.case.linkage.pattern
        return len(pattern.facets), sorted(pattern.edges)
    number = {point: k for k, point in enumerate(circuit.points)}
    pairs = {
        (k, number[to])
        for k, point in enumerate(circuit.points)
        for _, to in circuit.grid.neighbours(point)
        if number.get(to, -1) > k
    }
    return circuit.n, sorted(pairs)


def _of_circuit(exported: Exported) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    circuit, folding = exported.circuit, exported.folding
    assert circuit is not None
    n, pairs = neighbours(exported)
    nodes = [{"id": k, "cell": list(cell)} for k, cell in enumerate(circuit.cells)]
    edges = []
    for i, j in pairs:
        edge: dict[str, Any] = {"source": i, "target": j, "kind": "slit"}
        if j - i in (1, n - 1):
            crease = i if j - i == 1 else j
            edge |= {"kind": "crease", "crease": crease}
            if folding is not None:
                edge["fold"] = folding.assignment[crease]
        edges.append(edge)
    return nodes, edges


def _of_pattern(exported: Exported) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    pattern = exported.case.linkage.pattern
    count, pairs = neighbours(exported)
    nodes = [{"id": k, "panel": pattern.panel_of[k]} for k in range(count)]
    edges = []
    for pair in pairs:
        edge: dict[str, Any] = {"source": pair[0], "target": pair[1], "kind": "slit"}
        crease = pattern.creases.get(pair)
        if crease is not None:
            edge["kind"] = "rigid"
            if crease.face is not None:
                edge |= {"kind": "crease", "fold": crease.fold, "hinge": pattern.hinge_of(pair)}
        edges.append(edge)
    return nodes, edges
