"""Why images hardly match: mistakes that are made with images and calibrations, each tried, and what matches then."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stereorecal._errors import InputError
from stereorecal.decision import ENOUGH, Reason
from stereorecal.geometry import Camera, StereoRig, with_unit_baseline
from stereorecal.matching import AbstractMatcher
from stereorecal.recordings import Pair
from stereorecal.scoring import Pyramid, host, pyramid

MATCHED = 0.5  # of what has texture: aligned rigs match more
CAUSES = ("exchanged", "scaled", "late", "early")
_SCALE, _FRAMES = 1.0, 2  # at which it is tried
_YAW = np.radians(1.0)  # that may be missing
_BETTER = 1.5  # times as much matches
_RATIOS = (1 / 4, 1 / 3, 3 / 8, 1 / 2, 2 / 3, 3 / 4, 4 / 3, 3 / 2, 2.0, 8 / 3, 3.0, 4.0)  # of sizes of images
_NEAR_RATIO = 0.1  # principal points lie in the middle to a tenth
_TWO_MOMENTS = "Give images of one moment: a frame is missing in one folder, or a camera is late."


@dataclass(frozen=True, eq=False)
class Cause:
    """A mistake without which more matches.

    Attributes:
        name: as `fixed` and `--fix` take it.
        about: what is wrong, to follow "with".
        advice: what to do.
        rig, pairs: without it.
    """

    name: str
    about: str
    advice: str
    rig: StereoRig
    pairs: tuple[Pair, ...]


@dataclass(frozen=True, eq=False)
class Mismatch:
    """What is known of images of which so little matches that they cannot be of this rig.

    Attributes:
        covered: share of the image that matches, once pitch and roll are found.
        cause: a mistake without which `covered_without` of it match; None: none that was tried.
        two_moments: features lie as if one camera had moved between the exposures.
    """

    covered: float
    cause: Cause | None = None
    covered_without: float = 0.0
    two_moments: bool = False

    @property
    def verdict(self) -> str:
        """In one short sentence."""
        share = f"{100 * self.covered:.0f} %"
        if self.cause is not None:
            return f"Wrong input: {share} match; with {self.cause.about} {100 * self.covered_without:.0f} %."
        if self.two_moments:
            return f"Wrong input: {share} match; the images look like two moments."
        return f"Wrong input: {share} match; not this rig, or not these images."

    @property
    def advice(self) -> str:
        """What to do."""
        if self.cause is not None:
            return f"{self.cause.advice} With --fix {self.cause.name} that is done here."
        if self.two_moments:
            return _TWO_MOMENTS
        return "Check that both images are of this rig, of one moment, and as large and upright as in its calibration."

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "covered": self.covered,
            "cause": self.cause and self.cause.name,
            "covered_without": self.cause and self.covered_without,
            "two_moments": self.two_moments,
        }


def may_be_wrong_input(reason: Reason) -> bool:
    """Whether a verdict is none on images that show enough."""
    return not reason.healthy and reason not in (Reason.OUT_OF_BUDGET, Reason.TOO_LITTLE_TEXTURE, Reason.NOT_IMPROVED)


def mismatch_of(images: Pyramid, matcher: AbstractMatcher) -> Mismatch | None:
    """Why images match too little; None if enough of them does once pitch and roll are found, or if their features fit
    the rig but for a rotation: then it is out of calibration.

    Args:
        matcher: its disparity range is measured anew for each mistake.

    Raises:
        InputError: if the images are certainly no left and right image of this rig.
    """
    host.refuse_swapped_images(images)
    texture, found = max(one.texture for one in images.quality), Mismatch(_covered(images, matcher))
    least = ENOUGH.of_texture * texture
    for cause in _causes(images.rig, images.pairs) if found.covered < MATCHED * texture else ():
        try:
            without = _covered(pyramid(cause.rig, cause.pairs), matcher)
        except InputError:
            continue
        if without > max(_BETTER * found.covered, found.covered_without, least):
            found = replace(found, cause=cause, covered_without=without)
    if found.cause is not None:
        return found
    if found.covered >= least:
        return None
    motion = host.motion_by_features(images)
    return None if motion.turned else replace(found, two_moments=motion.aside)


def fixed(rig: StereoRig, pairs: tuple[Pair, ...], name: str) -> tuple[StereoRig, tuple[Pair, ...]]:
    """Rig and pairs without a mistake.

    Args:
        name: of its cause: one of CAUSES.

    Raises:
        InputError: if calibration and images do not say how.
    """
    for cause in _causes(rig, pairs):
        if cause.name == name:
            return cause.rig, cause.pairs
    raise InputError(f"nothing in calibration and images says how to mend {name!r}; leave --fix out.")


def _covered(images: Pyramid, matcher: AbstractMatcher) -> float:
    """Share of the image that matches once pitch and roll are found, coarsely: a rig may have turned besides."""
    extrinsics = np.asarray(images.rig.extrinsics, float)
    found = host.survey(images, extrinsics)
    turned = with_unit_baseline(extrinsics) + found.offset
    ranged = found.with_range(replace(matcher, num_disparities=None), _YAW)
    return host.correspondences(images.at(_SCALE, _FRAMES), turned, ranged).covered


def _causes(rig: StereoRig, pairs: tuple[Pair, ...]) -> Iterator[Cause]:
    """Mistakes that may have been made with these."""
    exchanged = tuple(replace(pair, left=pair.right, right=pair.left, origin=None) for pair in pairs)
    yield Cause(
        "exchanged",
        "left and right exchanged",
        "Exchange the left and right images; if both are upside down, turn them by 180 degrees instead.",
        rig,
        exchanged,
    )
    yield from _other_intrinsics(rig, pairs)
    for name, when, left, right in (("early", "later", pairs[:-1], pairs[1:]), ("late", "earlier", pairs[1:], pairs)):
        if len(pairs) > 1:
            each = zip(left, right, strict=False)
            moved = tuple(replace(one, right=other.right, origin=None) for one, other in each)
            yield Cause(name, f"{when} right images", _TWO_MOMENTS, rig, moved)


def _other_intrinsics(rig: StereoRig, pairs: tuple[Pair, ...]) -> Iterator[Cause]:
    """Camera matrices that belong to images of another size: principal points far from the middle say so, and by how
    much. Images that were cut out of larger ones match all the same."""
    size = np.array(rig.left.size)
    points = np.mean([camera.matrix[:2, 2] for camera in (rig.left, rig.right)], axis=0) + 0.5
    for wanted in 0.5 * size / points:
        ratio = min(_RATIOS, key=lambda one: abs(np.log(one / wanted)))
        made = tuple(np.round(size / ratio).astype(int).tolist())
        if abs(np.log(ratio / wanted)) < _NEAR_RATIO:
            scaled = replace(rig, left=_scaled(rig.left, ratio), right=_scaled(rig.right, ratio))
            yield Cause(
                "scaled",
                f"K scaled by {ratio:.3g}",
                f"K belongs to images of about {made[0]}x{made[1]}; scale it to {size[0]}x{size[1]}.",
                scaled,
                pairs,
            )


def _scaled(camera: Camera, ratio: float) -> Camera:
    matrix = np.asarray(camera.matrix, float) * np.array([ratio, ratio, 1.0])[:, None]
    matrix[:2, 2] += 0.5 * (ratio - 1.0)  # pixel corners stay corners
    return replace(camera, matrix=matrix)
