"""Simulated calibrations without images, to count on thousands of rigs what is rare.

A true rig is drawn, calibrated by OpenCV on simulated chessboards as an honest user would do it, drifts, and sees
scenes, of which `Simulated.correspondences` gives what the library's matcher would find, in raw images or in images
that were rectified by the calibration. Nothing in here is part of any estimate: it is a judge.

**Odd seeds stay unseen until the end**: whatever is chosen or tuned is chosen on even ones, and shown on odd ones.

Calibrations are kept in a folder, by seed (`simulated_calibrations.py`); all else is drawn anew, the same for a seed.
"""

import functools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from simulated_calibrations import calibration
from simulated_cameras import Eye, project, rays
from simulated_scenes import inverse_depth, matching_errors, unmatched

import stereorecal as sr
from stereorecal.geometry import PINHOLE, rectifying_rotations
from stereorecal.scoring import TILES, Correspondences

AXES = ("pitch", "yaw", "roll", "y", "z")
DRIFTS = ("none", "all", "yaw", "pitch", "roll")
DEGREES = (0.1, 0.3, 0.5, 2.5)
BASELINES = (4.0, 10.0, 30.0, 100.0)
CELLS, WINDOW = 4800, 11  # of the library's matcher: cells of a frame, pixels of a window
SHIFT = 0.009  # drift of y and z for a degree, in baselines
_DRIFT, _SCENE = 1, 2  # streams of random numbers of a seed; that of its calibration is another


def independent(side: int) -> float:
    """The share of the library's cells that is independent, as the library has it, since their windows overlap. Those
    simulated here are independent but for a smooth field: what is said of them is on the safe side."""
    reached = np.convolve(np.ones(WINDOW), np.ones(side))
    return float(side * np.sum(reached**2) / np.sum(reached) ** 2) ** 2


