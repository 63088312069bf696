"""Matching one rectified frame: valid are the pixels that pass `AbstractMatcher.match` (the matcher's own rules, then
texture and range, the same for all) and that lie inside the mapped area of both images."""

from stereorecal._arrays import namespace
from stereorecal._errors import InputError, MatcherError
from stereorecal.matching import AbstractMatcher, Disparity, name_of, origin_of
from stereorecal.scoring._rectify import Rectified


def match_frame(matcher: AbstractMatcher, frame: Rectified) -> Disparity:
    """Match one rectified frame and keep what lies inside the mapped area of both images.

    Valid: found by the matcher's own rules (unique, textured, left-right consistent), `d >= min_disparity`, and the
    pixel and its match both lie inside the mapped area. Traceable if the matcher is.

    Raises:
        MatcherError: if the matcher crashes; the message names it.
    """
    try:
        disparity = matcher.match(frame.left, frame.right)
    except InputError:
        raise
    except Exception as error:
        raise MatcherError(f"matcher {name_of(matcher)} ({origin_of(matcher)}) crashed: {error!r}") from error
    xp = namespace(disparity.values)
    width = disparity.values.shape[1]
    partner = xp.arange(width) - xp.round(disparity.values).astype(xp.int32)
    inside = (partner >= 0) & (partner < width)
    partner_area = xp.take_along_axis(xp.asarray(frame.right_area), xp.clip(partner, 0, width - 1), axis=1)
    return Disparity(disparity.values, disparity.valid & inside & frame.left_area & partner_area)
