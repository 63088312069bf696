"""Frames against each other: do they show one and the same rig?"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from stereorecal.objectives import SearchBox
from stereorecal.recalibration._evidence import TILES_OF_A_FRAME, Evidence, evidence
from stereorecal.scoring import Correspondences, Loss

_STEPS = 3  # of Gauss-Newton, once a frame is left out; the weights follow
_CHANCE = 1e-3  # that a frame of the same rig is taken for one of another
_ROWS_THAT_MATTER = 0.1  # pixels at full size: frames that differ by less agree well enough
MOST_APART = 1.0 / 3.0  # of the frames; if more disagree, which of them are wrong cannot be told


def agreed(box: SearchBox, found: Correspondences, z: Float[np.ndarray, "n"]) -> tuple[Evidence, tuple[int, ...]]:
    """The evidence at a solution, and the frames that disagree with the others; where those are few, they are left out,
    and the evidence is that of the others, at their own solution."""
    facts, frames = evidence(box, found, z), len(found.weight)
    apart = disagreeing(evidence(box, found, z, Loss.SOFT_L1)) if frames > 1 else ()
    if not 0 < len(apart) <= MOST_APART * frames:
        return facts, apart
    kept = np.isin(np.arange(frames), apart, invert=True)
    found = replace(found, weight=np.asarray(found.weight) * kept[:, None])
    facts = evidence(box, found, facts.z)
    for _ in range(_STEPS):
        facts = evidence(box, found, facts.z + facts.shift)
    return facts, apart


def disagreeing(found: Evidence) -> tuple[int, ...]:
    """The frames whose own solution lies apart from that of the others by more than chance (the jackknife over places
    says what that is) and by rows that matter: left out one by one, the farthest first."""
    from scipy.special import chdtri  # as in the evidence: not before it is needed

    sums, limit = _sums(found), chdtri(found.z.size, _CHANCE)
    apart: list[int] = []
    while len(kept := np.setdiff1d(np.unique(sums.frame), apart)) > 1:
        distances = {f: _distance(sums, f, np.setdiff1d(kept, f), found) for f in kept.tolist()}
        farthest = max(distances, key=lambda f: distances[f])
        if distances[farthest] <= limit:
            break
        apart.append(farthest)
    return tuple(sorted(apart))


class _Sums(NamedTuple):
    """Of the least-squares problem, for each tile of each frame that shows something."""

    normal: Float[np.ndarray, "t n n"]
    pull: Float[np.ndarray, "t n"]
    weight: Float[np.ndarray, "t"]
    frame: Int[np.ndarray, "t"]
    place: Int[np.ndarray, "t"]

    def of(self, frames: Int[np.ndarray, "f"]) -> "_Sums":
        return _Sums(*(part[np.isin(self.frame, frames)] for part in self))


def _sums(found: Evidence) -> _Sums:
    order = np.argsort(found.tile, kind="stable")
    tiles, first = np.unique(found.tile[order], return_index=True)
    jacobian, weight = found.jacobian[order], found.weight[order]
    weighted = weight[:, None] * jacobian
    normal = np.add.reduceat(weighted[:, :, None] * jacobian[:, None, :], first)
    pull = np.add.reduceat(weighted * found.residual[order][:, None], first)
    return _Sums(normal, pull, np.add.reduceat(weight, first), *np.divmod(tiles, TILES_OF_A_FRAME))


def _distance(sums: _Sums, one: int, others: Int[np.ndarray, "f"], found: Evidence) -> float:
    """Squared, in standard deviations: chi-squared where both show one rig; 0 where the rows would hardly differ."""
    parts = sums.of(np.array([one])), sums.of(others)
    (first, scatter), (second, scatter_of_others) = (_solution(part, found) for part in parts)
    apart = first - second
    rows2 = apart @ parts[0].normal.sum(0) @ apart / max(parts[0].weight.sum(), 1e-12)
    return float(apart @ np.linalg.solve(scatter + scatter_of_others, apart)) if rows2 > _ROWS_THAT_MATTER**2 else 0.0


def _solution(sums: _Sums, found: Evidence) -> tuple[Float[np.ndarray, "n"], Float[np.ndarray, "n n"]]:
    """The solution of some tiles, from z, and its covariance by the jackknife over places, with the prior's share."""
    prior = np.eye(found.z.size) / found.prior**2
    normal, pull = sums.normal.sum(0) + prior, sums.pull.sum(0) + prior @ found.z
    places = np.unique(sums.place)
    without = [(sums.normal[sums.place == p].sum(0), sums.pull[sums.place == p].sum(0)) for p in places]
    left = np.stack([-np.linalg.solve(normal - n, pull - p) for n, p in without])
    inverse, few = np.linalg.inv(normal), len(places)
    moves = left - left.mean(0)
    return -inverse @ pull, moves.T @ moves * (few - 1) / few + inverse @ prior @ inverse