@dataclass(frozen=True, eq=False)
class Simulated:
    """A rig whose calibration is known, and whose truth is known too.

    Attributes:
        calibrated: what the user has: the stored rig.
        left, right, rotation, translation: the truth after the drift; `x_right = rotation x_left + translation`, in the
            frames of the images.
        true_raw: the true rig after the drift, as it is; that of the images unless these were `rectified`.
        rectified: whether the images were rectified by the calibration: one K, no distortion, R = I.
    """

    seed: int
    calibrated: sr.StereoRig
    left: Eye
    right: Eye
    rotation: np.ndarray
    translation: np.ndarray
    true_raw: sr.StereoRig
    rectified: bool

    # What a matcher finds.

    def correspondences(self, frames: int = 1) -> Correspondences:
        """What the library's matcher would find in `frames` scenes: rays that the calibrated cameras give to true
        pixels with errors."""
        view, side, (to_left, _) = self._view, self._side, self._rotations
        columns, rows = view.size[0] // side, view.size[1] // side
        found = []
        for frame in range(frames):
            rng = np.random.default_rng([self.seed, _SCENE, 0, frame])
            x, y = (axis.ravel() for axis in np.meshgrid(np.arange(columns), np.arange(rows)))
            where = (np.stack([x, y], axis=1) + 0.5) * side - 0.5 + rng.normal(0.0, side / 8, (x.size, 2))
            given = np.asarray(view.directions(*where.T, 0)) @ to_left
            if view.projection != PINHOLE:  # what has no ray (x/z, y/z, 1) is not looked at
                flat = np.hypot(given[:, 0], given[:, 1]) < self.calibrated.left.lens_radius * given[:, 2]
                given = np.where(flat[:, None], given, [0.0, 0.0, 1.0])
            true = self.left.rays(project(self.calibrated.left, given))
            points = true / inverse_depth(true, rng)[:, None] * self._baseline
            right = self.right.pixels(points @ self.rotation.T + self.translation)
            error, variance = matching_errors(columns, rows, rng)
            if view.projection != PINHOLE:  # what a matcher believes is in its own rows
                beside = [right + np.array([0.0, off]) for off in (-0.5, 0.5)]
                shown = [view.pixels(rays(self.calibrated.right, ends) @ self._rotations[1].T, 1)[1] for ends in beside]
                variance = np.nan_to_num(variance * (shown[1] - shown[0]) ** 2, nan=np.inf)
            seen = rays(self.calibrated.right, right + error)
            good = np.isfinite(seen).all(axis=1) & ~unmatched(columns, rows, rng)
            if view.projection != PINHOLE:
                good &= flat
            weight = np.where(good, 1.0 / variance, 0.0)
            found.append((given, np.where(good[:, None], seen, given), weight))
        left, right, weight = (np.stack(part).astype(np.float32) for part in zip(*found, strict=True))
        tile = (np.arange(rows) * TILES[1] // rows)[:, None] * TILES[0] + np.arange(columns) * TILES[0] // columns
        return Correspondences(
            left,
            right,
            weight / weight[weight > 0].mean(),
            (np.arange(frames)[:, None] * TILES[0] * TILES[1] + tile.ravel()).astype(np.int32),
            np.asarray(view.focal, np.float32),
            np.asarray(1.0, np.float32),
            np.asarray(independent(side), np.float32),
            view.projection,
        )

    # Judges: points of the world, where they truly appear, as `rig` reads them.

    def rows_px(self, rig: sr.StereoRig, baselines: Sequence[float] = BASELINES, *, rms: bool = False) -> np.ndarray:
        """Median (or root mean square) |row difference| over the view under `rig` at these distances, in pixels of the
        stored rig's view."""
        apart = [rows for rows, _, _ in self.readings(rig, baselines)]
        return np.array([_rms(a) if rms else _median(np.abs(a)) for a in apart])

    def depth_error_percent(self, rig: sr.StereoRig, baselines: Sequence[float] = BASELINES) -> np.ndarray:
        """Median error of the depth that `rig` reads over the central half of the view, positive: too far; infinite
        where points seem to lie beyond infinity."""
        return np.array([_median(errors) for errors in self._depth_errors_percent(rig, baselines)])

    def absolute_depth_error_percent(self, rig: sr.StereoRig, baselines: Sequence[float] = BASELINES) -> np.ndarray:
        """The same of |errors|: where depth is too near on one side of the view and too far on the other, the median
        error is none, and every depth is wrong."""
        return np.array([_median(np.abs(errors)) for errors in self._depth_errors_percent(rig, baselines)])

    def _depth_errors_percent(self, rig: sr.StereoRig, baselines: Sequence[float]) -> Iterator[np.ndarray]:
        for (_, nearness, along), distance in zip(self.readings(rig, baselines), baselines, strict=True):
            near = nearness[self._central]
            depth = along[self._central] * float(rig.baseline) / np.where(near > 0.0, near, np.nan)
            depth = np.where(near <= 0.0, np.inf, depth)
            yield 100.0 * (depth / (distance * self._baseline) - 1.0)

    @property
    def _baseline(self) -> float:
        return float(np.linalg.norm(self.translation))

    @functools.cached_property
    def _view(self) -> sr.View:
        return sr.view(self.calibrated)

    @functools.cached_property
    def _rotations(self) -> tuple[np.ndarray, np.ndarray]:
        return rectifying_rotations(self.calibrated.rotation, self.calibrated.translation)

    @property
    def _side(self) -> int:
        return max(1, round((self._view.size[0] * self._view.size[1] / CELLS) ** 0.5))

    @functools.cached_property
    def _grid(self) -> tuple[np.ndarray, np.ndarray]:
        """Left pixels spread over the view of the stored rig, and what they truly show."""
        width, height = self._view.size
        x, y = np.meshgrid((np.arange(28) + 0.5) / 28 * width - 0.5, (np.arange(20) + 0.5) / 20 * height - 0.5)
        where = np.stack([x.ravel(), y.ravel()], axis=1)
        pixels = project(self.calibrated.left, np.asarray(self._view.directions(*where.T, 0)) @ self._rotations[0])
        return pixels, self.left.rays(pixels)

    @functools.cached_property
    def _central(self) -> np.ndarray:
        """The middle half of the view's columns and rows."""
        x, y = np.meshgrid(np.arange(28), np.arange(20))
        return ((x >= 7) & (x < 21) & (y >= 5) & (y < 15)).ravel()

    def readings(
        self, rig: sr.StereoRig, baselines: Sequence[float]
    ) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """What `rig` reads of points at each distance, in the stored rig's view: row differences in pixels, baselines
        over distance, and the depth along the left camera's axis of what is at distance 1 by the view's count."""
        pixels, true = self._grid
        to_left, to_right = rectifying_rotations(rig.rotation, rig.translation)
        column, row = self._view.pixels(rays(rig.left, pixels) @ to_left.T, 0)
        along = (np.asarray(self._view.directions(column, row, 0)) @ to_left)[:, 2]
        readings = []
        for distance in baselines:
            seen = self.right.pixels(true * distance * self._baseline @ self.rotation.T + self.translation)
            other, beside = self._view.pixels(rays(rig.right, seen) @ to_right.T, 1)
            readings.append((row - beside, np.asarray(self._view.nearness(column, column - other)), along))
        return readings


def _median(values: np.ndarray) -> float:
    """The median of numbers, some of which are NaN or infinite."""
    known = np.sort(values[~np.isnan(values)])
    return float(known[len(known) // 2]) if len(known) else float("nan")


def _rms(values: np.ndarray) -> float:
    """The root mean square of numbers, some of which are NaN."""
    known = values[~np.isnan(values)]
    return float(np.sqrt(np.mean(known**2))) if len(known) else float("nan")


def drift_of(kind: str, degrees: float, baseline: float, rng: np.random.Generator) -> np.ndarray:
    """A drift of pitch, yaw, roll [rad], x, y, z [m]. "all": each angle within ± `degrees`, y and z within ± 0.9 % of
    the baseline for each degree; one axis: this one alone by + or - `degrees`."""
    drift = np.zeros(6)
    if kind == "all":
        limits = np.radians(degrees), SHIFT * degrees * baseline
        drift[[0, 1, 2, 4, 5]] = rng.uniform(-1.0, 1.0, 5) * np.repeat(limits, [3, 2])
    elif kind != "none":
        drift[AXES.index(kind)] = rng.choice([-1.0, 1.0]) * np.radians(degrees)
    return drift


def simulated(seed: int, drift_kind: str = "none", drift_degrees: float = 0.0) -> Simulated:
    """The rig of a seed, calibrated and then drifted (`drift_of`)."""
    known = calibration(seed)
    size = known["size"]
    true_cameras = [sr.Camera(size, *known[side]) for side in ("true_left", "true_right")]
    read = [sr.Camera(size, *known[side]) for side in ("left", "right")]
    rng = np.random.default_rng([seed, _DRIFT, DRIFTS.index(drift_kind)])
    drift = drift_of(drift_kind, drift_degrees, float(np.linalg.norm(known["true_extrinsics"][3:])), rng)
    true_raw = sr.StereoRig(*true_cameras, known["true_extrinsics"] + drift)
    calibrated_raw = sr.StereoRig.from_rotation(*read, known["R"], known["T"])
    rotation, translation, eye = true_raw.rotation, true_raw.translation, np.eye(3)
    if not known["rectified"]:
        eyes, calibrated = [Eye(camera, None, eye, eye) for camera in true_cameras], calibrated_raw
    else:
        turns = rectifying_rotations(calibrated_raw.rotation, calibrated_raw.translation)
        matrix = np.asarray(sr.view(calibrated_raw).matrix_left, float)
        eyes = [Eye(c, r, t, matrix) for c, r, t in zip(true_cameras, read, turns, strict=True)]
        rotation, translation = turns[1] @ rotation @ turns[0].T, turns[1] @ translation
        flat = sr.Camera(size, matrix)
        calibrated = sr.StereoRig(flat, flat, np.array([0.0, 0.0, 0.0, -float(calibrated_raw.baseline), 0.0, 0.0]))
    return Simulated(seed, calibrated, *eyes, rotation, translation, true_raw, known["rectified"])
