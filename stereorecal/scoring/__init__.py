"""Scores of a calibration: pure functions of images, cameras, extrinsics and matcher."""

from stereorecal.scoring._bands import bands as bands
from stereorecal.scoring._correspondences import (
    TILES as TILES,
    Correspondences as Correspondences,
    correspondences as correspondences,
)
from stereorecal.scoring._count import (
    count as count,
    counts as counts,
    counts_one_by_one as counts_one_by_one,
    disparities as disparities,
)
from stereorecal.scoring._epipolar import (
    Loss as Loss,
    curvatures as curvatures,
    median_row_error as median_row_error,
    precisions as precisions,
    row_differences as row_differences,
)
from stereorecal.scoring._gradient import forward_gradient as forward_gradient
from stereorecal.scoring._prepare import ScoringData as ScoringData, normalised as normalised, prepare as prepare
from stereorecal.scoring._score import (
    Score as Score,
    disparity as disparity,
    rectify as rectify,
    score as score,
)
from stereorecal.scoring._soft_count import soft_count as soft_count
from stereorecal.scoring._survey import (
    Survey as Survey,
    survey as survey,
    with_disparity_range as with_disparity_range,
)
