"""Programs that count or list the Hamiltonian circuits of one array, each as a job for a process of its own.

A job takes the array and returns how many circuits and classes there are (None where it does not know the latter), how
many it listed, and two times: `build_s` until its data structure stands, `answer_s` for the number or for going through
the list.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from hcsearch_bench.peers.backtracker import hamiltonian_circuits
from hcsearch_bench.run.timing import Row, Stopwatch, repeated, timed
from hcsearch_bench.run.work_precision import OURS


@dataclass(frozen=True)
class Engine:
    """One program at one task, done by a job; `package` must be installed for it. `peer`: not our own."""

    name: str
    task: str
    job: Callable[..., Row]
    package: str = ""

    @property
    def peer(self) -> bool:
        """Whether it is another program."""
        return self.name != OURS

    @property
    def kind(self) -> str:
        """`count` or `list`: what it is compared in."""
        return self.task.split(":")[0]


def ours_count(grid: str, spec: str, repeats: int) -> Row:
    """Exact numbers by frontier states, and by Burnside up to symmetry."""
    from hcsearch.designs.grid import grid_named, parse_array
    from hcsearch.search.enumeration import count_array

    def run(spec: str = spec) -> Row:
        build, answer = Stopwatch(), Stopwatch()
        with build:
            array = parse_array(grid_named(grid), spec)
        with answer:
            numbers = count_array(array)
        return _row(build, answer, numbers.circuits, numbers.classes, None)

    run("p4x4")  # load the compiled kernels first
    return repeated(run, repeats)


def ours_masks(grid: str, spec: str, repeats: int) -> Row:
    """One circuit a class, as edge sets."""
    return _ours(grid, spec, repeats, words=False)


def ours_words(grid: str, spec: str, repeats: int) -> Row:
    """One circuit a class, as canonical step words."""
    return _ours(grid, spec, repeats, words=True)


def _ours(grid: str, spec: str, repeats: int, *, words: bool) -> Row:
    from hcsearch.designs.grid import grid_named, parse_array
    from hcsearch.search.enumeration import ArraySearch

    def run(spec: str = spec) -> Row:
        build, answer = Stopwatch(), Stopwatch()
        with build:
            search = ArraySearch(parse_array(grid_named(grid), spec))
            circuits = search.n_circuits
        order = search.group_order
        classes = copies = 0
        if words:
            for batch in timed(answer, search.batches()):
                classes += len(batch)
                copies += int((order // batch.symmetry).sum())
        else:
            for masks, symmetry in timed(answer, search.masks()):
                classes += len(masks)
                copies += int((order // symmetry).sum())
        if copies != circuits:
            raise AssertionError(f"{grid} {spec}: the classes hold {copies} circuits, but there are {circuits}")
        return _row(build, answer, circuits, classes, classes)

    run("p4x4")  # load the compiled kernels first
    return repeated(run, repeats)


def graphillion_count(grid: str, spec: str, repeats: int) -> Row:
    """The number of circuits from Graphillion's zero-suppressed decision diagram."""
    return _graphillion(grid, spec, repeats, listing=False)


def graphillion_list(grid: str, spec: str, repeats: int) -> Row:
    """Every circuit from Graphillion's zero-suppressed decision diagram."""
    return _graphillion(grid, spec, repeats, listing=True)


def _graphillion(grid: str, spec: str, repeats: int, *, listing: bool) -> Row:
    from graphillion import GraphSet

    _, edges = _graph(grid, spec)

    def run() -> Row:
        build, answer = Stopwatch(), Stopwatch()
        with build:
            # row by row; its default order, 'greedy', took up to forty times longer on these arrays
            GraphSet.set_universe(edges, traversal="as-is")
            cycles = GraphSet.cycles(is_hamilton=True)
        with answer:
            circuits = _length(cycles) if listing else int(cycles.len())
        return _row(build, answer, circuits, None, circuits if listing else None)

    return repeated(run, repeats)


def networkx_list(grid: str, spec: str, repeats: int) -> Row:
    """The longest among networkx's simple cycles; it has no search for Hamiltonian ones."""
    import networkx as nx

    n, edges = _graph(grid, spec)

    def run() -> Row:
        build, answer = Stopwatch(), Stopwatch()
        with build:
            graph = nx.Graph(edges)
        with answer:
            circuits = _length(cycle for cycle in nx.simple_cycles(graph) if len(cycle) == n)
        return _row(build, answer, circuits, None, circuits)

    return repeated(run, repeats)


def backtracker_list(grid: str, spec: str, repeats: int) -> Row:
    """Every circuit by backtracking in plain Python."""
    n, edges = _graph(grid, spec)

    def run() -> Row:
        answer = Stopwatch()
        with answer:
            circuits = _length(hamiltonian_circuits(n, edges))
        return _row(Stopwatch(), answer, circuits, None, circuits)

    return repeated(run, repeats)


def _graph(grid: str, spec: str) -> tuple[int, list[tuple[int, int]]]:
    from hcsearch.designs.grid import grid_named, parse_array

    array = parse_array(grid_named(grid), spec)
    return array.n, [(u, v) for u, v, _ in array.edges()]


def _length(items: Iterable[object]) -> int:
    return sum(1 for _ in items)


def _row(build: Stopwatch, answer: Stopwatch, circuits: int, classes: int | None, listed: int | None) -> Row:
    return {
        "circuits": circuits,
        "classes": classes,
        "listed": listed,
        "build_s": build.cpu,
        "answer_s": answer.cpu,
        "wall_s": build.wall + answer.wall,
    }


ENGINES = (
    Engine(OURS, "count", ours_count),
    Engine(OURS, "list: classes as edge sets", ours_masks),
    Engine(OURS, "list: classes as step words", ours_words),
    Engine("Graphillion", "count", graphillion_count, "graphillion"),
    Engine("Graphillion", "list: all as edges", graphillion_list, "graphillion"),
    Engine("networkx", "list: all as vertices", networkx_list, "networkx"),
    Engine("Python backtracker", "list: all as vertices", backtracker_list),
)
