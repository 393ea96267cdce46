"""The adjacency graph of an array, with the joint of each pair of neighbouring panels, as JSON or graph6."""

from __future__ import annotations

import json
from typing import Any

from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding
from hcsearch.shape.pattern import FacetPair, Pattern

GraphSubject = Folding | Circuit | Pattern
"""The subject of a graph: a folding, a circuit without assigned creases, or the pattern of an assembly."""
GraphItems = list[dict[str, Any]]


def node_link_json(name: str, array: GraphSubject) -> str:
    """Return the graph in networkx's node-link form (`networkx.node_link_graph(data, edges="edges")`), one item a line.

    Nodes are the panels of a design, numbered as in the circuit, with their cells; or the facets of an assembly, with
    their panels. Edges have a kind (`crease`, `rigid`, `slit`), and those of creases a number and a fold.
    """
    graph = {"name": name}
    if not isinstance(array, Pattern):
        circuit = array.circuit if isinstance(array, Folding) else array
        graph["array"] = circuit.array.canonical().notation
    nodes, edges = _items_of(array)
    facts = {"directed": False, "multigraph": False, "graph": graph}
    lines = [f' "{key}": {json.dumps(value)}' for key, value in facts.items()]
    for key, items in (("nodes", nodes), ("edges", edges)):
        listed = ",\n  ".join(json.dumps(item) for item in items)
        lines.append(f' "{key}": [\n  {listed}\n ]')
    return "{\n" + ",\n".join(lines) + "\n}\n"


def graph6_of(array: GraphSubject) -> bytes:
    """Return the graph in nauty's graph6 format, without a header; vertices are in the order of the circuit."""
    import networkx as nx  # noqa: PLC0415 - only this format needs it

    count, pairs = neighbouring_panels(array)
    graph = nx.Graph()
    graph.add_nodes_from(range(count))
    graph.add_edges_from(pairs)
    line: bytes = nx.to_graph6_bytes(graph, header=False)
    return line


def neighbouring_panels(array: GraphSubject) -> tuple[int, list[FacetPair]]:
    """Return the number of panels (facets, of an assembly), and the pairs that share an edge."""
    if isinstance(array, Pattern):
        return len(array.facets), sorted(array.edges)
    circuit = array.circuit if isinstance(array, Folding) else array
    number = {point: k for k, point in enumerate(circuit.points)}
    pairs = {
        (k, number[to])
        for k, point in enumerate(circuit.points)
        for _, to in circuit.grid.neighbours(point)
        if number.get(to, -1) > k
    }
    return circuit.n, sorted(pairs)


def _items_of(array: GraphSubject) -> tuple[GraphItems, GraphItems]:
    """Return the nodes and the edges with their attributes."""
    if isinstance(array, Pattern):
        return _of_pattern(array)
    return _of_circuit(array.circuit, array) if isinstance(array, Folding) else _of_circuit(array, None)


def _of_circuit(circuit: Circuit, folding: Folding | None) -> tuple[GraphItems, GraphItems]:
    n, pairs = neighbouring_panels(circuit)
    nodes: GraphItems = [{"id": k, "cell": list(cell)} for k, cell in enumerate(circuit.cells)]
    edges: GraphItems = []
    for i, j in pairs:
        edge: dict[str, Any] = {"source": i, "target": j, "kind": "slit"}
        if j - i in (1, n - 1):
            crease = i if j - i == 1 else j
            edge |= {"kind": "crease", "crease": crease}
            if folding is not None:
                edge["fold"] = folding.assignment[crease]
        edges.append(edge)
    return nodes, edges


def _of_pattern(pattern: Pattern) -> tuple[GraphItems, GraphItems]:
    count, pairs = neighbouring_panels(pattern)
    nodes: GraphItems = [{"id": k, "panel": pattern.panel_of[k]} for k in range(count)]
    edges: GraphItems = []
    for pair in pairs:
        edge: dict[str, Any] = {"source": pair[0], "target": pair[1], "kind": "slit"}
        crease = pattern.creases.get(pair)
        if crease is not None:
            edge["kind"] = "rigid"
            if crease.face is not None:
                edge |= {"kind": "crease", "fold": crease.fold, "hinge": pattern.hinge_of(pair)}
        edges.append(edge)
    return nodes, edges
