"""Simulated calibrations without images, to count on thousands of rigs what is rare.

Prints what the stored ones are worth, without any repair:

    python tests/benchmarks/simulated_rigs.py [--rigs N] [--first SEED] [--step N] [--folder FOLDER]

A true rig is drawn, calibrated by OpenCV on simulated chessboards as an honest user would do it, drifts, and sees
scenes, of which `Simulated.correspondences` gives what the library's matcher would find, in raw images or in images
that were rectified by the calibration. Nothing in here is part of any estimate: it is a judge.

**Odd seeds stay unseen until the end**: whatever is chosen or tuned is chosen on even ones, and shown on odd ones.

A calibration takes a tenth of a second and is kept in a folder, by seed; all else is drawn anew, the same for a seed.
"""

import argparse
import functools
import os
import pickle
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from rich.console import Console
from rich.table import Table

import stereorecal as sr
from stereorecal.geometry import PINHOLE, rectifying_rotations, rotation_from_euler
from stereorecal.scoring import TILES, Correspondences

FOLDER = Path(tempfile.gettempdir()) / "stereorecal-simulated-rigs"
VERSION = 2  # of what is kept: to be raised when calibrations are drawn otherwise
DRIFTS = ("none", "all", "yaw", "pitch", "roll")
DEGREES = (0.1, 0.3, 0.5, 2.5)
SPOILS = ("region", "late", "shutter", "stretch")
BASELINES = (4.0, 10.0, 30.0, 100.0)
SIZES = ((640, 480), (752, 480), (1280, 720), (1242, 375), (1024, 768))
CELLS, WINDOW = 4800, 11  # of the library's matcher: cells of a frame, pixels of a window
BOARD = (9, 6)  # inner corners
SHIFT = 0.009  # drift of y and z for a degree, in baselines
_CALIBRATION, _DRIFT, _SCENE, _SPOIL = range(4)  # streams of random numbers
_TERMINATE = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 30, 1e-6)

cv2.setNumThreads(1)


def project(camera: sr.Camera, points: np.ndarray) -> np.ndarray:
    """Pixels (n, 2) of points (n, 3); NaN where the camera does not see them or its lens model ends."""
    ahead = np.where(points[:, 2:] > 1e-6, points[:, 2:], np.nan)
    pixels = camera.project(np.column_stack([points[:, :2] / ahead, np.ones(len(points))]))
    radius = np.hypot(points[:, 0], points[:, 1]) / ahead[:, 0]
    seen = (radius < camera.lens_radius) & inside(pixels, camera.size)
    return np.where(seen[:, None], pixels, np.nan)


def rays(camera: sr.Camera, pixels: np.ndarray) -> np.ndarray:
    """Rays (n, 3) at depth 1 of pixels (n, 2); NaN outside of the image and where the lens model ends."""
    known = np.where(inside(pixels, camera.size)[:, None], pixels, np.nan)
    found = np.asarray(camera.rays(known), float)
    radius = np.hypot(found[:, 0], found[:, 1])
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        back = np.abs(camera.project(np.nan_to_num(found, nan=0.0, posinf=0.0, neginf=0.0)) - known).max(axis=1)
        return np.where(((radius < camera.lens_radius) & (back < 1e-6))[:, None], found, np.nan)


