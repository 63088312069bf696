"""What a rig's errors do: epipolar errors and wrong disparities of points over the view, at some distances.

Both follow points of the world: the true rig says in which pixels they appear, the used one reads those pixels. If the
truth is one of many rigs, drawn from a posterior, readings are exact at its mean, and linear around it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Inexact, Int

from stereorecal.estimation._mixture import remembered
from stereorecal.estimation._rig_parameters import moved_by_extrinsics, rays_by_lens
from stereorecal.geometry import (
    PINHOLE,
    Camera,
    Projection,
    StereoRig,
    View,
    projection,
    rectifying_rotations,
    reread,
    view as view_of,
)
from stereorecal.objectives import SIDES, RigChart

DISTANCES = (5, 10, 30, 100)  # baselines
_GRID = (9, 7)  # points of the left image
AHEAD = 0.1  # cosine of the angle off the axis
_FLAT = 2.0  # tangent of it: farther aside, a pinhole stretches the image five times, and no view shows it
_REACHED = 0.97  # of the angle up to which a lens model is good: a little other parameters end it sooner
_MARGIN = 0.05  # of the image, at each side
_TINY = 1e-30
_MIDDLE = 0.5  # of the image, each way


def points_of_view(rig: StereoRig, distance: float, view: View | None = None) -> Float[np.ndarray, "p 3"]:
    """Points over the left image, at a distance along its axis in baselines, that both cameras see, or, where that is
    too near for both, that the lens models reach; metres. Of a wide lens, of whatever model, or in a view that is no
    pinhole, over what the view shows of it; where that is no pinhole, at a distance from the left camera. The view is
    by default the rig's own pinhole."""
    (width, height), pinhole = rig.left.size, view is None or view.projection == PINHOLE
    rays = np.asarray(rig.left.rays(_pixel_grid(rig.left.size)))
    if rig.left.lens.WIDE or not pinhole or np.hypot(rays[:, 0], rays[:, 1]).max() > _FLAT:
        rays = _rays_of_view(rig, view_of(rig, projection=PINHOLE) if view is None else view)
    away = distance * float(rig.baseline)
    points = rays * away if pinhole else rays * (away / np.linalg.norm(rays, axis=1))[:, None]
    right = points @ rig.rotation.T + rig.translation
    ahead = (right[:, 2] > 0.0) & within_lens(rig.left, rays)
    at_1 = right / np.where(ahead, right[:, 2], 1.0)[:, None]
    inside = within_lens(rig.right, at_1)
    pixels = np.asarray(rig.right.project(at_1))
    by_both = ahead & inside & ((pixels >= 0.0) & (pixels <= np.array([width, height]) - 1.0)).all(axis=-1)
    return points[by_both] if by_both.any() else points[ahead & inside]


def within_lens(camera: Camera, rays: Float[np.ndarray, "p 3"]) -> Bool[np.ndarray, "p"]:
    """Whether rays at depth 1 are well within what the lens model is good for."""
    radius = np.hypot(rays[:, 0], rays[:, 1])
    return (radius < float(camera.lens_radius)) & (np.arctan(radius) < _REACHED * float(camera.lens_field))


def _pixel_grid(size: tuple[int, int]) -> Float[np.ndarray, "p 2"]:
    """Pixels over an image."""
    share = [np.linspace(_MARGIN, 1.0 - _MARGIN, n) for n in _GRID]
    return np.stack(np.meshgrid(*share), axis=-1).reshape(-1, 2) * [size[0] - 1, size[1] - 1]


def _weights(
    rig: StereoRig, points: Float[np.ndarray, "p 3"], which: Int[np.ndarray, "p"], view: View | None
) -> Float[np.ndarray, "2 p"]:
    """The weights of each set of points in a mean over the view, and over what lies ahead: the middle of the left
    image; over the view again where nothing does. In views that are no pinhole, points count by the squares of their
    disparities."""
    of_image = np.asarray(rig.left.project(points / points[:, 2:])) / np.array(rig.left.size)
    ahead = (np.abs(of_image - 0.5) <= 0.5 * _MIDDLE).all(axis=1)
    ahead |= np.bincount(which, ahead)[which] == 0
    weights = _stretch(rig, points, view) ** -2 * np.stack([np.ones(len(points)), ahead])
    return weights / np.stack([np.bincount(which, some)[which] for some in weights])


def _rays_of_view(rig: StereoRig, view: View) -> Float[np.ndarray, "_ 3"]:
    """Rays of the left camera, at depth 1; without the corners of a fisheye, which lie on no plane."""
    to_left, _ = rectifying_rotations(rig.rotation, rig.translation)
    columns, rows = _pixel_grid(view.size).T
    rays = np.asarray(view.directions(columns, rows, 0)) @ to_left
    rays = rays[rays[:, 2] > AHEAD * np.linalg.norm(rays, axis=1)]
    pixels = rig.left.project(rays)
    inside = ((pixels >= 0.0) & (pixels <= np.array(rig.left.size) - 1.0)).all(axis=1)
    return rays[inside] / rays[inside, 2:]


