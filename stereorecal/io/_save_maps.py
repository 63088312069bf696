"""Rectifying maps in a file."""

import io
from typing import Any

import numpy as np

from stereorecal.geometry import PINHOLE, AnyView, StereoRig, rectification
from stereorecal.io._atomic import write_bytes
from stereorecal.io._read_files import AnyPath


def save_maps(rig: StereoRig, path: AnyPath, overwrite: bool = False, view: AnyView = None) -> None:
    """Write what `sr.rectification(rig, view)` holds as an .npz, whole or not at all: `left_x`, `left_y`, `right_x`,
    `right_y` (h, w) float32, as `cv2.remap` takes them, `R1`, `R2`, `size` (width, height), `projection` by name,
    `focal`, and `centre_left`, `centre_right`, `centre_row` of the rectified images, pixels; of a pinhole also `P1`,
    `P2` and `Q`.

    Raises:
        InputError: if the file exists already, the place cannot be written to, or the view makes no sense.
    """
    made = rectification(rig, view)
    (left_x, left_y), (right_x, right_y) = made.maps
    used_view = made.view
    arrays: dict[str, Any] = {"P1": made.P1, "P2": made.P2, "Q": made.Q} if used_view.projection == PINHOLE else {}
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
        projection=np.array(used_view.projection),
        focal=np.array(float(used_view.focal)),
        centre_left=np.array(float(used_view.centre_left)),
        centre_right=np.array(float(used_view.centre_right)),
        centre_row=np.array(float(used_view.centre_row)),
        **arrays,
    )
    write_bytes(path, file.getvalue(), replace=overwrite)
