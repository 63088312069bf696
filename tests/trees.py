"""Small folders in the layouts of public data sets, for the tests of their loaders."""

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from stereorecal import InputError
from stereorecal.geometry import rotation_from_vector
from stereorecal.io import load_log, load_scene

SIZE = (24, 16)


def texture(seed: int, size: tuple[int, int] = SIZE, colour: bool = False) -> np.ndarray:
    shape = (*size[::-1], 3) if colour else size[::-1]
    return np.random.default_rng(seed).integers(0, 255, shape, dtype=np.uint8, endpoint=True)


def write_image(path: Path, seed: int, size: tuple[int, int] = SIZE, colour: bool = False) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    assert cv2.imwrite(str(path), texture(seed, size, colour))
    return path


def write_text(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


def pose_of(turn, place) -> np.ndarray:
    """A rigid motion (4, 4)."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation_from_vector(np.array(turn, float)), place
    return pose


def edit(path: Path, old: str, new: str) -> None:
    """Replace what must be there."""
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


def cut(path: Path, word: str) -> None:
    """Truncate a text in front of a word that must be there."""
    path.write_text(path.read_text().partition(word)[0])


def without_line(path: Path, word: str) -> None:
    """Take away the lines that begin with a word."""
    lines = path.read_text().splitlines(keepends=True)
    kept = [line for line in lines if not line.startswith(word)]
    assert len(kept) < len(lines)
    path.write_text("".join(kept))


def set_line(path: Path, key: str, values: object) -> None:
    """Give a line `key: values` other values."""
    without_line(path, f"{key}:")
    path.write_text(f"{path.read_text()}{key}: {values}\n")


def refused(folder: Path, *words: str, kind: type[InputError] = InputError) -> None:
    """The folder is not read, or one of its images is not, and one sentence says why."""
    with pytest.raises(InputError) as error:
        _read(folder)
    message = _one_sentence(error.value, kind)
    for word in words:
        assert word in message


def _read(folder: Path) -> None:
    for mission in load_log(folder).missions:
        tuple(mission.pairs)


def refused_scene(folder: Path, words: str, kind: type[InputError] = InputError, about: str = "calib.json") -> None:
    """The folder is not read as a scene, and one sentence says why (`words`, a pattern), and where."""
    with pytest.raises(InputError, match=words) as error:
        load_scene(folder)
    assert about in _one_sentence(error.value, kind)


def _one_sentence(error: InputError, kind: type[InputError]) -> str:
    """The message of an error that is of this kind itself."""
    message = str(error)
    assert type(error) is kind, message
    assert "\n" not in message
    assert message.endswith("."), message
    return message


def row(values: object) -> str:
    return " ".join(f"{value:.12e}" for value in np.asarray(values, float).reshape(-1))


# --- KITTI --------------------------------------------------------------------------------------------------

K = np.array([[21.0, 0.0, 11.5], [0.0, 21.0, 7.25], [0.0, 0.0, 1.0]])
# Where camera 00 stands in the frames of the four cameras, as KITTI's: the colour ones a little off the line.
PLACES = np.array([[0.0, 0.0, 0.0], [-0.54, 0.0, 0.0], [0.06, -0.0003, 0.0027], [-0.47, 0.0025, 0.0027]])


def projection(index: int) -> np.ndarray:
    return K @ np.column_stack([np.eye(3), PLACES[index]])


def kitti_projections() -> str:
    return "".join(f"P{index}: {row(projection(index))}\n" for index in range(4)) + f"Tr: {row(np.eye(3, 4))}\n"


def kitti_cam_to_cam(poses: list[np.ndarray] | None = None) -> str:
    """A calib_cam_to_cam.txt; `poses` are 4x4, from camera 00 to each."""
    poses = poses or [np.block([[np.eye(3), place[:, None]], [np.zeros(3), 1.0]]) for place in PLACES]
    lines = ["calib_time: 09-Jan-2012 13:57:47", "corner_dist: 9.950000e-02"]
    for index, pose in enumerate(poses):
        name = f"{index:02d}"
        lines += [
            f"S_{name}: {row(SIZE)}",
            f"K_{name}: {row(K + np.diag([index, index, 0.0]))}",
            f"D_{name}: {row([-0.3, 0.1, 0.001, 0.002, -0.01 * index])}",
            f"R_{name}: {row(pose[:3, :3])}",
            f"T_{name}: {row(pose[:3, 3])}",
            f"S_rect_{name}: {row(SIZE)}",
            f"R_rect_{name}: {row(np.eye(3))}",
            f"P_rect_{name}: {row(projection(index))}",
        ]
    return "\n".join(lines) + "\n"


def kitti_drive(drive: Path, cameras: tuple[int, ...] = (0, 1), frames: int = 3) -> Path:
    for camera in cameras:
        folder = drive / f"image_{camera:02d}"
        for index in range(frames):
            write_image(folder / "data" / f"{index:010d}.png", 10 * index + camera, colour=camera > 1)
        times = [f"2011-09-26 13:02:25.{100 * index + camera:03d}360375" for index in range(frames)]
        write_text(folder / "timestamps.txt", "\n".join(times) + "\n")
    return drive


def kitti_raw(root: Path) -> Path:
    day = root / "2011_09_26"
    write_text(day / "calib_cam_to_cam.txt", kitti_cam_to_cam())
    for number in (1, 2):
        kitti_drive(day / f"2011_09_26_drive_{number:04d}_sync")
    return day


def kitti_odometry(root: Path) -> Path:
    for name in ("00", "01"):
        folder = root / "sequences" / name
        for side in (0, 1):
            for index in range(2):
                write_image(folder / f"image_{side}" / f"{index:06d}.png", 2 * index + side)
        write_text(folder / "calib.txt", kitti_projections())
    write_text(root / "sequences" / "21" / "calib.txt", kitti_projections())  # its images were not unpacked
    return root


def kitti_2012(root: Path) -> Path:
    folder = root / "training"
    for number in range(3):
        for suffix in ("10", "11"):
            for seed, side in enumerate(("image_0", "image_1", "colored_0", "colored_1")):
                write_image(folder / side / f"{number:06d}_{suffix}.png", 10 * number + seed, colour=seed > 1)
        write_text(folder / "calib" / f"{number:06d}.txt", kitti_projections())
    return folder


def kitti_2015(root: Path) -> Path:
    folder = root / "training"
    for number in range(3):
        for seed, side in enumerate(("image_2", "image_3")):
            write_image(folder / side / f"{number:06d}_10.png", 10 * number + seed, colour=True)
        write_text(folder / "calib_cam_to_cam" / f"{number:06d}.txt", kitti_cam_to_cam())
    return folder


# --- EuRoC --------------------------------------------------------------------------------------------------

# As EuRoC's own, comments included; of the real ones only the size of the images is changed.
EUROC_SENSOR = """#Default imu sensor yaml file
sensor_type: camera
comment: VI-Sensor {camera} (MT9M034)

# Sensor extrinsics wrt. the body-frame.
T_BS:
  cols: 4
  rows: 4
  data: [{pose}]

# Camera specific definitions.
rate_hz: 20
resolution: [{width}, {height}]
camera_model: pinhole
intrinsics: [{intrinsics}] #fu, fv, cu, cv
distortion_model: radial-tangential
distortion_coefficients: [{distortion}]

"""
EUROC_POSES = (
    """0.0148655429818, -0.999880929698, 0.00414029679422, -0.0216401454975,
         0.999557249008, 0.0149672133247, 0.025715529948, -0.064676986768,
        -0.0257744366974, 0.00375618835797, 0.999660727178, 0.00981073058949,
         0.0, 0.0, 0.0, 1.0""",
    """0.0125552670891, -0.999755099723, 0.0182237714554, -0.0198435579556,
         0.999598781151, 0.0130119051815, 0.0251588363115, 0.0453689425024,
        -0.0253898008918, 0.0179005838253, 0.999517347078, 0.00786212447038,
         0.0, 0.0, 0.0, 1.0""",
)
EUROC_LENSES = (
    ("458.654, 457.296, 367.215, 248.375", "-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05"),
    ("457.587, 456.134, 379.999, 255.238", "-0.28368365,  0.07451284, -0.00010473, -3.55590700e-05"),
)
EUROC_TIMES = (1403715273262142976, 1403715273312143104, 1403715273362142976)


def euroc_sensor(index: int, pose: str | None = None, size: tuple[int, int] = SIZE) -> str:
    intrinsics, distortion = EUROC_LENSES[index]
    return EUROC_SENSOR.format(
        camera=f"cam{index}", pose=pose or EUROC_POSES[index], width=size[0], height=size[1],
        intrinsics=intrinsics, distortion=distortion,
    )  # fmt: skip


def euroc(root: Path) -> Path:
    folder = root / "V1_01_easy"
    for index in (0, 1):
        camera = folder / "mav0" / f"cam{index}"
        write_text(camera / "sensor.yaml", euroc_sensor(index))
        lines = [f"{time},{time}.png" for time in EUROC_TIMES]
        write_text(camera / "data.csv", "\n".join(["#timestamp [ns],filename", *lines]) + "\n")
        for number, time in enumerate(EUROC_TIMES):
            write_image(camera / "data" / f"{time}.png", 2 * number + index)
    return folder


TREES: dict[str, Callable[[Path], Path]] = {
    "kitti raw": kitti_raw,
    "kitti raw drive": lambda root: kitti_raw(root) / "2011_09_26_drive_0001_sync",
    "kitti odometry": kitti_odometry,
    "kitti odometry sequence": lambda root: kitti_odometry(root) / "sequences" / "00",
    "kitti stereo 2012": kitti_2012,
    "kitti stereo 2015": kitti_2015,
    "euroc": euroc,
    "mav0": lambda root: euroc(root) / "mav0",
}
