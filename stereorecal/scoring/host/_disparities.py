"""The disparities of all frames under one set of extrinsics."""

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray
from stereorecal.matching import AbstractMatcher, Disparity
from stereorecal.scoring._prepare import ScoringData
from stereorecal.scoring.host._blocks import match_in_blocks
from stereorecal.scoring.host._cores import on_all_cores
from stereorecal.scoring.host._rectified import rectified_frame


def disparities(data: ScoringData, extrinsics: Float[AnyArray, "6"], matcher: AbstractMatcher) -> list[Disparity]:
    """The disparity of each frame, NumPy arrays, in pixels of the scale of `data`.

    Args:
        matcher: any, with `num_disparities` in full-size pixels.
    """
    single, scaled = np.asarray(extrinsics, np.float32), matcher.scaled(data.scale)

    def one(frame: ScoringData) -> Disparity:
        return match_in_blocks(scaled, rectified_frame(frame, single))

    return on_all_cores(one, data.frames)