def readings(
    used: StereoRig, true: StereoRig, points: Float[np.ndarray, "p 3"], view: View | None = None
) -> tuple[Float[np.ndarray, "p"], Float[np.ndarray, "p"]]:
    """Row differences of points, and their relative errors of disparity (true depth over that read, less 1), as `used`
    reads the pixels in which `true` sees them; rows in pixels of the mean focal length of `used`, as wide as they are
    in the middle: where a view stretches rows, images are blurred by as much. The view in which both are read is by
    default a pinhole."""
    return readings_of_rays(used, *rays_read(used, true, points), points, view)


def rays_read(
    used: StereoRig, true: StereoRig, points: Float[np.ndarray, "p 3"]
) -> tuple[Float[np.ndarray, "p 3"], Float[np.ndarray, "p 3"]]:
    """Rays at depth 1 that the cameras of `used` give to the pixels in which those of `true` see points."""
    right = points @ true.rotation.T + true.translation
    left, right = points / points[:, 2:], right / right[:, 2:]
    return reread(left, true.left, used.left), reread(right, true.right, used.right)


def readings_of_rays(
    used: StereoRig,
    left: Float[np.ndarray, "p 3"],
    right: Float[np.ndarray, "p 3"],
    points: Float[np.ndarray, "p 3"],
    view: View | None = None,
) -> tuple[Float[np.ndarray, "p"], Float[np.ndarray, "p"]]:
    """`readings` of the rays that the used cameras give, of points in the frame of the true left camera."""
    to_left, to_right = rectifying_rotations(used.rotation, used.translation)
    rows, nearness = _rows_and_nearness(_formulas(view), left @ to_left.T, right @ to_right.T)
    relative = points[:, 2] / float(used.baseline) * nearness - 1.0
    return np.asarray(_focal(used) * rows / _stretch(used, points, view)), relative


def nearness_of(
    rig: StereoRig, left: Float[np.ndarray, "p 3"], right: Float[np.ndarray, "p 3"], view: View | None = None
) -> Float[np.ndarray, "p"]:
    """Baselines over depth along the axis of the left camera, of points that both cameras see along these rays; 0 of
    what they see behind themselves. In a view as `readings` has it."""
    to_left, to_right = rectifying_rotations(rig.rotation, rig.translation)
    left = left / left[:, 2:]
    _, nearness = _rows_and_nearness(_formulas(view), left @ to_left.T, right @ to_right.T)
    points = left * (float(rig.baseline) / np.where(nearness > 0.0, nearness, 1.0))[:, None]
    ahead = (points @ rig.rotation.T + rig.translation)[:, 2] > 0.0
    return np.where(ahead & (nearness > 0.0), nearness, 0.0)


def _formulas(view: View | None) -> Projection:
    return projection(PINHOLE) if view is None else view.formulas


def _rows_and_nearness(
    formulas: Projection, left: Inexact[np.ndarray, "*p 3"], right: Inexact[np.ndarray, "*p 3"]
) -> tuple[Inexact[np.ndarray, "*p"], Inexact[np.ndarray, "*p"]]:
    """Row differences in focal lengths, and baselines over depth along the axis of the left camera, of rectified rays
    (*p, 3) that are at depth 1 of the cameras; analytic."""
    (u, row), (v, other) = (formulas.project(*np.moveaxis(rays, -1, 0)) for rays in (left, right))
    return row - other, formulas.nearness(u, v) * formulas.length(*np.moveaxis(left, -1, 0))


def _stretch(used: StereoRig, points: Float[np.ndarray, "p 3"], view: View | None) -> Float[np.ndarray, "p"]:
    """How much the view stretches the rows of points; their disparities tell less by as much."""
    if view is None or view.projection == PINHOLE:
        return np.ones(len(points))
    x, y, z = (points @ rectifying_rotations(used.rotation, used.translation)[0].T).T
    return view.formulas.stretch(y, z, np.sqrt(x * x + y * y + z * z))


def _focal(used: StereoRig) -> float:
    """The mean focal length."""
    return float(np.mean([used.left.focal, used.right.focal]))


