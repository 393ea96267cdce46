"""A whole search of a box, which the package only makes in parts."""

from hcsearch.kernels.enclosure.refutation import (
    BOX_OPEN,
    BOX_UNFINISHED,
    REFUTATION_TESTED_BOXES,
    continue_refutation,
    start_refutation,
)


def refute_box(rings, low, high, max_boxes, work):
    """EMPTY, CLOSED or OPEN for a box, and the number of boxes used, up to `max_boxes`."""
    start_refutation(rings, low, high, work)
    verdict = continue_refutation(rings, max_boxes, work)
    return BOX_OPEN if verdict == BOX_UNFINISHED else verdict, work.counts[REFUTATION_TESTED_BOXES]
