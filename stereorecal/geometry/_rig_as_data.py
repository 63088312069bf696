"""A rig as plain data and back, without any rounding."""

from typing import Any

import numpy as np

from stereorecal._errors import InputError
from stereorecal.geometry._camera import Camera
from stereorecal.geometry._quarter_turns import UPRIGHT
from stereorecal.geometry._rig import StereoRig


def rig_as_data(rig: StereoRig) -> dict[str, Any]:
    """Lists and numbers: of each camera size, matrix, distortion and model (left out if radtan), the extrinsics in
    rad and metres, and by how much images are turned, unless they are not."""
    sides = {"left": rig.left, "right": rig.right}
    cameras = {
        side: {
            "size": list(camera.size),
            "matrix": np.asarray(camera.matrix, float).tolist(),
            "distortion": np.asarray(camera.distortion, float).tolist(),
            **({} if camera.model == Camera.model else {"model": camera.model}),
        }
        for side, camera in sides.items()
    }
    turns = {} if rig.turns == UPRIGHT else {"turns": list(rig.turns)}
    return {**cameras, "extrinsics": np.asarray(rig.extrinsics, float).tolist(), **turns}


def rig_from_data(data: Any) -> StereoRig:
    """The inverse.

    Raises:
        InputError: if these are no such data.
    """
    try:
        left, right = (_camera(data[side]) for side in ("left", "right"))
        first, second = (int(turn) % 4 for turn in data.get("turns", UPRIGHT))
        return StereoRig(left, right, np.array(data["extrinsics"], float), turns=(first, second))
    except InputError:
        raise
    except (AttributeError, KeyError, TypeError, ValueError):
        raise InputError("there is no rig in it; copy it again, or delete it.") from None


def _camera(data: Any) -> Camera:
    width, height = data["size"]
    matrix, distortion = (np.array(data[name], float) for name in ("matrix", "distortion"))
    return Camera((int(width), int(height)), matrix, distortion, model=data.get("model", Camera.model))
