"""Whether something is a rig, and how it stands."""

from typing import Any

from stereorecal._errors import InputError
from stereorecal.geometry._rig import StereoRig


def checked_rig(given: Any, name: str = "the rig") -> StereoRig:
    """The rig that is given, side by side.

    Raises:
        InputError: if it is none; of a result that has one, it says how to get it.
    """
    if isinstance(given, StereoRig):
        return given.side_by_side()
    own = "its .rig, or " if hasattr(type(given), "rig") or "rig" in getattr(given, "__dict__", ()) else ""
    raise InputError(
        f"{name} is a {type(given).__name__}; give {own}an sr.StereoRig, such as scene.rig, sr.io.load_rig(path) or "
        "sr.StereoRig.from_rotation(left, right, R, T)."
    )
