"""Image quality: whether a pair has enough light and texture to be matched, whatever the calibration; and the frames of
a recording that have most, spread over it.
"""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
from jaxtyping import Float

from stereorecal.recordings import Pair

_WIDTH = 128  # pixels: the scale at which texture is measured; finer texture is often noise
_BLOCK = 2  # columns: the noise of neighbouring pixels is correlated where colours were interpolated
_TEXTURED_SLOPE = 8.0  # x-Sobel response, four times a step in grey levels: fog and noise stay below
_DARK = 20.0  # mean grey level; what moves at night is noise
_FEWEST_LEVELS, _LEAST_CONTRAST = 12, 1.5  # grey levels
_SOME = 3  # every third pixel of every third row
_EVERY, _ASIDE = 4, 6  # rows of which one is looked at; columns that odd rows may be aside
_COMB = 0.9  # of the difference at no move: a comb of a pixel leaves 0.4 to 0.8
_CORRELATED = 0.2  # correlation of slopes in two halves of an image's columns: 0 for noise, 0.6 and more for texture
_TEXTURED = 1.0 / 3.0  # of what the lens shows; daylight shows 0.5 to 0.9, night and fog 0 to 0.2
_LEAST_TEXTURED = 0.2  # of the image: half of it matches, and less than a tenth of an image tells nothing
_ROUND = 0.9  # of the smallest circle around it: so much an image circle fills, and no street lamp

_RECENT = 16  # pairs that are held at once: a tenth of a second, at up to 160 pairs a second
_STEEP = 31.0  # grey levels of the x-Sobel response: matchers clip it there


@dataclass(frozen=True)
class ImageQuality:
    """The quality of the worse image of a pair.

    Attributes:
        brightness: mean grey level, 0 to 255, of what the lens shows.
        texture: share of the image with texture, 0 to 1; noise counts as texture.
        shown: share of the image that the lens shows: 1, or that of the image circle of a wide lens on black.
        coarse: True if there are so few different grey levels, or so little contrast, that rounding to whole levels
            moves what matches.
        interlaced: True if odd rows show another moment than even ones: they match them better some columns aside.
        noise: True if the texture is noise only, as behind a lens cap, whose image of 16 bit or floating point is
            stretched to full contrast.
    """

    brightness: float
    texture: float
    noise: bool = False
    shown: float = 1.0
    coarse: bool = False
    interlaced: bool = False

    @property
    def problem(self) -> str | None:
        """Why images would hardly match, or None."""
        if self.brightness < _DARK:
            return "the images are too dark"
        if self.noise:
            return "an image shows only noise, as behind a lens cap"
        if self.texture < max(_TEXTURED * self.shown, _LEAST_TEXTURED):
            return "the images have too little texture"
        if self.coarse:
            return "an image has only a few grey levels"
        return "an image is interlaced" if self.interlaced else None

    @property
    def misleading(self) -> bool:
        """True if images match elsewhere than their scene does."""
        return self.coarse or self.interlaced

    @property
    def enough(self) -> bool:
        """True if images of an aligned rig would match."""
        return self.problem is None


def image_quality(pair: Pair) -> ImageQuality:
    """The quality of a pair's images."""
    images = (pair.left, pair.right)
    shares = [_image_circle_share(_small(image)) for image in images]
    brightness = min(float(image.mean()) / share for image, share in zip(images, shares, strict=True))
    texture = min(float((np.abs(x_slopes(image)) > _TEXTURED_SLOPE).mean()) for image in images)
    shown = min(shares)
    noise = texture >= _TEXTURED * shown and any(_is_noise(image) for image in images)
    return ImageQuality(brightness, texture, noise, shown, is_coarse(pair), any(map(_is_interlaced, images)))


def is_coarse(pair: Pair) -> bool:
    """Whether an image of a pair has few different grey levels, or hardly any contrast: see `ImageQuality.coarse`."""
    levels = [np.sort(image[::_SOME, ::_SOME], axis=None) for image in (pair.left, pair.right)]
    return any(
        np.count_nonzero(np.diff(of_image)) + 1 < _FEWEST_LEVELS
        or np.ptp(np.quantile(of_image, (0.01, 0.99))) < _LEAST_CONTRAST
        for of_image in levels
    )


def _is_interlaced(image: Float[np.ndarray, "h w"]) -> bool:
    """Whether odd rows look more like their neighbours when they are moved to one side, and like the next odd rows
    where they are: a slanted stripe does not, and the colours of a raw image do as well to the other side."""
    height, width = image.shape
    if height < 2 * _EVERY or width <= 4 * _ASIDE:
        return False
    rows = np.arange(2, height - 2, _EVERY) // 2 * 2 + 1
    rows = rows[rows < height - 2]
    moves = range(-_ASIDE, _ASIDE + 1)

    def apart(distance: int) -> list[float]:
        around = 0.5 * (image[rows - distance] + image[rows + distance])[:, _ASIDE : width - _ASIDE]
        each = (image[rows, _ASIDE + by : width - _ASIDE + by] for by in moves)
        return [float(np.abs(moved - around).mean()) for moved in each]

    beside = apart(1)
    best = int(np.argmin(beside))
    moved = beside[best] < _COMB * min(beside[_ASIDE], beside[-1 - best])
    return moved and int(np.argmin(apart(2))) == _ASIDE


