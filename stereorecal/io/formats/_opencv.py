"""The calibration of a rig as OpenCV's stereo_calib writes it."""

from pathlib import Path

from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._about import about
from stereorecal.io.formats._file_storage import read_file_storage
from stereorecal.io.formats._numbers import image_size, numbers


def load_opencv_stereo(path: Path, size: tuple[int, int]) -> StereoRig:
    """The rig that `M1 D1 M2 D2 R T` describe, T in millimetres.

    Args:
        size: of the images, in case the file has no `imageSize`, as OpenCV's own have none.

    Raises:
        InputError: naming the file, if it cannot be read or a value cannot be a calibration.
        UnsupportedModelError: if the number of distortion coefficients is none of OpenCV's.
    """
    content = read_file_storage(path)
    with about(path):
        size = image_size(content, "imageSize") if "imageSize" in content else size
        left, right = (
            Camera(size, numbers(content, f"M{side}", (3, 3)), numbers(content, f"D{side}", (-1,))) for side in (1, 2)
        )
        return StereoRig.from_rotation(left, right, numbers(content, "R", (3, 3)), numbers(content, "T", (3,)) / 1000.0)
