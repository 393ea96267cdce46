"""A plain backtracker in Python: a simple reference, with the usual pruning rule only."""

from __future__ import annotations

from collections.abc import Iterator


def hamiltonian_circuits(n: int, edges: list[tuple[int, int]]) -> Iterator[tuple[int, ...]]:
    """Every Hamiltonian circuit once, as its vertices in order.

    A vertex that is not yet on the path needs two neighbours that are off the path or at one of its ends.
    """
    neighbours: list[list[int]] = [[] for _ in range(n)]
    for u, v in edges:
        neighbours[u].append(v)
        neighbours[v].append(u)
    free = [len(around) for around in neighbours]
    start = free.index(min(free))
    visited = [False] * n
    visited[start] = True
    path = [start]

    def walk(head: int) -> Iterator[tuple[int, ...]]:
        if len(path) == n:
            # both directions are walked; keep one
            if start in neighbours[head] and path[1] < head:
                yield tuple(path)
            return
        for to in neighbours[head]:
            if visited[to]:
                continue
            left = [] if head == start else [w for w in neighbours[head] if w != to and not visited[w]]
            for w in left:
                free[w] -= 1
            if all(free[w] >= 2 for w in left):
                visited[to] = True
                path.append(to)
                yield from walk(to)
                path.pop()
                visited[to] = False
            for w in left:
                free[w] += 1

    if min(free) >= 2:
        yield from walk(start)
