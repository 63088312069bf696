"""How OpenCV makes a pose of matches."""

import cv2
import numpy as np
from jaxtyping import Float

from stereorecal.geometry import Camera, euler_from_rotation
from stereorecal.objectives import StereoImages
from stereorecal.recordings import Pair
from stereorecal.strategies import Objective, Outcome, Status
from stereorecal_features._essential import Essential
from stereorecal_features._matches import Pixels


def search(how: Essential, objective: Objective, start: Float[np.ndarray, "n"]) -> Outcome:
    """The matches of all frames, and OpenCV's pose; see `Essential`."""
    images: StereoImages = objective.images  # there, since the core checks `needs`
    rig, chart = images.rig, images.chart
    if any(camera.model != "radtan" for camera in (rig.left, rig.right)):
        return Outcome(start, Status.STALLED, "cv2.recoverPose has no model for these lenses")
    pixels = []
    for pair in images.pairs:
        if objective.remaining <= 0:
            return Outcome(start, Status.BUDGET)
        pixels.append(_matched(pair, how.ratio))
    left, right = (np.concatenate(side) for side in zip(*pixels, strict=True))
    if len(left) < how.min_matches:
        return Outcome(start, Status.STALLED, f"only {len(left)} matches; {how.min_matches} are needed")
    (matrix, lens), (other_matrix, other_lens) = (_for_opencv(camera) for camera in (rig.left, rig.right))
    try:
        agree, essential, rotation, direction, *_ = cv2.recoverPose(
            left, right, matrix, lens, other_matrix, other_lens, prob=how.probability, threshold=how.threshold
        )
    except cv2.error:  # of matches that have no essential matrix
        return Outcome(start, Status.STALLED, f"{len(left)} matches, and no essential matrix")
    shift = np.asarray(direction).ravel()
    if essential is None or agree < how.min_matches or abs(shift[0]) < 1e-6:
        return Outcome(start, Status.STALLED, f"{agree} of {len(left)} matches agree on a pose")
    translation = shift * (float(rig.translation[0]) / shift[0])  # the scale is free, and x is known
    found = chart.coordinates(np.concatenate([euler_from_rotation(np.asarray(rotation)), translation]))
    message = f"{agree} of {len(left)} matches agree{'' if np.abs(found).max() <= 1.0 else ', outside the reach'}"
    return Outcome(np.clip(found, -1.0, 1.0), Status.CONVERGED, message)


def _matched(pair: Pair, ratio: float) -> tuple[Pixels, Pixels]:
    """SIFT with its defaults, matched as in OpenCV's tutorials: the nearest word, by the ratio test."""
    sift = cv2.SIFT.create()
    grey = (np.clip(np.rint(image), 0, 255).astype(np.uint8) for image in (pair.left, pair.right))
    (left, words), (right, others) = (sift.detectAndCompute(image, None) for image in grey)
    if min(len(left), len(right)) < 2:  # there is no second nearest
        return np.zeros((0, 2)), np.zeros((0, 2))
    nearest = cv2.BFMatcher(cv2.NORM_L2).knnMatch(words, others, k=2)
    good = [first for first, second in nearest if first.distance < ratio * second.distance]
    ends = [left[one.queryIdx].pt for one in good], [right[one.trainIdx].pt for one in good]
    return np.array(ends[0], float).reshape(-1, 2), np.array(ends[1], float).reshape(-1, 2)


def _for_opencv(camera: Camera) -> tuple[np.ndarray, np.ndarray]:
    """Matrix and coefficients."""
    lens = np.asarray(camera.distortion, float)
    return np.asarray(camera.matrix, float), lens if lens.size else np.zeros(4)
