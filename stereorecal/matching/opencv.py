"""OpenCV's block matcher and semi-global matcher behind the Matcher interface. They run on the host, untraced."""

from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray, eight_bit
from stereorecal._errors import InputError
from stereorecal.matching._matcher import AbstractMatcher, Disparity


@dataclass(frozen=True)
class BM(AbstractMatcher):
    """OpenCV's block matching (`cv2.StereoBM`).

    Options: see `AbstractMatcher`; `num_disparities` is rounded up to a multiple of 16. It always
    matches the x-Sobel response, so `pre_filter_cap` must be positive, and `block_size` at least 5.
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.block_size < 5 or self.pre_filter_cap < 1:
            raise InputError("BM needs a block_size of at least 5 and a pre_filter_cap of at least 1; change them.")

    def search(self, left: Float[AnyArray, "h w"], right: Float[AnyArray, "h w"]) -> Disparity:
        """See `AbstractMatcher.search`."""
        lowest, count = _rounded_range(self, left.shape[1])
        matcher = cv2.StereoBM.create(count, self.block_size)
        matcher.setMinDisparity(lowest)
        matcher.setUniquenessRatio(self.uniqueness_ratio)
        matcher.setDisp12MaxDiff(self.disp12_max_diff)
        matcher.setPreFilterCap(self.pre_filter_cap)
        matcher.setTextureThreshold(0)
        return _run(matcher, self, left, right)


@dataclass(frozen=True)
class SGBM(AbstractMatcher):
    """OpenCV's semi-global matching (`cv2.StereoSGBM`) with its suggested smoothness penalties.

    Options: see `AbstractMatcher`; `num_disparities` is rounded up to a multiple of 16.
    """

    block_size: int = 5
    uniqueness_ratio: int = 10

    def search(self, left: Float[AnyArray, "h w"], right: Float[AnyArray, "h w"]) -> Disparity:
        """See `AbstractMatcher.search`."""
        lowest, count = _rounded_range(self, left.shape[1])
        area = self.block_size**2
        matcher = cv2.StereoSGBM.create(
            minDisparity=lowest,
            numDisparities=count,
            blockSize=self.block_size,
            P1=8 * area,
            P2=32 * area,
            disp12MaxDiff=self.disp12_max_diff,
            preFilterCap=self.pre_filter_cap,
            uniquenessRatio=self.uniqueness_ratio,
        )
        return _run(matcher, self, left, right)


def _rounded_range(options: AbstractMatcher, width: int) -> tuple[int, int]:
    lowest, count = options.disparity_range(width)
    return lowest, -(-count // 16) * 16


def _run(matcher: cv2.StereoMatcher, options: AbstractMatcher, left: AnyArray, right: AnyArray) -> Disparity:
    fixed_point = matcher.compute(eight_bit(left), eight_bit(right))
    # OpenCV gives 16 times the disparity, and (min_disparity - 1) * 16 where it found none.
    found = fixed_point > (options.min_disparity - 1) * 16
    return Disparity(fixed_point.astype(np.float32) / 16.0, found)
