"""A video and a bag go to a repaired calibration, with a report, in one command each."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from bags import write_bag
from spoiled import turned

from stereorecal.geometry import rectifying_rotations
from stereorecal.io import load_rig, save_rig, save_scene
from stereorecal.synthetic import default_rig

SIZE, FRAMES = (320, 240), 4


@pytest.fixture(scope="module")
def seen(scene) -> list[tuple[np.ndarray, np.ndarray]]:
    return [
        (pair.left.round().astype(np.uint8), pair.right.round().astype(np.uint8))
        for pair in scene("harbour", 0, SIZE, FRAMES).pairs
    ]


@pytest.fixture(scope="module")
def calibration(scene, tmp_path_factory) -> Path:
    """Off by half a degree and more."""
    folder, shown = tmp_path_factory.mktemp("calibration") / "scene", scene("harbour", 0, SIZE)
    save_scene(replace(shown, rig=turned(shown.rig, 0.6, 0.3, -0.5), reference="stored"), folder)
    return folder / "calib.json"


def repaired(answer, folder: Path) -> str:
    """The page, of a repair that was accepted."""
    assert answer.code == 0, answer.err
    assert (folder / "new.json").exists()
    page = (folder / "out.html").read_text(encoding="utf-8")
    assert "Use the new calibration" in page
    assert len(page) < 3_000_000
    return page


@pytest.mark.slow
def test_a_side_by_side_video(command, seen, calibration, tmp_path):
    video = cv2.VideoWriter(str(tmp_path / "both.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 10.0, (2 * SIZE[0], SIZE[1]))
    for left, right in seen:
        video.write(cv2.cvtColor(np.concatenate([left, right], axis=1), cv2.COLOR_GRAY2BGR))
    video.release()
    places = ("--output", tmp_path / "new.json", "--html", tmp_path / "out.html")
    words = ("--side-by-side", tmp_path / "both.avi", "--calibration", calibration, "--limit", 1, "--pairs", "1:")
    page = repaired(command("recalibrate", *words, *places), tmp_path)
    assert "1 other pair" in page  # before --from
    assert "2 other pairs" in page  # with less texture
    assert "the pair with the most texture is used" in page


def test_a_bag_with_its_own_calibration(command, seen, tmp_path):
    """Its camera_info is one, that no file holds; the rig is right, and so is the verdict."""
    pytest.importorskip("rosbags", reason="rosbags is not installed")
    rig = default_rig().resized(SIZE)
    rotations = rectifying_rotations(rig.rotation, rig.translation)
    infos, focal = [], 200.0
    for side, camera, rotation, shift in zip("lr", (rig.left, rig.right), rotations, (0.0, rig.baseline), strict=True):
        numbers = {"d": camera.distortion, "k": np.ravel(camera.matrix), "r": np.ravel(rotation)}
        p = np.array([focal, 0, 160, -focal * shift, 0, focal, 120, 0, 0, 0, 1, 0])
        content = {"width": SIZE[0], "height": SIZE[1], "distortion_model": "plumb_bob", **numbers, "p": p}
        infos.append((f"/{side}/camera_info", content))
    stamped = [(f"/{side}/image_raw", 10**18, image) for side, image in zip("lr", seen[0], strict=True)]
    path = write_bag(tmp_path / "run.bag", stamped, ros1=True, infos=infos)
    words = ("--bag", path, "--left", "/l/image_raw", "--right", "/r/image_raw")
    answer = command("score", *words)
    assert (answer.code, answer.err) == (0, "")
    command("score", *words, "--format", "ros").refuses(": --format and --cameras belong to --calibration; leave them")


def test_frames_that_a_camera_lost_are_told(command, seen, calibration, tmp_path):
    """By order, the fourth of one would be paired with the fifth of the other."""
    left, right = tmp_path / "left", tmp_path / "right"
    for side, (folder, names) in enumerate({left: ["port1_3", "port1_4"], right: ["rear2_003", "rear2_005"]}.items()):
        folder.mkdir()
        for number, name in enumerate(names):
            cv2.imwrite(str(folder / f"{name}.png"), seen[number][side])
    answer = command("score", "--left", left, "--right", right, "--calibration", calibration)
    said = "left out, without partner in the other camera: left/port1_4.png, right/rear2_005.png"
    assert (answer.code, answer.err) == (1, f"stereorecal: {said}\n")


@pytest.mark.slow
@pytest.mark.parametrize("turns", [(0, 2), (1, 1)], ids=["right upside down", "one above the other"])
def test_cameras_that_stand_otherwise(command, seen, calibration, tmp_path, turns):
    """The same answers, and the file as it was but for what is repaired."""
    rig = load_rig(calibration)
    save_rig(replace(rig, turns=turns, source=None), tmp_path / "stands.yaml", format="opencv")
    for name, images, given in (("plain", (0, 0), calibration), ("turned", turns, tmp_path / "stands.yaml")):
        words = ["--calibration", given, "--unit", "m"] if name == "turned" else ["--calibration", given]
        for side, turn in enumerate(images):
            (tmp_path / name / str(side)).mkdir(parents=True)
            for number, pair in enumerate(seen[:1]):
                cv2.imwrite(str(tmp_path / name / str(side) / f"{number}.png"), np.rot90(pair[side], -turn))
        where = ("--left", tmp_path / name / "0", "--right", tmp_path / name / "1", *words)
        answer = command("recalibrate", *where, "--output", tmp_path / f"{name}{given.suffix}")
        assert answer.code == 0, answer.err
        assert ("images are turned by" in answer.err) == (name == "turned")
    plain, found = load_rig(tmp_path / "plain.json"), load_rig(tmp_path / "turned.yaml", unit="m")
    np.testing.assert_allclose(found.side_by_side().extrinsics, plain.extrinsics, atol=1e-6)
    assert found.turns == (0, 0)
    assert found.left.size == (SIZE[::-1] if turns == (1, 1) else SIZE)
    difference = command("diff", tmp_path / "plain.json", tmp_path / "turned.yaml", "--unit", "m")
    assert "rotation  0.000 deg" in difference.out
