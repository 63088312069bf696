"""Frames against each other: do they show one and the same rig?"""

from dataclasses import replace

import numpy as np
from jaxtyping import Float, Int
from scipy.special import chdtri

from stereorecal.objectives import SearchBox
from stereorecal.recalibration._evidence import TILES_OF_A_FRAME, Evidence, evidence
from stereorecal.recalibration._misfit import misfit, systematic
from stereorecal.scoring import Correspondences

_STEPS = 3  # of Gauss-Newton, once a frame is left out; the weights follow
_CHANCE = 1e-3  # that a frame of the same rig is taken for one of another
MOST_APART = 1.0 / 3.0  # of the frames; if more disagree, which of them are wrong cannot be told


def agreed(box: SearchBox, found: Correspondences, z: Float[np.ndarray, "n"]) -> tuple[Evidence, tuple[int, ...]]:
    """The evidence at a solution, and the frames that disagree with the others; where those are few, they are left out,
    and the evidence is that of the others, at their own solution."""
    facts = evidence(box, found, z)
    apart, frames = disagreeing(facts), len(found.weight)
    if not 0 < len(apart) <= MOST_APART * frames:
        return facts, apart
    kept = np.isin(np.arange(frames), apart, invert=True)
    found = replace(found, weight=np.asarray(found.weight) * kept[:, None])
    for _ in range(_STEPS):
        facts = evidence(box, found, facts.z + evidence(box, found, facts.z).shift)
    return facts, apart


def disagreeing(found: Evidence) -> tuple[int, ...]:
    """The frames whose own solution lies apart from that of the others by more than both can be wrong by (their
    covariances, widened by their misfit): left out one by one, the farthest first."""
    frame = found.tile // TILES_OF_A_FRAME
    apart: list[int] = []
    while len(kept := np.setdiff1d(np.unique(frame), apart)) > 1:
        distances = {int(f): _distance(found, frame, f, np.setdiff1d(kept, f)) for f in kept}
        farthest = max(distances, key=lambda f: distances[f])
        if distances[farthest] <= chdtri(found.z.size, _CHANCE):
            break
        apart.append(farthest)
    return tuple(sorted(apart))


def _distance(found: Evidence, frame: Int[np.ndarray, "m"], one: int, others: Int[np.ndarray, "f"]) -> float:
    """Squared, in standard deviations: chi-squared where both show one rig."""
    parts = [found.of(frame == one), found.of(np.isin(frame, others))]
    apart = parts[0].shift - parts[1].shift
    scatter = sum((p.covariance() + systematic(p, misfit(p)) for p in parts), np.zeros((apart.size, apart.size)))
    return float(apart @ np.linalg.solve(scatter, apart))