@dataclass(frozen=True, eq=False)
class Consequences:
    """`readings` near a used rig, linear in what the truth differs by.

    Attributes:
        distances: in baselines, of the first sets of points.
        points: (p, 3), set by set.
        which: (p,) the number of the set of each.
        rows: (p, n) pixels a unit of θ(used) - θ(true).
        nearness: (p, n) relative error of disparity, likewise.
        weights: (2, p) of each point in a mean of its set over the view, and over what lies ahead.
    """

    distances: tuple[float, ...]
    points: Float[np.ndarray, "p 3"]
    which: Int[np.ndarray, "p"]
    rows: Float[np.ndarray, "p n"]
    nearness: Float[np.ndarray, "p n"]
    weights: Float[np.ndarray, "2 p"]

    @property
    def at_distances(self) -> list[tuple[float, Bool[np.ndarray, "p"]]]:
        """Each of the distances, and which points lie there."""
        return [(distance, self.which == number) for number, distance in enumerate(self.distances)]

    @cached_property
    def mean_nearness(self) -> Float[np.ndarray, "d n"]:
        """Mean relative error of disparity over the view at each of the distances."""
        return self.mean_over_view(self.nearness)

    def mean_over_view(self, values: Float[np.ndarray, "p *n"]) -> Float[np.ndarray, "d *n"]:
        """The mean of values at all points over the view, at each of the distances."""
        return np.stack([self.weights[0, there] @ values[there] for _, there in self.at_distances])


def consequences(
    chart: RigChart,
    theta: Float[np.ndarray, "n"],
    distances: tuple[float, ...] = DISTANCES,
    view: View | None = None,
    more: Sequence[Float[np.ndarray, "_ 3"]] = (),
) -> Consequences:
    """The linear maps at the rig at θ, at distances in baselines, in a view as `points_of_view` and `readings` have
    it, and at more sets of points."""
    used = chart.rig_at(theta)
    sets = [*(points_of_view(used, distance, view) for distance in distances), *more]
    points, which = np.concatenate(sets), np.repeat(np.arange(len(sets)), [len(some) for some in sets])
    right = points @ used.rotation.T + used.translation
    # How the rays that the used cameras give move if the truth is another: those of pixels that stay, the other way.
    left_rays, right_rays = (np.zeros((chart.dim, *points.shape)) for _ in SIDES)
    for side, camera_points, moved in zip(SIDES, (points, right), (left_rays, right_rays), strict=True):
        own, by_lens = rays_by_lens(chart, used, side, camera_points)
        moved[own] = by_lens
    outer, by_extrinsics = moved_by_extrinsics(chart, used, points)
    right_rays[outer] = -(by_extrinsics - right / right[:, 2:] * by_extrinsics[..., 2:]) / right[:, 2:]
    to_left, to_right = rectifying_rotations(used.rotation, used.translation)
    # Complex steps (Squire & Trapp 1998): derivatives of rows and nearness, exact.
    turned = (
        (camera_points / camera_points[:, 2:] + _TINY * 1j * moved) @ np.asarray(rotation).T
        for camera_points, moved, rotation in ((points, left_rays, to_left), (right, right_rays, to_right))
    )
    rows, inverse_depth = _rows_and_nearness(_formulas(view), *turned)
    rows = _focal(used) * np.imag(rows) / _stretch(used, points, view) / _TINY
    nearness = np.imag(inverse_depth) / np.real(inverse_depth) / _TINY
    return Consequences(distances, points, which, rows.T, nearness.T, _weights(used, points, which, view))


@dataclass(frozen=True, eq=False)
class Readings:
    """What rigs read if one of them is the true one: exact if it is that at θ = at, linear around it.

    Attributes:
        chart: from θ to rigs.
        at: θ of the rig that is taken for the true one.
        view: in which rows and depth are read; None: the rig's own pinhole.
        near: the points, and slopes by θ at or near that rig.
    """

    chart: RigChart
    at: Float[np.ndarray, "n"]
    view: View | None
    near: Consequences

    @remembered  # where a search ends, the decision begins
    def of(self, used: Float[np.ndarray, "n"]) -> Float[np.ndarray, "2 p"]:
        """Epipolar errors [pixels] and relative errors of disparity of the rig at θ = used; read-only."""
        rig = self.chart.rig_at(used)
        kept = rig.left is self.chart.rig.left and rig.right is self.chart.rig.right
        rays = self._given_rays if kept else rays_read(rig, self.true, self.near.points)
        found = np.stack(readings_of_rays(rig, *rays, self.near.points, self.view))
        found.flags.writeable = False
        return found

    @cached_property
    def true(self) -> StereoRig:
        """The rig that is taken for the true one."""
        return self.chart.rig_at(self.at)

    @cached_property
    def _given_rays(self) -> tuple[Float[np.ndarray, "p 3"], Float[np.ndarray, "p 3"]]:
        """What the given cameras read, which most candidates keep."""
        return rays_read(self.chart.rig, self.true, self.near.points)
