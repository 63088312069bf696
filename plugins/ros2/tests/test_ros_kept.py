"""What outlives a restart, and what becomes of the files: the node's own, calibrations, and somebody else's."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from robots import BEST, BETTER, SIZE, Robot
from stereorecal_ros._worker import _RETRY

from stereorecal import InputError
from stereorecal.io import load_rig, save_rig
from stereorecal.synthetic import default_rig


def test_it_goes_on_after_a_restart(robot):
    one = robot()
    one.calibrate()
    one.see()
    one.accept(BETTER)
    one.watch.apply()
    one.accept(BEST)
    one.watch.close()
    two = robot()
    two.calibrate()
    two.see()
    assert two.turned() == pytest.approx(0.1, abs=0.01)  # what was applied, and not what waits
    assert "waits" in two.watch.status().message
    assert two.watch.roll_back()[0]
    two.watch.close()
    three = robot(auto_apply=True)
    three.calibrate()
    three.see()
    assert three.turned() == pytest.approx(0.0, abs=1e-9)
    assert not three.watch.settings.repair  # what was rolled back stays so


@pytest.mark.parametrize("what", ["state", "applied"])
def test_a_file_that_is_damaged_is_set_aside(robot, tmp_path: Path, what: str):
    name = {"state": "node.state", "applied": "node.state.applied.json"}[what]
    (tmp_path / name).write_text('{"schema": "stereorecal.ros-applied/1"')
    one = robot()
    one.calibrate()
    one.see()
    assert one.turned() == pytest.approx(0.0, abs=1e-9)
    assert one.said(name, "kept as")
    assert (tmp_path / f"{name}.bak").exists()


@pytest.mark.parametrize("auto_apply", [False, True])
def test_a_state_begun_anew_offers_nothing_that_was_not_accepted(robot, tmp_path: Path, auto_apply: bool):
    """What it begins with is what was given at first, and bad by then."""
    one = robot(auto_apply=True)
    one.calibrate()
    one.see()
    one.accept(BETTER)
    one.watch.close()
    (tmp_path / "node.state").write_text("cut off")
    two = robot(auto_apply=auto_apply)
    two.calibrate()
    two.see(3)
    assert two.turned() == pytest.approx(0.1, abs=0.01)
    assert "waits" not in two.watch.status().message
    two.watch.apply()
    assert two.turned() == pytest.approx(0.1, abs=0.01)
    two.accept(BEST)
    two.watch.apply()
    assert two.turned() == pytest.approx(0.2, abs=0.01)


def test_a_correction_is_of_one_calibration_with_all_that_it_consists_of(robot):
    """Another one may stand alike, with other lenses."""
    one = robot(auto_apply=True)
    one.calibrate()
    one.see()
    one.accept(BETTER)
    assert one.turned() == pytest.approx(0.1, abs=0.01)
    one.watch.close()
    two = robot()
    lenses = replace(two.rig.left, distortion=np.array([-0.1, 0.02, 0.0, 0.0]))
    two.rig = replace(two.rig, left=lenses)
    two.calibrate()
    two.see()
    assert two.turned() == pytest.approx(0.0, abs=1e-9)


def test_what_was_applied_outlives_a_worker_though_no_file_could_hold_it(robot, monkeypatch: pytest.MonkeyPatch):
    one = robot()
    one.calibrate()
    one.see()
    one.accept(BETTER)
    monkeypatch.setattr("stereorecal_ros._applied.write_json", lambda *_: (_ for _ in ()).throw(InputError("full")))
    one.watch.apply()
    one.work.exited = True
    one.see()
    one.now += _RETRY
    one.see()
    assert len(one.works) == 2
    assert one.turned() == pytest.approx(0.1, abs=0.01)


def test_files_are_read_and_saved_with_a_copy(robot, tmp_path: Path):
    files = (str(tmp_path / "left.yaml"), str(tmp_path / "right.yaml"))
    rig = default_rig().resized(SIZE)
    save_rig(rig, files, format="ros")
    before = [Path(name).read_bytes() for name in files]
    one = robot(calibration=files)
    assert one.watch.corrected is not None
    one.see()
    assert one.watch.status().values["missing"] == "nothing"
    one.accept(BETTER)
    one.watch.apply()
    done, said = one.watch.save()
    assert done
    assert f"{files[0]}.bak" in said
    assert [Path(f"{name}.bak").read_bytes() for name in files] == before
    np.testing.assert_allclose(load_rig(files).extrinsics, one.watch.rig.extrinsics, atol=1e-9)
    one.watch.close()
    two = robot(calibration=files)  # which now hold what was applied
    two.see()
    np.testing.assert_allclose(two.watch.rig.extrinsics, one.watch.rig.extrinsics, atol=1e-9)
    assert not two.said("new one begun")
    three = Robot(tmp_path / "other")
    assert not three.watch.save()[0]
