"""OpenCV's stereo calibration: the YAML or XML file of the stereo_calib sample."""

from pathlib import Path

from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._about import about
from stereorecal.io.formats._file_storage import read_file_storage
from stereorecal.io.formats._numbers import image_size, numbers


def load_opencv_stereo(path: Path, size: tuple[int, int]) -> StereoRig:
    """The rig that `M1 D1 M2 D2 R T` describe, with T in millimetres.

    Args:
        size: (width, height) of the images, used if the file has no `imageSize`; OpenCV's own files have none.

    Raises:
        InputError: naming the file, if it cannot be read or does not hold a valid calibration.
        UnsupportedModelError: if the number of distortion coefficients is not one of OpenCV's pinhole model.
    """
    content = read_file_storage(path)
    with about(path):
        size = image_size(content, "imageSize") if "imageSize" in content else size
        left, right = (
            Camera(size, numbers(content, f"M{side}", (3, 3)), numbers(content, f"D{side}", (-1,))) for side in (1, 2)
        )
        return StereoRig.from_rotation(left, right, numbers(content, "R", (3, 3)), numbers(content, "T", (3,)) / 1000.0)
