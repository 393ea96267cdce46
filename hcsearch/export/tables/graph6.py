"""Which panels are neighbours, in the graph6 format of nauty, as the tables of graphs have it."""

from __future__ import annotations

from hcsearch.export.exported import Exported
from hcsearch.export.settings import Settings
from hcsearch.export.tables.graphs import neighbours


def write(exported: Exported, settings: Settings) -> bytes:
    """One line without a header; vertices are the panels in the order of the circuit."""
    import networkx as nx  # noqa: PLC0415 - only this format needs it

    del settings
    count, pairs = neighbours(exported)
    graph = nx.Graph()
    graph.add_nodes_from(range(count))
    graph.add_edges_from(pairs)
    line: bytes = nx.to_graph6_bytes(graph, nodes=range(count), header=False)
    return line
