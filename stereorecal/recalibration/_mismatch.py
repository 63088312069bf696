"""Why images match too little: mistakes that are made with them, each tried, and what matches without it; and values of
a calibration that hardly any rig has."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stereorecal._errors import InputError
from stereorecal.decision import ENOUGH
from stereorecal.geometry import Camera, StereoRig
from stereorecal.matching import AbstractMatcher, as_matcher
from stereorecal.objectives import Parameters
from stereorecal.recalibration._case import Case
from stereorecal.recalibration._schedule import HALF, Schedule
from stereorecal.recalibration._settings import as_settings
from stereorecal.recalibration._stages import run_look, started
from stereorecal.recordings import Pair
from stereorecal.scoring import Correspondences, Pyramid, host, pyramid, select_frames

_BETTER = 1.5  # times as much matches
_ALSO_BETTER = 1.05  # the same, of what principal points or rows speak for, too
_SAME_ROW = 1 / 1000  # of the width: where half of the matches lie as of rectified images; of raw ones, five times that
_RATIOS = (1 / 4, 1 / 3, 3 / 8, 1 / 2, 2 / 3, 3 / 4, 4 / 3, 3 / 2, 2.0, 8 / 3, 3.0, 4.0)  # of sizes of images
_NEAR_RATIO = 0.1  # principal points lie in the middle to a tenth
_SOME = 8  # pairs of which the one with most texture is tried
_EVEN = 1.5  # times the median time between pairs: more, and one is missing
_TWO_MOMENTS = "Give synchronised images: a frame is missing in one folder, or a camera is late."
_LOOK = Schedule("look", (HALF,), survey=True)
_FIELD = (10.0, 140.0)  # degrees that a lens without fisheye model sees from left to right
_BASELINE = (0.002, 5.0)  # metres


@dataclass(frozen=True)
class Cause:
    """A mistake without which more matches.

    Attributes:
        name: as `fixed` and `--fix` take it.
        without: what would be right.
        advice: what to do.
        corrected: whether `fixed` can: nobody knows the camera matrices of images that were rectified elsewhere.
    """

    name: str
    without: str
    advice: str
    corrected: bool = True


@dataclass(frozen=True)
class Mismatch:
    """What is known of images that cannot be of this rig.

    Attributes:
        covered: share of the image that matches.
        cause: a mistake without which `covered_without` of it match; None: none that was tried.
        two_moments: features lie as if one camera had moved between the exposures.
    """

    covered: float
    cause: Cause | None = None
    covered_without: float = 0.0
    two_moments: bool = False

    @property
    def verdict(self) -> str:
        """The verdict, in one short sentence."""
        share = f"Wrong input: {100 * self.covered:.0f} % fit"
        if self.cause is not None:
            return f"{share}; {self.cause.without} {100 * self.covered_without:.0f} %."
        like = "the images look like two moments" if self.two_moments else "not this rig, or not these images"
        return f"{share}; {like}."

    @property
    def advice(self) -> str:
        """What to do."""
        if self.cause is not None:
            here = f" With --fix {self.cause.name} that is done here." if self.cause.corrected else ""
            return f"{self.cause.advice}{here}"
        if self.two_moments:
            return _TWO_MOMENTS
        return "Check that both images are of this rig, synchronised, and sized and oriented as its calibration."

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "covered": self.covered,
            "cause": self.cause and self.cause.name,
            "covered_without": self.cause and self.covered_without,
            "two_moments": self.two_moments,
        }


def mismatch_of(
    images: Pyramid, matcher: AbstractMatcher, covered: float, *, by_chance: bool = True, aligned: bool | None = None
) -> Mismatch | None:
    """Why images match too little; None if they match enough, or if their features fit the rig but for a rotation: then
    it is out of calibration. Where principal points lie as in images of another size, or the images are aligned as they
    are, that is tried even if enough matches: a candidate may match by lenses that it should not have.

    Args:
        matcher: its disparity range is measured anew for each mistake.
        covered: share of the image that matches in the end.
        aligned: whether what matches lies in the same row of both images, as if they were rectified; None: not known.
        by_chance: whether that may be chance.

    Raises:
        InputError: if the images are certainly no left and right image of this rig.
    """
    sparse = ENOUGH.of_texture * images.best_quality.texture
    ample = 2.0 * sparse
    spoken_for = {name for name, speaks in (("scaled", ratios_of_sizes(images.rig)), ("rectified", aligned)) if speaks}
    if not images.enough or (covered >= ample and not spoken_for):
        return None
    motion, found = None if covered >= ample else host.refuse_swapped_images(images), Mismatch(covered)
    turned = motion is None or motion.turned
    asked = [one for one in _causes(images.rig, images.pairs) if one[0].name in spoken_for or not turned]
    causes = [one for one in asked if one[0].name != "rectified" or aligned is not False]
    own = _covered(images.rig, images.pairs, images, matcher) if causes else 0.0
    for cause, rig, pairs in causes:
        if found.cause is not None and found.covered_without >= ample and cause.name != found.cause.name:
            break  # the likelier mistakes are asked first; one that explains little is asked against the others
        share = _covered(rig, pairs, images, matcher)
        if share > max((_ALSO_BETTER if cause.name in spoken_for else _BETTER) * own, found.covered_without, sparse):
            found = Mismatch(own, cause, share)
    if found.cause is not None:
        return found
    if motion is None or motion.turned or not (motion.aside or (by_chance and covered < sparse)):
        return None
    return Mismatch(covered, two_moments=motion.aside)


def are_aligned(rig: StereoRig, found: Correspondences) -> bool:
    """Whether what matches lies in the same row of both images, as they were given."""
    some = np.asarray(found.weight) > 0
    left, right = (
        getattr(rig, side).project(np.asarray(getattr(found, side))[some])[:, 1] for side in ("left", "right")
    )
    return bool(np.median(np.abs(left - right)) < _SAME_ROW * rig.left.size[0])


def fixed(rig: StereoRig, pairs: tuple[Pair, ...], name: str) -> tuple[StereoRig, tuple[Pair, ...]]:
    """Rig and pairs without a mistake.

    Args:
        pairs: all that follow each other, where some are a frame late.
        name: of its cause: exchanged, scaled, late or early; or turned, for images that are both upside down, which
            match no less if they are exchanged.

    Raises:
        InputError: if calibration and images do not say how.
    """
    if name == "turned":
        images = [[np.ascontiguousarray(image[::-1, ::-1]) for image in (pair.left, pair.right)] for pair in pairs]
        both = zip(pairs, images, strict=True)
        return rig, tuple(replace(pair, left=left, right=right, origin=None) for pair, (left, right) in both)
    found = [(rig, pairs) for cause, rig, pairs in _causes(rig, pairs) if cause.name == name and cause.corrected]
    if not found:
        raise InputError(f"calibration and images do not say how to correct {name!r}; leave --fix out.")
    if len(found) == 1:
        return found[0]
    images = pyramid(rig, pairs)
    return max(found, key=lambda each: _covered(*each, images, as_matcher(None)))


def _covered(rig: StereoRig, pairs: tuple[Pair, ...], given: Pyramid, matcher: AbstractMatcher) -> float:
    """Share of the image that matches in one of the pairs after a look at half scale: a rig may have turned besides. 0
    if the images do not fit."""
    settings = as_settings({"matcher": replace(matcher, num_disparities=None), "schedule": _LOOK})
    some = select_frames(pairs[:: -(-len(pairs) // _SOME)], 1)
    try:
        images = pyramid(rig, some, given.view if rig is given.rig else None)
        case, start, cost = started(Case(images, settings, settings.matcher, Parameters()))
        found = run_look(case, _LOOK.stages, start, cost)[0].found
    except InputError:
        return 0.0
    return 0.0 if found is None else found.covered


def _causes(rig: StereoRig, pairs: tuple[Pair, ...]) -> Iterator[tuple[Cause, StereoRig, tuple[Pair, ...]]]:
    """Mistakes that may have been made, and rig and pairs without them."""
    yield (
        Cause(
            "exchanged",
            "with left and right exchanged",
            "Exchange the left and right images; if both are upside down, turn them instead (--fix turned).",
        ),
        rig,
        tuple(replace(pair, left=pair.right, right=pair.left, origin=None) for pair in pairs),
    )
    for ratio in ratios_of_sizes(rig):
        size = np.array(rig.left.size)
        width, height = np.round(size / ratio).astype(int)
        advice = f"K belongs to images of about {width}x{height}; scale it to {size[0]}x{size[1]}."
        scaled = replace(rig, left=_scaled(rig.left, ratio), right=_scaled(rig.right, ratio))
        yield Cause("scaled", f"with K scaled by {ratio:.3g}", advice), scaled, pairs
    if any(np.any(camera.distortion) for camera in (rig.left, rig.right)):
        camera, baseline = Camera(rig.left.size, rig.left.matrix), np.array([-float(rig.baseline), 0.0, 0.0])
        advice = "The images are rectified already: give their own calibration (P1 and P2), or the images as taken."
        rectified = StereoRig.from_rotation(camera, camera, np.eye(3), baseline)
        yield Cause("rectified", "as rectified images", advice, corrected=False), rectified, pairs
    if _consecutive(pairs):
        for name, when, left, right in (("early", "later", pairs, pairs[1:]), ("late", "earlier", pairs[1:], pairs)):
            moved = tuple(replace(one, right=other.right, origin=None) for one, other in zip(left, right, strict=False))
            yield Cause(name, f"right images one frame {when}", _TWO_MOMENTS), rig, moved


def ratios_of_sizes(rig: StereoRig) -> tuple[float, ...]:
    """Ratios by which K may have to be scaled, by where its principal points lie; none where that is the middle."""
    half = 0.5 * np.array(rig.left.size)
    middle = np.mean([camera.matrix[:2, 2] for camera in (rig.left, rig.right)], axis=0) + 0.5
    nearest = dict.fromkeys(min(_RATIOS, key=lambda one: abs(np.log(one / each))) for each in half / middle)
    return tuple(ratio for ratio in nearest if np.abs(np.log(ratio * middle / half)).max() < _NEAR_RATIO)


def _consecutive(pairs: tuple[Pair, ...]) -> bool:
    """Whether no pair is missing, as far as times tell."""
    if len(pairs) < 2 or any(pair.time is None for pair in pairs):
        return len(pairs) > 1
    apart = np.diff([float(pair.time or 0.0) for pair in pairs])
    return bool(apart.min() > 0.0 and apart.max() < _EVEN * np.median(apart))


def _scaled(camera: Camera, ratio: float) -> Camera:
    matrix = np.asarray(camera.matrix, float) * np.array([ratio, ratio, 1.0])[:, None]
    matrix[:2, 2] += 0.5 * (ratio - 1.0)  # pixel corners stay corners
    return replace(camera, matrix=matrix)


def doubts(rig: StereoRig) -> tuple[str, ...]:
    """What is hardly ever true of a rig, each a sentence with what to check. Aligned rows do not show it: they depend
    neither on the length of the baseline nor on both focal lengths together."""
    found = [sentence for side in ("left", "right") if (sentence := _of_field(side, getattr(rig, side))) is not None]
    baseline = float(rig.baseline)
    if not _BASELINE[0] <= baseline <= _BASELINE[1]:
        found.append(f"the cameras would be {baseline:.3g} m apart; check the unit of the translation")
    return tuple(found)


def _of_field(side: str, camera: Camera) -> str | None:
    width, focal, wide = camera.size[0], float(np.asarray(camera.focal)[0]), camera.lens.WIDE
    field = np.degrees(width / focal if wide else 2.0 * np.arctan(width / 2.0 / focal))
    if _FIELD[0] <= field and (field <= _FIELD[1] or wide):
        return None
    return (
        f"a focal length of {focal:.4g} px in {width} px wide images is a view of {field:.0f} degrees; "
        f"check fx of the {side} camera"
    )
