"""The `CameraInfo` that calibration files of ROS hold."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import yaml

from stereorecal_ros._camera_info import CameraInfo


def infos_in(files: Sequence[str]) -> tuple[CameraInfo, CameraInfo] | None:
    """What the drivers of both cameras would publish that read two files, of the left and the right camera, which have
    been read as a calibration; None if they are of another format, which says no projection to ROS."""
    if len(files) != 2:
        return None
    try:
        left, right = (_info(yaml.safe_load(Path(name).read_text())) for name in files)
    except (yaml.YAMLError, LookupError, TypeError, ValueError):
        return None
    return left, right


def _info(content: Any) -> CameraInfo:
    names = ("distortion_coefficients", "camera_matrix", "rectification_matrix", "projection_matrix")
    arrays = (tuple(float(value) for value in content[name]["data"]) for name in names)
    model = str(content["distortion_model"] or "")
    return CameraInfo(int(content["image_width"]), int(content["image_height"]), model, *arrays)
