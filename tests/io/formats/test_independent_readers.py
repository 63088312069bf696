"""What is written, read by other programs' libraries under the names that they publish."""

import json
import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import jax
import numpy as np
import pytest
import samples
import yaml
from every import SAMPLES, beside
from refusals import refused
from scipy.spatial.transform import Rotation

from stereorecal.geometry import StereoRig
from stereorecal.io import load_rig, save_rig

CHANGE = np.array([0.004, -0.003, 0.002, 0.001, 0.0005, -0.0004])
SMALL = samples.rig_of(samples.RIG.extrinsics + CHANGE)


def repaired(name: str, folder: Path) -> tuple[StereoRig, list[Path]]:
    """A rig that has moved, in a copy of the sample."""
    paths = SAMPLES[name].write(folder)
    rig = SAMPLES[name].load(paths)
    rig = rig.with_extrinsics(rig.extrinsics + CHANGE)
    save_rig(rig, beside(paths))
    return rig, beside(paths)


def opencv_rectified(rig: StereoRig, length: float = 1.0, **options: Any) -> dict[str, np.ndarray]:
    cameras = (rig.left.matrix, rig.left.distortion, rig.right.matrix, rig.right.distortion)
    made = cv2.stereoRectify(*cameras, rig.left.size, rig.rotation, length * rig.translation[:, None], **options)
    return dict(zip(("R1", "R2", "P1", "P2", "Q"), made[:5], strict=True))


@pytest.mark.parametrize("name", ["opencv yaml", "opencv xml", "opencv json"])
def test_file_storage(tmp_path: Path, name: str):
    rig, (path,) = repaired(name, tmp_path)
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    assert storage.isOpened()
    np.testing.assert_allclose(storage.getNode("R").mat(), rig.rotation, atol=1e-15)
    np.testing.assert_allclose(storage.getNode("T").mat()[:, 0], 1000 * rig.translation, rtol=1e-14)
    assert storage.getNode("boat").string() == "Ladja"
    expected = opencv_rectified(rig, 1000.0, flags=cv2.CALIB_ZERO_DISPARITY, alpha=1.0)
    np.testing.assert_allclose(storage.getNode("R1").mat(), expected["R1"], atol=1e-7)
    np.testing.assert_allclose(storage.getNode("Q").mat(), expected["Q"], atol=1e-6)


@pytest.mark.parametrize("flags", [0, cv2.CALIB_ZERO_DISPARITY])
@pytest.mark.parametrize("alpha", [-1.0, 0.0, 0.3, 1.0])
def test_the_view_stays(tmp_path: Path, alpha: float, flags: int):
    """R1 R2 P1 P2 Q are made anew with the alpha and the flags of those in the file."""
    path, moved = tmp_path / "a.yaml", tmp_path / "b.yaml"
    matrices = {"R": SMALL.rotation, "T": SMALL.translation, **opencv_rectified(SMALL, flags=flags, alpha=alpha)}
    for side, camera in (("1", SMALL.left), ("2", SMALL.right)):
        matrices |= {f"K{side}": camera.matrix, f"D{side}": camera.distortion}
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    for name, matrix in matrices.items():
        storage.write(name, np.asarray(matrix))
    storage.release()
    rig = load_rig(path, size=samples.SIZE, unit="m")
    rig = rig.with_extrinsics(rig.extrinsics + CHANGE)
    save_rig(rig, moved)
    written = cv2.FileStorage(str(moved), cv2.FILE_STORAGE_READ)
    for name, expected in opencv_rectified(rig, flags=flags, alpha=alpha).items():
        np.testing.assert_allclose(written.getNode(name).mat(), expected, rtol=1e-6, atol=1e-6, err_msg=name)


@pytest.mark.parametrize("ending", [".yaml", ".xml", ".json"])
def test_new_file_storage(tmp_path: Path, ending: str):
    path = tmp_path / f"a{ending}"
    save_rig(SMALL, path, format="opencv")
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    np.testing.assert_array_equal(storage.getNode("K2").mat(), SMALL.right.matrix)
    np.testing.assert_allclose(storage.getNode("T").mat()[:, 0], SMALL.translation, rtol=1e-15)
    assert [storage.getNode("imageSize").at(i).real() for i in range(2)] == list(samples.SIZE)


