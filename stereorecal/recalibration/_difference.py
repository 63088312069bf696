"""What one calibration changes against another, in the units in which people read it: rotation, epipolar errors, errors
of depth.

Errors follow a point of the world: the better rig says in which pixels it appears, and the one that is used reads those
pixels in its own way. Everything is NumPy in float64.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray, json_data, refuse_tracers
from stereorecal._errors import InputError
from stereorecal.estimation import DISTANCES, readings
from stereorecal.geometry import (
    AXES,
    AnyView,
    Camera,
    StereoRig,
    View,
    angle_between,
    as_view,
    axis_changes,
    checked_rig,
    rectifying_rotations,
    reread,
    same_cameras,
)
from stereorecal.report.number_text import between, change, distance

ROW_DISTANCES = (10.0, np.inf)  # baselines
STEP = 1e-3  # of the box, for derivatives: some hundredths of a degree
_MOST = 0.9  # of the view
_GRID = (32, 24)  # columns and rows: as many as show what a lens or a roll does


def depth_errors(used: StereoRig, better: StereoRig) -> Mapping[int, float]:
    """How many percent the depth is wrong that `used` reports, if `better` is right, at some distances.

    For a point straight ahead of the rig at 5, 10, 30 and 100 baselines: projected into both cameras through `better`,
    rectified by `used`, whose disparity gives the depth. Positive: reported too far. Infinite where that disparity is
    not positive; NaN where the right camera does not see the point.
    """
    away = np.outer(float(better.baseline) * np.array(DISTANCES), [0.0, 0.0, 1.0])
    nearness = 1.0 + readings(used, better, away)[1]
    nearness[away @ better.rotation[2] + better.translation[2] <= 0.0] = np.nan
    return {distance: depth_error(one) for distance, one in zip(DISTANCES, nearness.tolist(), strict=True)}


def depth_error(nearness: float) -> float:
    """The error of depth in percent, positive: too far; infinite where points seem to lie beyond infinity."""
    return float("inf") if nearness <= 0.0 else 100.0 * (1.0 / nearness - 1.0)


def row_errors_of(
    used: StereoRig,
    better: StereoRig,
    view: View,
    columns: Float[np.ndarray, "w"],
    rows: Float[np.ndarray, "h"],
    distances: Sequence[float] = ROW_DISTANCES,
) -> Float[np.ndarray, "distances h w"]:
    """Row of a point in the left image rectified by `used` less its row in the right one, if `better` is right.

    Args:
        view: in which `used` rectifies.
        columns, rows: of the points in the left image of the view, in its pixels.
        distances: of the points from the left camera along its axis, in baselines.

    Returns:
        pixels of the view, at each distance; NaN where not both cameras see the point.
    """
    to_left, to_right = rectifying_rotations(used.rotation, used.translation)
    in_view = np.meshgrid(columns, rows)
    rays = np.asarray(view.directions(*in_view, 0)) @ to_left
    true = _reread(rays, used.left, better.left)
    row_errors = []
    for baselines in distances:
        from_right = true @ better.rotation.T + better.translation / (baselines * float(better.baseline))
        read = _reread(from_right, better.right, used.right) @ to_right.T
        row_errors.append(in_view[1] - view.pixels(_at_depth_1(read), 1)[1])
    return np.stack(row_errors)


def _reread(rays: Float[AnyArray, "*n 3"], true: Camera, read: Camera) -> Float[np.ndarray, "*n 3"]:
    """Where `read` takes points to lie that `true` sees along `rays`, at depth 1; NaN where they miss its image."""
    return _within_lens(reread(_nan_outside_image(rays, true), true, read), read)


def _nan_outside_image(rays: Float[AnyArray, "*n 3"], camera: Camera) -> Float[np.ndarray, "*n 3"]:
    """The rays, NaN where they miss the camera's image."""
    rays = _within_lens(_at_depth_1(rays), camera)
    pixels = camera.project(rays)
    inside = (pixels >= 0.0) & (pixels <= np.array(camera.size) - 1.0)
    return np.where(inside.all(axis=-1, keepdims=True), rays, np.nan)


def _at_depth_1(rays: Float[AnyArray, "*n 3"]) -> Float[np.ndarray, "*n 3"]:
    """(x/z, y/z, 1); NaN behind the camera."""
    rays = np.asarray(rays)
    return rays / np.where(rays[..., 2:] > 0.0, rays[..., 2:], np.nan)


def _within_lens(rays: Float[AnyArray, "*n 3"], camera: Camera) -> Float[np.ndarray, "*n 3"]:
    """Rays at depth 1, NaN beyond the radius that the lens model is good for."""
    return np.where(np.hypot(rays[..., :1], rays[..., 1:2]) < float(camera.lens_radius), rays, np.nan)


