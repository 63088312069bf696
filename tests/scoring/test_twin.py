"""The whole score against a twin in OpenCV and plain NumPy: rectify, match, count."""

import cv2
import numpy as np
import pytest

from stereorecal.geometry import rectifying_rotations, rotation_from_euler, view, with_unit_baseline
from stereorecal.matching import SAD, reference
from stereorecal.scoring import prepare
from stereorecal.scoring.host import counts


def slow_count(rig, pair, extrinsics, own_view, matcher):
    rotations = rectifying_rotations(rotation_from_euler(extrinsics[:3]), extrinsics[3:])
    sides = (
        (pair.left, rig.left, rotations[0], own_view.matrix_left),
        (pair.right, rig.right, rotations[1], own_view.matrix_right),
    )
    images, areas = [], []
    for image, camera, turn, matrix in sides:
        maps = cv2.initUndistortRectifyMap(camera.matrix, camera.distortion, turn, matrix, own_view.size, cv2.CV_32FC1)
        images.append(cv2.remap(image, *maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE))
        areas.append(
            (maps[0] >= 0) & (maps[0] <= camera.size[0] - 1) & (maps[1] >= 0) & (maps[1] <= camera.size[1] - 1)
        )
    found = reference.match(*images, matcher)
    width = own_view.size[0]
    partner = np.arange(width) - np.round(found.values).astype(int)
    seen = np.take_along_axis(areas[1], np.clip(partner, 0, width - 1), axis=1) & (partner >= 0) & (partner < width)
    return int(np.sum(found.valid & areas[0] & seen))


@pytest.mark.slow(after=2)
@pytest.mark.parametrize("turn", [(0.0, 0.0, 0.0), (0.2, 0.5, -0.3), (-1.0, 1.0, 1.0)])
@pytest.mark.parametrize(
    ("kind", "matcher"),
    [
        ("harbour", SAD(num_disparities=24)),
        ("street", SAD(min_disparity=-4, num_disparities=20, block_size=7)),
    ],
)
def test_twin(scene, kind, turn, matcher):
    given_scene = scene(kind, 3, (160, 120))
    rig, own_view = given_scene.rig, view(given_scene.rig)
    extrinsics = with_unit_baseline(rig.extrinsics) + np.radians([*turn, 0.0, 0.0, 0.0])
    fast = int(counts(prepare(rig, given_scene.pairs, own_view), extrinsics[None], matcher)[0])
    slow = slow_count(rig, given_scene.pairs[0], extrinsics, own_view, matcher)
    assert slow > 500
    assert fast == pytest.approx(slow, rel=0.005)
