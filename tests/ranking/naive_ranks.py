"""Obvious twins of the Pareto front and the score; None is a missing value."""

import math


def dominates(a, b, better):
    """Whether row a is no worse than row b in every criterion, and better in one."""

    def grade(value, way):
        return (0, 0) if value is None else (1, value if way == "higher" else -value)

    pairs = [(grade(x, way), grade(y, way)) for x, y, way in zip(a, b, better, strict=True)]
    return all(x >= y for x, y in pairs) and any(x > y for x, y in pairs)


def front(rows, better):
    """Rows that no row dominates, by comparing all pairs."""
    return [not any(dominates(other, row, better) for other in rows) for row in rows]


def score(row, weights, better, halves):
    """The weighted mean of x / (x + half), or of half / (x + half) where lower is better; 0 for None."""

    def worth(x, way, half):
        if x is None:
            return 0.0
        x = max(x, 0.0)
        return x / (x + half) if way == "higher" else half / (x + half)

    worths = [worth(x, way, half) for x, way, half in zip(row, better, halves, strict=True)]
    return math.fsum(w * u for w, u in zip(weights, worths, strict=True)) / math.fsum(weights)
