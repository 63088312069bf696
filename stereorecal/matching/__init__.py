"""Stereo matchers: one interface, a registry of plug-ins, and the core's own: SAD in JAX, OpenCV's BM and SGBM."""

from stereorecal._errors import MatcherError as MatcherError
from stereorecal.matching._matcher import (
    AbstractMatcher as AbstractMatcher,
    Disparity as Disparity,
    SoftDisparity as SoftDisparity,
)
from stereorecal.matching._matcher_registry import (
    as_matcher as as_matcher,
    matcher as matcher,
    matchers as matchers,
    name_of as name_of,
    origin_of as origin_of,
    overview as overview,
)
from stereorecal.matching._texture import box_sum as box_sum
from stereorecal.matching.opencv import BM as BM, SGBM as SGBM
from stereorecal.matching.sad import SAD as SAD
