"""Scores on the host: NumPy arrays, on all cores of a CPU, for every matcher. Repairs and comparisons use them."""

from stereorecal.scoring.host._disparities import (
    compile_in_background as compile_in_background,
    correspondences as correspondences,
    counts as counts,
    counts_by_tile as counts_by_tile,
    disparities as disparities,
)
from stereorecal.scoring.host._pixel_matches import match_pixels as match_pixels
from stereorecal.scoring.host._score import Score as Score, disparity as disparity, rectify as rectify, score as score
from stereorecal.scoring.host._survey import (
    survey as survey,
    with_disparity_range as with_disparity_range,
    with_measured_range as with_measured_range,
)
from stereorecal.scoring.host._swapped_images import refuse_swapped_images as refuse_swapped_images
from stereorecal.scoring.host._tracking import (
    Corners as Corners,
    Matches as Matches,
    corner_tracks as corner_tracks,
    corners as corners,
    match_radius as match_radius,
    tracked as tracked,
)
