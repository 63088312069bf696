"""Scores of a calibration.

The pure face, which users jit, batch and differentiate: `prepare` on the host, then `count`, `soft_count`,
`correspondences` and `row_differences` (`docs/tutorials/07-the-score-in-jax.md`). `host` has the same scores for every
matcher, on all cores.
"""

from stereorecal.scoring._correspondences import (
    TILES as TILES,
    Correspondences as Correspondences,
    Tracks as Tracks,
    correspondences as correspondences,
    median_row_error as median_row_error,
    row_differences as row_differences,
    with_rays_of as with_rays_of,
)
from stereorecal.scoring._count import (
    count as count,
    count_scaled as count_scaled,
    forward_gradient as forward_gradient,
    soft_count as soft_count,
    soft_count_scaled as soft_count_scaled,
)
from stereorecal.scoring._image_quality import (
    ImageQuality as ImageQuality,
    image_quality as image_quality,
    is_coarse as is_coarse,
    select_frames as select_frames,
)
from stereorecal.scoring._prepare import (
    Pyramid as Pyramid,
    ScoringData as ScoringData,
    bands as bands,
    prepare as prepare,
    pyramid as pyramid,
)
