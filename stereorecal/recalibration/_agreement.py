"""Frames against each other: do they show one and the same rig?"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int

from stereorecal.objectives import RigChart
from stereorecal.recalibration._evidence import Evidence, evidence, scatter
from stereorecal.recalibration._sums import Sums, sums
from stereorecal.recordings import Pair
from stereorecal.scoring import Correspondences, Loss, legible

_STEPS = 3  # of Gauss-Newton, once a frame is left out; the weights follow
_CHANCE = 1e-3  # that a frame of the same rig is taken for one of another
_MORE_PLACES = 7  # than parameters, of a frame that has a say, or a jackknife knows no scatter
LIKELY = 0.25  # of what has texture; aligned rigs cover a half of it and more, rigs a degree out a fifth at most
_FEWER = 0.5  # of what the frame that matches most covers
_ROWS_THAT_MATTER = 0.1  # pixels at full size: frames that differ by less agree well enough
MOST_APART = 1.0 / 3.0  # of the frames; if more disagree, which of them are wrong cannot be told


@dataclass(frozen=True, eq=False)
class Agreement:
    """What the frames say together.

    Attributes:
        facts: the evidence of the frames that are kept, at their solution.
        kept: (k,) which are judged.
        apart: frames that show another rig than most.
        refused: they are too many to say which are wrong; all frames are kept then.
    """

    facts: Evidence
    kept: Bool[np.ndarray, "k"]
    apart: tuple[int, ...]
    refused: bool


def agreed(
    chart: RigChart,
    found: Correspondences,
    z: Float[np.ndarray, "n"],
    pairs: Sequence[Pair],
) -> Agreement:
    """The frames at a solution. One shows another rig if its own solution lies apart from the others', or if it hardly
    matches where others do, though it has texture; where those are few, they are left out, and the evidence is that of
    the others, at their own solution. Frames that show nothing have no say.
    """
    frames = len(found.weight)
    fewer = unmatched(found, pairs) if frames > 1 else ()
    voting = without(found, fewer)
    others, seeing = disagreeing(evidence(chart, voting, z, Loss.SOFT_L1)) if frames > 1 else ((), 1)
    apart = tuple(sorted((*fewer, *others)))
    kept = np.isin(np.arange(frames), apart, invert=True)
    if len(apart) > MOST_APART * (seeing + len(fewer)):
        return Agreement(evidence(chart, found, z), np.ones(frames, bool), apart, refused=True)
    found = without(found, apart)
    facts = evidence(chart, found, z)
    for _ in range(_STEPS if apart else 0):
        facts = evidence(chart, found, facts.z + facts.shift)
    return Agreement(facts, kept, apart, refused=False)


def without(found: Correspondences, frames: Sequence[int]) -> Correspondences:
    """The correspondences of the other frames."""
    if not len(frames):
        return found
    kept = np.isin(np.arange(len(found.weight)), frames, invert=True)
    return replace(found, weight=np.asarray(found.weight) * kept[:, None])


def unmatched(found: Correspondences, pairs: Sequence[Pair]) -> tuple[int, ...]:
    """Frames with light and texture that hardly match, where another one does match."""
    covered = (np.asarray(found.weight) > 0).mean(axis=1)
    best = int(covered.argmax())
    fewer = [index for index, share in enumerate(covered) if share < _FEWER * covered[best]]
    if not fewer or covered[best] < LIKELY * legible(pairs[best]).texture:
        return ()
    shown = {index: legible(pairs[index]) for index in fewer}
    return tuple(i for i in fewer if shown[i].enough and covered[i] < LIKELY * shown[i].texture)


def disagreeing(found: Evidence) -> tuple[tuple[int, ...], int]:
    """The frames whose own solution lies apart from that of the others by more than chance (the jackknife over places
    says what that is) and by rows that matter: left out one by one, the farthest first. And how many frames show enough
    places to have a say."""
    parts = sums(found)
    frames, places = np.unique(parts.frame, return_counts=True)
    frames = frames[places >= found.z.size + _MORE_PLACES]
    apart: list[int] = []
    while len(kept := np.setdiff1d(frames, apart)) > 1:
        distances = {f: _distance(parts, f, np.setdiff1d(kept, f), found) for f in kept.tolist()}
        farthest = max(distances, key=lambda f: distances[f])
        if distances[farthest] <= 1.0:
            break
        apart.append(farthest)
    return tuple(sorted(apart)), len(frames)


def _distance(all_of_them: Sums, one: int, others: Int[np.ndarray, "f"], found: Evidence) -> float:
    """Between the solutions of a frame and of others, squared, over what chance allows one rig; 0 where the rows would
    hardly differ.

    Covariances of n parameters from u places are themselves uncertain: not chi-squared but Hotelling's distribution.
    """
    from scipy.special import fdtri  # a third of a second to import, where frames are compared

    parts = (all_of_them.of(all_of_them.frame == one), all_of_them.of(np.isin(all_of_them.frame, others)))
    (first, its_scatter), (second, their_scatter) = (_solution(part, found) for part in parts)
    apart, size = first - second, found.z.size
    rows2 = apart @ parts[0].normal.sum(0) @ apart / max(parts[0].weight.sum(), 1e-12)
    if rows2 <= _ROWS_THAT_MATTER**2:
        return 0.0
    free = max(len(np.unique(parts[0].place)) - size, 1)
    limit = size * (free + size - 1) / free * float(fdtri(size, free, 1.0 - _CHANCE))
    return float(apart @ np.linalg.solve(its_scatter + their_scatter, apart)) / limit


def _solution(part: Sums, found: Evidence) -> tuple[Float[np.ndarray, "n"], Float[np.ndarray, "n n"]]:
    """The solution of some tiles, from z, and its covariance by the jackknife over places, with the prior's share."""
    prior = np.eye(found.z.size) / found.prior**2
    normal, pull = part.normal.sum(0) + prior, part.pull.sum(0) + prior @ found.z
    places = np.unique(part.place)
    without = [(part.normal[part.place == p].sum(0), part.pull[part.place == p].sum(0)) for p in places]
    left = np.stack([-np.linalg.solve(normal - n, pull - p) for n, p in without])
    inverse = np.linalg.inv(normal)
    return -inverse @ pull, scatter(left) + inverse @ prior @ inverse
