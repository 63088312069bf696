"""A state as a file: steps go on, without what only the next pair could be compared with; others are refused."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rides import BEFORE, Ride

import stereorecal as sr
from stereorecal.geometry import changed_camera
from stereorecal.online import Config, Kind, Stepped, init, load, run, save, step
from stereorecal.scoring.host import Corners
from stereorecal.synthetic import default_rig


def content(state: sr.online.State, folder: Path) -> bytes:
    save(state, folder / "content")
    return (folder / "content").read_bytes()


@pytest.mark.slow
def test_the_same_pairs_give_the_same_states(ride: Ride, ridden: list[Stepped], tmp_path: Path):
    again = list(run(ride.rig, ride.pairs[: BEFORE + 3], Config()))
    assert content(again[-1].state, tmp_path) == content(ridden[BEFORE + 2].state, tmp_path)


def test_a_loaded_state_goes_on(ride: Ride, ridden: list[Stepped], tmp_path: Path):
    """From the first sign of a knock, which is then told and repaired."""
    sign = next(i for i, stepped in enumerate(ridden) if stepped.state.repair_pairs)
    save(ridden[sign].state, tmp_path / "state")
    state, kinds = load(tmp_path / "state"), []
    again = ridden[sign].state.alone()
    for pair in ride.pairs[sign + 1 :]:
        state, events = step(state, pair)
        again, _ = step(again, pair)
        kinds += [event.kind for event in events]
        if Kind.REPAIRED in kinds:
            break
    assert Kind.REPAIRED in kinds
    assert content(state, tmp_path) == content(again, tmp_path)


def test_the_images_of_corners_are_not_kept(tmp_path: Path):
    """The file stays small: two megabytes of images would wear a disk."""
    place, image = tmp_path / "state", np.random.default_rng(0).integers(0, 255, (1080, 1920), np.uint8)
    none = np.zeros((0, 2))
    state = init(default_rig()).replace(corners=Corners(image, none, none), corners_time=1.0, last=image[:180, :320])
    save(state, place)
    assert place.stat().st_size < 100_000
    again = load(place)
    assert again.corners is again.last is again.corners_time is None


def test_pairs_that_wait_for_a_repair_are_kept(ride: Ride, tmp_path: Path):
    state = init(ride.rig).replace(
        repair_pairs=tuple(ride.pairs[:2]), unmatched_in_a_row=2, matcher=sr.SAD(num_disparities=48)
    )
    save(state, tmp_path / "state")
    again = load(tmp_path / "state")
    np.testing.assert_array_equal(again.repair_pairs[1].left, ride.pairs[1].left)
    assert again.matcher == state.matcher
    assert again.config == state.config
    assert np.isnan(again.row_error)


@pytest.mark.usefixtures("unchecked")
def test_numbers_of_numpy_come_back(ride: Ride, tmp_path: Path):
    save(init(ride.rig, Config(every=np.int64(3))), tmp_path / "state")  # pyright: ignore[reportArgumentType]
    assert load(tmp_path / "state").config == Config(every=3)


def test_what_is_no_state_is_refused(ride: Ride, tmp_path: Path):
    path = tmp_path / "state"
    with pytest.raises(sr.InputError, match="cannot be read"):
        load(path)
    save(init(ride.rig), path)
    whole = path.read_bytes()
    for cut in (0, 10, len(whole) // 2):
        path.write_bytes(whole[:cut])
        with pytest.raises(sr.InputError, match="no state"):
            load(path)
    for flag in (0x01, 0x20):  # of the archive's first member: encrypted, patched
        flipped = bytearray(whole)
        flipped[whole.rindex(b"PK\1\2") + 8] |= flag
        path.write_bytes(flipped)
        with pytest.raises(sr.InputError, match="no state"):
            load(path)
    path.write_text("left,right\n1,2\n")
    with pytest.raises(sr.InputError, match="no state"):
        load(path)
    with open(path, "wb") as file:
        np.savez(file, content=np.frombuffer(json.dumps({"schema": "stereorecal.state/9"}).encode(), np.uint8))
    with pytest.raises(sr.InputError, match="of version"):
        load(path)


def test_a_state_of_another_calibration_is_refused(ride: Ride, tmp_path: Path):
    """A new calibration is not watched, and not written over, with what was learnt of the old one."""
    path = tmp_path / "state"
    began = init(ride.rig)
    before = np.array([0.2, 0.0, 0.0, 0.0, 0.0])
    save(began.replace(using=np.array([0.3, 0.0, 0.0, 0.0, 0.0]), previous=(np.zeros(5), before)), path)
    used = load(path).rig
    assert not np.allclose(used.extrinsics, ride.rig.extrinsics)
    sr.io.save_rig(used, (tmp_path / "ros_left.yaml", tmp_path / "ros_right.yaml"), format="ros")
    written = sr.io.load_rig(tmp_path / "ros_left.yaml", tmp_path / "ros_right.yaml")
    for known in (ride.rig, used, written, began.rig_at(before)):
        assert load(path, known).using[0] == 0.3
    turned = ride.rig.with_extrinsics(ride.rig.extrinsics + 1e-5 * np.eye(6)[1])
    longer = replace(ride.rig, left=changed_camera(ride.rig.left, {"f": 1e-5}))
    bent = replace(ride.rig, right=changed_camera(ride.rig.right, {"k1": 1e-5}))
    cropped = replace(
        ride.rig, **{side: replace(getattr(ride.rig, side), size=(320, 200)) for side in ("left", "right")}
    )
    for other in (turned, longer, bent, cropped, ride.rig.resized((160, 120))):
        with pytest.raises(sr.InputError, match="belongs to another calibration"):
            load(path, other)
        with pytest.raises(sr.InputError, match="belongs to another calibration"):
            sr.online.MonitorProcess(other, keep=path)


def test_a_matcher_that_is_not_installed(ride: Ride, tmp_path: Path):
    path = tmp_path / "state"
    save(init(ride.rig, Config(matcher=sr.SAD(num_disparities=48))), path)
    with np.load(path) as file:
        arrays = {name: file[name] for name in file.files}
    content = arrays["content"].tobytes().replace(b'{"matcher": "sad"', b'{"matcher": "mine"')
    with open(path, "wb") as file:
        np.savez(file, **{**arrays, "content": np.frombuffer(content, np.uint8)})  # pyright: ignore[reportArgumentType]
    with pytest.raises(sr.InputError, match="state: unknown matcher 'mine'"):
        load(path)


def test_a_failed_save_leaves_the_old_file(ride: Ride, tmp_path: Path):
    class Other(sr.SAD):
        pass

    path = tmp_path / "state"
    save(init(ride.rig), path)
    old = path.read_bytes()
    with pytest.raises(sr.InputError, match="cannot be saved"):
        save(replace(init(ride.rig), matcher=Other(num_disparities=48)), path)
    assert path.read_bytes() == old
    assert list(tmp_path.iterdir()) == [path]
