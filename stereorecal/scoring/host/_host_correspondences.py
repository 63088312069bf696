"""Correspondences by the programs of `disparities`, for every matcher."""

import jax
import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray
from stereorecal._compile_cache import cached_program
from stereorecal.matching import AbstractMatcher, Disparity
from stereorecal.scoring._correspondences import Correspondences, gathered, refined
from stereorecal.scoring._prepare import ScoringData
from stereorecal.scoring.host._cores import on_all_cores
from stereorecal.scoring.host._disparities import disparities, rectified

_refined = cached_program(refined)


def compile_in_background(data: ScoringData) -> None:
    """Start compiling, in a thread, the programs of `correspondences` for such data apart from the match: for a new
    image size, this takes longer than all stages before it."""
    frame, (width, height) = data.frames[0], data.view.size
    nothing = Disparity(np.zeros((height, width), np.float32), np.zeros((height, width), bool))
    for program, more in ((rectified, ()), (_refined, (_of_one(nothing),))):
        program.compile_in_background(frame, np.asarray([0.0, 0.0, 0.0, -1.0, 0.0, 0.0], np.float32), *more)


def correspondences(data: ScoringData, extrinsics: Float[AnyArray, "6"], matcher: AbstractMatcher) -> Correspondences:
    """As `stereorecal.correspondences`; NumPy arrays.

    Args:
        extrinsics: (6,): pitch, yaw, roll [rad] and the translation in any unit.
        matcher: any, with `num_disparities` in full-size pixels.
    """
    single = np.asarray(extrinsics, np.float32)

    def one(frame: ScoringData) -> tuple[np.ndarray, ...]:
        found = disparities(frame, single, matcher)[0]
        return tuple(map(np.asarray, _refined(frame, single, _of_one(found))))

    return gathered(data, *map(np.concatenate, zip(*on_all_cores(one, data.frames), strict=True)))


def _of_one(found: Disparity) -> Disparity:
    """The disparity of one frame as that of all: (1, h, w)."""
    return jax.tree.map(lambda leaf: leaf[None], found)
