"""The matcher interface: two rectified images in, a Disparity out."""

import abc
import math
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar, NamedTuple

import jax
from jaxtyping import Bool, Float, Int

from stereorecal._arrays import AnyArray, namespace, register_pytree
from stereorecal._errors import InputError, checked_choice
from stereorecal.matching._texture import textured


@register_pytree
@dataclass(frozen=True, eq=False)
class Disparity:
    """What a matcher found, for each pixel of the left image.

    Attributes:
        values: (h, w) float32, x_left - x_right in pixels; meaningful only where valid.
        valid: (h, w) bool, the pixels that passed all of the matcher's checks.
    """

    values: Float[AnyArray, "h w"]
    valid: Bool[AnyArray, "h w"]


class SoftDisparity(NamedTuple):
    """Candidates for the disparity of each pixel, and how sure they are.

    Attributes:
        values: (c, h, w) int32, whole disparities.
        confidence: (c, h, w) float32 in [0, 1], at most 1 over the candidates of a pixel; differentiable with respect
            to the images.
    """

    values: Int[jax.Array, "c h w"]
    confidence: Float[jax.Array, "c h w"]


@dataclass(frozen=True)
class AbstractMatcher(abc.ABC):
    """A stereo matcher. Its fields are its options, with OpenCV's names and meanings.

    Attributes:
        min_disparity: smallest disparity searched, in full-size pixels; may be negative.
        num_disparities: how many are searched, in full-size pixels; None: measured from the images by
            whatever takes images and a rig (`sr.score`, `sr.recalibrate`, `sr.with_disparity_range`).
        block_size: width of the square window in pixels (odd); does not scale with the image.
        uniqueness_ratio: percent by which the best cost must beat every other that is not its neighbour; 0: off.
        texture_threshold: least sum over the window of the absolute x-Sobel response, clipped at `pre_filter_cap`.
        disp12_max_diff: largest difference in pixels of the left-right check; negative: off.
        pre_filter_cap: clip of the x-Sobel response that is matched in place of grey levels.

    Class attributes:
        traceable: True if `search` is a pure JAX function that can be traced, batched and compiled.
        smooth: True if `soft_match` is offered as well.
    """

    min_disparity: int = 0
    num_disparities: int | None = None
    block_size: int = 11
    uniqueness_ratio: int = 15
    texture_threshold: int = 10
    disp12_max_diff: int = 1
    pre_filter_cap: int = 31

    traceable: ClassVar[bool] = False
    smooth: ClassVar[bool] = False

    def __new__(cls, *values: Any, **options: Any) -> "AbstractMatcher":
        """Refuse options that it does not have, OpenCV's camel case among them, in a sentence."""
        known = [option.name for option in fields(cls)]
        if values:
            raise InputError(f"name the options of {cls.__name__}, as in {called(cls)}(num_disparities=64).")
        for name in options:
            checked_choice(name, known, f"option of {cls.__name__}")
        return super().__new__(cls)

    @property
    def halo(self) -> int | None:
        """How many rows above and below a row decide what is found in it; None (the default): all of them. With a halo,
        an image may be matched in blocks of rows, on several cores."""
        return None

    def __post_init__(self) -> None:
        if self.block_size < 3 or self.block_size % 2 == 0:
            raise InputError(f"block_size is {self.block_size}; it must be odd and at least 3.")
        if self.num_disparities is not None and self.num_disparities < 1:
            raise InputError(f"num_disparities is {self.num_disparities}; it must be positive.")
        if not 0 <= self.uniqueness_ratio <= 100:
            raise InputError(f"uniqueness_ratio is {self.uniqueness_ratio}; it must be within 0..100 percent.")
        if self.texture_threshold < 0:
            raise InputError(f"texture_threshold is {self.texture_threshold}; it must not be negative.")
        if not 0 <= self.pre_filter_cap <= 63:
            raise InputError(f"pre_filter_cap is {self.pre_filter_cap}; it must be within 0..63.")

    def match(self, left: Float[AnyArray, "h w"], right: Float[AnyArray, "h w"]) -> Disparity:
        """Match two rectified images, (h, w) float32 in 0..255; they are rounded to whole grey levels first.

        What `search` finds is valid if it is also textured and not below `min_disparity`: the same rule for every
        matcher, so that their counts mean the same.

        Raises:
            InputError: if `num_disparities` is None, or the disparity range reaches beyond the width of the image.
        """
        found = self.search(left, right)
        texture = textured(left, self.block_size, self.texture_threshold, self.pre_filter_cap)
        in_range = found.values > self.min_disparity - 1.0  # sub-pixel parts reach half a pixel below
        return Disparity(found.values, found.valid & namespace(found.values).asarray(texture) & in_range)

    @abc.abstractmethod
    def search(self, left: Float[AnyArray, "h w"], right: Float[AnyArray, "h w"]) -> Disparity:
        """The matcher's own part of `match`: winners, and which of them are unique and left-right consistent."""

    def soft_match(
        self, left: Float[AnyArray, "h w"], right: Float[AnyArray, "h w"], temperature: float | Float[AnyArray, ""]
    ) -> SoftDisparity:
        """The differentiable twin of `match`, for matchers that are `smooth`: pure JAX, images not rounded, and a
        confidence that becomes the validity as `temperature` (> 0, dimensionless) goes to 0."""
        raise NotImplementedError(f"{type(self).__name__} has no differentiable twin")

    def disparity_range(self, width: int) -> tuple[int, int]:
        """(min_disparity, num_disparities) for an image of `width` pixels.

        Raises:
            InputError: if the number is not known, or the range reaches beyond the width of the image.
        """
        if self.num_disparities is None:
            raise InputError(
                "num_disparities is not set; give it, or measure it: sr.with_disparity_range(matcher, rig, pairs)."
            )
        if max(abs(self.min_disparity), abs(self.min_disparity + self.num_disparities)) >= width:
            raise InputError(
                f"the disparities [{self.min_disparity}, {self.min_disparity + self.num_disparities}) reach beyond the "
                f"width of the image ({width} pixels); give a smaller num_disparities, or a min_disparity nearer to 0."
            )
        return self.min_disparity, self.num_disparities

    def scaled(self, scale: float) -> "AbstractMatcher":
        """The matcher for images at `scale` times the size: the disparity range scales, the window does not."""
        if self.num_disparities is None:
            return self
        lowest = math.floor(self.min_disparity * scale)
        highest = math.ceil((self.min_disparity + self.num_disparities) * scale)
        return replace(self, min_disparity=lowest, num_disparities=max(1, highest - lowest))


def called(cls: type[AbstractMatcher]) -> str:
    """How a program calls the class: the core's own are public names of the library."""
    return f"sr.{cls.__name__}" if cls.__module__.partition(".")[0] == "stereorecal" else cls.__name__
