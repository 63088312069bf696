"""What outlives a restart, and what becomes of the files: the node's own, calibrations, and somebody else's."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from machine import full_disk
from robots import BEST, BETTER, SIZE, Robot
from stereorecal_ros import Applied, CameraInfo, Level, corrected

from stereorecal import InputError
from stereorecal.io import load_rig, save_rig
from stereorecal.online import Event, Kind, save
from stereorecal.synthetic import default_rig


def test_it_goes_on_after_a_restart(robot):
    one = robot()
    one.accept(BETTER)
    one.watch.apply()
    one.accept(BEST)
    one.watch.close()
    two = robot()
    assert two.turned() == pytest.approx(0.1, abs=0.01)  # what was applied, and not what waits
    assert "waits" in two.watch.status().message
    assert two.watch.roll_back()[0]
    two.watch.close()
    three = robot(auto_apply=True)
    assert three.turned() == pytest.approx(0.0, abs=1e-9)
    assert not three.watch.settings.repair  # what was rolled back stays so


@pytest.mark.parametrize("what", ["state", "applied"])
def test_a_file_that_is_damaged_is_set_aside(robot, tmp_path: Path, what: str):
    name = {"state": "node.state", "applied": "node.state.applied.json"}[what]
    (tmp_path / name).write_text('{"schema": "stereorecal.ros-applied/1"')
    one = robot()
    assert one.turned() == pytest.approx(0.0, abs=1e-9)
    assert one.said(name, "kept as")
    assert (tmp_path / f"{name}.bak").exists()


@pytest.mark.parametrize("auto_apply", [False, True])
def test_a_state_begun_anew_offers_nothing_that_was_not_accepted(robot, tmp_path: Path, auto_apply: bool):
    """What it begins with is what was given at first, and bad by then."""
    one = robot(auto_apply=True)
    one.accept(BETTER)
    one.watch.close()
    (tmp_path / "node.state").write_text("cut off")
    two = robot(auto_apply=auto_apply)
    two.see(2)
    assert two.turned() == pytest.approx(0.1, abs=0.01)
    assert "waits" not in two.watch.status().message
    two.watch.apply()
    assert two.turned() == pytest.approx(0.1, abs=0.01)
    two.accept(BEST)
    two.watch.apply()
    assert two.turned() == pytest.approx(0.2, abs=0.01)


def test_what_a_state_begun_anew_has_accepted_outlives_a_restart(robot, tmp_path: Path):
    one = robot(auto_apply=True)
    one.accept(BETTER)
    one.watch.close()
    (tmp_path / "node.state").write_text("cut off")
    two = robot()
    two.accept(BEST)
    two.watch.close()
    three = robot()
    assert three.turned() == pytest.approx(0.1, abs=0.01)
    assert "waits" in three.watch.status().message
    assert three.watch.apply()[0]
    assert three.turned() == pytest.approx(0.2, abs=0.01)
    assert three.watch.roll_back()[0]
    three.see()
    assert "waits" not in three.watch.status().message
    np.testing.assert_array_equal(three.work.state.using, BETTER)


def test_what_is_published_is_known_without_what_the_calibration_left():
    """To find it takes half a second, in a callback; where it is said to be nothing, nobody does."""
    rig = default_rig().resized(SIZE)
    published = Applied(rig, rig, (np.zeros(5), BETTER)).published
    assert published.config.prior == "exact"
    np.testing.assert_array_equal(published.using, BETTER)


def test_a_correction_is_of_one_calibration_with_all_that_it_consists_of(robot, blank):
    """Another one may stand alike, with other lenses."""
    one = robot(auto_apply=True)
    one.accept(BETTER)
    assert one.turned() == pytest.approx(0.1, abs=0.01)
    one.watch.close()
    two = blank()
    lenses = replace(two.rig.left, distortion=np.array([-0.1, 0.02, 0.0, 0.0]))
    two.rig = replace(two.rig, left=lenses)
    two.calibrate()
    two.see()
    assert two.turned() == pytest.approx(0.0, abs=1e-9)


def test_what_was_applied_outlives_a_worker_though_no_file_could_hold_it(robot):
    one = robot()
    one.accept(BETTER)
    with full_disk():
        one.watch.apply()
    one.work.exited = True
    one.see()
    one.now += 5.0  # seconds, after which another process is begun
    one.see()
    assert len(one.works) == 2
    assert one.turned() == pytest.approx(0.1, abs=0.01)


def test_files_are_read_and_saved_with_a_copy(blank, tmp_path: Path):
    files = (str(tmp_path / "left.yaml"), str(tmp_path / "right.yaml"))
    rig = default_rig().resized(SIZE)
    save_rig(rig, files, format="ros")
    before = [Path(name).read_bytes() for name in files]
    one = blank(calibration=files)
    one.see()
    assert one.watch.corrected is not None
    assert one.watch.status().values["missing"] == "nothing"
    one.accept(BETTER)
    one.watch.apply()
    done, said = one.watch.save()
    assert done
    assert f"{files[0]}.bak" in said
    assert [Path(f"{name}.bak").read_bytes() for name in files] == before
    np.testing.assert_allclose(load_rig(files).extrinsics, one.watch.rig.extrinsics, atol=1e-9)
    one.watch.close()
    two = blank(calibration=files)  # which now hold what was applied
    two.see()
    np.testing.assert_allclose(two.watch.rig.extrinsics, one.watch.rig.extrinsics, atol=1e-9)
    assert not two.said("new one begun")
    three = Robot(tmp_path / "other")
    assert not three.watch.save()[0]


def test_a_calibration_file_that_is_restored_by_hand_wins(blank, tmp_path: Path):
    """Over what was applied and saved in it; old and new are told, and what was known is set aside."""
    files = (str(tmp_path / "left.yaml"), str(tmp_path / "right.yaml"))
    save_rig(default_rig().resized(SIZE), files, format="ros")
    one = blank(calibration=files)
    one.see()
    one.accept(BETTER)
    one.watch.apply()
    one.watch.save()
    one.watch.close()
    for name in files:
        Path(f"{name}.bak").replace(name)
    two = blank(calibration=files)
    two.see()
    assert two.turned() == pytest.approx(0.0, abs=1e-6)
    turns = [np.degrees(watch.rig.extrinsics[:3]) for watch in (one.watch, two.watch)]
    old, new = ("pitch {:+.4f} yaw {:+.4f} roll {:+.4f} deg".format(*turn) for turn in turns)
    assert two.said("another calibration is given than the one before", f": {old}", f" -> {new}")
    assert (tmp_path / "node.state.bak").exists()
    assert not two.watch.roll_back()[0]
    two.accept(BETTER)
    two.watch.apply()
    two.watch.close()
    three = blank(calibration=files)  # applied, and not saved: the file is as it was
    three.see()
    assert three.turned() == pytest.approx(0.1, abs=0.01)
    assert not three.said("another calibration")


def test_what_was_applied_after_a_save_outlives_the_state(blank, tmp_path: Path):
    """Offsets are of the calibration that was given at first, which the file does not hold any more."""
    file = str(tmp_path / "stereo.json")
    save_rig(default_rig().resized(SIZE), file)
    one = blank(calibration=(file,))
    one.see()
    one.accept(BETTER)
    one.watch.apply()
    one.watch.save()
    one.accept(BEST)
    one.watch.apply()
    one.watch.close()
    (tmp_path / "node.state").write_bytes(b"")
    two = blank(calibration=(file,))
    two.see()
    assert two.turned() == pytest.approx(0.2, abs=0.01)
    assert two.watch.roll_back()[0]
    assert two.turned() == pytest.approx(0.1, abs=0.01)


def published_by_a_driver(file: Path) -> CameraInfo:
    content = yaml.safe_load(file.read_text())
    names = ("distortion_coefficients", "camera_matrix", "rectification_matrix", "projection_matrix")
    size = content["image_width"], content["image_height"]
    return CameraInfo(*size, content["distortion_model"], *(tuple(content[name]["data"]) for name in names))


def test_the_projection_of_ros_files_is_that_of_their_camera_info(blank, tmp_path: Path):
    """As their driver publishes it: nothing changes until something is applied, and then R and the baseline alone."""
    files = (tmp_path / "left.yaml", tmp_path / "right.yaml")
    rig = default_rig().resized(SIZE)
    save_rig(rig, files, format="ros")
    before = [published_by_a_driver(name) for name in files]
    one = blank(calibration=tuple(map(str, files)))
    one.see()
    assert [a.is_like(b) for a, b in zip(one.watch.corrected, before, strict=True)] == [True, True]
    assert not corrected(rig)[0].is_like(before[0])  # a view of ours shows less
    one.accept(BETTER)
    one.watch.apply()
    for info, given in zip(one.watch.corrected, before, strict=True):
        np.testing.assert_allclose(np.delete(info.p, 3), np.delete(given.p, 3))
        assert np.abs(np.subtract(info.r, given.r)).max() > 1e-4


def test_a_roll_back_that_the_worker_did_not_come_to(robot):
    """It was killed: the next one is asked to."""
    one = robot(auto_apply=True)
    one.accept(BETTER)
    one.accept(BEST)
    one.work.slow = True
    one.watch.roll_back()
    one.watch.roll_back()
    save(one.work.state, one.work.keep)
    two = robot(auto_apply=True)
    assert two.turned() == pytest.approx(0.0, abs=1e-9)
    assert "waits" not in two.watch.status().message
    two.watch.set(repair=True)
    two.see()
    assert two.turned() == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_array_equal(two.work.state.using, np.zeros(5))
    assert two.work.state.config.repair


def test_a_state_that_cannot_be_saved_stands_in_the_status(robot):
    one = robot()
    one.work.events.append(Event(1, Kind.NOT_SAVED, "node.state: there is no room."))
    one.see(3)
    assert one.watch.status().message.endswith("nothing is kept over a restart: node.state: there is no room.")
    assert one.watch.status().level >= Level.WARN
    assert one.said("cannot be saved", "there is no room")
    one.work.events.append(Event(4, Kind.SAVED))
    one.see()
    assert "nothing is kept" not in one.watch.status().message


def test_what_is_applied_is_kept_when_there_is_room_again(robot, monkeypatch: pytest.MonkeyPatch):
    one = robot()
    one.accept(BETTER)
    with monkeypatch.context() as patch:
        patch.setattr("stereorecal_ros._applied.write_json", lambda *_: (_ for _ in ()).throw(InputError("full")))
        one.watch.apply()
        one.see(300)
        assert sum("cannot be kept over a restart: full" in text for _, text in one.log) == 1
        assert "nothing is kept over a restart: full" in one.watch.status().message
    one.see(300)
    one.see()
    assert "nothing is kept" not in one.watch.status().message
    two = robot()
    assert two.turned() == pytest.approx(0.1, abs=0.01)


@pytest.mark.parametrize("content", [b"%YAML:1.0\n", b"\x89PNG\r\n"])
def test_somebody_elses_file_is_not_taken_for_the_state(tmp_path: Path, content: bytes):
    place = tmp_path / "left.yaml"
    place.write_bytes(content)
    with pytest.raises(InputError, match=r"left\.yaml: is no state of this node; give another name"):
        Robot(tmp_path, state_file=str(place))
    assert place.read_bytes() == content
    with pytest.raises(InputError, match="is a folder; name a file in it"):
        Robot(tmp_path, state_file=str(tmp_path))


@pytest.mark.parametrize("content", [b"", bytes(4096), b"PK\x03\x04 cut short"])
def test_a_state_that_a_loss_of_power_has_damaged_is_set_aside(robot, tmp_path: Path, content: bytes):
    place = tmp_path / "mine"
    place.write_bytes(content)
    one = robot(state_file=str(place))
    assert one.said("kept as", "mine.bak")
    assert (tmp_path / "mine.bak").read_bytes() == content
