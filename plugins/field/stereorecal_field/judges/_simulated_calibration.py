"""A calibration as an honest user makes it: OpenCV on chessboards, here simulated ones, of a true rig."""

from collections.abc import Iterator

import cv2
import numpy as np
from jaxtyping import Float

from stereorecal import InputError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.synthetic import default_rig

_CORNERS, _SQUARE = (9, 6), 0.08  # inner corners; metres
_VIEWS = 16
_NEAR, _FAR = 0.30, 0.60  # of the width that a board fills
_TILT = np.radians(35.0)
_NOISE = 0.15  # px, of a corner
_FOCAL, _CENTRE, _LENS = 0.01, 6.0, 0.01  # deviations of true cameras: a share, pixels, of k1 and k2
_TANGENTIAL = 3e-4


def true_rig(seed: int) -> StereoRig:
    """A rig like the default one, with cameras of its own."""
    draw, rig = np.random.default_rng([seed, 41]), default_rig()
    return StereoRig(_camera(rig.left, draw), _camera(rig.right, draw), rig.extrinsics)


def calibrated(rig: StereoRig, seed: int) -> StereoRig:
    """What `cv2.stereoCalibrate` makes of the rig's own views of a chessboard; k3 is fixed at 0, as many do."""
    draw = np.random.default_rng([seed, 43])
    flat = np.stack(np.meshgrid(*map(np.arange, _CORNERS)), axis=-1).reshape(-1, 2) - (np.array(_CORNERS) - 1) / 2
    board = _SQUARE * np.column_stack([flat, np.zeros(len(flat))])
    views = [view for view, _ in zip(_views(rig, board, draw), range(_VIEWS), strict=False)]
    objects = [board.astype(np.float32)] * len(views)
    left, right = (
        [(view[side] + draw.normal(0.0, _NOISE, view[side].shape)).astype(np.float32) for view in views]
        for side in (0, 1)
    )
    cameras = []
    for corners in (left, right):
        _, matrix, lens, *_ = cv2.calibrateCamera(
            objects, corners, rig.left.size, np.eye(3), np.zeros(5), flags=cv2.CALIB_FIX_K3
        )
        cameras.append((matrix, lens))
    (K1, D1), (K2, D2) = cameras
    flags = cv2.CALIB_USE_INTRINSIC_GUESS | cv2.CALIB_FIX_K3
    _, K1, D1, K2, D2, R, T, *_ = cv2.stereoCalibrate(objects, left, right, K1, D1, K2, D2, rig.left.size, flags=flags)
    return StereoRig.from_matrices(K1, D1, K2, D2, R, T, rig.left.size)


def _camera(camera: Camera, draw: np.random.Generator) -> Camera:
    matrix = np.array(camera.matrix, float)
    matrix[[0, 1], [0, 1]] *= 1.0 + draw.normal(0.0, _FOCAL)
    matrix[:2, 2] += draw.normal(0.0, _CENTRE, 2)
    lens = np.zeros(5)
    lens[:2] = np.asarray(camera.distortion)[:2] + draw.normal(0.0, _LENS, 2)
    lens[2:4] = draw.normal(0.0, _TANGENTIAL, 2)
    return Camera(camera.size, matrix, lens)


def _views(
    rig: StereoRig, board: Float[np.ndarray, "n 3"], draw: np.random.Generator
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Corners of boards that both cameras see whole, left and right (n, 2)."""
    width, height = rig.left.size
    focal, across = float(rig.left.matrix[0, 0]), float(np.ptp(board[:, 0]))
    for _ in range(200 * _VIEWS):
        depth = across * focal / (draw.uniform(_NEAR, _FAR) * width)
        axis = draw.normal(size=3) * [1.0, 1.0, 0.3]
        turn = cv2.Rodrigues(draw.uniform(0.0, _TILT) * axis / np.linalg.norm(axis))[0]
        middle = draw.uniform(-0.35, 0.35, 2) * [width, height] / focal * depth
        points = board @ turn.T + np.array([middle[0] + 0.5 * float(rig.baseline), middle[1], depth])
        sides = points, points @ rig.rotation.T + rig.translation
        corners = [
            camera.project(side / side[:, 2:]) for camera, side in zip((rig.left, rig.right), sides, strict=True)
        ]
        inside = [((pixels >= 0) & (pixels <= np.array(rig.left.size) - 1.0)).all() for pixels in corners]
        if all(inside):
            yield np.asarray(corners[0]), np.asarray(corners[1])
    raise InputError("no view of a chessboard fits into both images of this rig; give a rig whose views overlap more.")