def x_slopes(image: Float[np.ndarray, "h w"]) -> Float[np.ndarray, "rows columns"]:
    """The x-Sobel response of the image at a width of 128 pixels."""
    return cv2.Sobel(_small(image), cv2.CV_32F, 1, 0)


def _small(image: Float[np.ndarray, "h w"]) -> Float[np.ndarray, "rows columns"]:
    height, width = image.shape
    return _resized(image, _WIDTH, max(1, height * _WIDTH // width))


def _image_circle_share(image: Float[np.ndarray, "h w"]) -> float:
    """The share of an image that its lens shows: less than 1 where darkness that reaches from all four corners leaves
    a disc, or as much of one as fits."""
    height, width = image.shape
    dark = np.ascontiguousarray(image < _DARK, np.uint8)
    corners = [(0, 0), (width - 1, 0), (0, height - 1), (width - 1, height - 1)]
    if min(height, width) < 3 or not all(dark[y, x] for x, y in corners):
        return 1.0
    for corner in corners:
        cv2.floodFill(dark, None, corner, 2)
    lit = np.argwhere(dark != 2)[:, ::-1].astype(np.float32)
    if not len(lit):
        return 1.0
    centre, radius = cv2.minEnclosingCircle(lit)
    disc = cv2.circle(np.zeros_like(dark), (round(centre[0]), round(centre[1])), round(radius), 1, cv2.FILLED)
    return len(lit) / dark.size if len(lit) > _ROUND * int(disc.sum()) else 1.0


def _is_noise(image: Float[np.ndarray, "h w"]) -> bool:
    """Whether the slopes of alternating pairs of columns are uncorrelated: texture is in both, noise is independent."""
    height, width = image.shape
    if width < 8 * _BLOCK:
        return False
    step, size = 2 * _BLOCK, min(_WIDTH, width // (2 * _BLOCK))
    columns = [image[:, first : width // step * step : step] for first in range(step)]
    halves = (np.mean(some, axis=0) for some in (columns[:_BLOCK], columns[_BLOCK:]))
    small = (_resized(half, size, max(1, height * size // width)) for half in halves)
    first, second = (cv2.Sobel(half, cv2.CV_32F, 1, 0) for half in small)
    energy = float(np.sqrt((first**2).sum() * (second**2).sum()))
    return energy > 0.0 and float((first * second).sum()) < _CORRELATED * energy


def _resized(image: Float[np.ndarray, "h w"], width: int, height: int) -> Float[np.ndarray, "rows columns"]:
    return cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA)


def select_frames(
    pairs: Sequence[Pair], most: int, follows: Callable[[Pair, Pair], bool] | None = None
) -> tuple[Pair, ...]:
    """The pairs, at most `most`, in order: of as many equal stretches, the pair with the most texture of each, so that
    they show different moments.

    Args:
        follows: whether a pair follows another; each of half as many stretches then gives a pair and a neighbour: the
            next pair that follows it, else the last one before that it follows.
    """
    if len(pairs) <= most:
        return tuple(pairs)
    bounds = np.linspace(0, len(pairs), (most if follows is None else most // 2) + 1).round().astype(int)
    stretches = [pairs[first:end] for first, end in pairwise(bounds)]
    # One stretch after the other: the pairs may lie in a video.
    if follows is None:
        return tuple(max(stretch, key=_texture) for stretch in stretches)
    return tuple(pair for stretch in stretches for pair in _with_neighbour(stretch, follows))


def _with_neighbour(stretch: Sequence[Pair], follows: Callable[[Pair, Pair], bool]) -> tuple[Pair, ...]:
    """The pair with the most texture, and a neighbour; each pair is read once."""
    best, texture, before, after = None, -1.0, None, None
    recent: deque[Pair] = deque(maxlen=_RECENT)  # the last pair that a pair follows, and those after it
    for pair in stretch:
        while len(recent) > 1 and follows(recent[1], pair):
            recent.popleft()
        if best is not None and after is None and follows(best, pair):
            after = pair
        if (here := _texture(pair)) > texture:
            earlier = recent[0] if recent and follows(recent[0], pair) else None
            best, texture, before, after = pair, here, earlier, None
        recent.append(pair)
    assert best is not None
    if after is not None:
        return best, after
    return (best,) if before is None else (before, best)


def _texture(pair: Pair) -> float:
    """The mean response of an x-Sobel filter to the left image, clipped."""
    return float(np.minimum(np.abs(x_slopes(pair.left)), _STEEP).mean())
