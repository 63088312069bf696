"""What frames say of a rig that others tell without them: which frames can, and where rows are for the worse."""

import numpy as np
from jaxtyping import Bool, Float

from stereorecal.estimation._consequences import REGIONS
from stereorecal.estimation._groups import PLACES, Groups

_SAME_PLACE = 1.0  # pixels of disparity: what a matcher tells apart


def frames_by_place(groups: Groups) -> list[tuple[int, ...]]:
    """Numbers of the frames, those of the same place together. Frames between which half of what both show hardly
    changes its disparity err alike: neither tests what the other says."""
    frames = np.unique(groups.frame)
    disparity = np.stack([_disparities(groups.of(groups.frame == frame)) for frame in frames])
    found: list[list[int]] = []
    for index in range(len(frames)):
        same = (place for place in found if any(_same_disparity(disparity[index], disparity[other]) for other in place))
        place = next(same, None)
        found.append([index]) if place is None else place.append(index)
    return [tuple(frames[place].tolist()) for place in found]


def _disparities(groups: Groups) -> Float[np.ndarray, "p"]:
    """At each place of the view, on average; NaN where nothing is shown."""
    size = int(np.prod(PLACES))
    number = np.bincount(groups.place, groups.count, size)
    total = np.bincount(groups.place, groups.count * groups.disparity, size)
    return np.where(number > 0, total / np.maximum(number, 1), np.nan)


def _same_disparity(one: Float[np.ndarray, "p"], other: Float[np.ndarray, "p"]) -> bool:
    both = np.isfinite(one) & np.isfinite(other)
    return bool(both.any()) and float(np.median(np.abs(one - other)[both])) < _SAME_PLACE


def largest_loss(groups: Groups, before: Float[np.ndarray, "g"], after: Float[np.ndarray, "g"]) -> float:
    """By how much |row differences| grow at most, on average over a frame, or over a ninth of the view; pixels. NaN if
    a ninth shows nothing."""
    row, column = np.divmod(groups.place, PLACES[0])
    region = row * REGIONS // PLACES[1] * REGIONS + column * REGIONS // PLACES[0]
    growth = np.abs(after) - np.abs(before)

    def mean(within: Bool[np.ndarray, "g"]) -> float:
        return float(np.average(growth[within], weights=groups.count[within])) if within.any() else float("nan")

    of_regions = [mean(region == number) for number in range(REGIONS**2)]
    return float(np.max([*of_regions, *(mean(groups.frame == frame) for frame in np.unique(groups.frame))]))