def inside(pixels: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Whether pixels lie in an image; NaN do not."""
    return ((pixels >= 0.0) & (pixels <= np.array(size) - 1.0)).all(axis=1)


@dataclass(frozen=True, eq=False)
class Eye:
    """A true camera, and what was done to its images.

    Attributes:
        lens: the true camera.
        read: as which camera its images were rectified; None: they are raw.
        turn: (3, 3), the camera's frame to that of the images.
        matrix: (3, 3), of the rectified images.
    """

    lens: sr.Camera
    read: sr.Camera | None
    turn: np.ndarray
    matrix: np.ndarray

    def pixels(self, points: np.ndarray) -> np.ndarray:
        """Where points (n, 3) in the frame of the images appear in them, (n, 2); NaN where they do not."""
        return self.shown(project(self.lens, points @ self.turn))

    def shown(self, raw: np.ndarray) -> np.ndarray:
        """Where pixels (n, 2) of the raw image are in the images; NaN where they are not."""
        if self.read is None:
            return raw
        turned = rays(self.read, raw) @ self.turn.T
        shown = (turned / turned[:, 2:] @ self.matrix.T)[:, :2]
        return np.where(inside(shown, self.lens.size)[:, None], shown, np.nan)

    def rays(self, pixels: np.ndarray) -> np.ndarray:
        """What pixels (n, 2) of the images truly show: rays (n, 3) at depth 1 in the frame of the images, or NaN."""
        if self.read is not None:
            flat = np.column_stack([pixels, np.ones(len(pixels))]) @ np.linalg.inv(self.matrix).T
            pixels = project(self.read, np.where(inside(pixels, self.lens.size)[:, None], flat, np.nan) @ self.turn)
        turned = rays(self.lens, pixels) @ self.turn.T
        return turned / turned[:, 2:]


@dataclass(frozen=True, eq=False)
class Simulated:
    """A rig whose calibration is known, and whose truth is known too.

    Attributes:
        calibrated: what the user has: the stored rig.
        left, right, rotation, translation: the truth after the drift; `x_right = rotation x_left + translation`, in the
            frames of the images.
        drift: (6,), what was added to the true extrinsics: pitch, yaw, roll [rad], x, y, z [m].
        true_raw: the true rig after the drift, as it is; that of the images unless these were `rectified`.
        calibrated_raw: the calibration's rig, as `cv2.stereoCalibrate` left it.
        boards: those of the calibration, as the images show them: the corners of a view (n, 2) in both, and the
            corners on the board (n, 3) as the user believes them to be, metres.
        rectified: whether the images were rectified by the calibration: one K, no distortion, R = I.
        about: how it was calibrated: views, baselines, noise, squares, sloppy, joint, richer, rms, degrees of view.
    """

    seed: int
    drift_kind: str
    drift_degrees: float
    calibrated: sr.StereoRig
    left: Eye
    right: Eye
    rotation: np.ndarray
    translation: np.ndarray
    drift: np.ndarray
    true_raw: sr.StereoRig
    calibrated_raw: sr.StereoRig
    rectified: bool
    boards: tuple[sr.Board, ...]
    about: dict

    # What a matcher finds.

    def correspondences(
        self,
        frames: int = 1,
        spoil: str | None = None,
        draw: int = 0,
        late: Sequence[tuple[np.ndarray, np.ndarray]] | None = None,
    ) -> Correspondences:
        """What the library's matcher would find in `frames` scenes: rays that the calibrated cameras give to true
        pixels with errors.

        Args:
            spoil: one of SPOILS: a region of the right image is moved by 0.5 to 2 rows (the same in all frames), the
                right image is late on a vehicle that moves, the rows of the right image shift linearly from top to
                bottom (another amount in each frame), the right image is stretched vertically (the same).
            draw: another one gives other scenes and errors.
            late: how the points of each frame move, as the left camera has them, before the right image is taken: a
                rotation (3, 3), and a translation (3,) [m] after it.
        """
        if spoil is not None and spoil not in SPOILS:
            raise ValueError(f"{spoil!r} is none of {SPOILS}")
        view, side, (to_left, _) = self._view, self._side, self._rotations
        spoiled = Spoiled(spoil, np.random.default_rng([self.seed, _SPOIL, draw]), self)
        columns, rows = view.size[0] // side, view.size[1] // side
        found = []
        for frame in range(frames):
            rng = np.random.default_rng([self.seed, _SCENE, draw, frame])
            x, y = (axis.ravel() for axis in np.meshgrid(np.arange(columns), np.arange(rows)))
            where = (np.stack([x, y], axis=1) + 0.5) * side - 0.5 + rng.normal(0.0, side / 8, (x.size, 2))
            given = np.asarray(view.directions(*where.T, 0)) @ to_left
            if view.projection != PINHOLE:  # what has no ray (x/z, y/z, 1) is not looked at
                flat = np.hypot(given[:, 0], given[:, 1]) < self.calibrated.left.lens_radius * given[:, 2]
                given = np.where(flat[:, None], given, [0.0, 0.0, 1.0])
            true = self.left.rays(project(self.calibrated.left, given))
            points = true / _nearness(true, rng)[:, None] * self._baseline
            points, shift = spoiled.frame(points, where)
            if late is not None:
                points = points @ late[frame][0].T + late[frame][1]
            right = self.right.pixels(points @ self.rotation.T + self.translation)
            error, variance = _errors(columns, rows, rng)
            if view.projection != PINHOLE:  # what a matcher believes is in its own rows
                beside = [right + np.array([0.0, off]) for off in (-0.5, 0.5)]
                shown = [view.pixels(rays(self.calibrated.right, ends) @ self._rotations[1].T, 1)[1] for ends in beside]
                variance = np.nan_to_num(variance * (shown[1] - shown[0]) ** 2, nan=np.inf)
            seen = rays(self.calibrated.right, spoiled.bent(right) + shift + error)
            good = np.isfinite(seen).all(axis=1) & ~_missing(columns, rows, rng)
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
            np.asarray(min(1.0, side**2 / WINDOW**2), np.float32),
            view.projection,
        )

    def ranges(self, number: int, noise: float = 0.01, draw: int = 0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Of a scene of its own: left and right pixels (n, 2) that show the same, with errors of 0.15 pixels, and the
        distances (n,) [m] that something else measured of it, with a noise of so large a share; a tenth is of other
        things."""
        rng = np.random.default_rng([self.seed, _SCENE, draw, 1000])
        left = rng.uniform(0.05, 0.95, (4 * number, 2)) * self.calibrated.left.size
        true = self.left.rays(left)
        points = true / _nearness(true, rng)[:, None] * self._baseline
        right = self.right.pixels(points @ self.rotation.T + self.translation)
        right += rng.normal(0.0, 0.15, right.shape)
        metres = np.linalg.norm(points, axis=1) * (1.0 + noise * rng.normal(size=len(points)))
        other = rng.random(len(metres)) < 0.1
        metres[other] *= rng.uniform(0.3, 3.0, other.sum())
        seen = np.flatnonzero(np.isfinite(right).all(axis=1) & np.isfinite(metres))[:number]
        return left[seen], right[seen], metres[seen]

    # Judges: points of the world, where they truly appear, as `rig` reads them.

    def rows_px(self, rig: sr.StereoRig, baselines: Sequence[float] = BASELINES, *, rms: bool = False) -> np.ndarray:
        """Median (or root mean square) |row difference| over the view under `rig` at these distances, in pixels of the
        stored rig's view."""
        apart = [rows for rows, _, _ in self.readings(rig, baselines)]
        return np.array([_rms(a) if rms else _median(np.abs(a)) for a in apart])

    def depth_error_percent(self, rig: sr.StereoRig, baselines: Sequence[float] = BASELINES) -> np.ndarray:
        """Median error of the depth that `rig` reads over the central half of the view, positive: too far; infinite
        where points seem to lie beyond infinity."""
        errors = []
        for (_, nearness, along), distance in zip(self.readings(rig, baselines), baselines, strict=True):
            near = nearness[self._central]
            depth = along[self._central] * float(rig.baseline) / np.where(near > 0.0, near, np.nan)
            depth = np.where(near <= 0.0, np.inf, depth)
            errors.append(100.0 * (_median(depth) / (distance * self._baseline) - 1.0))
        return np.array(errors)

    def disparity_offset_px(self, rig: sr.StereoRig, baselines: float = 30.0) -> float:
        """Median over the view of the disparity that `rig` reads less the one that it would have for the true depth, in
        pixels of the stored rig's view."""
        ((_, nearness, along),) = self.readings(rig, [baselines])
        expected = along * float(rig.baseline) / (baselines * self._baseline)
        return _median(self._view.focal * (nearness - expected))

    def calibration_errors(self) -> dict[str, float]:
        """What the calibration left: each parameter less the truth before the drift, raw cameras: f in percent, centres
        in pixels for a width of 640, rotations in degrees, y, z and the baseline's length in percent of it."""
        errors = {}
        for side in ("left", "right"):
            given, true = getattr(self.calibrated_raw, side), getattr(self.true_raw, side)
            size = 640.0 / true.size[0]
            errors |= {
                f"{side}.f": 100.0 * (given.matrix[0, 0] / true.matrix[0, 0] - 1.0),
                f"{side}.cx": size * (given.matrix[0, 2] - true.matrix[0, 2]),
                f"{side}.cy": size * (given.matrix[1, 2] - true.matrix[1, 2]),
            }
            names = ("k1", "k2", "p1", "p2")
            errors |= {f"{side}.{n}": given.distortion[i] - true.distortion[i] for i, n in enumerate(names)}
        true = self.true_raw.extrinsics - self.drift
        apart = self.calibrated_raw.extrinsics - true
        errors |= {name: float(np.degrees(apart[i])) for i, name in enumerate(("pitch", "yaw", "roll"))}
        length = float(np.linalg.norm(true[3:]))
        errors |= {"y": 100.0 * apart[4] / length, "z": 100.0 * apart[5] / length}
        return errors | {"length": 100.0 * (float(self.calibrated_raw.baseline) / length - 1.0)}

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
        """Of points at each distance, as `rig` reads them in the stored rig's view: row differences in pixels,
        baselines over distance, and the depth along the left camera's axis of what is at distance 1 by the view's
        count."""
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
    """Of numbers some of which are NaN or infinite."""
    known = np.sort(values[~np.isnan(values)])
    return float(known[len(known) // 2]) if len(known) else float("nan")


def _rms(values: np.ndarray) -> float:
    """Of numbers some of which are NaN."""
    known = values[~np.isnan(values)]
    return float(np.sqrt(np.mean(known**2))) if len(known) else float("nan")


# What is seen.


def _nearness(shown: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Inverse depth along rays at depth 1, in 1 / baselines, of a scene made of planes: the nearest one counts."""
    x, y = shown[:, 0], shown[:, 1]
    right, bottom = np.nanquantile(np.abs(x), 0.98), np.nanquantile(np.abs(y), 0.98)
    if rng.random() < 0.25:  # a room
        nearest, farthest = 4.0, rng.uniform(9.0, 15.0)
        walls = [np.full_like(x, 1.0 / rng.uniform(0.7 * farthest, farthest)) + rng.normal(0.0, 0.01) * x]
        for axis, edge in ((x, right), (-x, right), (y, bottom), (-y, bottom)):
            walls.append((axis + rng.normal(0.0, 0.05)) / (edge * rng.uniform(nearest, 10.0)))
    else:
        nearest, farthest = rng.uniform(3.0, 8.0), np.exp(rng.uniform(np.log(30.0), np.log(400.0)))
        walls = [np.full_like(x, 1.0 / farthest)]
        if rng.random() < 0.85:  # the ground, the horizon nearly level
            horizon = rng.normal(0.0, 0.05)
            height = (bottom - horizon) * nearest * rng.uniform(1.0, 1.6)
            walls.append((y - horizon + rng.normal(0.0, 0.05) * x) / height)
        for _ in range(rng.integers(0, 4)):  # facades: planes along or across the view, up to some height
            angle = rng.uniform(-0.5, 0.5) + rng.choice([0.0, np.pi / 2, -np.pi / 2], p=[0.3, 0.35, 0.35])
            plane = (np.sin(angle) * x + np.cos(angle)) / np.exp(
                rng.uniform(np.log(2 * nearest), np.log(0.7 * farthest))
            )
            shows = (x > rng.uniform(-1.2, 0.5) * right) & (x < rng.uniform(-0.5, 1.2) * right)
            walls.append(np.where(shows & (y > -rng.uniform(0.2, 1.5) * bottom), plane, 0.0))
    for _ in range(rng.integers(0, 9)):  # boxes, nearly parallel to the images
        width, height = rng.uniform(0.1, 0.5) * right, rng.uniform(0.1, 0.7) * bottom
        over = (np.abs(x - rng.uniform(-1, 1) * right) < width) & (np.abs(y - rng.uniform(-0.6, 1) * bottom) < height)
        plane = (1.0 + rng.normal(0.0, 0.2) * x) / np.exp(rng.uniform(np.log(nearest), np.log(0.7 * farthest)))
        walls.append(np.where(over, plane, 0.0))
    return np.clip(np.max(walls, axis=0), 1.0 / farthest, 1.0 / nearest)


def _field(columns: int, rows: int, across: int, down: int, rng: np.random.Generator) -> np.ndarray:
    """A smooth random field of variance 1 over the cells, `across` times `down` bumps, (rows * columns,)."""
    coarse = rng.normal(size=(down + 3, across + 3)).astype(np.float32)
    fine = cv2.resize(coarse, None, fx=columns / across, fy=rows / down, interpolation=cv2.INTER_CUBIC)
    top, side = int(rng.uniform(1.0, 2.0) * rows / down), int(rng.uniform(1.0, 2.0) * columns / across)
    field = fine[top : top + rows, side : side + columns].astype(float).ravel()
    return field / fine.std()


def _missing(columns: int, rows: int, rng: np.random.Generator) -> np.ndarray:
    """Where nothing is found: 10 to 50 % of the cells, in patches."""
    patches = _field(columns, rows, 10, 7, rng) + 0.3 * rng.normal(size=columns * rows)
    return patches < np.quantile(patches, rng.uniform(0.1, 0.5))


def _errors(columns: int, rows: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Errors of the right pixels (n, 2), and the variances of their rows (n,) that a matcher believes in."""
    count = columns * rows
    sigma = np.clip(rng.uniform(0.05, 0.09) * np.exp(0.3 * rng.normal(size=count)), 0.04, 0.12)
    error = np.stack([rng.normal(0.0, rng.uniform(0.1, 0.2), count), rng.normal(0.0, sigma)], axis=1)
    for axis in (0, 1):  # what neighbours have in common
        error[:, axis] += rng.uniform(0.02, 0.04) * _field(columns, rows, *TILES, rng)
    outliers = rng.random(count) < rng.uniform(0.01, 0.03)
    error[outliers] += rng.uniform(-2.0, 2.0, (outliers.sum(), 2))
    return error, sigma**2 * np.exp(0.3 * rng.normal(size=count))


class Spoiled:
    """What is wrong with the right images."""

    def __init__(self, kind: str | None, rng: np.random.Generator, of: Simulated) -> None:
        self._kind, self._rng, self._of = kind, rng, of
        self._size = np.array(of.calibrated.left.size, float)
        self._stretch = rng.choice([-1.0, 1.0]) * rng.uniform(0.001, 0.005)
        self._rows = rng.choice([-1.0, 1.0]) * rng.uniform(0.5, 2.0)
        share, place = rng.uniform(0.2, 0.5), rng.choice(4)
        wide = rng.uniform(share, min(1.0, share / 0.4))
        # Left, right, top, or a rectangle: from, to, in shares of the width and the height.
        corner = rng.uniform(0.0, 1.0, 2) * (1.0 - np.array([wide, share / wide]))
        self._region = [
            ((0.0, 0.0), (share, 1.0)),
            ((1.0 - share, 0.0), (1.0, 1.0)),
            ((0.0, 0.0), (1.0, share)),
            (corner, (corner[0] + wide, corner[1] + share / wide)),
        ][place]

    def frame(self, points: np.ndarray, where: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """A frame's points (n, 3) as the right camera sees them, and how far its pixels are moved (n, 2)."""
        shift = np.zeros((len(points), 2))
        self._shutter = self._rng.choice([-1.0, 1.0]) * self._rng.uniform(0.3, 2.0)
        advance, turn = self._rng.uniform(0.05, 0.5), self._rng.uniform(-0.3, 0.3, 3) / np.sqrt(3.0)
        if self._kind == "region":
            start, end = (np.array(corner) * self._size for corner in self._region)
            shift[((where >= start) & (where <= end)).all(axis=1), 1] = self._rows
        elif self._kind == "late":
            baseline = np.linalg.norm(self._of.translation)
            points = (points - [0.0, 0.0, advance * baseline]) @ rotation_from_euler(np.radians(turn)).T
        return points, shift

    def bent(self, pixels: np.ndarray) -> np.ndarray:
        """Where the right pixels of this frame end up."""
        height, rows = self._size[1], pixels[:, 1]
        moved = {"shutter": self._shutter * rows / height, "stretch": self._stretch * (rows - 0.5 * (height - 1.0))}
        return pixels + np.column_stack([0.0 * rows, moved.get(self._kind or "", 0.0 * rows)])


# Calibrations.


def simulated(seed: int, drift_kind: str = "none", drift_degrees: float = 0.0, *, folder: Path = FOLDER) -> Simulated:
    """The rig of a seed, calibrated and then drifted.

    Args:
        drift_kind: one of DRIFTS. "all": each angle within ± `drift_degrees`, y and z within ± 0.9 % of the baseline
            for each degree; one axis: this one alone by + or - `drift_degrees`.
        folder: where calibrations are kept.
    """
    if drift_kind not in DRIFTS:
        raise ValueError(f"{drift_kind!r} is none of {DRIFTS}")
    known = _calibration(seed, Path(folder))
    size, about = known["size"], known["about"]
    true_cameras = [sr.Camera(size, *known[side]) for side in ("true_left", "true_right")]
    read = [sr.Camera(size, *known[side]) for side in ("left", "right")]
    drift = np.zeros(6)
    rng = np.random.default_rng([seed, _DRIFT, DRIFTS.index(drift_kind)])
    if drift_kind == "all":
        limits = np.radians(drift_degrees), SHIFT * drift_degrees * np.linalg.norm(known["true_extrinsics"][3:])
        drift[[0, 1, 2, 4, 5]] = rng.uniform(-1.0, 1.0, 5) * np.repeat(limits, [3, 2])
    elif drift_kind != "none":
        drift[("pitch", "yaw", "roll").index(drift_kind)] = rng.choice([-1.0, 1.0]) * np.radians(drift_degrees)
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
    board, views = known["boards"]
    boards = [_board([eye.shown(some) for eye, some in zip(eyes, view, strict=True)], board) for view in views]
    return Simulated(
        seed,
        drift_kind,
        drift_degrees,
        calibrated,
        *eyes,
        rotation,
        translation,
        drift,
        true_raw,
        calibrated_raw,
        known["rectified"],
        tuple(one for one in boards if one is not None),
        about,
    )


def _board(seen: list[np.ndarray], points: np.ndarray) -> sr.Board | None:
    """The corners that both images hold; None of a board of which rectified images hold less than half."""
    both = np.isfinite(np.column_stack(seen)).all(axis=1)
    return sr.Board(seen[0][both], seen[1][both], points[both]) if 2 * both.sum() >= len(both) else None


def _calibration(seed: int, folder: Path) -> dict:
    """The true rig of a seed and what its calibration found, kept in a file."""
    path = folder / f"{VERSION}-{seed:06d}.pickle"
    if path.exists():
        return pickle.loads(path.read_bytes())
    known = next(filter(None, (_calibrated([seed, _CALIBRATION, attempt]) for attempt in range(1000))))
    folder.mkdir(parents=True, exist_ok=True)
    mine = path.with_suffix(f".{os.getpid()}")
    mine.write_bytes(pickle.dumps(known))
    mine.replace(path)
    return known


def _lenses(rng: np.random.Generator, size: tuple[int, int]) -> tuple[list[sr.Camera], dict]:
    """Two true cameras of one make."""
    width, height = size
    while True:
        degrees, k1 = rng.uniform(50.0, 95.0), rng.uniform(-0.35, 0.05)
        k2 = -k1 * rng.uniform(0.1, 0.45)
        edge = np.tan(np.radians(degrees / 2))
        focal = 0.5 * width / (edge * (1 + k1 * edge**2 + k2 * edge**4))
        radii = np.linspace(0.0, 3.0, 601)
        image = radii * (1 + k1 * radii**2 + k2 * radii**4)
        needed = 1.08 * np.hypot(width, height) / 2 / focal
        if focal < 0 or not (image > needed).any():
            continue
        reached = int(np.argmax(image > needed))
        if np.gradient(image, radii)[: reached + 1].min() > 0.3:
            break
    richer = str(rng.choice(["no", "k3", "fifth"], p=[0.5, 0.25, 0.25]))
    corner = np.hypot(width, height) / 2 / focal
    k3 = rng.normal(0.0, 0.0015) / corner**6 if richer == "k3" else 0.0  # 0.15 % of the radius in the corners
    lenses = []
    for _ in range(2):
        own = [k1 + rng.normal(0.0, 0.004), k2 + rng.normal(0.0, 0.004), *rng.normal(0.0, 5e-4, 2), k3]
        # A lens that is no body of rotation: terms of second and fourth degree, some tenths of a pixel in the corners.
        odd = (
            rng.normal(0.0, 0.3 / focal, 4) / np.array([corner**2, corner**4] * 2) if richer == "fifth" else np.zeros(4)
        )
        f = focal * (1 + rng.normal(0.0, 0.003))
        c = (np.array(size) - 1) / 2 + rng.normal(0.0, 0.01 * width, 2)
        matrix = np.array([[f, 0, c[0]], [0, f * (1 + rng.normal(0.0, 3e-4)), c[1]], [0, 0, 1.0]])
        lenses.append(sr.Camera(size, matrix, np.concatenate([own, np.zeros(3), odd])))
    return lenses, {"degrees": degrees, "richer": richer}


def _views(rng: np.random.Generator, rig: sr.StereoRig, number: int, far: float) -> tuple[np.ndarray, list]:
    """The corners of a board of square 1 about its middle, and of each view those in both images, without noise.

    `far`: distance in baselines of a board that fills 45 % of the width; all views show the same board.
    """
    width, height = rig.left.size
    focal, baseline = rig.left.matrix[0, 0], float(rig.baseline)
    square = 0.45 * width / focal * far * baseline / BOARD[0]
    grid = np.mgrid[0 : BOARD[0], 0 : BOARD[1]].reshape(2, -1).T - (np.array(BOARD) - 1) / 2
    board = np.column_stack([grid, np.zeros(len(grid))]) * square
    views = []
    for _ in range(60 * number):
        depth = far * baseline * 0.45 / rng.uniform(0.3, 0.65)
        tilt, about = np.radians(rng.uniform(0.0, 40.0)), rng.uniform(0.0, 2 * np.pi)
        turned = (
            board
            @ (
                cv2.Rodrigues(tilt * np.array([np.cos(about), np.sin(about), 0.0]))[0]
                @ cv2.Rodrigues(np.array([0.0, 0.0, rng.normal(0.0, 0.2)]))[0]
            ).T
        )
        middle = rng.uniform(-0.5, 0.5, 2) * [width, height] / focal * depth + [0.5 * baseline, 0.0]
        points = turned + np.array([*middle, depth])
        left, right = project(rig.left, points), project(rig.right, points @ rig.rotation.T + rig.translation)
        if np.isfinite(left).all() and np.isfinite(right).all():
            views.append((left, right, depth / baseline))
        if len(views) == number:
            break
    return board, views


def _calibrated(stream: list[int]) -> dict | None:
    """A true rig and its calibration; None where a user would have thrown it away."""
    rng = np.random.default_rng(stream)
    size = SIZES[rng.integers(len(SIZES))]
    lenses, about = _lenses(rng, size)
    baseline = np.exp(rng.uniform(np.log(0.06), np.log(0.5)))
    translation = np.array([-1.0, *rng.normal(0.0, 0.005, 2)])
    translation *= baseline / np.linalg.norm(translation)
    true = sr.StereoRig(*lenses, np.concatenate([np.radians(rng.normal(0.0, 0.3, 3)), translation]))
    number, far = int(rng.integers(6, 31)), np.exp(rng.uniform(np.log(2.1), np.log(10.0)))
    noise, squares = np.exp(rng.uniform(np.log(0.05), np.log(0.3))), rng.choice([0.0, 0.0, -0.002, 0.002])
    board, views = _views(rng, true, number, far)
    if len(views) < 6:
        return None
    flags, sloppy = (0 if rng.random() < 0.05 else cv2.CALIB_FIX_K3), "no"
    joint_flags, joint = 0, bool(rng.random() < 0.5)
    if rng.random() < 0.1:
        sloppy = str(rng.choice(["aspect", "focal", "tangent", "centre"]))
        name = {"aspect": "FIX_ASPECT_RATIO", "tangent": "ZERO_TANGENT_DIST", "centre": "FIX_PRINCIPAL_POINT"}.get(
            sloppy
        )
        flags |= getattr(cv2, f"CALIB_{name}") if name else 0
        if sloppy == "focal":
            joint, joint_flags = True, cv2.CALIB_SAME_FOCAL_LENGTH
    objects = [(board * (1 + squares)).astype(np.float32)] * len(views)
    seen = [[(v[s] + rng.normal(0.0, noise, v[s].shape)).astype(np.float32) for v in views] for s in (0, 1)]
    rectified = bool(rng.random() < 0.25)
    try:
        monos = []
        for points in seen:
            rms, K, D, *_ = cv2.calibrateCamera(
                objects, points, size, np.eye(3), np.zeros(5), flags=flags, criteria=_TERMINATE
            )
            monos.append((rms, K, D))
        stereo = (flags | joint_flags | cv2.CALIB_USE_INTRINSIC_GUESS) if joint else cv2.CALIB_FIX_INTRINSIC
        (_, K1, D1), (_, K2, D2) = monos
        rms, K1, D1, K2, D2, R, T, *_ = cv2.stereoCalibrate(
            objects, *seen, K1, D1, K2, D2, size, flags=stereo, criteria=_TERMINATE
        )
        found = sr.StereoRig.from_matrices(K1, D1, K2, D2, R, T, size)
        sr.view(found)
    except (cv2.error, sr.InputError):
        return None
    scale = [
        g.matrix[i, i] / t.matrix[i, i] - 1
        for g, t in ((found.left, lenses[0]), (found.right, lenses[1]))
        for i in (0, 1)
    ]
    if (
        rms > 1.0
        or max(monos[0][0], monos[1][0]) > 1.0
        or np.abs(scale).max() > 0.1
        or not np.isfinite(sr.view(found).focal)
    ):
        return None
    return {
        "size": size,
        "true_left": (lenses[0].matrix, lenses[0].distortion),
        "true_right": (lenses[1].matrix, lenses[1].distortion),
        "true_extrinsics": true.extrinsics,
        "left": (found.left.matrix, found.left.distortion),
        "right": (found.right.matrix, found.right.distortion),
        "R": np.asarray(R),
        "T": np.ravel(T),
        "rectified": rectified,
        "boards": (objects[0], np.stack(seen, axis=1)),
        "about": about
        | {
            "views": len(views),
            "baselines": (float(min(v[2] for v in views)), float(max(v[2] for v in views))),
            "noise": float(noise),
            "squares": float(squares),
            "sloppy": sloppy,
            "joint": joint,
            "k3": not flags & cv2.CALIB_FIX_K3,
            "rms": float(rms),
        },
    }


# What the stored calibrations are worth.


def main() -> None:
    """Calibrate, let drift, judge."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rigs", type=int, default=200)
    parser.add_argument("--first", type=int, default=0, help="seed of the first rig")
    parser.add_argument("--step", type=int, default=1, help="2: even seeds only, or odd ones")
    parser.add_argument("--folder", type=Path, default=FOLDER, help="where calibrations are kept")
    options = parser.parse_args()
    seeds = [options.first + options.step * index for index in range(options.rigs)]
    for seed in seeds:
        _calibration(seed, options.folder)
    console = Console(width=165)
    shown = Table(title=f"{len(seeds)} stored calibrations: medians over rigs (nine of ten below)", box=None)
    shown.add_column("drift")
    for head in [f"rows {b:.0f} B" for b in BASELINES] + [f"|depth| {b:.0f} B, %" for b in BASELINES]:
        shown.add_column(head, justify="right")
    for kind in DRIFTS:
        for degrees in (0.0,) if kind == "none" else DEGREES:
            rigs = [simulated(seed, kind, degrees, folder=options.folder) for seed in seeds]
            rows = np.array([rig.rows_px(rig.calibrated) for rig in rigs])
            depth = np.abs([rig.depth_error_percent(rig.calibrated) for rig in rigs])
            values = np.concatenate([rows, depth], axis=1)
            middle, high = (np.nanquantile(values, q, axis=0, method="higher") for q in (0.5, 0.9))
            cells = [f"{m:.3g} ({h:.3g})" for m, h in zip(middle, high, strict=True)]
            shown.add_row(f"{kind} {degrees}°" if degrees else kind, *cells)
    console.print(shown)
    left = [simulated(seed, folder=options.folder).calibration_errors() for seed in seeds]
    errors = Table(title="what calibrations leave", box=None)
    for head in ("parameter", "standard deviation", "1.48 x median |error|"):
        errors.add_column(head, justify="left" if head == "parameter" else "right")
    for name in ("f", "cx", "cy", "k1", "k2", "p1", "p2", "pitch", "yaw", "roll", "y", "z", "length"):
        values = np.array([value for row in left for key, value in row.items() if key.rpartition(".")[2] == name])
        errors.add_row(name, f"{np.sqrt(np.mean(values**2)):.4f}", f"{1.4826 * np.median(np.abs(values)):.4f}")
    console.print(errors)


if __name__ == "__main__":
    main()
