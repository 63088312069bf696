"""The outline of a part of the view that moved as a whole.

All rectangles are tried, and what grows of the best. Evidence is of the outline alone, everything else integrated, so
parameters and outline need not take turns. Half of the probability is for rectangles, all alike: images are cut along
their rows and columns, and what moves is often as wide as high. The other half has a price for each edge, what a closed
walk on a lattice takes to be told.
"""

from collections.abc import Iterable, Iterator
from functools import cache

import numpy as np
from jaxtyping import Bool, Float

from stereorecal.estimation._evidence import Normal
from stereorecal.estimation._groups import PLACES

# Pixels of row: what moves between two exposures, or while one is read, moves by a row or two; more finds no match.
MOVED = 1.5
_EDGE = 1.0  # nats: closed walks of n steps on a square lattice are about 2.64ⁿ many
_FEWEST = 4  # places inside, and outside: fewer are outliers
_RARER = 4  # power of the share that stood still: what moves covers a sixth of an image on average, hardly ever most
_STEPS = 60  # of single places that change sides
_ALIKE = 0.1  # of the places: outlines that differ by less are one
_KEPT = 2  # outlines: a region, and its rival


def outlines(
    several: Iterable[Normal], present: Bool[np.ndarray, "p"]
) -> list[tuple[float, Bool[np.ndarray, "p"], float]]:
    """The log evidence of the most probable outlines that differ, what moved on the one side or on the other, and the
    logarithm of the prior probability of each: rows alone cannot tell which side of an outline stood still; by
    likelihoods of offsets under priors of θ, of the places that have rows."""
    found = sorted((one for offsets in several for one in _searched(offsets, present)), key=lambda one: -one[0])
    chosen = []
    for log_evidence, log_prior, label in found:
        difference = [(label != one)[present].mean() for *_, one in chosen]
        if all(_ALIKE < share < 1.0 - _ALIKE for share in difference):
            chosen.append((log_evidence, log_prior, label))
    return [
        (log_evidence, side, log_prior + _RARER * float(np.log1p(-side.sum() / present.sum())))
        for log_evidence, log_prior, label in chosen[:_KEPT]
        for side in (label, present & ~label)
    ]


def _searched(offsets: Normal, present: Bool[np.ndarray, "p"]) -> Iterator[tuple[float, float, Bool[np.ndarray, "p"]]]:
    """Log evidence, log prior and outline: the best rectangle, the best one that the rest moved around, and what grows
    of both."""
    whole = present.astype(float)
    of_whole = offsets.a @ whole
    pull, stiff = _sums(offsets.b), _squares(offsets.a)
    log_prior = -float(np.log(2.0 * 2.0 * len(pull)))
    rest_pull, rest_stiff = offsets.b @ whole - pull, whole @ of_whole - 2.0 * _sums(of_whole) + stiff
    number = _sums(whole)
    fits = (number >= _FEWEST) & (number <= whole.sum() - _FEWEST)
    if not fits.any():
        return
    for gains, around in ((_gain(pull, stiff), False), (_gain(rest_pull, rest_stiff), True)):
        index = int(np.where(fits, gains, -np.inf).argmax())
        label = present & (_rectangle(index) != around)
        yield float(gains[index]) + log_prior, log_prior, label
        yield _grown(offsets, label, present)


def _gain(pull: Float[np.ndarray, "s"], stiff: Float[np.ndarray, "s"]) -> Float[np.ndarray, "s"]:
    """Log evidence of an offset of the places l over that of none, for bᵀl and lᵀ a l."""
    return 0.5 * pull**2 / (stiff + MOVED**-2.0) - 0.5 * np.log1p(MOVED**2 * np.maximum(stiff, 0.0))


def _grown(
    offsets: Normal, label: Bool[np.ndarray, "p"], present: Bool[np.ndarray, "p"]
) -> tuple[float, float, Bool[np.ndarray, "p"]]:
    """Single places change sides, the one that gains most first, while that helps."""
    side, adjacency = label.astype(float), _neighbours() * present * present[:, None]
    degree, own, log_evidence = adjacency.sum(axis=1), np.diag(offsets.a), -np.inf
    for _ in range(_STEPS):
        sign, al, inside = 1.0 - 2.0 * side, offsets.a @ side, adjacency @ side
        pull, stiff = offsets.b @ side + sign * offsets.b, side @ al + 2.0 * sign * al + own
        edges = side @ (degree - inside) + sign * (degree - 2.0 * inside)
        gains = _gain(pull, stiff) - _EDGE * edges
        number = side.sum() + sign
        gains[~present | (number < _FEWEST) | (number > present.sum() - _FEWEST)] = -np.inf
        p = int(gains.argmax())
        if not gains[p] > log_evidence:
            break
        log_evidence = float(gains[p])
        side[p] += sign[p]
    log_prior = -_EDGE * float(side @ (degree - adjacency @ side)) - float(np.log(2.0))
    return log_evidence - float(np.log(2.0)), log_prior, side > 0.5


# All rectangles: of each span of rows, all spans of columns.


@cache
def _spans(n: int) -> Float[np.ndarray, "m n"]:
    """All intervals of n numbers, 1 inside."""
    ends = [(i, j) for i in range(n) for j in range(i + 1, n + 1)]
    return np.array([(np.arange(n) >= i) & (np.arange(n) < j) for i, j in ends]).astype(float)


def _sums(values: Float[np.ndarray, "p"]) -> Float[np.ndarray, "s"]:
    """The sums of values inside of each rectangle."""
    across, down = map(_spans, PLACES)
    return (down @ values.reshape(len(down[0]), -1) @ across.T).ravel()


def _squares(a: Float[np.ndarray, "p p"]) -> Float[np.ndarray, "s"]:
    """lᵀ a l for each rectangle l."""
    (columns, rows), (across, down) = PLACES, map(_spans, PLACES)
    of_columns = a.reshape(rows, columns, rows, columns) @ across.T  # (rows, columns, rows, spans of columns)
    of_columns = np.einsum("yxzc,cx->cyz", of_columns, across)
    return np.einsum("cyd,dy->dc", of_columns @ down.T, down).ravel()


def _rectangle(index: int) -> Bool[np.ndarray, "p"]:
    """Which places are inside."""
    across, down = map(_spans, PLACES)
    of_rows, of_columns = divmod(index, len(across))
    return np.outer(down[of_rows], across[of_columns]).ravel() > 0.0


@cache
def _neighbours() -> Float[np.ndarray, "p p"]:
    """1 where two places share an edge."""
    row, column = np.divmod(np.arange(PLACES[0] * PLACES[1]), PLACES[0])
    return (np.abs(row[:, None] - row) + np.abs(column[:, None] - column) == 1).astype(float)
