"""What is asked of the images of recordings that are solved together, each in a worker: matches, ranges, counts."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int

from stereorecal.estimation import MatchedRanges
from stereorecal.geometry import StereoRig, View, with_unit_baseline
from stereorecal.matching import AbstractMatcher
from stereorecal.recalibration._match_ranges import match_ranges
from stereorecal.recordings import Pair, Range
from stereorecal.scoring import Correspondences, pyramid
from stereorecal.scoring.host import correspondences, counts_by_tile


@dataclass(frozen=True, eq=False)
class MatchTask:
    """Pairs to look at through rigs: no more than a worker needs travels to it.

    Attributes:
        scale: at which they are matched.
    """

    rigs: tuple[StereoRig, ...]
    pairs: tuple[Pair, ...]
    view: View
    matcher: AbstractMatcher
    scale: float
    ranges: tuple[Range, ...] = ()


def matched(task: MatchTask) -> Correspondences:
    """The correspondences under the first rig."""
    rig = task.rigs[0]
    data = pyramid(rig, task.pairs, task.view).at(task.scale)
    return correspondences(data, with_unit_baseline(rig.extrinsics), task.matcher)


def range_matches(task: MatchTask) -> MatchedRanges:
    """The ranges, matched under the first rig."""
    rig = task.rigs[0]
    return match_ranges(pyramid(rig, task.pairs, task.view).at(task.scale), rig, task.matcher, task.pairs, task.ranges)


def counted(task: MatchTask) -> Int[np.ndarray, "rigs k tiles"]:
    """Counts of the tiles of all frames at full scale, under each rig."""
    return np.stack(
        [
            counts_by_tile(
                pyramid(rig, task.pairs, task.view).at(1.0), with_unit_baseline(rig.extrinsics)[None], task.matcher
            )[0]
            for rig in task.rigs
        ]
    )