@dataclass(frozen=True, eq=False)
class Difference:
    """What a calibration `after` changes against a calibration `before`.

    Rows and depth say what goes wrong for those who use `before` if `after` is right; different intrinsics enter there.

    Attributes:
        rotation_deg: change of pitch, yaw and roll, in degrees, by name.
        angle_deg: of the rotation that leads from one to the other, in degrees.
        translation_percent: change of y and z, in percent of the baseline, by name: of its direction, as in
            `axis_errors`.
        baseline_percent: by how much the baseline is longer.
        same_intrinsics: whether the cameras are the same.
        baseline: of `after`, metres.
        depth_error_percent: of `before`, in percent, at 5, 10, 30 and 100 baselines; positive: too far; infinite where
            the rays of a point do not meet.
        columns, rows: of the grid of points, in pixels of the view of `before`.
        row_differences: row in the left rectified image less the row in the right one, in pixels of that view, for
            points at 10 baselines (the first plane) and at infinity (the second); NaN where not both cameras see the
            point.
    """

    rotation_deg: Mapping[str, float]
    angle_deg: float
    translation_percent: Mapping[str, float]
    baseline_percent: float
    same_intrinsics: bool
    baseline: float
    depth_error_percent: Mapping[int, float]
    columns: Float[np.ndarray, "w"]
    rows: Float[np.ndarray, "h"]
    row_differences: Float[np.ndarray, "2 h w"]

    @property
    def row_map(self) -> Float[np.ndarray, "h w"]:
        """The row differences, with their signs, at whichever distance they are larger."""
        larger = np.argmax(np.nan_to_num(np.abs(self.row_differences), nan=-1.0), axis=0)
        return np.take_along_axis(self.row_differences, larger[None], axis=0)[0]

    @property
    def row_error_median(self) -> float:
        """Median |row difference| over the grid and both distances, in pixels; NaN if nothing is seen."""
        return self._row_error(0.5)

    @property
    def row_error_most(self) -> float:
        """90th percentile of |row difference|, in pixels; NaN if nothing is seen."""
        return self._row_error(_MOST)

    @property
    def row_error_worst(self) -> float:
        """Largest |row difference|, in pixels; NaN if nothing is seen."""
        return self._row_error(1.0)

    def _row_error(self, share: float) -> float:
        errors = np.abs(self.row_differences[np.isfinite(self.row_differences)])
        return float(np.quantile(errors, share)) if errors.size else float("nan")

    @property
    def depth_text(self) -> str:
        """The errors of depth, by distance."""
        said = []
        for baselines, percent in self.depth_error_percent.items():
            metres = baselines * self.baseline
            wrong = 0.01 * percent * metres
            said.append(f"{between(wrong, wrong)} ({change(percent, 'far')}) at {distance(metres)}")
        return ", ".join(said)

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON; None for what is infinite or unknown."""
        return json_data(
            {
                "rotation_deg": dict(self.rotation_deg),
                "angle_deg": self.angle_deg,
                "translation_percent": dict(self.translation_percent),
                "baseline_percent": self.baseline_percent,
                "same_intrinsics": self.same_intrinsics,
                "row_error_px": {
                    "median": self.row_error_median,
                    "percentile_90": self.row_error_most,
                    "worst": self.row_error_worst,
                },
                "row_map": {"columns": self.columns, "rows": self.rows, "difference_px": self.row_map},
                "depth_error_percent": dict(self.depth_error_percent),
            }
        )

    def __str__(self) -> str:
        angles = ", ".join(f"{name} {value:+z.3f}" for name, value in self.rotation_deg.items())
        shifts = ", ".join(f"{name} {value:+z.2f} %" for name, value in self.translation_percent.items())
        rows = "no point of the view is seen by both cameras"
        if not np.isnan(self.row_error_median):
            rows = (
                f"error {self.row_error_median:.2f} px (median over the view), within {self.row_error_most:.2f} px in "
                f"{100 * _MOST:.0f} % of it"
            )
            if self.row_error_worst >= 0.005:  # else rounding chooses the point
                row, column = np.unravel_index(np.nanargmax(np.abs(self.row_map)), self.row_map.shape)
                where = f"({self.columns[column]:.0f}, {self.rows[row]:.0f})"
                rows += f"; the worst point, {where}, has {self.row_error_worst:.2f} px"
        lines = [
            f"rotation  {self.angle_deg:.3f} deg: {angles}",
            f"baseline  {shifts}, length {change(self.baseline_percent, 'long')}",
            f"epipolar  {rows}",
            f"depth     {self.depth_text}",
        ]
        return "\n".join(lines if self.same_intrinsics else [*lines, "cameras   the intrinsics differ too"])


def difference(before: StereoRig, after: StereoRig, *, view: AnyView = None) -> Difference:
    """What a calibration changes against another one of the same rig.

    Args:
        before, after: the calibrations; intrinsics may differ, the size of the images may not.
        view: in which rows are compared; default the view of `before`.

    Raises:
        InputError: if the calibrations are for images of different sizes.
    """
    refuse_tracers("sr.difference", "differences of the extrinsics", before, after)
    before, after = checked_rig(before, "before"), checked_rig(after, "after")
    _check_sizes(before, after)
    view = as_view(view, before)
    changes = dict(zip(AXES, axis_changes(before, after).tolist(), strict=True))
    columns, rows = (np.linspace(0.0, size - 1.0, count) for size, count in zip(view.size, _GRID, strict=True))
    return Difference(
        rotation_deg={name: changes[name] for name in AXES[:3]},
        angle_deg=float(np.degrees(angle_between(before.rotation, after.rotation))),
        translation_percent={name: changes[name] for name in ("y", "z")},
        baseline_percent=float(100.0 * (after.baseline / before.baseline - 1.0)),
        same_intrinsics=same_cameras(before, after),
        baseline=float(after.baseline),
        depth_error_percent=depth_errors(before, after),
        columns=columns,
        rows=rows,
        row_differences=row_errors_of(before, after, view, columns, rows),
    )


def _check_sizes(before: StereoRig, after: StereoRig) -> None:
    for side in ("left", "right"):
        sizes = ["x".join(map(str, getattr(rig, side).size)) for rig in (before, after)]
        if sizes[0] != sizes[1]:
            raise InputError(
                f"the calibrations are for {side} images of {sizes[0]} and of {sizes[1]}; resize one with "
                "`StereoRig.resized`."
            )
