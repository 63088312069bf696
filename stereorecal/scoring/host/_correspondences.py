"""Correspondences by the programs of `disparities`, for every matcher."""

import jax
import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray
from stereorecal._kept import kept
from stereorecal.matching import AbstractMatcher
from stereorecal.scoring._correspondences import Correspondences, gathered, refined
from stereorecal.scoring._prepare import ScoringData
from stereorecal.scoring.host._cores import on_all_cores
from stereorecal.scoring.host._disparities import disparities

_refined = kept(refined)


def correspondences(data: ScoringData, extrinsics: Float[AnyArray, "6"], matcher: AbstractMatcher) -> Correspondences:
    """As `stereorecal.correspondences`; NumPy arrays.

    Args:
        extrinsics: (6,): pitch, yaw, roll [rad] and the translation in any unit.
        matcher: any, with `num_disparities` in full-size pixels.
    """
    single = np.asarray(extrinsics, np.float32)

    def one(frame: ScoringData) -> tuple[np.ndarray, ...]:
        found = jax.tree.map(lambda leaf: leaf[None], disparities(frame, single, matcher)[0])
        return jax.tree.map(np.asarray, _refined(frame, single, found))

    left, right, weight = (np.concatenate(parts) for parts in zip(*on_all_cores(one, data.frames), strict=True))
    return gathered(data, left, right, weight)
