"""Rigid motions, and how the cameras of a file stand: each on a body, or on another camera that has a place itself."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import Mat3, Vec3
from stereorecal._errors import InputError
from stereorecal.geometry import AS_IN_FILE, Camera, StereoRig, extrinsics_of
from stereorecal.io.formats._numbers import key_name, numbers
from stereorecal.io.formats.text._nodes import Keys

Motion = Float[np.ndarray, "4 4"]
_ROUNDING = 1e-3  # of the last row of a pose


def pose(rotation: Mat3, translation: Vec3) -> Motion:
    """The rigid motion x -> R x + T as a matrix (4, 4)."""
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = rotation, translation
    return made


def stated_pose(content: Mapping[str, Any], key: str | Keys) -> Motion:
    """The rigid motion under a key, stated as four rows or as sixteen numbers."""
    motion, name = numbers(content, key, (4, 4)), key_name(key)
    if not np.allclose(motion[3], [0.0, 0.0, 0.0, 1.0], rtol=0.0, atol=_ROUNDING):
        raise InputError(f"the last row of {name} is not 0 0 0 1; correct it, or copy the file again.")
    try:
        extrinsics_of(motion[:3, :3], motion[:3, 3])
    except InputError:
        raise InputError(
            f"{name} is not a rotation (orthonormal, determinant +1) beside a translation; correct it."
        ) from None
    return motion


def inverse(motion: Motion) -> Motion:
    """The inverse of a rigid motion (4, 4)."""
    try:
        return np.linalg.inv(motion)
    except np.linalg.LinAlgError:
        raise InputError("R is not a rotation (orthonormal, determinant +1); correct the calibration.") from None


def pose_of_rectified(left: tuple[Mat3, Vec3], right: tuple[Mat3, Vec3]) -> Motion:
    """The motion from a left camera to a right one, of which each is known by the rotation that rectifies it and t of
    its projection matrix K [I | t]; t has x, of cameras one above the other y, of KITTI's all three."""
    (to_left, left_place), (to_right, place) = left, right
    return pose(to_right.T @ to_left, to_right.T @ (place - left_place))


def left_to_right(rig: StereoRig) -> Motion:
    """The pose that takes points of the left camera's frame to the right one's."""
    return pose(np.asarray(rig.rotation), np.asarray(rig.translation))


def rig_of(left: Camera, right: Camera, motion: Motion) -> StereoRig:
    """The rig of the first and the second camera of a file, and the motion from the first frame to the second one:
    `_read_rig.py` says which is the left one."""
    return StereoRig(left, right, extrinsics_of(motion[:3, :3], motion[:3, 3]), source=AS_IN_FILE)


@dataclass(frozen=True)
class Link:
    """How a camera stands on a frame, as a file states it."""

    camera: str
    frame: str  # a body, or another camera
    motion: Motion  # from the frame to the camera
    inverted: bool = False  # from the camera to the frame
    key: str = ""  # where it is stated, if a camera has several

    @property
    def ends(self) -> tuple[str, str]:
        """The frames from which and to which the motion leads."""
        return (self.camera, self.frame) if self.inverted else (self.frame, self.camera)


def motions_from(first: str, links: Sequence[Link]) -> dict[str, Motion]:
    """The motions from a frame to all that links lead to; of two ways, by the links that come first."""
    found, known = {first: np.eye(4)}, 0
    while len(found) > known:
        known = len(found)
        for link in links:
            one, other = link.ends
            if one in found and other not in found:
                found[other] = link.motion @ found[one]
            elif other in found and one not in found:
                found[one] = inverse(link.motion) @ found[other]
    return found


def moved(links: Sequence[Link], left: str, right: str, motion: Motion) -> Iterator[tuple[Link, Motion]]:
    """The links that state another motion once that from left to right is this one: those between the right camera,
    with all that stand on it, and what stays; where the left one stands on the right one, it moves in its place."""
    now = motions_from(left, links)
    stays = _upon(left, links, right) if left in _upon(right, links) else now.keys() - _upon(right, links)
    way = inverse(now[right]) @ motion
    now |= {frame: motion if frame == right else place @ way for frame, place in now.items() if frame not in stays}
    for link in links:
        one, other = link.ends
        if (one in stays) != (other in stays):
            yield link, now[other] @ inverse(now[one])


def _upon(frame: str, links: Sequence[Link], without: str = "") -> set[str]:
    """A frame, and all cameras that stand on it, or on one that does."""
    found = {frame}
    while more := {link.camera for link in links if link.frame in found} - found - {without}:
        found |= more
    return found
