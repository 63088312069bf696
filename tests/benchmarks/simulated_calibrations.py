"""Calibrations by simulated chessboards: the true rig of each seed, and what an honest user's OpenCV makes of it.

Two lenses of one make, 6 to 30 views of one board, noise; sometimes its squares have another size than the user
believes, or an option holds what should be free. A calibration takes a tenth of a second and is kept in a folder, by
seed.
"""

import os
import pickle
import tempfile
from pathlib import Path

import cv2
import numpy as np
from simulated_cameras import project

import stereorecal as sr

FOLDER = Path(tempfile.gettempdir()) / "stereorecal-simulated-rigs"
VERSION = 2  # of what is kept: to be raised when calibrations are drawn otherwise
SIZES = ((640, 480), (752, 480), (1280, 720), (1242, 375), (1024, 768))
BOARD = (9, 6)  # inner corners
_STREAM = 0  # of random numbers of a seed; those of `simulated_rigs.py` are others
_TERMINATE = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 30, 1e-6)

cv2.setNumThreads(1)


def calibration(seed: int) -> dict:
    """The true rig of a seed and what its calibration found, kept in a file.

    Returns:
        The image `size`; cameras as matrix and distortion: `true_left` and `true_right`, and as they were found, `left`
        and `right`; `true_extrinsics` (6,), and what was found, `R` and `T`; whether images are to be `rectified`.
    """
    path = FOLDER / f"{VERSION}-{seed:06d}.pickle"
    if path.exists():
        return pickle.loads(path.read_bytes())
    known = next(filter(None, (_calibrated([seed, _STREAM, attempt]) for attempt in range(1000))))
    FOLDER.mkdir(parents=True, exist_ok=True)
    mine = path.with_suffix(f".{os.getpid()}")
    mine.write_bytes(pickle.dumps(known))
    mine.replace(path)
    return known


def _calibrated(stream: list[int]) -> dict | None:
    """A true rig and its calibration; None where a user would have thrown it away."""
    rng = np.random.default_rng(stream)
    size = SIZES[rng.integers(len(SIZES))]
    lenses = _lenses(rng, size)
    baseline = np.exp(rng.uniform(np.log(0.06), np.log(0.5)))
    translation = np.array([-1.0, *rng.normal(0.0, 0.005, 2)])
    translation *= baseline / np.linalg.norm(translation)
    true = sr.StereoRig(*lenses, np.concatenate([np.radians(rng.normal(0.0, 0.3, 3)), translation]))
    number, far = int(rng.integers(6, 31)), np.exp(rng.uniform(np.log(2.1), np.log(10.0)))
    noise, squares = np.exp(rng.uniform(np.log(0.05), np.log(0.3))), rng.choice([0.0, 0.0, -0.002, 0.002])
    board, views = _views(rng, true, number, far)
    if len(views) < 6:
        return None
    flags = 0 if rng.random() < 0.05 else cv2.CALIB_FIX_K3
    joint_flags, joint = 0, bool(rng.random() < 0.5)
    if rng.random() < 0.1:
        sloppy = rng.choice(["FIX_ASPECT_RATIO", "SAME_FOCAL_LENGTH", "ZERO_TANGENT_DIST", "FIX_PRINCIPAL_POINT"])
        if sloppy == "SAME_FOCAL_LENGTH":
            joint, joint_flags = True, cv2.CALIB_SAME_FOCAL_LENGTH
        else:
            flags |= getattr(cv2, f"CALIB_{sloppy}")
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
    scale = [found.left.focal / lenses[0].focal - 1.0, found.right.focal / lenses[1].focal - 1.0]
    worst_rms = max(rms, monos[0][0], monos[1][0])
    if worst_rms > 1.0 or np.abs(scale).max() > 0.1 or not np.isfinite(sr.view(found).focal):
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
    }


def _lenses(rng: np.random.Generator, size: tuple[int, int]) -> list[sr.Camera]:
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
        odd = np.zeros(4)
        if richer == "fifth":
            odd = rng.normal(0.0, 0.3 / focal, 4) / np.array([corner**2, corner**4] * 2)
        f = focal * (1 + rng.normal(0.0, 0.003))
        c = (np.array(size) - 1) / 2 + rng.normal(0.0, 0.01 * width, 2)
        matrix = np.array([[f, 0, c[0]], [0, f * (1 + rng.normal(0.0, 3e-4)), c[1]], [0, 0, 1.0]])
        lenses.append(sr.Camera(size, matrix, np.concatenate([own, np.zeros(3), odd])))
    return lenses


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
        tilted = cv2.Rodrigues(tilt * np.array([np.cos(about), np.sin(about), 0.0]))[0]
        turned = board @ (tilted @ cv2.Rodrigues(np.array([0.0, 0.0, rng.normal(0.0, 0.2)]))[0]).T
        middle = rng.uniform(-0.5, 0.5, 2) * [width, height] / focal * depth + [0.5 * baseline, 0.0]
        points = turned + np.array([*middle, depth])
        left, right = project(rig.left, points), project(rig.right, points @ rig.rotation.T + rig.translation)
        if np.isfinite(left).all() and np.isfinite(right).all():
            views.append((left, right))
        if len(views) == number:
            break
    return board, views
