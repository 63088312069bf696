"""How far one rig is from another, axis by axis (the one definition that tables and JSON files use), and whether they
are the same but for what writing and reading them rounds."""

import numpy as np
from jaxtyping import Float

from stereorecal.geometry._camera import same_camera
from stereorecal.geometry._rig import AXES, StereoRig, with_unit_baseline

_SAME = 1e-9


def axis_errors(rig: StereoRig, reference: StereoRig) -> dict[str, float]:
    """Absolute errors of `rig` by name, as `axis_changes` has them, when `reference` is right."""
    return dict(zip(AXES, np.abs(axis_changes(reference, rig)).tolist(), strict=True))


def axis_changes(before: StereoRig, after: StereoRig) -> Float[np.ndarray, "6"]:
    """What `after` changes against `before`, with its sign: pitch, yaw, roll [degrees], x, y, z of the direction of the
    baseline [percent]: images do not show its length. The definition that `axis_errors` rests on."""
    change = with_unit_baseline(after.extrinsics) - with_unit_baseline(before.extrinsics)
    return np.concatenate([np.degrees(change[:3]), 100.0 * change[3:]])


def same_rig(one: StereoRig, other: StereoRig, rounding: float = _SAME) -> bool:
    """Whether all numbers, of images as they were taken, are equal but for rounding, radians, metres, and parts of
    intrinsics; coefficients that a lens model lacks are 0."""
    one, other = one.as_taken(), other.as_taken()
    poses = ((one.rotation, other.rotation), (one.translation, other.translation))
    sides = ((one.left, other.left), (one.right, other.right))
    same_pose = all(np.allclose(a, b, rtol=rounding, atol=rounding) for a, b in poses)
    return same_pose and all(a.size == b.size and same_camera(a, b, rounding) for a, b in sides)


def same_cameras(one: StereoRig, other: StereoRig) -> bool:
    """Whether both have the same cameras, to the last digit."""
    return same_camera(one.left, other.left) and same_camera(one.right, other.right)
