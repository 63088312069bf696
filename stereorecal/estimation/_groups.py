"""Correspondences in groups by frame, place and disparity: each group one mean row difference and its deviation.

Neighbours err together (windows overlap, a surface slants), so many correspondences of one place tell little more than
a few; and what lies near and far there tells apart what a mean of both would hide.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from stereorecal.geometry import PINHOLE, StereoRig, projection, rectifying_rotations, with_unit_baseline
from stereorecal.objectives import LinearRows, RigChart, differences_at, linearised
from stereorecal.scoring import Correspondences, with_rays_of

PLACES = (14, 9)  # columns and rows of places in the left image
_DISPARITIES = 3  # near, middle, far: a third of all correspondences each
_FEWEST = 4  # correspondences in a group
FEWEST_GROUPS = 6  # from fewer nothing is to be learnt of a rig
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
        frame, place: (g,) of each group; places are numbered by rows.
        disparity: (g,) pixels at full size, under the rig at which they were grouped.
        count: (g,) correspondences.
        focal: of the rectified rows, in pixels at full size.
        resolution: (g,) pixels of the middle that a row of the view is wide there: 1 of pinholes, less where a view
            stretches what a wide lens shows.
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
    projection: str = PINHOLE

    def __len__(self) -> int:
        return len(self.offset)

    def of(self, which: Any) -> "Groups":
        """Some of them."""
        names = ("left", "right", "offset", "deviation", "frame", "place", "disparity", "count", "resolution")
        return replace(self, **{name: getattr(self, name)[which] for name in names})

    def rows(self, chart: RigChart, theta: Float[np.ndarray, "n"]) -> LinearRows:
        """Their mean row differences at θ and the derivatives there, in pixels of the images that the cameras at θ
        have: (1, g), (n, 1, g). Noise is in those: longer focal lengths must not make it smaller, nor rows that are
        wider apart in the view make it larger."""
        rows = linearised(self._as_correspondences(), chart, theta)
        by_focal, zoom = _by_focal(chart), self._zoom(chart, theta)
        differences = zoom * (rows.differences + self.offset)
        jacobian = zoom * rows.jacobian + by_focal[:, None, None] * differences
        return replace(rows, differences=differences, jacobian=jacobian)

    def differences(self, chart: RigChart, theta: Float[np.ndarray, "n"]) -> Float[np.ndarray, "g"]:
        """The same without the derivatives."""
        (rows,) = differences_at(self._as_correspondences(), chart, theta)
        return self._zoom(chart, theta) * (rows + self.offset)

    def _zoom(self, chart: RigChart, theta: Float[np.ndarray, "n"]) -> Float[np.ndarray, "g"]:
        """Pixels of the images that the cameras at θ have, per pixel of a row."""
        return float(np.exp(_by_focal(chart) @ theta)) * self.resolution

    def _as_correspondences(self) -> Correspondences:
        number, one = len(self), np.ones(())
        weight, tile = np.ones((1, number)), np.zeros((1, number), np.int32)
        focal = np.asarray(self.focal)
        return Correspondences(self.left[None], self.right[None], weight, tile, focal, one, one, self.projection)


def _by_focal(chart: RigChart) -> Float[np.ndarray, "n"]:
    """The logarithm of the mean of both focal lengths, by each parameter: they are in percent."""
    return 0.005 * chart.units * [name.endswith(".f") for name in chart.names]


def grouped(found: Correspondences, chart: RigChart, theta: Float[np.ndarray, "n"]) -> Groups:
    """The groups of correspondences, whose rays the cameras of the chart's rig give; outliers are told from the others
    of their group under the rig at θ."""
    focal, scale = float(found.focal), float(found.scale)
    valid = np.asarray(found.weight) > 0
    frame = np.nonzero(valid)[0]
    left, right, weight = (np.asarray(part, float)[valid] for part in (found.left, found.right, found.weight))
    rows, disparity = _rectified(found, chart, theta, valid)
    places = places_of(np.asarray(chart.rig.left.project(left)), chart.rig.left.size)
    if not valid.any():
        nothing, numbers = np.zeros(0), np.zeros(0, int)
        return Groups(
            left, right, nothing, nothing, numbers, numbers, nothing, numbers, focal / scale, nothing, found.projection
        )
    cuts = np.quantile(disparity, np.arange(1, _DISPARITIES) / _DISPARITIES) if len(disparity) else []
    key = (frame * np.prod(PLACES) + places) * _DISPARITIES + np.searchsorted(cuts, disparity)
    order = np.argsort(key, kind="stable")
    keys, first, counts = np.unique(key[order], return_index=True, return_counts=True)
    number = np.repeat(np.arange(len(keys)), counts)
    rows, disparity, weight = rows[order], disparity[order], weight[order]
    middle = _group_medians(rows, number, first, counts)
    spread = 1.4826 * _group_medians(np.abs(rows - middle[number]), number, first, counts) + _LEAST_SPREAD
    inliers = np.abs(rows - middle[number]) < _FAR_OFF * spread[number]

    def mean(values):
        return np.bincount(number, inliers * weight * values, len(keys)) / np.maximum(total, 1e-300)

    total = np.bincount(number, inliers * weight, len(keys))
    n = np.bincount(number, inliers, len(keys)).astype(int)
    means = {
        name: np.stack([mean(rays[order][:, axis]) for axis in range(3)], axis=-1)
        for name, rays in (("left", left), ("right", right))
    }
    resolution = _resolution(chart.rig_at(theta), means["left"], found.projection)
    by_noise = resolution * spread / np.sqrt(np.maximum(n * float(found.independent), 1.0)) / scale
    # What windows on weak texture have in common is larger, as is their noise; both in pixels of the images.
    in_images, typical = total / np.maximum(n, 1) / resolution**2, float(np.median(weight / resolution[number] ** 2))
    texture = np.maximum(in_images, _LEAST_WEIGHT) / max(typical, _LEAST_WEIGHT)
    deviation = np.hypot(by_noise, FLOOR / np.sqrt(np.minimum(texture, 1.0)))
    groups = Groups(
        **means,
        offset=np.zeros(len(keys)),
        deviation=deviation,
        frame=frame[order][first],
        place=places[order][first],
        disparity=mean(disparity) / scale,
        count=n,
        focal=focal / scale,
        resolution=resolution,
        projection=found.projection,
    ).of(n >= _FEWEST)
    if not len(groups):
        return groups
    of_rays = differences_at(groups._as_correspondences(), chart, theta)[0]
    return replace(groups, offset=(mean(rows) / scale)[n >= _FEWEST] - of_rays)


def _rectified(found: Correspondences, chart: RigChart, theta: Float[np.ndarray, "n"], valid):
    """Row differences and disparities of what was found, in pixels of its scale, under the rig at θ."""
    rig = chart.rig_at(theta)
    read = with_rays_of(rig, found, matched_rig=chart.rig)
    extrinsics = with_unit_baseline(rig.extrinsics)
    rotations = rectifying_rotations(rig.rotation, extrinsics[3:])
    of_view = projection(found.projection)
    (x, y), (u, v) = (
        of_view.project(*(np.asarray(rays, float)[valid] @ rotation.T).T)
        for rays, rotation in zip((read.left, read.right), rotations, strict=True)
    )
    return float(found.focal) * (y - v), float(found.focal) * (x - u)


def _resolution(rig: StereoRig, left: Float[np.ndarray, "g 3"], projection_name: str) -> Float[np.ndarray, "g"]:
    """Pixels of the middle that a row of the view is wide, at rays."""
    to_left, _ = rectifying_rotations(rig.rotation, rig.translation)
    x, y, z = (left @ to_left.T).T
    return np.ones(len(left)) / projection(projection_name).stretch(y, z, np.sqrt(x * x + y * y + z * z))


def places_of(pixels: Float[np.ndarray, "m 2"], size: tuple[int, int]) -> Int[np.ndarray, "m"]:
    """Places of the left image, of a width and a height, in which pixels lie."""
    share = pixels / np.array(size)
    column, row = (np.clip((share[:, axis] * PLACES[axis]).astype(int), 0, PLACES[axis] - 1) for axis in (0, 1))
    return row * PLACES[0] + column


def _group_medians(values, number, first, counts) -> Float[np.ndarray, "g"]:
    """The median of the values of each group; `number` runs up."""
    ordered = values[np.lexsort((values, number))]
    return 0.5 * (ordered[first + (counts - 1) // 2] + ordered[first + counts // 2])