def test_ros(tmp_path: Path):
    rig, paths = repaired("ros", tmp_path)
    left, right = (yaml.safe_load(path.read_text()) for path in paths)
    turns = [np.reshape(c["rectification_matrix"]["data"], (3, 3)) for c in (left, right)]
    projections = [np.reshape(c["projection_matrix"]["data"], (3, 4)) for c in (left, right)]
    np.testing.assert_allclose(turns[1].T @ turns[0], rig.rotation, atol=1e-12)
    baseline = -projections[1][0, 3] / projections[1][0, 0]
    assert baseline == pytest.approx(float(rig.baseline), rel=1e-12)
    np.testing.assert_allclose(turns[1].T @ [-baseline, 0, 0], rig.translation, atol=1e-12)
    assert left["camera_name"] == "narrow_stereo/left"
    assert left["projection_matrix"]["data"][3] == 0.0


def test_kalibr(tmp_path: Path):
    rig, (path,) = repaired("kalibr", tmp_path)
    content = yaml.safe_load(path.read_text())
    motion = np.array(content["cam1"]["T_cn_cnm1"])
    np.testing.assert_allclose(motion[:3], rig_matrix(rig)[:3], atol=1e-15)
    np.testing.assert_allclose(content["cam1"]["T_cam_imu"], motion @ content["cam0"]["T_cam_imu"], atol=1e-12)
    assert content["cam1"]["timeshift_cam_imu"] == -2.0e-05


def rig_matrix(rig: StereoRig, length: float = 1.0) -> np.ndarray:
    return np.vstack([np.column_stack([rig.rotation, length * rig.translation]), [0, 0, 0, 1]])


def test_euroc(tmp_path: Path):
    rig, paths = repaired("euroc", tmp_path)
    left, right = (np.reshape(yaml.safe_load(path.read_text())["T_BS"]["data"], (4, 4)) for path in paths)
    np.testing.assert_allclose(np.linalg.inv(right) @ left, rig_matrix(rig), atol=1e-12)
    assert paths[0].read_text() == SAMPLES["euroc"].texts[0]


def test_boofcv(tmp_path: Path):
    rig, (path,) = repaired("boofcv", tmp_path)
    stated = yaml.safe_load(path.read_text())["rightToLeft"]
    back = np.reshape(stated["rotation"], (3, 3))
    np.testing.assert_allclose(back, np.asarray(rig.rotation).T, atol=1e-12)
    np.testing.assert_allclose([stated[key] for key in "xyz"], -1000 * back @ rig.translation, atol=1e-9)


def test_basalt(tmp_path: Path):
    rig, (path,) = repaired("basalt", tmp_path)
    poses = []
    for stated in json.loads(path.read_text())["value0"]["T_imu_cam"]:
        pose = np.eye(4)
        pose[:3, :3] = Rotation.from_quat([stated[f"q{key}"] for key in "xyzw"]).as_matrix()
        pose[:3, 3] = [stated[f"p{key}"] for key in "xyz"]
        poses.append(pose)
    np.testing.assert_allclose(np.linalg.inv(poses[1]) @ poses[0], rig_matrix(rig), atol=1e-12)


# --- DepthAI: centimetres, sockets, and modes that cut or scale -----------------------------------------------


@pytest.fixture
def oak(tmp_path: Path) -> Path:
    """SMALL in a new file."""
    save_rig(SMALL, tmp_path / "oak.json", format="depthai")
    return tmp_path / "oak.json"


def test_depthai(oak: Path):
    content = json.loads(oak.read_text())
    (one, left), (two, _) = content["cameraData"]
    assert (one, two, left["extrinsics"]["toCameraSocket"]) == (1, 2, 2)
    shift = [left["extrinsics"]["translation"][key] for key in "xyz"]
    np.testing.assert_allclose(shift, 100 * SMALL.translation, rtol=1e-12)
    assert len(left["distortionCoeff"]) == 14
    turned = np.array(content["stereoRectificationData"]["rectifiedRotationRight"])
    np.testing.assert_allclose(turned @ SMALL.translation, [-SMALL.baseline, 0, 0], atol=1e-12)


@pytest.mark.parametrize("to", ["the left one", "a third one"])
def test_depthai_whose_cameras_are_linked_otherwise(oak: Path, to: str):
    content = json.loads(oak.read_text())
    (_, left), (_, right) = content["cameraData"]
    from_right = np.linalg.inv(rig_matrix(SMALL, 100.0))
    if to == "the left one":
        left["extrinsics"]["toCameraSocket"] = -1
        link(right, 1, from_right)
    else:
        left_to_third = np.eye(4)
        left_to_third[:3, :3], left_to_third[:3, 3] = SMALL.rotation.T @ SMALL.rotation.T, [3.0, -1.0, 2.0]
        link(left, 0, left_to_third)
        link(right, 0, left_to_third @ from_right)
    oak.write_text(json.dumps(content))
    rig = load_rig(oak)
    np.testing.assert_allclose(rig.extrinsics, SMALL.extrinsics, atol=1e-12)
    moved = rig.with_extrinsics(rig.extrinsics + CHANGE)
    save_rig(moved, oak, overwrite=True)
    np.testing.assert_allclose(load_rig(oak).extrinsics, moved.extrinsics, atol=1e-12)
    assert load_rig(oak, size=(128, 96)).left.size == (128, 96)


