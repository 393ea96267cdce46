"""Half-chains, the halves of circuits that fold, listed by their last place and exit.

A half-chain is the part of a circuit between the two flat creases of a folding: h + 1 panels, h = n / 2 - 1, walked
outward from the first crease. Its first panel is at home, and the crease is the least edge of its class there. The
panel on the other side of the crease begins the other half-chain, which is the mirror image, in the crease, of one that
starts at home. The turns of a half-chain are letters, sharpest left first, packed into one integer, its code.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import Bitsets, Integers16, WholeNumbers
from hcsearch.kernels.circuits.step_tables import StepTables, turn_moves
from hcsearch.kernels.compiling.compiled import compiled

UNREACHED_DISTANCE = 32767


class Plane(NamedTuple):
    """The region of the tiling around home that two half-chains can reach.

    steps : of the tiling. moves : increment of the place number for each step.
    bits : bits per letter in a code.
    kinds : kind of the cell at each place. distance : steps from home to each place, `UNREACHED_DISTANCE` beyond reach.
    reach : places within h steps of home.
    home : the first panel. crease : the step from it across the first crease.
    classes : class of the edge that each step crosses. reflected : whether a reflection alone takes a step to the least
        one of its class. mirror : image of each place in the first crease, home where it is out of the region.
        mirror_steps : of each step.
    h : steps of a half-chain.
    """

    steps: StepTables
    moves: WholeNumbers
    bits: int
    kinds: NDArray[np.uint8]
    distance: Integers16
    reach: WholeNumbers
    home: int
    crease: int
    classes: WholeNumbers
    reflected: NDArray[np.bool_]
    mirror: WholeNumbers
    mirror_steps: WholeNumbers
    h: int


class HalfChains(NamedTuple):
    """Half-chains of one key, grouped by the alternating sum of their turns.

    codes, reversed_codes : code of the chain, and of the chain walked from its end.
    sums : alternating sum of turns, the first with a plus.
    steps : shape (n_chains, h).
    masks : shape (words, n_chains), bit sets of the occupied cells that the other half-chain can reach.
    flat_bit_planes : shape (4, n_chains), of h numbers below `directions`: crease k is flat in another folding if the
              numbers of the first and the second half-chain are equal.
    crease_sets : shape (3, n_chains), of first half-chains: creases of a lower class, of the class of the first crease,
              and those beyond which a panel must be reflected to be at home.
    """

    codes: Bitsets
    reversed_codes: Bitsets
    sums: Integers16
    steps: NDArray[np.int8]
    masks: Bitsets
    flat_bit_planes: Bitsets
    crease_sets: Bitsets


@compiled
def _walk(
    plane: Plane,
    exit_face: int,
    toward: Integers16,
    bit: Integers16,
    blocked: NDArray[np.uint8],
    sizes: WholeNumbers,
    chains: HalfChains,
) -> int:
    """Enumerate the half-chains that start at home, in ascending order of their codes; return their number.

    toward : steps from a place to the required end of the walk, `UNREACHED_DISTANCE` for forbidden places.
    exit_face : step by which the walk must leave, or -1 for any; then chains are only counted, in `sizes`, shape
                (places, steps), by last place and exit.
    bit : bit of each place in a mask, -1 for none.
    """
    steps, moves, h, home = plane.steps, plane.moves, plane.h, plane.home
    n_turns = steps.following.shape[1]
    offsets = turn_moves(steps, moves)
    words = len(chains.masks)
    letters = np.zeros(h + 1, np.int64)
    heading = np.zeros(h + 1, np.int64)
    face = np.zeros(h + 1, np.int64)
    total = np.zeros(h + 1, np.int64)
    place = np.zeros(h + 1, np.int64)
    code = np.zeros(h + 1, np.uint64)
    mask = np.zeros((h + 1, words), np.uint64)
    width = np.uint64(plane.bits)
    one = np.uint64(1)
    written = 0
    heading[0] = steps.back[plane.crease]
    face[0] = plane.crease
    place[0] = home
    letters[0] = -1
    blocked[home] = 1
    if exit_face >= 0 and bit[home] >= 0:
        mask[0, bit[home] >> 6] |= one << np.uint64(bit[home] & 63)
    k = 0
    while k >= 0:
        letter = letters[k] + 1
        letters[k] = letter
        if letter == n_turns:
            blocked[place[k]] = 0
            k -= 1
            continue
        before = np.uint64(heading[k])
        to = place[k] + offsets[before, np.uint64(letter)]
        if toward[to] > h - 1 - k or blocked[to] != 0:
            continue
        d = np.uint64(steps.following[before, np.uint64(letter)])
        turn = steps.turns[before, np.uint64(letter)]
        r = steps.carried[d, np.uint64(face[k])]  # the first crease, carried across this one
        if k + 1 < h:
            code[k + 1] = (code[k] << width) | np.uint64(letter)
            total[k + 1] = total[k] + (turn if k % 2 == 0 else -turn)
            k += 1
            heading[k] = d
            place[k] = to
            face[k] = r
            letters[k] = -1
            blocked[to] = 1
            if exit_face >= 0:
                for w in range(words):
                    mask[k, w] = mask[k - 1, w]
                if bit[to] >= 0:
                    mask[k, bit[to] >> 6] |= one << np.uint64(bit[to] & 63)
            continue
        if r == steps.back[d]:  # back through the last crease
            continue
        if exit_face < 0:
            if blocked[to + moves[r]] == 0:
                sizes[to, r] += 1
                written += 1
            continue
        if r != exit_face:
            continue
        last = steps.codes[d, r] - steps.first_codes[d]
        leaving = steps.turns[d, last]
        reverse = np.uint64(n_turns - 1 - last)
        for t in range(h - 1, 0, -1):
            reverse = (reverse << width) | np.uint64(n_turns - 1 - letters[t])
        chains.codes[written] = (code[k] << width) | np.uint64(letter)
        chains.reversed_codes[written] = reverse
        chains.sums[written] = total[k] + (turn if k % 2 == 0 else -turn) + (leaving if h % 2 == 0 else -leaving)
        for t in range(1, h):
            chains.steps[written, t - 1] = heading[t]
        chains.steps[written, h - 1] = d
        for w in range(words):
            chains.masks[w, written] = mask[h - 1, w]
        if bit[to] >= 0:
            chains.masks[bit[to] >> 6, written] |= one << np.uint64(bit[to] & 63)
        written += 1
    return written


@compiled
def _new_chains(n_chains: int, h: int, words: int) -> HalfChains:
    return HalfChains(
        np.empty(n_chains, np.uint64),
        np.empty(n_chains, np.uint64),
        np.empty(n_chains, np.int16),
        np.empty((n_chains, h), np.int8),
        np.empty((words, n_chains), np.uint64),
        np.zeros((4, n_chains), np.uint64),
        np.zeros((3, n_chains), np.uint64),
    )


@compiled
def count_chains(plane: Plane, sizes: WholeNumbers) -> int:
    """Count half-chains by last place and exit into `sizes`, shape (places, steps); return their total."""
    toward = np.full(len(plane.distance), np.int16(0))
    blocked = np.zeros(len(plane.distance), np.uint8)
    blocked[plane.home + plane.moves[plane.crease]] = 1
    bit = np.empty(0, np.int16)
    return _walk(plane, -1, toward, bit, blocked, sizes, _new_chains(0, plane.h, 1))


@compiled
def _distances_to(plane: Plane, end: int) -> Integers16:
    """Return the steps from each place to another place, over places within h steps of home."""
    distances = np.full(len(plane.distance), np.int16(UNREACHED_DISTANCE))
    queue = np.empty(len(plane.reach), np.int64)
    queue[0] = end
    distances[end] = 0
    first, last = 0, 1
    while first < last:
        place = queue[first]
        first += 1
        for step in plane.steps.leaving[plane.kinds[place]]:
            to = place + plane.moves[step]
            if plane.distance[to] <= plane.h and distances[to] == UNREACHED_DISTANCE:
                distances[to] = distances[place] + 1
                queue[last] = to
                last += 1
    return distances


@compiled
def _chains_of_key(
    plane: Plane, end: int, exit_face: int, n_chains: int, bit: Integers16, words: int, distances: Integers16
) -> HalfChains:
    """Return the half-chains of one key; distances : from each place to its end."""
    size = len(plane.distance)
    toward = np.full(size, np.int16(UNREACHED_DISTANCE))
    blocked = np.zeros(size, np.uint8)
    for place in plane.reach:
        if plane.distance[place] + distances[place] <= plane.h:
            toward[place] = distances[place]
    blocked[plane.home + plane.moves[plane.crease]] = 1
    blocked[end + plane.moves[exit_face]] = 1
    chains = _new_chains(n_chains, plane.h, words)
    _walk(plane, exit_face, toward, bit, blocked, np.empty((0, 0), np.int64), chains)
    return chains


@compiled
def _mirror_chains(plane: Plane, chains: HalfChains) -> None:
    """Reflect half-chains in the first crease, across which they start then."""
    flips = mirror_code(plane)
    for i in range(len(chains.codes)):
        chains.codes[i] = flips - chains.codes[i]
        chains.reversed_codes[i] = flips - chains.reversed_codes[i]
        chains.sums[i] = -chains.sums[i]
        for k in range(plane.h):
            chains.steps[i, k] = plane.mirror_steps[chains.steps[i, k]]


@compiled
def mirror_code(plane: Plane) -> np.uint64:
    """Return the code from which a code is subtracted to give that of the mirror image."""
    flips = np.uint64(0)
    for _ in range(plane.h):
        flips = (flips << np.uint64(plane.bits)) | np.uint64(plane.steps.following.shape[1] - 1)
    return flips


@compiled
def _fill_bit_planes(plane: Plane, chains: HalfChains, mate: bool) -> None:
    """Fill `flat_bit_planes` for first half-chains, or for their mates.

    Crease k of the first half-chain is flat when the alternating sums of its first k turns and of the second one's
    first h + 1 - k, both with a plus for the first turn, add up to (h + 1) m / 2, mod m
    (docs/explanation/theory.md, 23).
    """
    n_chains, h = chains.steps.shape
    directions, directed = plane.steps.directions, plane.steps.directed
    goal = (h + 1) * (directions // 2) % directions
    into = directed[plane.crease if mate else plane.steps.back[plane.crease]]
    count = bit_plane_count(plane)
    for i in range(n_chains):
        before = into
        total = np.int64(0)
        for k in range(1, h + 1):
            d = directed[chains.steps[i, k - 1]]
            total += d - before if k % 2 == 1 else before - d
            before = d
            u = total % directions
            crease = np.uint64(k)
            if mate:
                u = (goal - u) % directions
                crease = np.uint64(h + 1 - k)
            for p in range(count):
                chains.flat_bit_planes[p, i] |= np.uint64((u >> p) & 1) << crease


@compiled
def _fill_crease_sets(plane: Plane, chains: HalfChains) -> None:
    """Fill `crease_sets`."""
    one = np.uint64(1)
    if plane.classes.max() == 0 and not plane.reflected.any():
        chains.crease_sets[1] = (one << np.uint64(plane.h + 1)) - np.uint64(2)  # bits 1 .. h
        return
    for i in range(len(chains.codes)):
        for k in range(plane.h):
            step = chains.steps[i, k]
            crease = one << np.uint64(k + 1)
            if plane.classes[step] < plane.classes[plane.crease]:
                chains.crease_sets[0, i] |= crease
            if plane.classes[step] == plane.classes[plane.crease]:
                chains.crease_sets[1, i] |= crease
            if plane.reflected[plane.steps.back[step]]:
                chains.crease_sets[2, i] |= crease


@compiled
def _grouped(chains: HalfChains, starts: WholeNumbers, offset: int) -> HalfChains:
    """Sort chains by their sums; those of sum s are at starts[s + offset] .. starts[s + offset + 1] - 1."""
    n_chains = len(chains.codes)
    starts[:] = 0
    for s in chains.sums:
        starts[s + offset + 1] += 1
    for i in range(1, len(starts)):
        starts[i] += starts[i - 1]
    free = starts.copy()
    ordered = _new_chains(n_chains, chains.steps.shape[1], len(chains.masks))
    for i in range(n_chains - 1, -1, -1):  # mirror images of ascending codes descend
        to = free[chains.sums[i] + offset]
        free[chains.sums[i] + offset] += 1
        ordered.codes[to] = chains.codes[i]
        ordered.reversed_codes[to] = chains.reversed_codes[i]
        ordered.sums[to] = chains.sums[i]
        ordered.steps[to] = chains.steps[i]
        ordered.masks[:, to] = chains.masks[:, i]
    return ordered


@compiled
def list_chains(plane: Plane, key: WholeNumbers) -> tuple[HalfChains, HalfChains, WholeNumbers]:
    """Return the half-chains of a key, their possible mates sorted by sums, and the start of each sum among these.

    Mates start across the first crease. Those of sum s are at starts[s + offset] .. starts[s + offset + 1] - 1, with
    the offset of `sum_offset`.

    key : last place and exit of the first half-chains, their number, and the number of mates.
    """
    end, face = key[0], key[1]
    # the mates' mirror images, which start at home
    mate_end, mate_face = plane.mirror[end + plane.moves[face]], plane.mirror_steps[plane.steps.back[face]]
    distances, mate_distances = _distances_to(plane, end), _distances_to(plane, mate_end)
    h = plane.h
    bits, mate_bits = np.full(len(plane.distance), np.int16(-1)), np.full(len(plane.distance), np.int16(-1))
    n_bits = 0
    for place in plane.reach:
        mate_place = plane.mirror[place]
        if plane.distance[place] + distances[place] > h or plane.distance[mate_place] > h:
            continue
        if plane.distance[mate_place] + mate_distances[mate_place] <= h:
            bits[place] = n_bits
            mate_bits[mate_place] = n_bits
            n_bits += 1
    n_words = max(1, (n_bits + 63) // 64)
    first = _chains_of_key(plane, end, face, key[2], bits, n_words, distances)
    _fill_bit_planes(plane, first, False)
    _fill_crease_sets(plane, first)
    offset = sum_offset(plane)
    starts = np.zeros(2 * offset + 2, np.int64)
    mates = _chains_of_key(plane, mate_end, mate_face, key[3], mate_bits, n_words, mate_distances)
    _mirror_chains(plane, mates)
    second = _grouped(mates, starts, offset)
    _fill_bit_planes(plane, second, True)
    return first, second, starts


@compiled
def bit_plane_count(plane: Plane) -> int:
    """Return the number of bits of a direction."""
    return 2 if plane.steps.directions == 4 else 3 if plane.steps.directions <= 8 else 4


@compiled
def sum_offset(plane: Plane) -> int:
    """Return a bound of the absolute sum of turns of a half-chain."""
    return plane.steps.directions // 2 * (plane.h + 1)
