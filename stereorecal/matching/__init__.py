"""Stereo matchers: SAD in JAX, OpenCV's BM and SGBM, one interface."""

from stereorecal.matching._by_name import MATCHERS as MATCHERS, as_matcher as as_matcher
from stereorecal.matching._matcher import (
    AbstractMatcher as AbstractMatcher,
    Disparity as Disparity,
    SoftDisparity as SoftDisparity,
)
from stereorecal.matching._texture import box_sum as box_sum, textured as textured
from stereorecal.matching.opencv import BM as BM, SGBM as SGBM
from stereorecal.matching.sad import SAD as SAD
