"""Compile in advance, so that the first repair need not wait."""

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np

from stereorecal._errors import InputError
from stereorecal.geometry import AnyView, StereoRig
from stereorecal.matching import AbstractMatcher, as_matcher
from stereorecal.recalibration._recalibrate import recalibrate
from stereorecal.recalibration._schedule import Schedule
from stereorecal.recordings import Pair
from stereorecal.scoring.host import RANGES

_USUAL = (64, 96, 128)


def warm_up(
    rig: StereoRig,
    *,
    matcher: AbstractMatcher | str | None = None,
    schedule: Schedule | str | None = None,
    view: AnyView = None,
    disparities: Sequence[int] = _USUAL,
) -> None:
    """Compile what repairs of this rig need, so that none of them waits: some ten seconds, and a few for each range.

    What is compiled depends on the size of the images, on the models of the lenses and how many coefficients they have,
    on the projection of the view, and on the disparity range; neither on their contents, nor on the numbers of the
    calibration, nor, on a CPU, on how many images there are. (A GPU counts in batches, which are compiled for each
    number of frames at its first use.) It stays in this process; where JAX's compilation cache is switched on, as the
    command line does, later processes find it there: `jax.config.update("jax_compilation_cache_dir", folder)`, and
    `"jax_persistent_cache_min_compile_time_secs", 0.1`.

    Args:
        matcher: a matcher, or the name of an installed one (default "sad"); with `num_disparities`, that range alone is
            compiled.
        schedule, view: as `recalibrate` has them.
        disparities: the ranges that are compiled. Measured ranges are one of 16, 32, 48, 64, 96, 128, 192, 256, 384
            and 512 (`Solution.matcher` tells).

    Raises:
        InputError: if a range is none of those, or reaches beyond the width of the images; or as `recalibrate`.
    """
    chosen, pair = as_matcher(matcher), _noise(rig.left.size)
    if chosen.num_disparities is None and (unknown := [n for n in disparities if n not in RANGES]):
        raise InputError(f"disparities {unknown[0]} is not one of the measured ranges; choose from {RANGES}.")
    for number in disparities if chosen.num_disparities is None else (chosen.num_disparities,):
        recalibrate(rig, [pair], matcher=replace(chosen, num_disparities=number), schedule=schedule, view=view)


def _noise(size: tuple[int, int]) -> Pair:
    """Images that match: smooth noise, the right one shifted a little."""
    width, height = size
    coarse = np.random.default_rng(0).uniform(0, 255, (height // 3 + 1, width // 3 + 4)).astype(np.float32)
    wide = cv2.resize(coarse, (width + 8, height), interpolation=cv2.INTER_CUBIC)
    left, right = (np.ascontiguousarray(np.clip(side, 0, 255)) for side in (wide[:, :width], wide[:, 8:]))
    return Pair(left, right, "noise")
