"""Each format by name: the sample texts, what their keys are that a repair may change, and the names of new files."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import samples
import yaml
from hypothesis import strategies as st
from lenses import WIDE_LENSES
from parts_of_repairs import Hints, as_in_file, document, named, scaled

from stereorecal.geometry import METRES, Camera, StereoRig
from stereorecal.io import load_rig


@dataclass(frozen=True)
class Sample:
    """Texts of one format.

    Attributes:
        changes: keys, as they are spelled on the way down, that hold the extrinsics or what is derived from them.
        unit: of the file, where it says none.
    """

    texts: tuple[str, ...]
    ending: str
    changes: frozenset[str]
    unit: str | None = None
    rectified: bool = False
    size: tuple[int, int] | None = None

    def paths(self, folder: Path) -> list[Path]:
        return [folder / f"calibration{index}{self.ending}" for index in range(len(self.texts))]

    def write(self, folder: Path) -> list[Path]:
        paths = self.paths(folder)
        for path, text in zip(paths, self.texts, strict=True):
            path.write_text(text)
        return paths

    def changed(self, *changes: tuple[str, str]) -> "Sample":
        """With other words in place of some, in whichever texts they stand."""
        texts = self.texts
        for old, new in changes:
            assert any(old in text for text in texts), old
            texts = tuple(text.replace(old, new) for text in texts)
        return replace(self, texts=texts)

    def load(self, paths: list[Path]) -> StereoRig:
        return load_rig(paths, unit=self.unit, size=self.size)


def as_json(text: str) -> str:
    """OpenCV's YAML as OpenCV's own JSON."""
    storage = cv2.FileStorage(text, cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY)
    return rewritten(storage, ".json")


def on_imu(text: str, key: str) -> str:
    """A Kalibr chain without T_cn_cnm1, whose cameras have only a pose on the IMU, of sixteen numbers."""
    content = yaml.safe_load(text)
    for camera in content.values():
        camera.pop("T_cn_cnm1", None)
        to_camera = np.array(camera.pop("T_cam_imu"))
        camera[key] = (to_camera if key == "T_cam_imu" else np.linalg.inv(to_camera)).ravel().tolist()
    return yaml.safe_dump(content)


def as_xml(text: str) -> str:
    storage = cv2.FileStorage(text, cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY)
    return rewritten(storage, ".xml")


def rewritten(storage: cv2.FileStorage, ending: str) -> str:
    out = cv2.FileStorage(ending, cv2.FILE_STORAGE_WRITE | cv2.FILE_STORAGE_MEMORY)
    for key in storage.root().keys():  # noqa: SIM118
        node = storage.getNode(key)
        if node.isMap():
            out.write(key, node.mat())
        elif node.isSeq():
            out.startWriteStruct(key, cv2.FILE_NODE_SEQ)
            for index in range(node.size()):
                out.write("", int(node.at(index).real()))
            out.endWriteStruct()
        elif node.isString():
            out.write(key, node.string())
        else:
            out.write(key, node.real())
    return out.releaseAndGetString()


_OPENCV = frozenset({"R", "T", "R1", "Q"})
_INTRINSICS, _SEP, _EXTRINSICS = samples.OPENCV.partition("R: !!")
_HEAD = "%YAML:1.0\n---\n"
SAMPLES: dict[str, Sample] = {
    "opencv yaml": Sample((samples.OPENCV,), ".yml", _OPENCV, "mm"),
    "opencv xml": Sample((as_xml(samples.OPENCV),), ".xml", _OPENCV, "mm"),
    "opencv json": Sample((as_json(samples.OPENCV),), ".json", _OPENCV, "mm"),
    "opencv pair": Sample((_INTRINSICS, _HEAD + _SEP + _EXTRINSICS), ".yml", _OPENCV, "mm"),
    "ros": Sample(samples.ROS_PAIR, ".yaml", frozenset({"rectification_matrix", "projection_matrix"})),
    "ros 1 messages": Sample(samples.ROS_1_MESSAGES, ".yaml", frozenset({"R", "P"})),
    "ros 2 messages": Sample(tuple(map(samples.as_ros_2, samples.ROS_1_MESSAGES)), ".yaml", frozenset({"r", "p"})),
    "kalibr": Sample((samples.KALIBR,), ".yaml", frozenset({"cam1.T_cn_cnm1", "cam1.T_cam_imu"})),
    "messages of both": Sample(
        ("\n---\n".join([*samples.ROS_1_MESSAGES, samples.ROS_1_MESSAGES[0]]),),
        ".yaml",
        frozenset(f"documents.{at}.{key}" for at in range(3) for key in "RP"),
    ),
    "kalibr on imu": Sample((on_imu(samples.KALIBR, "T_cam_imu"),), ".yaml", frozenset({"cam1.T_cam_imu"})),
    "kalibr to imu": Sample((on_imu(samples.KALIBR, "T_imu_cam"),), ".yaml", frozenset({"cam1.T_imu_cam"})),
    "euroc": Sample(samples.EUROC_PAIR, ".yaml", frozenset({"T_BS"})),
    "boofcv": Sample((samples.BOOFCV,), ".yaml", frozenset({"rightToLeft"}), "mm"),
    "kitti-raw": Sample((samples.KITTI_RAW,), ".txt", frozenset({"R_01", "T_01"})),
    "middlebury": Sample((samples.MIDDLEBURY,), ".txt", frozenset({"baseline"}), rectified=True),
    "kitti-odometry": Sample((samples.KITTI_ODOMETRY,), ".txt", frozenset({"P1"}), rectified=True, size=samples.SIZE),
    "basalt": Sample((samples.BASALT,), ".json", frozenset({"value0.T_imu_cam.1"})),
}


def flat(content: Any, keys: str = "") -> dict[str, Any]:
    """Every value by the keys that lead to it, joined by dots."""
    items = content.items() if isinstance(content, dict) else enumerate(content) if isinstance(content, list) else None
    if items is None:
        return {keys: content}
    return {name: item for key, value in items for name, item in flat(value, f"{keys}.{key}".lstrip(".")).items()}


def unchanged(text: str, sample: Sample) -> dict[str, Any]:
    """The values that a repair leaves alone."""
    found = flat(dict(document("a text", text).content))
    return {
        key: value
        for key, value in found.items()
        if not any(f"{key}.".startswith(f"{change}.") for change in sample.changes)
    }


# --- new files ----------------------------------------------------------------------------------------------

NEW = ("opencv", "ros", "kalibr", "euroc", "boofcv", "kitti-raw", "basalt", "depthai", "stereorecal")
_ENDINGS = {"basalt": ".json", "depthai": ".json", "stereorecal": ".json", "kitti-raw": ".txt"}

HOLDS = {
    "radtan": NEW,
    "equidistant": ("kalibr", "ros", "euroc", "basalt", "depthai", "opencv", "stereorecal"),
    "ds": ("kalibr", "basalt", "stereorecal"),
    "eucm": ("kalibr", "basalt", "stereorecal"),
    "omni": ("kalibr", "stereorecal"),
}
TERMS = {"radtan": samples.LENS, **WIDE_LENSES}
STANDS = {"right below": (1, 1), "right above": (3, 3), "right upside down": (0, 2), "left upside down": (2, 0)}

# Of more than this, the rectified cameras that ROS's files state may have no focal length that fits so small an image.
angles = st.tuples(*[st.floats(-0.3, 0.3)] * 3)
shifts = st.tuples(st.floats(-2.0, -0.02), st.floats(-0.015, 0.015), st.floats(-0.015, 0.015))


def of_model(model: str, extrinsics=(0.02, -0.03, 0.01, -0.12, 0.004, -0.003), scale: float = 1.0) -> StereoRig:
    lens, matrices = scale * np.array(TERMS[model]), (samples.RIG.left.matrix, samples.RIG.right.matrix)
    left, right = (Camera(samples.SIZE, matrix, lens, model=model) for matrix in matrices)
    return StereoRig(left, right, np.array(extrinsics, float))


def write_exchanged(rig: StereoRig, name: str, paths: list[Path]) -> None:
    """A new file whose right camera stands first."""
    format, turned = named(name), as_in_file(rig, exchanged=True)
    syntax = next(iter(format.syntax.values()))
    blank = tuple(document("new", text, syntax) for text in format.blank(turned, syntax))
    cameras = {0: turned.left, 1: turned.right}
    values = format.write(scaled(turned, 1.0 / METRES[format.unit or "m"]), blank, Hints(), cameras)
    for path, new, numbers in zip(paths, blank, values, strict=True):
        path.write_text(new.with_values(numbers))


def new_files(folder: Path, name: str) -> list[Path]:
    """Where a rig is written in a format."""
    return [folder / f"{index}{_ENDINGS.get(name, '.yaml')}" for index in range(2 if name in ("ros", "euroc") else 1)]


def unit_of(name: str) -> str | None:
    """The unit of new files, for formats that say none."""
    return "m" if name in ("opencv", "boofcv") else None


def beside(paths: list[Path], word: str = "new") -> list[Path]:
    return [path.with_name(f"{word}-{path.name}") for path in paths]


def contents(paths: list[Path]) -> list[bytes]:
    return [path.read_bytes() for path in paths]


def assert_same(one: StereoRig, other: StereoRig) -> None:
    np.testing.assert_allclose(one.extrinsics, other.extrinsics, rtol=0, atol=1e-12)
    for a, b in ((one.left, other.left), (one.right, other.right)):
        assert (a.size, a.model) == (b.size, b.model)
        np.testing.assert_allclose(a.matrix, b.matrix, rtol=1e-12)
        length = max(a.distortion.size, b.distortion.size)
        lenses = [np.pad(camera.distortion, (0, length - camera.distortion.size)) for camera in (a, b)]
        np.testing.assert_allclose(*lenses, rtol=0, atol=1e-12)
