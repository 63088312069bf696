"""Correspondences in groups by frame, place and disparity: each group one mean row difference and its deviation.

Neighbours err together (windows overlap, a surface slants), so many correspondences of one place tell little more than
a few; and what lies near and far there tells apart what a mean of both would hide. Frames that show the same err
together as well, and are one: what is seen a dozen times is not known a dozen times as well.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from stereorecal._arrays import group_medians
from stereorecal.geometry import PINHOLE, StereoRig, projection, rectifying_rotations
from stereorecal.objectives import RigChart, linearised, rectified_at
from stereorecal.scoring import Correspondences

PLACES = (14, 9)  # columns and rows of places in the left image
_DISPARITIES = 3  # near, middle, far: a third of all correspondences each
_FEWEST = 4  # correspondences in a group
FEWEST_GROUPS = 6  # from fewer nothing is to be learnt of a rig
_SAME = 1.0  # pixels of disparity: what a matcher tells apart
_FAR_OFF = 3.0  # robust deviations: beyond, a correspondence has no part in the mean of its group
_LEAST_SPREAD = 0.02  # pixels
_LEAST_WEIGHT = 0.05  # of a mean correspondence
FLOOR = 0.03  # pixels at full size: what the rows of a group have in common, whatever their number


@dataclass(frozen=True, eq=False)
class Groups:
    """Mean row differences of g groups, near a rig θ.

    Attributes:
        left, right: (g, 3) mean rays, as the cameras of the chart's rig give them.
        offset: (g,) pixels at full size that the mean row difference exceeds that of the mean rays.
        deviation: (g,) standard deviation of the mean, pixels of the images.
        frame, place: (g,) of each group; frames that show the same have the number of their first, and places are
            numbered by rows.
        disparity: (g,) pixels at full size, under the rig at which they were grouped.
        count: (g,) correspondences.
        focal: of the rectified rows, in pixels at full size.
        resolution: (g,) pixels of the middle that a row of the view is wide there: 1 of pinholes, less where a view
            stretches what a wide lens shows.
        first: (k,) of each frame the first of those that show the same, and are one here.
        projection: by which rays become rows.
    """

    left: Float[np.ndarray, "g 3"]
    right: Float[np.ndarray, "g 3"]
    offset: Float[np.ndarray, "g"]
    deviation: Float[np.ndarray, "g"]
    frame: Int[np.ndarray, "g"]
    place: Int[np.ndarray, "g"]
    disparity: Float[np.ndarray, "g"]
    count: Int[np.ndarray, "g"]
    focal: float
    resolution: Float[np.ndarray, "g"]
    first: Int[np.ndarray, "k"]
    projection: str = PINHOLE

    def __len__(self) -> int:
        return len(self.offset)

    def of(self, which: Any) -> "Groups":
        """Some of them."""
        names = ("left", "right", "offset", "deviation", "frame", "place", "disparity", "count", "resolution")
        return replace(self, **{name: getattr(self, name)[which] for name in names})

    def rows(
        self, chart: RigChart, theta: Float[np.ndarray, "n"]
    ) -> tuple[Float[np.ndarray, "g"], Float[np.ndarray, "g n"]]:
        """Their mean row differences at θ and the derivatives there, in pixels of the images that the cameras at θ
        have. Noise is in those: longer focal lengths must not make it smaller, nor rows that are wider apart in the
        view make it larger."""
        rows, slopes = linearised((self.left, self.right), self.projection, chart, theta)
        zoom = self._zoom(chart, theta)
        differences = zoom * (self.focal * rows + self.offset)
        jacobian = (zoom * self.focal)[:, None] * slopes.T
        return differences, jacobian + np.outer(differences, _by_focal(chart))

    def differences(self, chart: RigChart, theta: Float[np.ndarray, "n"]) -> Float[np.ndarray, "g"]:
        """The same without the derivatives."""
        return self._zoom(chart, theta) * (self._of_means(chart, theta) + self.offset)

    def _of_means(self, chart: RigChart, theta: Float[np.ndarray, "n"]) -> Float[np.ndarray, "g"]:
        """The row differences of the mean rays at θ, pixels at full size."""
        return self.focal * rectified_at((self.left, self.right), self.projection, chart, theta)[0]

    def _zoom(self, chart: RigChart, theta: Float[np.ndarray, "n"]) -> Float[np.ndarray, "g"]:
        """Pixels of the images that the cameras at θ have, per pixel of a row."""
        return float(np.exp(_by_focal(chart) @ theta)) * self.resolution


def _by_focal(chart: RigChart) -> Float[np.ndarray, "n"]:
    """The logarithm of the mean of both focal lengths, by each parameter: they are in percent."""
    return 0.005 * chart.units * [name.endswith(".f") for name in chart.names]


def grouped(
    found: Correspondences, chart: RigChart, theta: Float[np.ndarray, "n"], first: Int[np.ndarray, "k"] | None = None
) -> Groups:
    """The groups of correspondences, whose rays the cameras of the chart's rig give; outliers are told from the others
    of their group under the rig at θ. `first` has of each frame the first of those that it is one with; default
    itself."""
    focal, scale = float(found.focal), float(found.scale)
    valid = np.asarray(found.weight) > 0
    first = np.arange(len(valid)) if first is None else first
    seen_in = np.nonzero(valid)[0]
    left, right, weight = (np.asarray(part, float)[valid] for part in (found.left, found.right, found.weight))
    if not len(weight):
        no, at = np.zeros(0), np.zeros(0, int)
        return Groups(left, right, no, no, at, at, no, at, focal / scale, no, first, found.projection)
    rows, disparity = (focal * part for part in rectified_at((left, right), found.projection, chart, theta))
    cuts = np.quantile(disparity, np.arange(1, _DISPARITIES) / _DISPARITIES)
    places = places_of(np.asarray(chart.rig.left.project(left)), chart.rig.left.size)
    parts = len(valid), int(np.prod(PLACES)), _DISPARITIES
    key = np.ravel_multi_index((first[seen_in], places, np.searchsorted(cuts, disparity)), parts)
    keys, number, counts = np.unique(key, return_inverse=True, return_counts=True)
    frame, place, _ = np.unravel_index(keys, parts)
    apart = np.abs(rows - group_medians(rows, number, counts)[number])
    spread = 1.4826 * group_medians(apart, number, counts) + _LEAST_SPREAD
    inliers = apart < _FAR_OFF * spread[number]

    def mean(values: Float[np.ndarray, "m"]) -> Float[np.ndarray, "g"]:
        return np.bincount(number, inliers * weight * values, len(keys)) / np.maximum(total, 1e-300)

    total = np.bincount(number, inliers * weight, len(keys))
    n = np.bincount(number, inliers, len(keys)).astype(int)
    mean_left, mean_right = (np.stack([mean(axis) for axis in rays.T], axis=-1) for rays in (left, right))
    resolution = _resolution(chart.rig_at(theta), mean_left, found.projection)
    news, independent = np.ones(len(keys)), float(found.independent)
    if any_same(first):
        news = _news_of_frames(rows, seen_in, number, inliers, spread**2 / independent)
    by_noise = resolution * spread / np.sqrt(np.maximum(news * n * independent, 1.0)) / scale
    # What windows on weak texture have in common is larger, as is their noise; both in pixels of the images.
    in_images, typical = total / np.maximum(n, 1) / resolution**2, float(np.median(weight / resolution[number] ** 2))
    texture = np.maximum(in_images, _LEAST_WEIGHT) / max(typical, _LEAST_WEIGHT)
    deviation = np.hypot(by_noise, FLOOR / np.sqrt(np.minimum(texture, 1.0)))
    told = mean_left, mean_right, mean(rows) / scale, deviation, frame, place, mean(disparity) / scale, n
    enough = news * n > _FEWEST - 0.5
    groups = Groups(*told, focal / scale, resolution, first, found.projection).of(enough)
    if not len(groups):
        return groups
    return replace(groups, offset=groups.offset - groups._of_means(chart, theta))


def _resolution(rig: StereoRig, left: Float[np.ndarray, "g 3"], projection_name: str) -> Float[np.ndarray, "g"]:
    """Pixels of the middle that a row of the view is wide, at rays."""
    to_left, _ = rectifying_rotations(rig.rotation, rig.translation)
    x, y, z = (left @ to_left.T).T
    return np.ones(len(left)) / projection(projection_name).stretch(y, z, np.sqrt(x * x + y * y + z * z))


def _news_of_frames(
    rows: Float[np.ndarray, "m"],
    frame: Int[np.ndarray, "m"],
    number: Int[np.ndarray, "m"],
    inliers: Bool[np.ndarray, "m"],
    noise: Float[np.ndarray, "g"],
) -> Float[np.ndarray, "g"]:
    """The share of its correspondences that tells a group something new, where several frames are in it: what their
    means differ by less than noise would make them, they have in common; `noise` is the variance of one independent
    correspondence."""
    keys, of_frame = np.unique(number[inliers] * (frame.max() + 1) + frame[inliers], return_inverse=True)
    group = keys // (frame.max() + 1)
    frames = np.bincount(group, minlength=len(noise))
    if frames.max() < 2:
        return np.ones(len(noise))
    counts = np.bincount(of_frame)
    means = np.bincount(of_frame, rows[inliers]) / counts
    middle = np.bincount(group, means, len(noise)) / np.maximum(frames, 1)
    several = frames > 1
    between = np.bincount(group, (means - middle[group]) ** 2, len(noise))[several] / (frames[several] - 1)
    expected = noise[several] * (np.bincount(group, 1.0 / counts, len(noise)) / np.maximum(frames, 1))[several]
    independent = float(np.mean(np.minimum(between / expected, 1.0)))
    return 1.0 / (frames * (1.0 - independent) + independent).clip(min=1.0)


def any_same(first: Int[np.ndarray, "k"]) -> bool:
    """Whether frames show the same as an earlier one."""
    return bool((first != np.arange(len(first))).any())


def first_of_same(groups: Groups) -> Int[np.ndarray, "k"]:
    """The first of the frames that show the same as each frame: between them, or between others that do, half of what
    both show hardly changes its disparity."""
    frames, first = np.unique(groups.frame), groups.first.copy()
    disparity = {frame: _disparities(groups.of(groups.frame == frame)) for frame in frames.tolist()}
    for index, frame in enumerate(frames):
        before = frames[:index]
        same = next((one for one in before if _same_disparity(disparity[frame], disparity[one])), frame)
        first[frame] = first[same]
    return first


def _disparities(groups: Groups) -> Float[np.ndarray, "p"]:
    """The mean disparity at each place of the view; NaN where nothing is shown."""
    size = int(np.prod(PLACES))
    number = np.bincount(groups.place, groups.count, size)
    total = np.bincount(groups.place, groups.count * groups.disparity, size)
    return np.where(number > 0, total / np.maximum(number, 1), np.nan)


def _same_disparity(one: Float[np.ndarray, "p"], other: Float[np.ndarray, "p"]) -> bool:
    both = np.isfinite(one) & np.isfinite(other)
    return bool(both.any()) and float(np.median(np.abs(one - other)[both])) < _SAME


def places_of(pixels: Float[np.ndarray, "m 2"], size: tuple[int, int]) -> Int[np.ndarray, "m"]:
    """Places of the left image, of a width and a height, in which pixels lie."""
    share = pixels / np.array(size)
    column, row = (np.clip((share[:, axis] * PLACES[axis]).astype(int), 0, PLACES[axis] - 1) for axis in (0, 1))
    return row * PLACES[0] + column
