"""Panels, creases and slits as a graph in JSON, which `networkx.node_link_graph` reads."""

from __future__ import annotations

import json

from hcsearch.export.exported import Exported
from hcsearch.export.settings import Settings
from hcsearch.export.tables.graphs import graph_of


def write(exported: Exported, settings: Settings) -> str:
    """The graph in node-link form, an item a line."""
    del settings
    data = graph_of(exported)
    lists = {name: ",\n  ".join(json.dumps(item) for item in data.pop(name)) for name in ("nodes", "edges")}
    head = "".join(f" {json.dumps(name)}: {json.dumps(value)},\n" for name, value in data.items())
    return "{\n" + head + ",\n".join(f' "{name}": [\n  {text}\n ]' for name, text in lists.items()) + "\n}\n"
