"""Scores on the host: NumPy arrays, on all cores of a CPU, for every matcher. What repairs and comparisons run on."""

from stereorecal.scoring.host._correspondences import correspondences as correspondences
from stereorecal.scoring.host._counts import counts as counts, counts_one_by_one as counts_one_by_one
from stereorecal.scoring.host._disparities import disparities as disparities