def link(camera: dict[str, Any], socket: int, motion: np.ndarray) -> None:
    """Say where a camera is, seen from another one."""
    camera["extrinsics"] |= {"toCameraSocket": socket, "rotationMatrix": motion[:3, :3].tolist()}
    camera["extrinsics"]["translation"] = dict(zip("xyz", motion[:3, 3].tolist(), strict=True))


@pytest.mark.parametrize(("scale", "rows"), [(1, 44), (2, 20), (4, 9), (1, 1), (1, 47)])
def test_depthai_of_a_mode_that_cuts_rows(tmp_path: Path, oak: Path, scale: int, rows: int):
    """f as in the whole image, over the scale; and back into the file."""
    new = tmp_path / "new.json"
    rig = load_rig(oak, size=(64 // scale, rows))
    whole = SMALL.resized((64 // scale, 48 // scale))
    expected = np.array(whole.left.matrix) - [[0, 0, 0], [0, 0, (48 // scale - rows) // 2], [0, 0, 0]]
    np.testing.assert_allclose(rig.left.matrix, expected, rtol=0, atol=1e-12)
    left = replace(rig.left, matrix=np.array(rig.left.matrix) + np.diag([0.5, 0.25, 0.0]))
    save_rig(replace(rig, left=left), new)
    np.testing.assert_allclose(load_rig(new, size=left.size).left.matrix, left.matrix, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(load_rig(new).right.matrix, load_rig(oak).right.matrix)


@pytest.mark.parametrize(
    ("size", "words"),
    [
        ((50, 48), "crop the rig in Python: rig.cropped"),
        ((64, 49), "calibrate for these images"),
        ((30, 20), "rig.cropped"),
        ((32, 30), "rig.cropped"),
    ],
)
def test_depthai_of_no_mode(oak: Path, size: tuple[int, int], words: str):
    refused(lambda: load_rig(oak, size=size), "leave size out, and ", words)


# --- what a rig remembers -----------------------------------------------------------------------------------


def test_the_memory_survives_what_keeps_a_rig_and_drops_under_jax(tmp_path: Path):
    rig = load_rig(SAMPLES["kalibr"].write(tmp_path))
    assert rig.source is not None
    for same in (rig.with_extrinsics(rig.extrinsics + CHANGE), replace(rig), pickle.loads(pickle.dumps(rig))):
        assert same.source == rig.source
    plain = StereoRig(rig.left, rig.right, rig.extrinsics)
    assert jax.tree.structure(rig) == jax.tree.structure(plain)
    assert jax.tree.map(lambda leaf: leaf, rig).source is None
    traces = []

    @jax.jit
    def length(value: StereoRig):
        traces.append(1)
        return value.baseline

    length(rig), length(plain), length(replace(rig, source="anything"))
    assert len(traces) == 1


# --- real files ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["stereo.yaml", "stereo_Bumblebee2_Square.yaml"])
def test_real_boofcv(data_dir: Path, tmp_path: Path, name: str):
    path = data_dir / "boofcv_bumblebee2" / "calibration_chess" / name
    rig = load_rig(path, unit="mm")
    stated = yaml.safe_load(path.read_text())
    assert rig.left.matrix[0, 0] == stated["left"]["pinhole"]["fx"]
    assert rig.baseline == pytest.approx(0.12, rel=0.01)
    if name == "stereo.yaml":  # from which the scenes' calib.json were made, by another hand
        scene = json.loads((data_dir / "boofcv_bumblebee2" / "garden01" / "calib.json").read_text())
        np.testing.assert_allclose(rig.rotation, scene["R"], atol=1e-9)
        np.testing.assert_allclose(rig.translation, scene["T"], atol=1e-9)
    moved = rig.with_extrinsics(rig.extrinsics + CHANGE)
    save_rig(moved, tmp_path / "new.yaml")
    np.testing.assert_allclose(load_rig(tmp_path / "new.yaml", unit="mm").extrinsics, moved.extrinsics, atol=1e-12)
    lines = zip(path.read_text().splitlines(), (tmp_path / "new.yaml").read_text().splitlines(), strict=True)
    assert sum(one != two for one, two in lines) == 12
