"""Rectifying maps in a file."""

import io

import numpy as np

from stereorecal.geometry import StereoRig, rectification
from stereorecal.io._atomic import write_bytes
from stereorecal.io._read_files import AnyPath


def save_maps(rig: StereoRig, path: AnyPath, overwrite: bool = False) -> None:
    """Write what `sr.rectification(rig)` holds as an .npz, whole or not at all: `left_x`, `left_y`, `right_x`,
    `right_y` (h, w) float32, as `cv2.remap` takes them, `R1`, `R2`, `P1`, `P2`, `Q`, and `size` (width, height).

    Raises:
        InputError: if the file exists already, or the place cannot be written to.
    """
    made = rectification(rig)
    (left_x, left_y), (right_x, right_y) = made.maps
    file = io.BytesIO()
    np.savez_compressed(
        file,
        left_x=left_x,
        left_y=left_y,
        right_x=right_x,
        right_y=right_y,
        size=np.array(made.size),
        R1=made.R1,
        R2=made.R2,
        P1=made.P1,
        P2=made.P2,
        Q=made.Q,
    )
    write_bytes(path, file.getvalue(), replace=overwrite)
