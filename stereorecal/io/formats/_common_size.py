"""Rigs whose cameras have images of two sizes: they are used at the smaller one, and written at their own."""

from dataclasses import replace

from stereorecal.geometry import Camera, StereoRig, same_camera


def at_common_size(rig: StereoRig) -> StereoRig:
    """The rig whose larger images are resampled to the size of the smaller ones."""
    if rig.left.size == rig.right.size:
        return rig
    return rig.resized(min(rig.left.size, rig.right.size, key=lambda size: size[0] * size[1]))


def at_own_sizes(rig: StereoRig, own: StereoRig) -> StereoRig:
    """A rig at its common size, with the sizes of `own`, which it was; a camera that has not changed is the same."""
    if rig.left.size != rig.right.size:
        return rig
    left, right = (
        before if same_camera(seen, now) else now.resized(before.size)
        for before, seen, now in zip(_cameras(own), _cameras(at_common_size(own)), _cameras(rig), strict=True)
    )
    return replace(rig, left=left, right=right)


def _cameras(rig: StereoRig) -> tuple[Camera, Camera]:
    return rig.left, rig.right
