"""A survey of the images at a coarse scale: a rough rotation of the rig, and the disparity range."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from jaxtyping import Float

from stereorecal._arrays import Extrinsics, refuse_tracers
from stereorecal.geometry import AXES, AnyView, StereoRig, View, checked_rig, with_unit_baseline
from stereorecal.matching import SAD, AbstractMatcher, Disparity, as_matcher
from stereorecal.recordings import Pairs
from stereorecal.scoring._prepare import Pyramid, pyramid
from stereorecal.scoring.host._disparities import counts, disparities
from stereorecal.scoring.host._swapped_images import refuse_swapped_images

_COARSE_WIDTH = 128  # pixels: a few degrees of drift are a few rows here, within the window of the matcher
_COARSE_HEIGHT = 24  # pixels, at least, for panoramic images
RANGES = (16, 32, 48, 64, 96, 128, 192, 256, 384, 512)  # few, since each is a program of its own to compile
_MARGIN = 1.25  # the nearest surface may be small, or seen closer in another frame
_DEFAULT_REACH = np.radians(3.0)
_INSIDE = 0.7  # of the reach: where the outermost steps of roll lie
_STEP = 4  # coarse pixels, in whole times of which points are searched beyond infinity: few programs to compile
_MOST_BEYOND = 0.25  # of the width: of a view that is hardly wider than the reach
_FARTHEST = 0.05  # quantile: the farthest points, but for false matches
_FRAMES = 4
_FEWEST = 50  # pixels of surfaces; fewer do not determine the range
_SURELY_RIGHT = 0.5  # share of the pixels that match in front of infinity: of images that are exchanged, no more do
_INVALID = -(2**15)  # in place of a disparity
_SPECKLE = 100  # pixels of the coarse image: about a hundredth of it


@dataclass(frozen=True, eq=False)
class Survey:
    """The result of a coarse match of the images."""

    offset: Float[np.ndarray, "6"]  # what to add to the extrinsics so that most pixels match
    disparities: Float[np.ndarray, "n"]  # of the surfaces found, with that, in pixels of the coarse scale
    view: View  # at that scale
    scale: float  # pixels there per pixel at full size
    cost: float  # in matcher runs on a full-size frame

    def with_range(self, matcher: AbstractMatcher, yaw: float) -> AbstractMatcher:
        """The matcher with its number of disparities: its own, or measured when it is None.

        Measured: the 99.5 % quantile of the coarse match (a quarter of the width where nothing matches; 0 where all
        seems to lie beyond infinity), plus 25 %, plus what the yaw [rad] that may be missing moves (of a pinhole
        `focal * tan(yaw)`); then the next of a few round numbers.
        """
        if matcher.num_disparities is not None:
            return matcher
        enough = self.disparities.size > _FEWEST
        nearest = np.quantile(self.disparities, 0.995) if enough else self.view.size[0] / 4
        widest = (_MARGIN * max(nearest, 0.0) + float(self.view.focal) * self.view.formulas.edge(yaw)) / self.scale
        width = round(self.view.size[0] / self.scale)
        limit = width - 1 - abs(matcher.min_disparity)
        wanted = max(16, next((n for n in RANGES if n >= widest), widest) - matcher.min_disparity)
        return replace(matcher, num_disparities=int(min(wanted, limit // 16 * 16)))


def survey(
    images: Pyramid,
    extrinsics: Extrinsics,
    reach: float = _DEFAULT_REACH,
    *,
    aligned: bool = False,
    yaw: bool = False,
) -> Survey:
    """Match the images at a coarse scale over a grid of pitch and roll, since the rig may be decalibrated. Points are
    searched beyond infinity, too: where little lies in front of it, and features fit the rig but for a rotation, the
    farthest that a reach explains tell the yaw, which brings them to infinity. A yaw of the other sign only makes all
    points seem nearer.

    Args:
        extrinsics: (6,) of the rig, the middle of the grid.
        reach: largest rotation error expected, radians.
        aligned: the rows are known to be aligned, so pitch and roll are not searched.
        yaw: whether the offset may have one.

    Raises:
        InputError: if the images are certainly exchanged, upside down, or of different scenes.
    """
    size = images.view.size
    scale = min(1.0, max(_COARSE_WIDTH / size[0], _COARSE_HEIGHT / size[1]))
    data = images.at(scale, _FRAMES)
    focal, edge, infinity = float(data.view.focal), data.view.formulas.edge, float(data.view.at_infinity)
    beyond = int(_STEP * np.ceil((focal * edge(max(reach, _DEFAULT_REACH)) - infinity) / _STEP) / scale)
    beyond = min(max(beyond, 0), int(_MOST_BEYOND * size[0]))
    coarse = SAD(min_disparity=-beyond, num_disparities=size[0] // 2 + beyond, block_size=7)
    offsets = np.zeros((1, 6)) if aligned else _offset_grid(data.view, reach)
    candidates = np.asarray(with_unit_baseline(extrinsics) + offsets, np.float32)
    runs, winner = 1, 0  # aligned: there is nothing to choose from
    if not aligned:
        winner = int(np.argmax(counts(data, candidates, coarse)))
        runs += len(candidates)
    surveyed = disparities(data, candidates[winner], coarse)
    angles = [_parallaxes(data.view, found) for found in surveyed]
    ahead = sum(int(np.sum(found.valid & (some >= 0.0))) for found, some in zip(surveyed, angles, strict=True))
    fits = False  # of images that are exchanged, all is beyond infinity, too
    if ahead < _SURELY_RIGHT * data.pixels and not aligned:
        fits = refuse_swapped_images(images, largest_rotation=2.0 * max(reach, _DEFAULT_REACH)).turned
    surfaces, parallaxes = _surfaces(surveyed, angles, -reach - 1.0 / focal)
    offset, missing = offsets[winner], 0.0
    if yaw and fits and surfaces.size > _FEWEST:
        missing = -float(np.quantile(parallaxes, _FARTHEST))
    if missing > 1.0 / focal:
        offset, surfaces = offset + np.eye(6)[AXES.index("yaw")] * missing, surfaces + focal * edge(missing)
    return Survey(offset, surfaces, data.view, scale, runs * data.cost)


def with_measured_range(
    matcher: AbstractMatcher | str | None, images: Pyramid, reach: float = _DEFAULT_REACH
) -> AbstractMatcher:
    """The matcher with its number of disparities: its own, or measured by a `survey`, with a margin for a yaw error of
    `reach` [rad].

    Raises:
        InputError: if, while measuring, the images turn out to be exchanged.
    """
    matcher = as_matcher(matcher)
    if matcher.num_disparities is not None:
        return matcher
    return survey(images, images.rig.extrinsics, reach).with_range(matcher, reach)


def with_disparity_range(
    matcher: AbstractMatcher | str | None,
    rig: StereoRig,
    pairs: Pairs,
    view: AnyView = None,
    reach: float = _DEFAULT_REACH,
) -> AbstractMatcher:
    """The matcher with its number of disparities: its own, or measured on the images, whose rig may be decalibrated.

    Args:
        matcher: a matcher, or the name of an installed one ("sad" for None).
        view: default the view of `rig`.
        reach: largest rotation error expected, radians; a yaw error moves far things by up to `focal * tan(reach)`.

    Raises:
        InputError: if images and calibration do not fit, while measuring the images turn out to be exchanged, or it is
            called under `jit`, `vmap` or `grad`.
    """
    refuse_tracers("sr.with_disparity_range", "it before tracing", rig, pairs, view)
    return with_measured_range(matcher, pyramid(checked_rig(rig), pairs, view), reach)


def _offset_grid(view: View, reach: float) -> Float[np.ndarray, "n 6"]:
    """Offsets of the extrinsics, so dense that the coarse matcher finds matches at one of them. The nearest come first:
    of those that match as much, the first is taken."""
    pitch_step = 1.5 / float(view.focal)  # a row and a half
    pitches = _either_way(reach, max(1, int(np.ceil(reach / pitch_step))))
    rolls = _either_way(_INSIDE * reach, max(1, round(reach / _DEFAULT_REACH)))
    grid = np.array([(pitch, 0.0, roll, 0.0, 0.0, 0.0) for pitch in pitches for roll in rolls])
    return grid[np.argsort(np.linalg.norm(grid, axis=1), kind="stable")]


def _either_way(farthest: float, steps: int) -> Float[np.ndarray, "n"]:
    """0, and as many equal steps to both sides."""
    return np.arange(-steps, steps + 1) * (farthest / max(steps, 1))


def _parallaxes(view: View, found: Disparity) -> Float[np.ndarray, "h w"]:
    """The angle [rad] along the baseline between what both cameras see of each point: 0 at infinity, negative beyond.
    A yaw adds to all alike."""

    def angle(columns: Float[np.ndarray, "..."], centre: float) -> Float[np.ndarray, "..."]:
        x, _, z = view.formulas.directions((columns - centre) / float(view.focal), 0.0)
        return np.arctan2(x, z)

    columns, values = np.arange(found.values.shape[1], dtype=float), np.where(found.valid, found.values, 0.0)
    return angle(columns, float(view.centre_left)) - angle(columns - values, float(view.centre_right))


def _surfaces(
    surveyed: Sequence[Disparity], parallaxes: Sequence[Float[np.ndarray, "h w"]], lowest: float
) -> tuple[Float[np.ndarray, "n"], Float[np.ndarray, "n"]]:
    """The disparities that form patches, and their parallaxes, without the isolated pixels of false matches, and what
    lies below the lowest parallax that a reach explains."""
    found = []
    for one, angles in zip(surveyed, parallaxes, strict=True):
        values = np.asarray(one.values)
        fixed_point = np.where(one.valid & (angles > lowest), 16 * values, _INVALID).astype(np.int16)
        cv2.filterSpeckles(fixed_point, _INVALID, maxSpeckleSize=_SPECKLE, maxDiff=16)
        in_patches = fixed_point > _INVALID
        found.append((values[in_patches], angles[in_patches]))
    surfaces, of_surfaces = zip(*found, strict=True)
    return np.concatenate(surfaces), np.concatenate(of_surfaces)
