"""Matchers as scores use them: by name or value, at the scale of the images."""

from stereorecal._errors import InputError
from stereorecal.matching import AbstractMatcher, as_matcher


def pure_matcher(matcher: AbstractMatcher | str, scale: float, score: str, *, smooth: bool = False) -> AbstractMatcher:
    """The matcher at an image scale, if the pure function called `score` can use it.

    Raises:
        InputError: if it runs on the host, is not smooth where it must be, or its disparity range is not known.
    """
    matcher = as_matcher(matcher)
    name = type(matcher).__name__
    if not (matcher.smooth if smooth else matcher.traceable):
        raise InputError(
            f"{score} needs a matcher in JAX{' with a differentiable twin' if smooth else ''}, and {name} is none; "
            "use sr.SAD(...), or sr.score, which takes every matcher."
        )
    if matcher.num_disparities is None:
        raise InputError(
            f"{score} needs to know the disparity range; give num_disparities, as in sr.{name}(num_disparities=96), or "
            "have it measured: sr.with_disparity_range(matcher, rig, pairs)."
        )
    return matcher.scaled(scale)
