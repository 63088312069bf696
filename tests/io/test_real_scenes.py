"""Every scene of the real data loads."""

import json
from pathlib import Path

import numpy as np
import pytest

from stereorecal.io import load_pairs, load_scene

CALIBRATED = {
    "boofcv_bumblebee2/chair01": 1,
    "boofcv_bumblebee2/garden01": 1,
    "boofcv_bumblebee2/stones01": 1,
    "boofcv_bumblebee2/sundial01": 1,
    "drobotics_wide/office_050": 1,
    "euroc/vicon_room_seq": 7,
    "kitti2012/000000_10": 1,
    "kitti2015/000001_10": 1,
    "kitti_odometry/suburb_seq": 8,
    "middlebury2014/motorcycle_quarter": 1,
    "simplestereo/guitar_room": 1,
    "simplestereo/ukulele_wall": 1,
}


@pytest.mark.parametrize(("name", "frames"), [*CALIBRATED.items(), ("crestereo/fence_water", 1)])
def test_scene(data_dir: Path, name: str, frames: int):
    scene = load_scene(data_dir / name)
    content = json.loads((data_dir / name / "calib.json").read_text())
    assert scene.name == name
    assert len(scene.pairs) == frames
    assert all(pair.size == tuple(content["image_size"]) for pair in scene.pairs)
    assert scene.info["rectified"] == content["rectified"]
    assert scene.info["original_files"] == content["original_files"]
    if name not in CALIBRATED:
        assert scene.rig is None
        return
    assert scene.rig is not None
    np.testing.assert_allclose(scene.rig.rotation, content["R"], atol=1e-6)
    np.testing.assert_array_equal(scene.rig.translation, content["T"])
    assert scene.rig.baseline == pytest.approx(content["baseline_m"], rel=1e-6)
    np.testing.assert_array_equal(scene.rig.left.distortion, content["D_left"][: scene.rig.left.distortion.size])
    assert not any(content["D_left"][scene.rig.left.distortion.size :])


def test_a_folder_of_many_pairs(data_dir: Path):
    chess = data_dir / "boofcv_bumblebee2" / "calibration_chess"
    pairs = load_pairs(f"{chess}/left*.jpg", f"{chess}/right*.jpg")
    assert [pair.name for pair in pairs] == [f"left{i:02d}.jpg" for i in range(1, 12)]
    assert [Path(pair.origin[1][1]).name for pair in pairs] == [f"right{i:02d}.jpg" for i in range(1, 12)]
