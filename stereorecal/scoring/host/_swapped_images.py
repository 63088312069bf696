"""Images that cannot be a left and right pair of the rig: swapped, mirrored, upside down, or of different scenes.

The check runs only where little matches. Sparse features, which do not depend on the rig's extrinsics, give
the rotation between the cameras, so the answer is the same for any drift. In doubt nothing is refused.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from jaxtyping import Bool, Float, Int

from stereorecal._arrays import eight_bit
from stereorecal._errors import InputError
from stereorecal.geometry import StereoRig, angle_between
from stereorecal.recordings import Pair
from stereorecal.scoring._image_quality import image_quality, select_frames
from stereorecal.scoring._prepare import Pyramid

_FRAMES = 2
_WIDTH = 640  # pixels, at which features are sought
_SMALLEST = 100  # pixels: the features of smaller images are those of their enlargement
_FEATURES = 1200  # in an image, at most
_GLARE = 250  # grey level
_AROUND = 8  # pixels around glare
_RATIO = 0.8  # of the distances to the best and to the second best match
_ENOUGH = 300  # features in each image: some of them must match if both show the same
_CHANCE = 14  # pairs that agree on some rigid motion by chance: it has five degrees of freedom
_ENOUGH_AGREE = 30  # pairs that agree
_MANY_TIMES = 3  # as many pairs agree once an image is flipped; of correct images a ninth
_AGREE = 1.5  # pixels from the epipolar line
_MOST = 0.8  # share of the pairs that agree, and of those that say the same
_BEHIND = -1.0  # of parallax, in units of _AGREE: what is farther behind both cameras is no noise
_AHEAD, _NOT_AHEAD = 0.9, 0.5  # share of the pairs that are ahead of both cameras; of right images 0.98 and more
_ALIGNED = 0.75  # of the pairs, by a rotation alone: of one moment; 0.8 and more do, of late images on the move 0.7
_TURNED = np.radians(6.0)  # more is another rig
_ASIDE = np.radians(30.0)  # from the baseline: of true pairs up to 10 degrees, of late ones on the move 65
_TURNED_LESS = np.radians(3.0)  # by exchanged images, which then explain the pairs better
_DISTINCT = 150.0  # between descriptors of 512: one thing seen twice is nearer, two different things are farther
_ROUNDS = 6  # of least squares, which converge in two or three
_TRANSPOSED = np.radians(5.0)  # the least rotation between cameras that cannot be a drift of its inverse
_NEAR = np.radians(15.0)  # from the given rotation, three times the drift that must never be called a mistake

_Rays = tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, "n 3"]]  # at depth 1, of the left and the right camera


class _Features(NamedTuple):
    """Where features are, in pixels of the image; their descriptors; and which are clear of glare."""

    pixels: Float[np.ndarray, "n 2"]
    descriptors: Float[np.ndarray, "n c"]
    clear: Bool[np.ndarray, "n"]


@dataclass(frozen=True)
class FeatureMotion:
    """What features say of the motion between two cameras, whatever the calibration."""

    turned: bool  # they fit the rig, but for a rotation
    aside: bool  # they fit the rig's rotation, but not the direction of its baseline, as if a camera had moved


def refuse_swapped_images(
    images: Pyramid, frames: Sequence[int] | None = None, *, largest_rotation: float = _TURNED
) -> FeatureMotion:
    """Refuse images that are certainly no left and right image of this rig; what features of the others say of the
    motion between the cameras.

    Args:
        frames: indices of the pairs to check, which differ from the others; default all.
        largest_rotation: radians, from the given one; more is another rig.

    Raises:
        InputError: one sentence that names what is wrong, and the frames, where some were given.
    """
    pairs = images.pairs if frames is None else [images.pairs[frame] for frame in frames]
    found = [_mistake_in(images.rig, pair, largest_rotation) for pair in select_frames(pairs, _FRAMES)]
    mistakes = {mistake for mistake, _ in found}
    if len(mistakes) == 1 and (sentence := mistakes.pop()) is not None:
        which = "" if frames is None else f"{', '.join(pair.name for pair in pairs)} (unlike the other pairs): "
        raise InputError(which + sentence)
    turned = any(motion.turned for _, motion in found)
    return FeatureMotion(turned, not turned and any(motion.aside for _, motion in found))


def _mistake_in(rig: StereoRig, pair: Pair, largest_rotation: float) -> tuple[str | None, FeatureMotion]:
    if not image_quality(pair).enough or pair.size[0] < _SMALLEST:
        return None, FeatureMotion(turned=False, aside=False)
    left, right = (_features(image) for image in (pair.left, pair.right))
    tolerance = _AGREE * max(1.0, pair.size[0] / _WIDTH) / float(rig.left.focal[0])  # at depth 1
    given = _cheirality(rig, left, right, tolerance)
    turned = given.share >= _AHEAD and given.aligned >= _ALIGNED and given.angle < largest_rotation
    motion = FeatureMotion(bool(turned), bool(given.agree >= _MOST and given.aside > _ASIDE))
    return _sentence(rig, pair, left, right, given, tolerance), motion


def _sentence(
    rig: StereoRig, pair: Pair, left: _Features, right: _Features, given: "_Cheirality", tolerance: float
) -> str | None:
    enough = _ENOUGH // (4 if pair.size[0] < _WIDTH // 2 else 1)
    if min(len(left.pixels), len(right.pixels)) < enough:
        return None
    flipped = _features(np.fliplr(pair.right))
    *_, mirrored = _rotation(_rays_of_matches(rig, left, flipped), tolerance)
    if mirrored.sum() >= max(_ENOUGH_AGREE, _MANY_TIMES * given.agreeing) and mirrored.mean() >= _MOST:
        return "one of the two images is mirrored; flip it from left to right."
    if given.agreeing <= _CHANCE:
        if not (_distinct(left.descriptors) and _distinct(right.descriptors)):
            return None  # a texture that repeats has no unambiguous matches in a correct pair either
        if min(left.clear.sum(), right.clear.sum()) < enough:
            return None  # the sun on waves is elsewhere in each image
        return "the left and right images show different things; give images that both cameras took at the same time."
    if given.agreeing < _ENOUGH_AGREE or given.agree < _MOST:
        return None
    calibrated = np.asarray(rig.rotation)
    if angle_between(given.rotation @ np.diag([-1.0, -1.0, 1.0]), calibrated) < _NEAR:
        return "one of the two images is upside down; turn it by 180 degrees."
    angle = angle_between(calibrated, np.eye(3))
    if angle > _TRANSPOSED and angle_between(given.rotation, calibrated.T) < 0.5 * angle:
        return (
            "the rotation between the cameras looks inverted (transposed): it must turn points of the left camera into "
            "the right one; transpose it."
        )
    exchanged = _cheirality(rig, right, left, tolerance)
    if (
        exchanged.share >= _AHEAD
        and exchanged.angle < _NEAR
        and (given.share < _NOT_AHEAD or given.angle > exchanged.angle + _TURNED_LESS)
    ):
        return (
            "near things lie on the wrong side: the left and right images look exchanged (--fix exchanged), or both "
            "are upside down (--fix turned) or mirrored, or R and T of the calibration are inverted; correct that."
        )
    return None


def _rays_of_matches(rig: StereoRig, left: _Features, right: _Features) -> _Rays:
    """Rays of the features of both images that are mutual nearest neighbours."""
    which = _mutual_matches(left.descriptors, right.descriptors)
    sides = zip((rig.left, rig.right), (left, right), which, strict=True)
    first, second = (np.asarray(camera.rays(found.pixels[index]), float) for camera, found, index in sides)
    return _at_depth_1(first), _at_depth_1(second)


@dataclass(frozen=True, eq=False)
class _Cheirality:
    """Cheirality, once rows are aligned across the given baseline."""

    rotation: Float[np.ndarray, "3 3"]  # of the motion on which most pairs agree, left to right
    agreeing: int  # how many do
    share: float = 0.0  # of the pairs that agree on a motion, that are not behind both cameras
    agree: float = 0.0  # share of all pairs that agree on the motion
    aligned: float = 0.0  # share of all pairs that this rotation aligns
    angle: float = np.pi  # rad, from the given rotation to that one
    aside: float = 0.0  # rad, from the given baseline to the direction of the motion, or its opposite


def _cheirality(rig: StereoRig, left: _Features, right: _Features, tolerance: float) -> _Cheirality:
    """If the first images are the left camera's. The sign of parallax tells, since the direction of the baseline is
    known better than any essential matrix has it."""
    rays = _rays_of_matches(rig, left, right)
    rotation, along, agree = _rotation(rays, tolerance)
    agreeing = int(agree.sum())
    if agreeing <= _CHANCE:
        return _Cheirality(rotation, agreeing)
    calibrated = np.asarray(rig.rotation)
    towards = np.asarray(rig.translation, float) / float(rig.baseline)
    start = rotation if angle_between(rotation, calibrated) < _NEAR else calibrated
    first, second = (found[agree] for found in rays)
    turned = _aligned(first, second, start, towards, tolerance)
    across = np.einsum("ni,ni->n", second, np.cross(towards, first @ turned.T))
    parallax = (second - _at_depth_1(first @ turned.T)) @ towards / tolerance
    aligned = float(np.sum(np.abs(across) < tolerance)) / len(agree)
    aside = float(np.arccos(np.clip(abs(along @ towards), 0.0, 1.0)))
    share, angle = float(np.mean(parallax > _BEHIND)), float(angle_between(turned, calibrated))
    return _Cheirality(rotation, agreeing, share, float(agree.mean()), aligned, angle, aside)


def _features(image: np.ndarray) -> _Features:
    scale = _WIDTH / image.shape[1]
    how = cv2.INTER_AREA if scale < 1.0 else cv2.INTER_CUBIC
    grey = eight_bit(cv2.resize(image, None, fx=scale, fy=scale, interpolation=how))
    points, descriptors = cv2.SIFT.create(_FEATURES).detectAndCompute(grey, None)
    if descriptors is None:
        return _Features(np.zeros((0, 2)), np.zeros((0, 128), np.float32), np.zeros(0, bool))
    where = np.array([point.pt for point in points])
    glare = cv2.dilate((grey >= _GLARE).astype(np.uint8), np.ones((2 * _AROUND + 1,) * 2, np.uint8))
    column, row = np.clip(np.round(where), 0, np.array(grey.shape)[::-1] - 1).astype(int).T
    return _Features((where + 0.5) / scale - 0.5, descriptors, glare[row, column] == 0)


def _mutual_matches(
    first: Float[np.ndarray, "n c"], second: Float[np.ndarray, "m c"]
) -> tuple[Int[np.ndarray, "p"], Int[np.ndarray, "p"]]:
    """Indices of mutual nearest neighbours that pass the ratio test."""
    distances = _squared_distances(first, second)
    of_first, of_second = distances.argmin(axis=1), distances.argmin(axis=0)
    indices = np.arange(len(first))
    best = distances[indices, of_first]
    clear = best < _RATIO**2 * np.minimum(_second_best(distances, 1)[indices], _second_best(distances, 0)[of_first])
    chosen = indices[clear & (of_second[of_first] == indices)]
    return chosen, of_first[chosen]


def _distinct(descriptors: Float[np.ndarray, "n c"]) -> bool:
    """Whether most features of an image differ from all others of it."""
    return float(np.median(_second_best(_squared_distances(descriptors, descriptors), 1))) > _DISTINCT**2


def _squared_distances(first: Float[np.ndarray, "n c"], second: Float[np.ndarray, "m c"]) -> Float[np.ndarray, "n m"]:
    return (first**2).sum(1)[:, None] + (second**2).sum(1) - 2.0 * first @ second.T


def _second_best(distances: Float[np.ndarray, "n m"], axis: int) -> Float[np.ndarray, "k"]:
    return np.partition(distances, 1, axis=axis).take(1, axis=axis)


def _rotation(
    rays: _Rays, tolerance: float
) -> tuple[Float[np.ndarray, "3 3"], Float[np.ndarray, "3"], Bool[np.ndarray, "n"]]:
    """Rotation, left to right, and direction of the motion on which most pairs agree, and which do."""
    none = np.eye(3), np.zeros(3), np.zeros(len(rays[0]), bool)
    if len(rays[0]) < _CHANCE:
        return none
    left, right = (np.ascontiguousarray(of_side[:, :2]) for of_side in rays)
    essential, agree = cv2.findEssentialMat(left, right, np.eye(3), cv2.RANSAC, 0.999, tolerance)
    if essential is None or essential.shape != (3, 3):
        return none
    _, turned, along, _ = cv2.recoverPose(essential, left, right, np.eye(3), mask=agree.copy())
    return turned, along.reshape(3), agree.reshape(-1) > 0


def _aligned(
    left: Float[np.ndarray, "n 3"],
    right: Float[np.ndarray, "n 3"],
    turned: Float[np.ndarray, "3 3"],
    towards: Float[np.ndarray, "3"],
    tolerance: float,
) -> Float[np.ndarray, "3 3"]:
    """The rotation near `turned` that aligns the rows across a baseline, whichever way along it the right camera is."""
    for _ in range(_ROUNDS):
        ray = left @ turned.T
        across = np.einsum("ni,ni->n", right, np.cross(towards, ray))
        slopes = np.cross(ray, np.cross(right, towards))
        vote = 1.0 / (1.0 + (across / tolerance) ** 2)
        step = -np.linalg.lstsq(slopes * np.sqrt(vote)[:, None], across * np.sqrt(vote), rcond=1e-6)[0]
        turned = cv2.Rodrigues(step)[0] @ turned
    return turned


def _at_depth_1(rays: np.ndarray) -> Float[np.ndarray, "n 3"]:
    return rays / rays[:, 2:]
