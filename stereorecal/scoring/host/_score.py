"""The score, the rectified images and the disparity of one calibration."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import refuse_tracers
from stereorecal._errors import InputError
from stereorecal.geometry import AnyView, StereoRig, checked_rig, with_unit_baseline
from stereorecal.matching import AbstractMatcher, Disparity
from stereorecal.recordings import Pairs
from stereorecal.scoring._prepare import Pyramid, pyramid
from stereorecal.scoring.host._disparities import compiled_rotations, counts_by_tile, disparities, rectified_frame
from stereorecal.scoring.host._survey import with_measured_range


@dataclass(frozen=True)
class Score:
    """The number of matched pixels.

    Attributes:
        count: pixels with a valid disparity, over all frames.
        pixels: pixels of the view, over all frames.
    """

    count: int
    pixels: int

    @property
    def fraction(self) -> float:
        """Share of the pixels that are valid."""
        return self.count / self.pixels

    def __str__(self) -> str:
        return f"{self.count:,} of {self.pixels:,} pixels ({100 * self.fraction:.1f} %)".replace(",", " ")


def score(
    rig: StereoRig,
    pairs: Pairs,
    *,
    matcher: AbstractMatcher | str | None = None,
    view: AnyView = None,
    scale: float = 1.0,
) -> Score:
    """How many pixels of the pairs find a valid disparity under the rig's calibration. Works on the host.

    Args:
        matcher: a matcher, or the name of an installed one (default "sad"); without `num_disparities` the range is
            measured.
        view: default the view of `rig`. Scores are comparable only within one view and one disparity range: to
            compare calibrations, give both (a `Solution` carries its own).
        scale: image scale, (0, 1].

    Raises:
        InputError: if images and calibration do not fit, or it is called under `jit`, `vmap` or `grad`.
    """
    refuse_tracers("sr.score", "sr.count(data, extrinsics, matcher) on data = sr.prepare(rig, pairs)", rig, pairs, view)
    images = pyramid(checked_rig(rig), pairs, view)
    data = images.at(scale)
    candidate = with_unit_baseline(images.rig.extrinsics)[None]
    return Score(int(counts_by_tile(data, candidate, with_measured_range(matcher, images)).sum()), data.pixels)


def rectify(
    rig: StereoRig, pair: Pairs, *, view: AnyView = None
) -> tuple[Float[np.ndarray, "h w"], Float[np.ndarray, "h w"]]:
    """Left and right image rectified, float32 in the view (default: the rig's own); borders are repeated."""
    refuse_tracers("sr.rectify", "sr.prepare before tracing, and a score of its data", rig, pair, view)
    rig = checked_rig(rig)
    data = _only(pyramid(rig, pair, view)).at(1.0)
    frame = rectified_frame(data, compiled_rotations(with_unit_baseline(rig.extrinsics)))
    return np.asarray(frame.left), np.asarray(frame.right)


def disparity(
    rig: StereoRig, pair: Pairs, *, matcher: AbstractMatcher | str | None = None, view: AnyView = None
) -> Disparity:
    """The disparity of one pair, NumPy arrays; `valid` is what `score` counts with the same view and matcher."""
    refuse_tracers("sr.disparity", "matcher.match on rectified images", rig, pair, view)
    rig = checked_rig(rig)
    images = _only(pyramid(rig, pair, view))
    return disparities(images.at(1.0), with_unit_baseline(rig.extrinsics), with_measured_range(matcher, images))[0]


def _only(images: Pyramid) -> Pyramid:
    if len(images.pairs) > 1:
        raise InputError(f"{len(images.pairs)} pairs were given, and one is taken; give one after the other.")
    return images
