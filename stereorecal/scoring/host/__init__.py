"""Scores on the host: NumPy arrays, on all cores of a CPU, for every matcher. What repairs and comparisons run on."""

from stereorecal.scoring.host._correspondences import (
    compile_ahead as compile_ahead,
    correspondences as correspondences,
    correspondences_and_count as correspondences_and_count,
)
from stereorecal.scoring.host._counts import (
    counts as counts,
    counts_by_tile as counts_by_tile,
    counts_one_by_one as counts_one_by_one,
)
from stereorecal.scoring.host._disparities import disparities as disparities
from stereorecal.scoring.host._mixed_up import refuse_mixed_up as refuse_mixed_up
from stereorecal.scoring.host._partners import partners as partners
from stereorecal.scoring.host._score import (
    Score as Score,
    disparity as disparity,
    rectify as rectify,
    score as score,
)
from stereorecal.scoring.host._survey import (
    RANGES as RANGES,
    Survey as Survey,
    ranged as ranged,
    survey as survey,
    with_disparity_range as with_disparity_range,
)
from stereorecal.scoring.host._tracking import (
    Corners as Corners,
    Matches as Matches,
    corners as corners,
    shown_again as shown_again,
    tracked as tracked,
)
