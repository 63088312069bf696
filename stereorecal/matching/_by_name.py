"""Matchers by name."""

from typing import Any

from stereorecal._errors import InputError
from stereorecal._names import known
from stereorecal.matching._matcher import AbstractMatcher
from stereorecal.matching.opencv import BM, SGBM
from stereorecal.matching.sad import SAD

MATCHERS: dict[str, type[AbstractMatcher]] = {"sad": SAD, "bm": BM, "sgbm": SGBM}


def as_matcher(matcher: Any) -> AbstractMatcher:
    """The matcher itself, the one of that name with its default options, or `SAD()` for None.

    Raises:
        InputError: if the name is unknown, or it is no matcher.
    """
    if matcher is None:
        return SAD()
    if isinstance(matcher, AbstractMatcher):
        return matcher
    if isinstance(matcher, str):
        return MATCHERS[known(matcher, MATCHERS, "matcher")]()
    if isinstance(matcher, type) and issubclass(matcher, AbstractMatcher):
        raise InputError(f"matcher is the class {matcher.__name__}; make one of it, such as sr.{matcher.__name__}().")
    raise InputError(
        f"matcher is a {type(matcher).__name__}; give a name (sad, bm, sgbm) or a matcher such as "
        "sr.SGBM(num_disparities=128)."
    )
